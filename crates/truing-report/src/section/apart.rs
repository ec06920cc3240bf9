//! What these data cannot tell apart, and which measurement would.

use model_discrepancy::{Closure, Step};
use nalgebra::DMatrix;

use super::added::step_name;
use super::{Context, for_both, paragraph};
use crate::data_table::{DataTable, Datum};
use crate::heatmap::Heatmap;
use crate::markup::Markup;
use crate::number::{count, fixed};

/// Candidates in the picture; the most confusable are kept.
const MOST_CANDIDATES: usize = 22;

pub(crate) fn apart(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "What cannot be told apart, and which measurement would");
    let classes: Vec<&Step> =
        closure.steps.iter().filter(|s| !s.indistinguishable_from.is_empty()).collect();
    if classes.is_empty() {
        let text = if closure.steps.is_empty() {
            "Nothing was added, so there is no name to be unsure of."
        } else {
            "What was added has no rival: no other candidate explains these data as well."
        };
        paragraph(out, "", text);
    }
    for step in classes {
        one_class(out, step);
    }
    picture(out, closure);
}

fn one_class(out: &mut Markup, step: &Step) {
    out.open("div", &[("class", &"rivals")]);
    out.open("p", &[]);
    out.open("strong", &[]);
    out.name(&step_name(step));
    out.close("strong");
    for rival in &step.indistinguishable_from {
        out.text(" · ");
        out.open("strong", &[]);
        out.name(rival);
        out.close("strong");
    }
    out.close("p");
    out.open("p", &[]);
    match &step.separate_by {
        Some(text) => {
            out.text("To tell them apart: ");
            out.named_prose(text);
            if !text.ends_with('.') {
                out.text(".");
            }
        }
        None => out.text("No further measurement known to this kind of case would split them."),
    }
    out.close("p");
    out.close("div");
}

fn picture(out: &mut Markup, closure: &Closure) {
    let ids = &closure.confusable_ids;
    let matrix = &closure.confusability;
    let n = ids.len();
    if n < 2 || matrix.nrows() != n || matrix.ncols() != n {
        paragraph(out, "quiet", "With fewer than two candidates there is nothing to confuse.");
        return;
    }
    let chosen = most_confusable(matrix);
    let rows: Vec<Vec<f64>> =
        chosen.iter().map(|i| chosen.iter().map(|j| matrix[(*i, *j)].abs()).collect()).collect();
    let heatmap = Heatmap {
        names: chosen.iter().map(|i| ids[*i].clone()).collect(),
        alternative: alternative(ids, matrix),
        rows,
    };
    out.element("h3", &[], "How alike the candidates look to this design");
    out.open("figure", &[]);
    for_both(out, |width, class| heatmap.draw(width, class));
    let mut caption = vec![
        "|cos| of the angle between what two candidates leave in the residual: 0 cannot be \
         mistaken, 1 look the same. The angle says how large an effect must be to be told apart; \
         whether it was, the data decide."
            .to_string(),
    ];
    if chosen.len() < n {
        let all = count(n);
        caption.push(format!("The {} most easily confused of {all} are drawn.", chosen.len()));
    }
    out.element("figcaption", &[], &caption.join(" "));
    out.close("figure");
    let names = || chosen.iter().map(|i| ids[*i].as_str());
    let mut data = DataTable::new(["candidate"].into_iter().chain(names()));
    for (name, row) in names().zip(heatmap.rows) {
        data.push([Datum::from(name)].into_iter().chain(row.into_iter().map(Datum::from)));
    }
    data.link(out, "how alike the candidates look");
}

/// Indices of those with the nearest neighbours, in the order given.
fn most_confusable(matrix: &DMatrix<f64>) -> Vec<usize> {
    let nearest = |i: usize| {
        let others = (0..matrix.ncols()).filter(|j| *j != i).map(|j| matrix[(i, j)].abs());
        others.filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let mut order: Vec<usize> = (0..matrix.nrows()).collect();
    order.sort_by(|a, b| nearest(*b).total_cmp(&nearest(*a)));
    order.truncate(MOST_CANDIDATES);
    order.sort_unstable();
    order
}

fn alternative(ids: &[String], matrix: &DMatrix<f64>) -> String {
    let pairs = (0..ids.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let finite = pairs.filter(|p| matrix[*p].is_finite());
    match finite.max_by(|a, b| matrix[*a].abs().total_cmp(&matrix[*b].abs())) {
        Some((i, j)) => format!(
            "Similarity of {} candidates; most alike: {} and {}, {}",
            ids.len(),
            ids[j],
            ids[i],
            fixed(matrix[(i, j)].abs(), 3)
        ),
        None => format!("Similarity of {} candidates", ids.len()),
    }
}
