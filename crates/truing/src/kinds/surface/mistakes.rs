//! What may be wrong with the numbers of a drawing, or with touches of the part.

use crate::case::{Document, Table};
use crate::kind::Files;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Twice, Yardstick, clipped_of_few, copies, cycles, doubled,
    exchanged_rows, exchanges, farthest, held, increments, lengths, number, of_another_part,
    other_setting, polar, rows_left_out, rows_shifted, scaled_setting, signs, silent, slips,
    spread_of, standing_still, units, zeros,
};

pub(crate) const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// Deviation over the spread of the touches that no part has: 0.3 mm in 100 mm.
const GROSS: f64 = 0.003;
/// The same beyond which part and touches have nothing to do with each other.
const UNMATCHED: f64 = 0.05;
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;

/// Sign and unit of the vertex radius, the diameter for the radius, the sign of the conic.
pub(crate) fn mistakes_of_drawing(files: &Files) -> Vec<Hypothesis> {
    let document = &files.document;
    let mut all = lengths(document, &["surface", "radius_mm"]);
    let bowl = "of the opposite sign (bowl for dome, inward normal)";
    let radius = ["surface", "radius_mm"];
    all.extend(scaled_setting(document, &radius, "input:sign", bowl, -1.0));
    let conic = ["surface", "conic"];
    all.extend(scaled_setting(document, &conic, "input:sign", "of the opposite sign", -1.0));
    let eccentricity = number(document, &conic).filter(|e| *e > 0.0);
    all.extend(eccentricity.and_then(|e| {
        let what = "the eccentricity, not the conic constant";
        scaled_setting(document, &conic, "input:eccentricity", what, -e)
    }));
    all.extend(lengths(document, &["surface", "unit_mm"]));
    all.extend(numbers_of_form(document));
    let what = "taken off already, the coordinates are those of the contact and not of the centre of the ball";
    all.extend(scaled_setting(
        document,
        &["probe", "tip_radius_mm"],
        "input:compensated",
        what,
        0.0,
    ));
    all
}

/// A coefficient of the form, or a term of a polynomial, with its decimal point elsewhere or another sign; the two
/// coordinates of terms exchanged.
fn numbers_of_form(document: &Document) -> Vec<Hypothesis> {
    let shifted = [10.0, 0.1, 100.0, 0.01, 1e3, 1e-3];
    let of_list =
        |key: &'static str, number: &dyn Fn(&mut toml::Value) -> Option<&mut toml::Value>| {
            let path = ["surface", key];
            let list = document.value(&path).and_then(|value| value.as_array().cloned());
            let list = list.unwrap_or_default();
            let of_one = |i: usize, factor: f64| {
                let mut changed = list.clone();
                let number = number(&mut changed[i])?;
                let before = number.as_float()?;
                *number = toml::Value::Float(before * factor);
                let (effect, what) = if factor < 0.0 {
                    ("input:sign", "has the opposite sign in")
                } else {
                    (
                        "input:decimal-point",
                        "has a decimal point in the wrong place (a factor, an exponent) in",
                    )
                };
                let what = format!(
                    "wrong, it {what} number {}: {} instead of {before}",
                    i + 1,
                    before * factor
                );
                Some(other_setting(&path, effect, &what, toml::Value::Array(changed)))
            };
            let factors = || std::iter::once(-1.0).chain(shifted);
            let numbers = (0..list.len()).flat_map(|i| factors().map(move |factor| (i, factor)));
            numbers.filter_map(|(i, factor)| of_one(i, factor)).collect::<Vec<_>>()
        };
    let mut all = of_list("coefficients", &|value| Some(value));
    all.extend(of_list("terms", &|term| term.as_array_mut()?.get_mut(2)));
    let path = ["surface", "terms"];
    let terms =
        document.value(&path).and_then(|value| value.as_array().cloned()).unwrap_or_default();
    for (i, j) in (0..terms.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
        let number = |of: usize| terms[of].as_array().and_then(|term| term.get(2)).cloned();
        let Some((one, other)) = number(i).zip(number(j)) else { continue };
        let mut changed = terms.clone();
        for (at, value) in [(i, other), (j, one)] {
            if let Some(term) = changed[at].as_array_mut() {
                term[2] = value;
            }
        }
        let what = format!(
            "wrong, the numbers of its terms {} and {} are exchanged (swapped)",
            i + 1,
            j + 1
        );
        all.push(other_setting(&path, "input:exchanged", &what, toml::Value::Array(changed)));
    }
    if let Some(mut terms) = document.value(&path).and_then(|value| value.as_array().cloned()) {
        for term in terms.iter_mut().filter_map(toml::Value::as_array_mut).filter(|t| t.len() > 1) {
            term.swap(0, 1);
        }
        let what = "wrong, the coordinates x and y are exchanged (swapped) in its terms: `[j, i, a]` for `[i, j, a]`";
        all.push(other_setting(&path, "input:exchanged", what, toml::Value::Array(terms)));
    }
    all
}

/// Units, signs and order of the coordinates of a table of points.
pub(crate) fn mistakes_of_points(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = units(file, table, &XYZ, Dimension::Length);
    all.extend(doubled(file, table, &XYZ, Twice::Diameter));
    all.extend(polar(file, table, &XYZ));
    all.extend(signs(file, table, &XYZ));
    all.extend(increments(file, table, &XYZ, &[]));
    all.extend(copies(file, table, &XYZ, Proof::Gross));
    all.extend(exchanges(file, table, &XYZ));
    all.extend(cycles(file, table, XYZ));
    all
}

/// Rows of a table of points in another order, of another part, or with a slip of the pen; `known` columns
/// of text have a meaning of their own.
pub(crate) fn mistakes_of_rows(
    file: &'static str,
    table: Option<&Table>,
    known: &[&str],
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let of_column = |column: &&str| rows_shifted(file, table, &[*column], None);
    let mut all: Vec<Hypothesis> = XYZ.iter().flat_map(of_column).collect();
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(file, rows)];
    all.extend(silent(file, table, &XYZ));
    all.extend(standing_still(file, table, &XYZ, without));
    all.extend(held(file, table, &XYZ, without));
    all.extend(clipped_of_few(file, table, &XYZ, without));
    all.extend(zeros(file, table, &XYZ, without));
    let far = fitted.map(|fitted| (fitted, farthest(fitted, FARTHEST)));
    let far = far.as_ref().map(|(fitted, rows)| (*fitted, &rows[..]));
    all.extend(slips(file, table, &XYZ, far));
    if let Some((_, far)) = far {
        all.extend(exchanged_rows(file, table, &XYZ[2..], far));
        all.extend(of_another_part(file, table, known));
    }
    all
}

/// What a deviation of touches at these places is measured by.
pub(crate) fn yardstick_of<'p>(places: impl Iterator<Item = &'p [f64]> + Clone) -> Yardstick {
    let spread = spread_of(places);
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}
