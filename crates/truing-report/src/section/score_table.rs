//! The scores of one pass in numbers.

use model_discrepancy::{Outcome, Pass, Score};

use super::{Cell, Context, Kind, paragraph, table};
use crate::markup::Markup;
use crate::number::{count, p_value, percent, significant};

/// Candidates that were not significant, shown at once.
const LEADING: usize = 6;
/// Candidates in a table.
const MOST_ROWS: usize = 60;

/// What was significant and the next best at once, the others folded away.
pub(super) fn score_table(out: &mut Markup, context: &Context, number: usize, pass: &Pass) {
    let notable = |s: &&Score| s.outcome != Outcome::NotSignificant;
    let (first, others) = if pass.scores.len() <= 2 * LEADING {
        (pass.scores.iter().collect(), Vec::new())
    } else {
        let mut quiet = 0;
        pass.scores.iter().partition::<Vec<&Score>, _>(|s| {
            quiet += usize::from(!notable(s));
            notable(s) || quiet <= LEADING
        })
    };
    rows(out, context, &format!("Scores in pass {number}"), &first);
    if others.is_empty() {
        return;
    }
    out.open("details", &[]);
    out.element("summary", &[], &format!("{} more that were not significant", count(others.len())));
    rows(out, context, &format!("Further scores in pass {number}"), &others);
    out.close("details");
}

fn rows(out: &mut Markup, context: &Context, caption: &str, scores: &[&Score]) {
    let held_out = context.shown.title("unseen error if added");
    let detectable = context.shown.title("detectable from");
    let columns = [
        ("candidate", Kind::Name),
        ("outcome", Kind::Words),
        ("p", Kind::Number),
        ("F", Kind::Number),
        (held_out.as_str(), Kind::Number),
        ("absorbed by the model", Kind::Number),
        (detectable.as_str(), Kind::Number),
    ];
    let shown = scores.iter().take(MOST_ROWS).map(|score| score_row(context, score));
    table(out, caption, &columns, shown);
    if scores.len() > MOST_ROWS {
        let more = count(scores.len() - MOST_ROWS);
        paragraph(out, "quiet", &format!("{more} more scored lower and are not listed."));
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
