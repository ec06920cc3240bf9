//! How often what was chosen is chosen again.

use std::ops::Range;

use rayon::prelude::*;

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::confounded::Attribution;
use crate::choice::candidate::{Candidate, Source};
use crate::choice::context::Context;
use crate::choice::select::{select, still_needed};
use crate::choice::selected::{Selected, What};
use crate::count::count;
use crate::levels::DECIDED;
use crate::model::moved::Moved;
use crate::noise::linear::Linear;

/// Repetitions with moved readings, and how many of them are enough where all find everything again:
/// the rest could not bring any share below one half.
const TIMES_MOVED: usize = 8;
const ENOUGH_ALIKE: usize = 4;

/// Per addition: share of the choices with every reading moved within its resolution that find it,
/// or a rival of it, again.
pub(crate) fn where_readings_move(
    context: &Context<'_>,
    keep: &[bool],
    (base, declared): (&Estimate, &Linear<'_>),
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    attributions: &[Option<Attribution<'_>>],
) -> Vec<Option<f64>> {
    if chosen.added.is_empty() {
        return Vec::new();
    }
    let rows = rows_of(&context.model.declared().layout, keep);
    let plain = System::declared(context.model);
    let both = [(&plain, declared), (&chosen.system, lin)];
    // A scatter that the data show is another one with other data.
    let linearised = if context.model.declared().between_variance { &[][..] } else { &both[..] };
    let progress = &context.options.progress;
    progress.expect(TIMES_MOVED);
    let repeated = |times: Range<usize>| -> Vec<Vec<What>> {
        let one = |times| {
            let moved = Moved::within_resolution(context.model, times);
            let context = Context { model: &moved, thorough: false, linearised, ..*context };
            let declared = System::declared(&moved).fit_anew(&rows, base).ok();
            let choice = declared.map(|declared| whats(select(&context, keep, &declared)));
            progress.done();
            choice
        };
        times.into_par_iter().filter_map(one).collect()
    };
    let mut choices = repeated(0..ENOUGH_ALIKE);
    let found = shares(chosen, attributions, &choices);
    let are_alike = choices.len() == ENOUGH_ALIKE && found.iter().all(|share| *share == Some(1.0));
    if are_alike {
        (ENOUGH_ALIKE..TIMES_MOVED).for_each(|_| progress.done());
        return found;
    }
    choices.extend(repeated(ENOUGH_ALIKE..TIMES_MOVED));
    shares(chosen, attributions, &choices)
}

/// What a repetition with fewer groups found of what was `chosen`: what it added, and where it added
/// nothing else, also what its groups need as much as anything that is to stay beside a rival. A level that
/// is kept with all groups is kept with fewer in half of the repetitions, however real what just reaches it.
pub(crate) fn found_again(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
    again: Selected<'_>,
) -> Vec<What> {
    let mut found = whats(again);
    let all: Vec<&What> = chosen.added.iter().map(|a| &a.what).collect();
    if found.len() >= all.len() || !found.iter().all(|what| all.contains(&what)) {
        return found;
    }
    let missed: Vec<usize> = (0..all.len()).filter(|&i| !found.contains(all[i])).collect();
    let still = |&i: &usize| still_needed(context, keep, chosen, i, DECIDED);
    found.extend(missed.into_iter().filter(still).map(|i| all[i].clone()));
    found
}

/// What was added.
fn whats(chosen: Selected<'_>) -> Vec<What> {
    chosen.added.into_iter().map(|a| a.what).collect()
}

/// Per addition: share of the choices that find it, or a rival of it, again; `None` of no choices.
pub(crate) fn shares(
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
    choices: &[Vec<What>],
) -> Vec<Option<f64>> {
    let share = |(added, attribution): (&What, &Option<Attribution<'_>>)| {
        let again = |choice: &&Vec<What>| {
            choice.iter().any(|again| agrees(again, added, attribution.as_ref()))
        };
        let found = choices.iter().filter(again).count();
        (!choices.is_empty()).then(|| count(found) / count(choices.len()))
    };
    chosen.added.iter().map(|a| &a.what).zip(attributions).map(share).collect()
}

/// Whether a repetition found the same effect, or one that counts as the same.
fn agrees(again: &What, added: &What, attribution: Option<&Attribution<'_>>) -> bool {
    let rival = |r: &Candidate| match (&r.source, again) {
        (Source::Effect(a), What::Effect(e)) => a.effect == *e,
        (Source::Empirical(a), What::Empirical(covariate, _)) => a.covariate == *covariate,
        _ => false,
    };
    let same = match (again, added) {
        (What::Empirical(a, _), What::Empirical(b, _)) => a == b,
        _ => again == added,
    };
    same || attribution.is_some_and(|a| a.confounded.iter().any(rival))
}
