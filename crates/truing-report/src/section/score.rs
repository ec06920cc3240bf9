//! How every candidate scored.

use model_discrepancy::{Closure, HoldOut, Outcome, Pass};

use super::added::step_name;
use super::score_table::score_table;
use super::{Context, for_both, paragraph};
use crate::data_table::DataTable;
use crate::markup::Markup;
use crate::number::{counted, p_value};
use crate::score_chart::{ScoreChart, ScoreRow, bar_sign};

/// Candidates drawn in a chart.
const MOST_BARS: usize = 12;

pub(crate) fn scores(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "How each candidate effect scored");
    if closure.passes.iter().all(|p| p.scores.is_empty()) {
        paragraph(out, "quiet", "There was no candidate to score.");
        return;
    }
    paragraph(
        out,
        "",
        "Each candidate is judged alone, beside what is already in the model. It is added when it \
         is significant after correction for the size of the catalogue and the error on unseen \
         data falls; then all others are judged again. Two that explain the data only together \
         may be added as a pair.",
    );
    paragraph(
        out,
        "quiet",
        "F: what the effect takes off the misfit per amplitude, over what is left per degree of \
         freedom; noise alone makes it about 1. p: how often noise alone makes F as large; the \
         smaller, the less it is chance. Threshold: p times the number of candidates that are \
         still open (Holm) has to stay below half of 0.05, below 0.01 once something was added. The \
         p shown is before this correction. Absorbed: share of the effect that the declared model \
         takes up and so hides. Detectable from: smallest effect, as rms residual, that the F \
         test alone would find 9 times in 10. Of effects that move one reading each, the \
         strongest and the significant ones are listed.",
    );
    let mut shown: Option<&Pass> = None;
    let mut number = 0;
    for (i, pass) in closure.passes.iter().enumerate() {
        // After a step that is no candidate of the catalogue the same scores may come again.
        let again = shown.is_some_and(|last| same(last, pass));
        if !pass.scores.is_empty() && !again {
            number += 1;
            one_pass(out, context, number, pass, without(closure, i));
            shown = Some(pass);
        }
    }
}

fn same(a: &Pass, b: &Pass) -> bool {
    let key = |pass: &Pass| -> Vec<(String, u64)> {
        pass.scores.iter().map(|s| (s.label.clone(), s.p_value.to_bits())).collect()
    };
    key(a) == key(b)
}

fn one_pass(out: &mut Markup, context: &Context, number: usize, pass: &Pass, without: Option<f64>) {
    out.element("h3", &[], &heading(number, pass));
    // A pass that added nothing is told by its table.
    if pass.scores.iter().any(|s| s.outcome == Outcome::Added) {
        let chart = chart(context, number, pass, without);
        figure(out, &chart, pass);
        chart_data(&chart).link(out, &format!("scores in pass {number}"));
    }
    score_table(out, context, number, pass);
}

fn figure(out: &mut Markup, chart: &ScoreChart, pass: &Pass) {
    out.open("figure", &[]);
    legend(out, pass);
    for_both(out, |width, class| chart.draw(width, class));
    let mut caption = vec![match chart.without {
        Some(_) => "Square: error on unseen data were it added; dashed line: without it.".into(),
        None => "Square: error on unseen data were it added.".to_string(),
    }];
    if pass.scores.len() > MOST_BARS {
        let all = counted(pass.scores.len(), "candidate");
        caption.push(format!("The best {MOST_BARS} of {all} are drawn."));
    }
    out.element("figcaption", &[], &caption.join(" "));
    out.close("figure");
}

fn chart_data(chart: &ScoreChart) -> DataTable {
    let mut data = DataTable::new(["candidate", "p", chart.error_title.as_str()]);
    for row in &chart.rows {
        data.push([row.name.as_str().into(), row.p_value.into(), row.held_out.into()]);
    }
    data
}

/// What the looks of bars mean: those that occur.
fn legend(out: &mut Markup, pass: &Pass) {
    out.open("p", &[("class", &"legend")]);
    for (look, words) in LOOKS {
        if pass.scores.iter().any(|s| class(s.outcome) == look) {
            out.open("span", &[("class", &"key")]);
            out.append(&bar_sign(look));
            out.text(words);
            out.close("span");
        }
    }
    out.close("p");
}

/// Looks of bars and what they mean.
const LOOKS: [(&str, &str); 4] = [
    ("added", "added"),
    ("rival", "as good as the one added"),
    ("weaker", "significant, not added"),
    ("small", "not significant"),
];

fn heading(number: usize, pass: &Pass) -> String {
    let added = added(pass);
    if added.is_empty() {
        format!("Pass {number}: nothing added")
    } else {
        format!("Pass {number}: {} added", added.join(" and "))
    }
}

/// Labels of what was added in a pass.
fn added(pass: &Pass) -> Vec<&str> {
    let added = pass.scores.iter().filter(|s| s.outcome == Outcome::Added);
    added.map(|s| s.label.as_str()).collect()
}

fn chart(context: &Context, number: usize, pass: &Pass, without: Option<f64>) -> ScoreChart {
    let rows = pass.scores.iter().take(MOST_BARS).map(|score| ScoreRow {
        name: score.label.clone(),
        p_value: if score.outcome == Outcome::NotObservable { f64::NAN } else { score.p_value },
        held_out: context.show(score.held_out_rms),
        class: class(score.outcome),
    });
    let best =
        pass.scores.first().map(|s| format!("; best: {}, p {}", s.label, p_value(s.p_value)));
    ScoreChart {
        rows: rows.collect(),
        without: without.map(|rms| context.show(rms)),
        error_title: context.shown.title("error on unseen data if added"),
        alternative: format!(
            "Scores of {} in pass {number}{}; the table below has the numbers",
            counted(pass.scores.len(), "candidate"),
            best.unwrap_or_default()
        ),
    }
}

/// Error with groups left out in turn before this pass, where the closure holds it.
fn without(closure: &Closure, pass: usize) -> Option<f64> {
    let earlier = &closure.passes[..pass];
    let labels: Vec<&str> = earlier.iter().flat_map(added).collect();
    let last_added = closure.steps.iter().rposition(|s| labels.contains(&step_name(s).as_str()));
    let rms = match last_added {
        Some(step) => {
            // Between passes that added nothing, covariates may have been added.
            let quiet = earlier.last().is_some_and(|p| added(p).is_empty());
            let after = closure.steps[step + 1..].iter();
            let covariates = after.take_while(|s| quiet && s.effect.starts_with("covariate:"));
            covariates.last().unwrap_or(&closure.steps[step]).held_out_rms
        }
        // On check groups the error is not comparable with groups left out in turn.
        None if pass > 0 || closure.before.hold_out == HoldOut::CheckGroups => return None,
        None => closure.before.held_out_rms,
    };
    Some(rms).filter(|rms| rms.is_finite())
}

fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Added => "added",
        Outcome::Rival => "rival",
        Outcome::Weaker | Outcome::DidNotGeneralise => "weaker",
        Outcome::NotSignificant | Outcome::NotObservable => "small",
    }
}
