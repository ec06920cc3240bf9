//! Findings in words that follow their sign and say their size.

use crate::number::with_expanded;

/// Comparisons and what they are when the amplitude is negative.
const OPPOSITES: &[(&str, &str)] = &[
    ("too large", "too small"),
    ("too long", "too short"),
    ("larger than", "smaller than"),
    ("longer than", "shorter than"),
    ("farther than", "less far than"),
    ("higher than", "lower than"),
    ("more than", "less than"),
    ("this late", "this early"),
    ("reads long", "reads short"),
];

/// Ends of a description that stand for the size, which follows.
const STANDS_FOR_SIZE: &[&str] = &[" by a ratio", " by the same ratio", " in proportion"];

/// The description of an effect with one amplitude: «the vertex radius is shorter than declared:
/// 0.0110 ± 0.0012 mm»; of several amplitudes as it is, for they are listed.
///
/// `amplitudes` are values, standard uncertainties and units; the uncertainty shown is expanded
/// (k = 2).
pub(crate) fn in_words(description: &str, amplitudes: &[(f64, f64, &str)]) -> String {
    let values: Vec<f64> = amplitudes.iter().map(|(value, ..)| *value).collect();
    with_size(&by_sign(description, &values), amplitudes)
}

/// The description of an effect with one amplitude, its comparison turned where that is negative;
/// of several amplitudes as it is.
#[must_use]
pub fn by_sign(description: &str, values: &[f64]) -> String {
    match values {
        [value] if *value < 0.0 && is_signed(description) => opposite(description),
        _ => description.to_owned(),
    }
}

fn is_signed(description: &str) -> bool {
    OPPOSITES.iter().any(|(more, less)| description.contains(more) || description.contains(less))
}

/// What was said [`by_sign`], with its size.
///
/// `amplitudes` are values, standard uncertainties and units; the uncertainty shown is expanded
/// (k = 2).
#[must_use]
pub fn with_size(said: &str, amplitudes: &[(f64, f64, &str)]) -> String {
    let [(value, std, unit)] = amplitudes else { return said.to_owned() };
    let short = STANDS_FOR_SIZE.iter().find_map(|end| said.strip_suffix(end)).unwrap_or(said);
    let short = short.trim_end_matches('.');
    let size = if is_signed(said) { value.abs() } else { *value };
    let (size, expanded) = with_expanded(size, *std);
    format!("{short}: {size} ± {expanded}{}", after_number(unit))
}

/// A unit as it follows a number: nothing where that is a pure one.
#[must_use]
pub fn after_number(unit: &str) -> String {
    if matches!(unit, "" | "1") { String::new() } else { format!(" {unit}") }
}

/// Every comparison the other way round.
fn opposite(description: &str) -> String {
    let mut said = String::new();
    let mut rest = description;
    while !rest.is_empty() {
        let found = OPPOSITES.iter().find_map(|(more, less)| {
            let other = |from: &str, to: &'static str| rest.strip_prefix(from).map(|r| (to, r));
            other(more, less).or_else(|| other(less, more))
        });
        if let Some((turned, after)) = found {
            said.push_str(turned);
            rest = after;
        } else {
            let next = rest.char_indices().nth(1).map_or(rest.len(), |(at, _)| at);
            said.push_str(&rest[..next]);
            rest = &rest[next..];
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::{by_sign, in_words, with_size};

    #[test]
    fn sign_turns_the_comparison_and_the_size_follows() {
        let longer = "the vertex radius of the part is longer than declared";
        assert_eq!(
            in_words(longer, &[(-0.011, 0.0006, "mm")]),
            "the vertex radius of the part is shorter than declared: 0.0110 ± 0.0012 mm"
        );
        assert_eq!(
            in_words(longer, &[(0.011, 0.0006, "mm")]),
            "the vertex radius of the part is longer than declared: 0.0110 ± 0.0012 mm"
        );
    }

    #[test]
    fn what_follows_the_sign_already_is_not_turned_again() {
        let long = "the machine's x axis reads long";
        let short = by_sign(long, &[-120.0]);
        assert_eq!(short, "the machine's x axis reads short");
        assert_eq!(with_size(&short, &[(-120.0, 5.0, "ppm")]), format!("{short}: 120 ± 10 ppm"));
        assert_eq!(by_sign(long, &[120.0]), long);
        assert_eq!(by_sign(long, &[-1.0, 2.0]), long);
    }

    #[test]
    fn opposite_comparisons_are_turned_both() {
        let cross = "the sensor reads Mx too large and My too small by the same ratio";
        assert_eq!(
            in_words(cross, &[(-0.5, 0.05, "%")]),
            "the sensor reads Mx too small and My too large: 0.50 ± 0.10 %"
        );
    }

    #[test]
    fn what_has_no_opposite_keeps_its_sign_and_several_amplitudes_are_listed() {
        assert_eq!(
            in_words("the part turned", &[(-2.0, 0.05, "µrad")]),
            "the part turned: −2.00 ± 0.10 µrad"
        );
        assert_eq!(in_words("sag", &[(1.0, 0.1, "mm"), (2.0, 0.1, "mm")]), "sag");
    }
}
