//! Numbers as they are written down.

/// Without the digits that dividing by ten adds.
pub(super) fn shortest(value: f64) -> f64 {
    let rounded = format!("{value:.12e}");
    rounded.parse().unwrap_or(value)
}

/// The numbers that have two neighbouring digits the other way round.
pub(super) fn digits_exchanged(number: f64) -> Vec<f64> {
    let written = number.to_string();
    let digits: Vec<usize> =
        written.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
    let exchanged = digits.windows(2).filter_map(|pair| {
        let mut other = written.clone().into_bytes();
        other.swap(pair[0], pair[1]);
        String::from_utf8(other).ok()?.parse::<f64>().ok()
    });
    exchanged.filter(|to| to.total_cmp(&number).is_ne()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_was_divided_reads_as_it_was_meant() {
        assert_eq!(shortest(-1089.539 / 10.0).to_string(), "-108.9539");
        assert_eq!(shortest(0.3 / 0.001).to_string(), "300");
    }

    #[test]
    fn neighbouring_digits_are_exchanged_across_the_point_too() {
        assert_eq!(digits_exchanged(0.77), [7.07]);
        assert_eq!(digits_exchanged(12.5), [21.5, 15.2]);
    }
}
