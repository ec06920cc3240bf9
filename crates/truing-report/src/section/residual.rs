//! The residual before and after, on one scale.

use super::covariates::{covariate_figures, drawn};
use super::order::order_figure;
use super::residual_data::residual_data;
use super::residual_table::residual_table;
use super::{Context, paragraph};
use crate::axis::Range;
use crate::markup::Markup;
use crate::number::{count, significant};
use crate::reading::Reading;

/// A residual that fell by more than this is also shown on a scale of its own.
const FLATTENED: f64 = 4.0;

pub(crate) fn residual_before(out: &mut Markup, context: &Context) {
    out.element("h2", &[], "Residual of the declared model");
    figures(out, context, &context.before, "declared model");
    if context.undrawable > 0 {
        let n = count(context.undrawable);
        paragraph(out, "quiet", &format!("{n} residuals are not numbers and are not drawn."));
    }
    residual_table(out, context);
}

pub(crate) fn residual_after(out: &mut Markup, context: &Context) {
    if context.closure.is_none() {
        return;
    }
    out.element("h2", &[], "Residual with the added effects");
    if !context.is_extended() {
        let text = "Nothing was added: the residual is the one above.";
        paragraph(out, "quiet", text);
        return;
    }
    paragraph(out, "", "On the same scale as before.");
    figures(out, context, &context.after, "with the added effects");
    enlarged(out, context);
}

fn figures(out: &mut Markup, context: &Context, readings: &[Reading], model: &str) {
    if readings.is_empty() {
        paragraph(out, "quiet", "There is no residual to draw.");
        return;
    }
    order_figure(out, context, readings, context.range, model);
    covariate_figures(out, context, readings, context.range, model);
    let data = residual_data(context, readings, &drawn(context));
    data.link(out, &format!("residual {model}"));
}

/// What is left on a scale of its own, where the common one flattens it.
fn enlarged(out: &mut Markup, context: &Context) {
    let values = context.after.iter().map(|r| r.value);
    let Some(range) = Range::of(values.chain([0.0])).map(|r| r.padded(0.06)) else {
        return;
    };
    let factor = context.range.span() / range.span();
    if factor < FLATTENED {
        return;
    }
    out.open("details", &[]);
    let title = format!("The same enlarged {}×", significant(factor, 2));
    out.element("summary", &[], &title);
    let model = "with the added effects, enlarged";
    order_figure(out, context, &context.after, range, model);
    covariate_figures(out, context, &context.after, range, model);
    out.close("details");
}
