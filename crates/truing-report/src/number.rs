//! Numbers for people: sensible digits, a true minus sign, no NaN.

/// What stands in for a number that does not exist.
pub(crate) const NONE: &str = "–";

/// Coverage factor of every «±» on a page.
pub const COVERAGE: f64 = 2.0;

/// Below it a significance says nothing more: the tail of no real distribution is known there.
const SMALLEST_P: f64 = 1e-16;

/// A value with `digits` significant digits.
#[must_use]
pub fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return NONE.to_string();
    }
    if value == 0.0 {
        return "0".to_string();
    }
    let magnitude = decade(value);
    if (-4..7).contains(&magnitude) {
        fixed(value, digits - 1 - magnitude)
    } else {
        scientific(value, digits - 1)
    }
}

/// A value with at most `digits` significant digits: as a person would have written it.
pub(crate) fn trimmed(value: f64, digits: i32) -> String {
    let text = significant(value, digits);
    if text.contains('.') && !text.contains('×') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// A value to the digits that its expanded uncertainty supports, and that uncertainty: two
/// significant digits of it, and the value to the same place.
#[must_use]
pub fn with_expanded(value: f64, std: f64) -> (String, String) {
    let expanded = COVERAGE * std;
    if !value.is_finite() || !expanded.is_finite() || expanded <= 0.0 {
        return (significant(value, UNCERTAIN_DIGITS), NONE.to_string());
    }
    let decimals = decimals_of(expanded);
    if decimals > MOST_DECIMALS || decade(value) > 7 || decade(expanded) > 7 {
        // As many digits as reach the last place of the uncertainty.
        let digits = (decade(value) + 1 + decimals).clamp(2, 17);
        return (significant(value, digits), significant(expanded, 2));
    }
    (fixed(value, decimals), fixed(expanded, decimals))
}

/// Digits of a value whose uncertainty is not known.
const UNCERTAIN_DIGITS: i32 = 4;

/// Decimals beyond which a number is written with a power of ten.
const MOST_DECIMALS: i32 = 9;

/// Decimals that leave two significant digits of an uncertainty, as it is after rounding.
fn decimals_of(expanded: f64) -> i32 {
    let decimals = 1 - decade(expanded);
    let unit = 10f64.powi(-decimals);
    // 0.0996 is 0.10, not 0.100.
    1 - decade((expanded / unit).round() * unit * (1.0 + f64::EPSILON))
}

/// A significance.
pub(crate) fn p_value(p: f64) -> String {
    if !p.is_finite() {
        NONE.to_string()
    } else if p < SMALLEST_P {
        format!("< {}", scientific(SMALLEST_P, 0))
    } else if p < 1e-3 {
        scientific(p, 0)
    } else if p < 0.1 {
        significant(p, 2)
    } else {
        fixed(p, 2)
    }
}

/// A share, `0 … 1`, in percent.
pub(crate) fn percent(share: f64) -> String {
    if !share.is_finite() {
        return NONE.to_string();
    }
    let hundredths = 100.0 * share;
    // «100 %» and «0 %» are kept for what is exactly that.
    if hundredths > 99.0 && hundredths < 99.95 {
        format!("{hundredths:.1}\u{a0}%")
    } else if hundredths > 99.0 && hundredths < 100.0 {
        "> 99.9\u{a0}%".to_string()
    } else if hundredths > 0.0 && hundredths < 0.5 {
        "< 1\u{a0}%".to_string()
    } else {
        format!("{}\u{a0}%", fixed(hundredths, 0))
    }
}

/// A count with thin spaces between thousands.
pub(crate) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, c) in digits.chars().enumerate() {
        let left = digits.len() - i;
        if i > 0 && left.is_multiple_of(3) && digits.len() > 4 {
            grouped.push('\u{202f}');
        }
        grouped.push(c);
    }
    grouped
}

/// A count with its noun, in the plural where it should be.
pub(crate) fn counted(n: usize, noun: &str) -> String {
    let noun = if n == 1 { noun.to_string() } else { plural(noun) };
    format!("{} {noun}", count(n))
}

/// The plural of an English noun; words out of a user's header are treated alike.
pub(crate) fn plural(noun: &str) -> String {
    if !noun.ends_with(|c: char| c.is_ascii_alphabetic()) {
        return noun.to_string();
    }
    let hisses = ["s", "x", "z", "ch", "sh"].iter().any(|end| noun.ends_with(end));
    if hisses { format!("{noun}es") } else { format!("{noun}s") }
}

/// A count as a coordinate.
#[expect(clippy::cast_precision_loss, reason = "counts on a page are far below 2^53")]
pub(crate) fn real(n: usize) -> f64 {
    n as f64
}

/// Digits after the point, at most 12; negative rounds before the point.
pub(crate) fn fixed(value: f64, decimals: i32) -> String {
    let decimals_shown = usize::try_from(decimals.clamp(0, 12)).expect("clamped to 0..=12");
    let rounded = if decimals < 0 {
        let unit = 10f64.powi(-decimals);
        (value / unit).round() * unit
    } else {
        value
    };
    typographic(&format!("{rounded:.decimals_shown$}"))
}

fn scientific(value: f64, decimals: i32) -> String {
    let decimals = usize::try_from(decimals.clamp(0, 12)).expect("clamped to 0..=12");
    let text = format!("{value:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let power = format!("10{}", superscript(exponent));
    match mantissa {
        "1" => power,
        "-1" => format!("−{power}"),
        _ => format!("{}×{power}", typographic(mantissa)),
    }
}

/// A power of ten, as `10⁻³`.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0 => "1".to_string(),
        _ => format!("10{}", superscript(&exponent.to_string())),
    }
}

fn superscript(digits: &str) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    };
    digits.chars().map(raised).collect()
}

/// True minus sign, and no minus before zero.
fn typographic(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().any(|c| c.is_ascii_digit() && c != '0') => format!("−{rest}"),
        Some(rest) => rest.to_string(),
        None => text.to_string(),
    }
}

/// Decimal exponent of a finite value.
#[expect(clippy::cast_possible_truncation, reason = "exponents of f64 lie within ±324")]
pub(crate) fn decade(value: f64) -> i32 {
    if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 }
}
