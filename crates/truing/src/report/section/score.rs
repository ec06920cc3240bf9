//! How every candidate scored.

use model_discrepancy::{Closure, HoldOut, Outcome, Pass, Score};

use super::{Cell, Context, Kind, for_both, paragraph, table};
use crate::report::markup::Markup;
use crate::report::number::{count, counted, p_value, percent, significant};
use crate::report::score_chart::{ScoreChart, ScoreRow, bar_sign};

/// Candidates drawn in a chart.
const MOST_BARS: usize = 14;
/// Candidates in a table.
const MOST_ROWS: usize = 40;

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
         data falls; then all others are judged again.",
    );
    for (i, pass) in closure.passes.iter().enumerate() {
        if !pass.scores.is_empty() {
            one_pass(out, context, closure, i, pass);
        }
    }
}

fn one_pass(out: &mut Markup, context: &Context, closure: &Closure, index: usize, pass: &Pass) {
    out.element("h3", &[], &heading(index, pass));
    let chart = chart(context, closure, index, pass);
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
    score_table(out, context, index, pass);
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

fn heading(index: usize, pass: &Pass) -> String {
    let added = pass.scores.iter().find(|s| s.outcome == Outcome::Added);
    match added {
        Some(score) => format!("Pass {}: {} added", index + 1, score.label),
        None => format!("Pass {}: nothing added", index + 1),
    }
}

fn chart(context: &Context, closure: &Closure, index: usize, pass: &Pass) -> ScoreChart {
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
        without: without(closure, index).map(|rms| context.show(rms)),
        error_title: context.shown.title("error on unseen data if added"),
        alternative: format!(
            "Scores of {} in pass {}{}; the table below has the numbers",
            counted(pass.scores.len(), "candidate"),
            index + 1,
            best.unwrap_or_default()
        ),
    }
}

/// Error with groups left out in turn before this pass, where the closure holds it.
fn without(closure: &Closure, pass: usize) -> Option<f64> {
    match pass.checked_sub(1) {
        Some(step) => closure.steps.get(step).map(|s| s.held_out_rms),
        // On check groups the error is not comparable with groups left out in turn.
        None if closure.before.hold_out == HoldOut::CheckGroups => None,
        None => Some(closure.before.held_out_rms),
    }
    .filter(|rms| rms.is_finite())
}

fn score_table(out: &mut Markup, context: &Context, index: usize, pass: &Pass) {
    let held_out = context.shown.title("unseen error if added");
    let detectable = context.shown.title("detectable from");
    let caption = format!("Scores in pass {}", index + 1);
    let columns = [
        ("candidate", Kind::Name),
        ("outcome", Kind::Words),
        ("p", Kind::Number),
        ("F", Kind::Number),
        (held_out.as_str(), Kind::Number),
        ("absorbed by the model", Kind::Number),
        (detectable.as_str(), Kind::Number),
    ];
    let rows = pass.scores.iter().take(MOST_ROWS).map(|score| score_row(context, score));
    table(out, &caption, &columns, rows);
    paragraph(
        out,
        "quiet",
        "p before correction for the size of the catalogue. Absorbed: share of the effect that \
         the declared model takes up and so hides. Detectable from: smallest effect, as rms \
         residual, that would be found 9 times in 10.",
    );
    if pass.scores.len() > MOST_ROWS {
        let more = pass.scores.len() - MOST_ROWS;
        let text = format!("{} more scored lower and are not listed.", count(more));
        paragraph(out, "quiet", &text);
    }
}

fn score_row(context: &Context, score: &Score) -> Vec<Cell> {
    let error = |v: f64| Cell::number(significant(context.show(v), 3), v);
    vec![
        Cell::new(&score.label),
        Cell::new(outcome_words(score.outcome)),
        Cell::number(p_value(score.p_value), score.p_value),
        Cell::number(significant(score.f_statistic, 3), score.f_statistic),
        error(score.held_out_rms),
        Cell::number(percent(score.absorbed), score.absorbed),
        error(score.detectable_rms),
    ]
}

fn outcome_words(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Added => "added",
        Outcome::Rival => "as good as the one added",
        Outcome::Weaker => "another was better",
        Outcome::NotSignificant => "not significant",
        Outcome::DidNotGeneralise => "unseen error did not fall",
        Outcome::NotObservable => "cannot be seen",
    }
}

fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Added => "added",
        Outcome::Rival => "rival",
        Outcome::Weaker | Outcome::DidNotGeneralise => "weaker",
        Outcome::NotSignificant | Outcome::NotObservable => "small",
    }
}
