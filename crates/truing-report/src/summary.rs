//! The line of a case in a table over many.

use model_discrepancy::HoldOut;
use serde::{Deserialize, Serialize};

use super::error_rms::Rms;
use super::input::{Published, Story};
use super::reading::rms;
use super::section::{Context, INPUT_WRONG, verdict_words};

/// One case in one line: carried inside its page, shown in an index.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the case.
    pub title: String,
    /// Kind of the case.
    pub kind: String,
    /// Where the data come from.
    pub source: Option<String>,
    /// Unit of `before` and `after`.
    pub unit: String,
    /// The declared model, on the input as it is.
    pub before: Rms,
    /// The model with every accepted effect; `None` where the loop was not closed.
    pub after: Option<Rms>,
    /// How the error on unseen data was obtained; `None` where it was not.
    pub hold_out: Option<String>,
    /// Mistakes in the input and effects added, with those that explain the data as well.
    pub added: Vec<Vec<String>>,
    /// The verdict in words.
    pub verdict: Option<String>,
    /// Figure printed in the source.
    pub published: Option<Published>,
    /// What is asked of the data, and known of them from elsewhere.
    #[serde(default)]
    pub story: Option<Story>,
    /// Whether the data come from a simulation.
    #[serde(default)]
    pub simulated: bool,
}

impl Summary {
    pub(crate) fn of(context: &Context) -> Self {
        let input = context.input;
        let closure = context.closure;
        let solved = Rms {
            train: rms(&context.before).map(|v| v / context.shown.factor),
            held_out: None,
            held_out_std: None,
        };
        let mistakes = input.mistakes.iter().map(|mistake| mistake.names.clone());
        let verdict = closure.map(|c| verdict_words(c.verdict).to_string());
        let is_wrong = !input.mistakes.is_empty();
        let added = closure.into_iter().flat_map(|c| &c.steps).map(|step| {
            let own = super::section::step_name(step);
            [vec![own], step.indistinguishable_from.clone()].concat()
        });
        Self {
            title: input.title.to_string(),
            kind: input.kind.to_string(),
            source: input.source.map(str::to_string),
            unit: input.layout.unit.clone(),
            before: input.as_read.unwrap_or(closure.map_or(solved, |c| Rms::from(&c.before))),
            after: closure.map(|c| Rms::from(&c.after)),
            hold_out: closure.map(|c| hold_out_words(c.after.hold_out).to_string()),
            added: mistakes.chain(added).collect(),
            verdict: if is_wrong { Some(INPUT_WRONG.to_string()) } else { verdict },
            published: input.published.cloned(),
            story: input.story.cloned(),
            simulated: input.simulated,
        }
    }
}

fn hold_out_words(hold_out: HoldOut) -> &'static str {
    match hold_out {
        HoldOut::CheckGroups => "groups set aside",
        HoldOut::Nested => "left out in turn, choice repeated",
        HoldOut::LeaveOneOut => "left out in turn",
    }
}
