//! Names that effects had before, still read where a user wrote them down.

/// Former id of an effect, and the one that it has in every kind now.
const FORMER: &[(&str, &str)] = &[("machine-scale", "axis-scale"), ("ball-radius", "tip-radius")];

/// Id under which errors of form had their names as subjects.
const FORM: &str = "form";

/// Subjects of [`FORM`] that are ids of their own now.
const FORMS: &[(&str, &str)] =
    &[("power", "focus"), ("astigmatism", "astigmatism"), ("coma", "coma"), ("trefoil", "trefoil")];

/// Former name of an amplitude, by the effect's present id.
const AMPLITUDES: &[(&str, &str, &str)] = &[("focus", "rim", "height")];

/// The present id and subject of an effect.
pub(super) fn present<'a>(id: &'a str, subject: Option<&'a str>) -> (&'a str, Option<&'a str>) {
    let own = |(former, _): &&(&str, &str)| id == FORM && subject == Some(*former);
    if let Some((_, now)) = FORMS.iter().find(own) {
        return (now, None);
    }
    (FORMER.iter().find(|(former, _)| *former == id).map_or(id, |(_, now)| now), subject)
}

/// The present name of an amplitude of an effect with that present id.
pub(super) fn present_amplitude<'a>(id: &str, name: &'a str) -> &'a str {
    let own = AMPLITUDES.iter().find(|(effect, former, _)| *effect == id && *former == name);
    own.map_or(name, |(_, _, now)| now)
}

#[cfg(test)]
mod tests {
    use super::{present, present_amplitude};

    #[test]
    fn former_names_are_read_and_others_stay() {
        assert_eq!(present("machine-scale", Some("x")), ("axis-scale", Some("x")));
        assert_eq!(present("ball-radius", None), ("tip-radius", None));
        assert_eq!(present("pretravel", None), ("pretravel", None));
        assert_eq!(present("form", Some("power")), ("focus", None));
        assert_eq!(present("form", Some("lobes")), ("form", Some("lobes")));
        assert_eq!(present_amplitude("focus", "rim"), "height");
        assert_eq!(present_amplitude("coma", "cos"), "cos");
    }
}
