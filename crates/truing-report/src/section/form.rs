//! The form of a test.

use super::{Cell, Context, Kind, facts, paragraph, table};
use crate::form::FormResult;
use crate::markup::Markup;
use crate::number::{NONE, percent, trimmed, with_expanded};

/// What stands where nothing is declared: a form hides no empty field.
const NOT_DECLARED: &str = "not declared";

pub(crate) fn form(out: &mut Markup, context: &Context) {
    let Some(form) = context.input.form else { return };
    out.element("h2", &[], &form.title);
    out.open("div", &[("class", &"form")]);
    let declared = |(name, value): &(String, Option<String>)| {
        (name.clone(), value.clone().unwrap_or_else(|| NOT_DECLARED.to_owned()))
    };
    let header = form.header.iter().map(declared);
    let conditions = form.conditions.iter().map(|f| (f.name.clone(), f.value.clone()));
    facts(out, header.chain(conditions));
    results(out, "Results, ± expanded uncertainty (k\u{a0}=\u{a0}2)", &form.results);
    if !form.compensated.is_empty() {
        let caption = "The same with the named effects taken off: what would be left if they were compensated";
        results(out, caption, &form.compensated);
    }
    for note in &form.notes {
        paragraph(out, "quiet", note);
    }
    if let Some(rule) = &form.rule {
        out.element("h3", &[], "Decision rule");
        paragraph(out, "", rule);
    }
    out.close("div");
}

fn results(out: &mut Markup, caption: &str, results: &[FormResult]) {
    let mut columns = vec![
        ("symbol", Kind::Name),
        ("quantity", Kind::Words),
        ("value", Kind::Number),
        ("±", Kind::Number),
        ("unit", Kind::Unit),
    ];
    let is_judged = results.iter().any(|result| result.limit.is_some());
    if is_judged {
        columns.extend([
            ("limit", Kind::Number),
            ("within it", Kind::Number),
            ("decision", Kind::Unit),
        ]);
    }
    let rows = results.iter().map(|result| row(result, is_judged));
    table(out, caption, &columns, rows);
}

fn row(result: &FormResult, is_judged: bool) -> Vec<Cell> {
    let (value, std) = (result.value.unwrap_or(f64::NAN), result.std.unwrap_or(f64::NAN));
    let (shown, expanded) = with_expanded(value, std);
    let mut cells = vec![
        Cell::new(&result.symbol),
        Cell::new(&result.name),
        Cell::number(shown, value),
        Cell::number(expanded, std),
        Cell::new(&result.unit),
    ];
    match &result.limit {
        Some(held) => cells.extend([
            Cell::number(trimmed(held.limit, 6), held.limit),
            held.probability.map_or_else(|| Cell::new(NONE), |p| Cell::number(percent(p), p)),
            Cell::new(held.decision),
        ]),
        None if is_judged => cells.extend([NONE; 3].map(Cell::new)),
        None => {}
    }
    cells
}
