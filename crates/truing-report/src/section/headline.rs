//! The headline: error before and after on data the fit never saw.

use model_discrepancy::{Closure, ErrorSummary, HoldOut, Role};

use super::verdict::change;
use super::{Context, HALF, NARROW, paragraph};
use crate::data_table::{DataTable, Datum};
use crate::interval::{IntervalChart, IntervalRow};
use crate::markup::Markup;
use crate::number::{COVERAGE, counted, plural, significant, with_expanded};

pub(crate) fn headline(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "Error on data the fit never saw");
    let chart = chart(context, closure);
    // Side by side where there is room, so that the pictures begin on the first screen.
    out.open("div", &[("class", &"pair")]);
    out.open("div", &[]);
    big_numbers(out, context, closure);
    paragraph(out, "", &how_held_out(context, closure.after.hold_out));
    link(out, context, &chart);
    out.close("div");
    out.open("figure", &[]);
    out.append(&chart.draw(HALF, "plot wide"));
    out.append(&chart.draw(NARROW, "plot narrow"));
    out.element("figcaption", &[], "Filled: on data the fit never saw, the bar is ± its expanded \
        uncertainty (k\u{a0}=\u{a0}2) from its spread over groups. Open: on the data fitted. Root mean \
        square per observation.");
    out.close("figure");
    out.close("div");
    published(out, context);
}

/// The numbers of the chart.
fn link(out: &mut Markup, context: &Context, chart: &IntervalChart) {
    let expanded = "expanded uncertainty (k = 2)";
    let columns = ["on unseen data", expanded, "on data fitted"];
    let titles = columns.map(|quantity| context.shown.title(quantity));
    let mut data = DataTable::new(["model".to_owned()].into_iter().chain(titles));
    for row in &chart.rows {
        let numbers = [row.held_out, row.expanded, row.fitted].map(Datum::from);
        data.push([Datum::from(row.name.as_str())].into_iter().chain(numbers));
    }
    data.link(out, "error on data the fit never saw");
}

fn big_numbers(out: &mut Markup, context: &Context, closure: &Closure) {
    out.open("div", &[("class", &"headline")]);
    big_number(out, context, "declared model", &closure.before, "was");
    if context.is_extended() {
        out.element("span", &[("class", &"to"), ("aria-hidden", &"true")], "→");
        big_number(out, context, "with the added effects", &closure.after, "is");
        let change = change(closure.before.held_out_rms, closure.after.held_out_rms);
        out.element("span", &[("class", &"change")], &change);
    } else {
        out.element("span", &[("class", &"change quiet")], "nothing was added");
    }
    out.close("div");
}

fn big_number(out: &mut Markup, context: &Context, name: &str, error: &ErrorSummary, class: &str) {
    let (value, expanded) =
        with_expanded(context.show(error.held_out_rms), context.show(error.held_out_std));
    out.open("div", &[("class", &format!("figure {class}"))]);
    out.element("span", &[("class", &"label")], name);
    out.element("span", &[("class", &"value")], &value);
    let spread = format!("± {expanded} {}", context.shown.unit);
    out.element("span", &[("class", &"spread")], &spread);
    out.close("div");
}

/// How the error on unseen data was obtained.
fn how_held_out(context: &Context, hold_out: HoldOut) -> String {
    let noun = context.input.group_noun;
    let all = plural(noun);
    match hold_out {
        HoldOut::CheckGroups => format!(
            "Judged on {} set aside by the user: used neither for fitting nor for choosing.",
            counted(context.group_count(Role::Check), noun)
        ),
        HoldOut::Nested => format!(
            "The {all} were left out in turn; fit and choice of effects were repeated without \
             those on which the error was then judged."
        ),
        HoldOut::LeaveOneOut => format!(
            "The {all} were left out in turn. With {} there are too few to repeat the choice of \
             effects without each: the choice has seen all of them, so the error after is on the \
             low side.",
            counted(context.group_count(Role::Fit), noun)
        ),
    }
}

fn chart(context: &Context, closure: &Closure) -> IntervalChart {
    let row = |name: &str, error: &ErrorSummary, colour| IntervalRow {
        name: name.to_string(),
        held_out: context.show(error.held_out_rms),
        expanded: COVERAGE * context.show(error.held_out_std),
        fitted: context.show(error.train_rms),
        colour,
    };
    let mut rows = vec![row("declared model", &closure.before, 0)];
    if context.is_extended() {
        rows.push(row("with the added effects", &closure.after, 2));
    }
    let shown = |v: f64| significant(context.show(v), 3);
    let published = context.input.published;
    IntervalChart {
        rows,
        title: context.shown.title("error"),
        reference: published
            .and_then(|p| p.rms.filter(|v| v.is_finite() && *v >= 0.0))
            .map(|rms| (context.show(rms), format!("published: {}", shown(rms)))),
        alternative: format!(
            "Error on unseen data: {} before, {} after, {}",
            shown(closure.before.held_out_rms),
            shown(closure.after.held_out_rms),
            context.shown.unit
        ),
    }
}

fn published(out: &mut Markup, context: &Context) {
    let Some(published) = context.input.published else {
        return;
    };
    out.open("p", &[("class", &"published")]);
    out.text("Published: ");
    out.name(&published.text);
    out.text(" (");
    out.name(&published.source);
    out.text(").");
    out.close("p");
}
