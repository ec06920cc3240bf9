//! Effects that no measurement on offer tells from others.

use truing_report::shortened;

use super::design::{Design, Goal, HOPELESS};
use super::planned::PlanClass;
use super::question::{Ask, Question};

/// Share of the non-centrality with all measurements that is asked for where all are not enough.
const OF_ALL: f64 = 0.5;
/// Share of what all measurements show of an amplitude, squared, that a rival leaves of it where it holds
/// the effect as a part of itself: round-off and the curvature of a model over its own size.
const PART: f64 = 1e-4;

/// An effect and what no measurement tells it from at the size that matters.
pub(super) struct Inseparable {
    ask: usize,
    rival: String,
    /// Whether no size would help either: of an amplitude of the effect, the rival leaves nothing over all
    /// measurements.
    is_part: bool,
}

/// Pairs of an effect and what no measurement tells it from at the size that matters. A larger one
/// may be told: a share of what all measurements would show is asked for; where they show nothing,
/// the goal is taken out, and effect and rival are one answer. What no measurement shows of an effect
/// is not asked to be told from anything.
pub(super) fn taken_out(design: &Design, goals: &mut Vec<(usize, Goal)>) -> Vec<Inseparable> {
    let all = design.with_all();
    let mut pairs: Vec<Inseparable> = Vec::new();
    // What all measurements show of an amplitude beside the base and nothing else.
    let alone: Vec<(usize, Vec<usize>, f64)> = (goals.iter())
        .filter_map(|(ask, goal)| match goal {
            Goal::Seen { of, from: None, .. } => Some((*ask, of.clone(), design.value(goal, all))),
            _ => None,
        })
        .collect();
    goals.retain_mut(|(ask, goal)| {
        let most = design.value(goal, all);
        let Goal::Seen { of, from: Some(rival), needed, .. } = goal else { return true };
        if most >= *needed {
            return true;
        }
        let shown = alone.iter().find(|(a, columns, _)| a == ask && columns == of);
        let shown = shown.map_or(0.0, |(.., shown)| *shown);
        if shown <= HOPELESS {
            return false;
        }
        let is_part = most <= PART * shown;
        match pairs.iter_mut().find(|pair| pair.ask == *ask && pair.rival == *rival) {
            Some(pair) => pair.is_part |= is_part,
            None => pairs.push(Inseparable { ask: *ask, rival: rival.clone(), is_part }),
        }
        *needed = OF_ALL * most;
        !is_part && most > HOPELESS
    });
    pairs
}

/// For each effect asked for, the rivals of it among pairs that are parts, or are not.
fn by_effect<'a>(
    question: &'a Question,
    pairs: &'a [Inseparable],
    are_parts: bool,
) -> impl Iterator<Item = (&'a str, Vec<String>)> {
    question.asks.iter().enumerate().filter_map(move |(index, ask)| {
        let Ask::Visible { effect } = ask else { return None };
        let own = pairs.iter().filter(|pair| pair.ask == index && pair.is_part == are_parts);
        let rivals: Vec<String> = own.map(|pair| pair.rival.clone()).collect();
        (!rivals.is_empty()).then_some((effect.as_str(), rivals))
    })
}

/// Effects that no measurement of the offer tells from others at the size that matters, in words.
pub(super) fn not_told_apart(
    question: &Question,
    pairs: &[Inseparable],
    noun: &str,
) -> Vec<String> {
    let told = |(effect, rivals): (&str, Vec<String>)| {
        format!(
            "no {noun} that the machine is said to make tells {effect} from {} at the size from which \
             on it matters",
            shortened(&rivals)
        )
    };
    by_effect(question, pairs, false).map(told).collect()
}

/// Effects with the rivals that hold them as a part of themselves: one answer, however much is measured.
pub(super) fn classes(question: &Question, pairs: &[Inseparable]) -> Vec<PlanClass> {
    let class = |(effect, with): (&str, _)| PlanClass { effect: effect.to_owned(), with };
    by_effect(question, pairs, true).map(class).collect()
}
