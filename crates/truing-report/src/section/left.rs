//! What is left, and what the reader should be warned of.

use model_discrepancy::{Closure, Verdict};

use super::{Cell, Context, Kind, paragraph, table};
use crate::markup::Markup;
use crate::number::{p_value, significant};
use crate::unit::column_title;

pub(crate) fn left(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "What is left");
    paragraph(out, "", &conclusion(closure));
    if closure.remaining.is_empty() {
        return;
    }
    table(
        out,
        "Structure left in the residual",
        &[("in", Kind::Name), ("shape", Kind::Words), ("p", Kind::Number)],
        closure.remaining.iter().map(|r| {
            vec![
                Cell::new(column_title(&r.covariate)),
                Cell::new(&r.shape),
                Cell::number(p_value(r.p_value), r.p_value),
            ]
        }),
    );
    paragraph(out, "quiet", "p before correction for the number of columns and shapes tried.");
}

fn conclusion(closure: &Closure) -> String {
    let noise = closure.after.chi2_per_dof.map(|chi2| {
        format!(
            " Scatter is {}\u{a0}times the declared noise.",
            significant(chi2.max(0.0).sqrt(), 2)
        )
    });
    let sentence = match closure.verdict {
        Verdict::NothingMissing => "No structure was found in the residual of the declared model.",
        Verdict::Explained => "No structure was found in the residual of the final model.",
        Verdict::StructureRemains => {
            "The residual of the final model still has structure that no candidate explains."
        }
        Verdict::NoiseLargerThanDeclared => {
            "No structure was found, but the residual is larger than the declared noise allows."
        }
    };
    sentence.to_string() + &noise.unwrap_or_default()
}

pub(crate) fn warnings(out: &mut Markup, context: &Context) {
    let found = context.closure.map_or(&[][..], |c| c.warnings.as_slice());
    let mut all: Vec<&String> = Vec::new();
    for warning in context.input.warnings.iter().chain(found) {
        if !all.contains(&warning) {
            all.push(warning);
        }
    }
    out.element("h2", &[], "Warnings");
    if all.is_empty() {
        paragraph(out, "quiet", "None.");
        return;
    }
    out.open("ul", &[("class", &"warnings")]);
    for warning in all {
        out.open("li", &[]);
        out.named_prose(warning);
        out.close("li");
    }
    out.close("ul");
}
