//! Error before, after each added effect, and after all of them.

use model_discrepancy::{ErrorSummary, HoldOut};

use super::added::step_name;
use super::verdict::hold_out_short;
use super::{Cell, Context, Kind, paragraph, table};
use crate::markup::Markup;
use crate::number::{COVERAGE, NONE, significant, with_expanded};

pub(crate) fn error_path(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "Error, step by step");
    let mut rows = vec![summary_row(context, "declared model", &closure.before)];
    for step in &closure.steps {
        rows.push(vec![
            Cell::new(format!("+ {}", step_name(step))),
            error(context, step.train_rms),
            error(context, step.held_out_rms),
            Cell::new(NONE),
            Cell::new("groups left out in turn"),
            Cell::new(NONE),
        ]);
    }
    if context.is_extended() {
        rows.push(summary_row(context, "final model", &closure.after));
    }
    let unit = &context.shown.unit;
    let caption = format!("Root mean square residual per observation, {unit}");
    let columns = [
        ("model", Kind::Name),
        ("on data fitted", Kind::Number),
        ("on unseen data", Kind::Number),
        ("± (k\u{a0}=\u{a0}2)", Kind::Number),
        ("unseen data", Kind::Words),
        ("χ² per dof", Kind::Number),
    ];
    table(out, &caption, &columns, rows);
    if closure.before.hold_out == HoldOut::CheckGroups && !closure.steps.is_empty() {
        paragraph(
            out,
            "quiet",
            "The effects were chosen by leaving groups out in turn, the final judgement is on \
             the groups set aside: the two columns of numbers are not comparable line by line.",
        );
    }
}

fn summary_row(context: &Context, name: &str, summary: &ErrorSummary) -> Vec<Cell> {
    let std = context.show(summary.held_out_std);
    let (held_out, expanded) = with_expanded(context.show(summary.held_out_rms), std);
    let chi2 = summary.chi2_per_dof;
    vec![
        Cell::new(name),
        error(context, summary.train_rms),
        Cell::number(held_out, summary.held_out_rms),
        Cell::number(expanded, COVERAGE * std),
        Cell::new(hold_out_short(context, summary.hold_out)),
        Cell::number(
            chi2.map_or(NONE.to_string(), |v| significant(v, 3)),
            chi2.unwrap_or(f64::NAN),
        ),
    ]
}

fn error(context: &Context, value: f64) -> Cell {
    Cell::number(significant(context.show(value), 3), value)
}
