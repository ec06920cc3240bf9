//! Names that effects had before, still read where a user wrote them down.

/// Former id of an effect, and the one that it has in every kind now.
const FORMER: &[(&str, &str)] = &[("machine-scale", "axis-scale"), ("ball-radius", "tip-radius")];

/// The present id of an effect.
pub(super) fn present(id: &str) -> &str {
    FORMER.iter().find(|(former, _)| *former == id).map_or(id, |(_, now)| now)
}

#[cfg(test)]
mod tests {
    use super::present;

    #[test]
    fn former_names_are_read_and_others_stay() {
        assert_eq!(present("machine-scale"), "axis-scale");
        assert_eq!(present("ball-radius"), "tip-radius");
        assert_eq!(present("pretravel"), "pretravel");
    }
}
