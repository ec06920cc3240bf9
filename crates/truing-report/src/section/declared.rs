//! The declared model and what it solved.

use super::{Cell, Context, Kind, paragraph, table};
use crate::input::ParameterRow;
use crate::markup::Markup;
use crate::number::{count, with_expanded};

/// Rows of a table of parameters; a bundle may have thousands.
const MOST_PARAMETERS: usize = 60;

pub(crate) fn declared(out: &mut Markup, context: &Context) {
    let input = context.input;
    out.element("h2", &[], "Declared model");
    for line in input.declared {
        paragraph(out, "", line);
    }
    if !input.residual.is_empty() {
        let unit = &input.layout.unit;
        paragraph(out, "", &format!("Residual: {}, in {unit}.", input.residual));
    }
    if input.parameters.is_empty() {
        paragraph(out, "quiet", "The declared model has no free parameter.");
        return;
    }
    table(
        out,
        "Solved parameters of the declared model, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
        &[
            ("parameter", Kind::Name),
            ("value", Kind::Number),
            ("±", Kind::Number),
            ("unit", Kind::Unit),
        ],
        input.parameters.iter().take(MOST_PARAMETERS).map(parameter),
    );
    rest(out, input.parameters.len());
}

fn parameter(row: &ParameterRow) -> Vec<Cell> {
    let (value, expanded) = with_expanded(row.value, row.std.unwrap_or(f64::NAN));
    vec![
        Cell::new(&row.name),
        Cell::number(value, row.value),
        Cell::number(expanded, row.std.unwrap_or(f64::NAN)),
        Cell::new(&row.unit),
    ]
}

/// Says how many parameters the table leaves out.
pub(super) fn rest(out: &mut Markup, parameters: usize) {
    if parameters > MOST_PARAMETERS {
        let more = count(parameters - MOST_PARAMETERS);
        paragraph(out, "quiet", &format!("{more} more are in the JSON result."));
    }
}

/// What the accepted effects do to the solved parameters.
pub(super) fn shifted(out: &mut Markup, parameters: &[ParameterRow]) {
    let shifted = parameters.iter().filter_map(|p| p.after.map(|after| (p, after)));
    let rows: Vec<_> = shifted.take(MOST_PARAMETERS).map(shifted_row).collect();
    if rows.is_empty() {
        return;
    }
    table(
        out,
        "What this does to the solved parameters, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
        &[
            ("parameter", Kind::Name),
            ("declared model", Kind::Number),
            ("±", Kind::Number),
            ("with the added effects", Kind::Number),
            ("±", Kind::Number),
            ("unit", Kind::Unit),
        ],
        rows,
    );
    rest(out, parameters.len());
}

fn shifted_row((row, (after, std)): (&ParameterRow, (f64, f64))) -> Vec<Cell> {
    let std_before = row.std.unwrap_or(f64::NAN);
    let (before, expanded_before) = with_expanded(row.value, std_before);
    let (shown, expanded) = with_expanded(after, std);
    vec![
        Cell::new(&row.name),
        Cell::number(before, row.value),
        Cell::number(expanded_before, std_before),
        Cell::number(shown, after),
        Cell::number(expanded, std),
        Cell::new(&row.unit),
    ]
}
