use serde::Serialize;

use super::hypothesis::{Hypothesis, Proof};
use super::search::{Found, Misfit, Plain, search};
use crate::case::{Edit, Files};
use crate::kinds::Fitted;
use crate::{Case, Error};

/// Mistakes named in one case at most: what needs more was not one case.
const MOST_MISTAKES: usize = 3;
/// Physics loses to a mistake that is like it in size only where it leaves this much more.
const PHYSICS_LEAVES: f64 = 1.5;
/// It loses to one that it could only imitate by amplitudes of the size of the thing itself where
/// it leaves as much: the mistake has no free parameter.
const PHYSICS_IMITATES: f64 = 0.9;
/// Mistakes that may be as small as physics.
const MILD: [&str; 4] = ["input:clock", "input:row-shift", "input:labels", "input:saturation"];
/// Rivals of one sort told in the description; all of them are in `indistinguishable_from`.
const MOST_TOLD: usize = 3;

/// A mistake in the input that the data bear out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suspect {
    /// Id, `input:…`.
    pub effect: String,
    /// File and column.
    pub subject: String,
    /// What to change.
    pub description: String,
    /// Misfit of the case as it stands; `None` where it cannot be fitted.
    pub rms_before: Option<f64>,
    /// Misfit with the change; `None` where the data do not tell what they should have been.
    pub rms_after: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// Chance of such a gain with no mistake.
    pub p_value: f64,
    /// Other mistakes that would explain the data as well.
    pub indistinguishable_from: Vec<String>,
}

/// A case with what is wrong with its input.
#[derive(Debug, Default)]
pub(crate) struct Examined {
    pub(crate) suspects: Vec<Suspect>,
    /// The case as it would be with every mistake mended that can be; `None` where none can.
    pub(crate) corrected: Option<Case>,
}

/// Looks for mistakes in the input of a case that can be fitted.
pub(crate) fn examine(case: &Case, fitted: &Fitted) -> Result<Examined, Error> {
    let mut examined = Examined::default();
    let mut edits: Vec<Edit> = Vec::new();
    while examined.suspects.len() < MOST_MISTAKES {
        let current = examined.corrected.as_ref().unwrap_or(case);
        let refitted = examined.corrected.as_ref().map(|c| c.measured.fit()).transpose()?;
        let fitted = refitted.as_ref().unwrap_or(fitted);
        let (misfit, yardstick) = Misfit::of(&*current.measured, fitted);
        let plain = Plain { misfit, yardstick, fitted };
        if !plain.is_suspicious() {
            break;
        }
        let found = search(&current.files, Some(&plain));
        let found = match found {
            Some(found) if found.is_subtle && !beats_physics(current, &found) => None,
            found => found,
        };
        let Some(found) = found.or_else(|| unmatched(current, &plain)) else { break };
        examined.suspects.push(Suspect::of(&found, Some(&misfit)));
        if found.named.edits.is_empty() {
            break;
        }
        edits.extend(found.named.edits);
        examined.corrected = Some(case.with(&edits)?);
    }
    Ok(examined)
}

/// The error of a case that cannot be fitted, with the mistake that would explain it.
pub(crate) fn named_cause(files: &Files, source: Error) -> Error {
    // What is wrong in form, and what too few data leave free, says so itself.
    if matches!(source, Error::Case { .. }) || source.is_undetermined() && !source.is_unsettled() {
        return source;
    }
    match search(files, None) {
        Some(found) => {
            let suspect = Suspect::of(&found, None);
            Error::Input { source: Box::new(source), suspect: Box::new(suspect) }
        }
        None => source,
    }
}

/// Tables whose numbers have nothing to do with each other, whatever the reason.
fn unmatched(case: &Case, plain: &Plain<'_>) -> Option<Found> {
    if plain.misfit.share < plain.yardstick.unmatched || physics_explains(case) {
        return None;
    }
    let description = format!(
        "what is left is {:.0} % of what was measured, and no single change to a column explains \
         it: the tables do not belong together; look for a table from another session, labels or \
         rows in another order, columns exchanged in more than one place, or units mixed",
        100.0 * plain.misfit.share
    );
    let named = Hypothesis {
        effect: "input:unmatched",
        subject: case.files.kind.name.to_owned(),
        description,
        edits: Vec::new(),
        proof: Proof::Data,
    };
    Some(Found { named, after: None, rivals: Vec::new(), is_subtle: false })
}

/// Share of a misfit that physics leaves at most where it explains it.
const EXPLAINED: f64 = 0.5;

/// Whether the loop's physics takes most of the misfit: of tables that do not belong together it
/// takes little.
fn physics_explains(case: &Case) -> bool {
    by_physics(case).is_some_and(|[before, after]| after <= EXPLAINED * before)
}

/// Error of the fitted observations without and with what the loop adds; `None` where it cannot be
/// closed.
fn by_physics(case: &Case) -> Option<[f64; 2]> {
    let prepared = case.measured.prepare().ok()?;
    let options = case.loop_settings.options();
    let closed =
        model_discrepancy::close_loop(&*prepared.model, &prepared.covariates, &options).ok()?;
    Some([closed.before.train_rms, closed.after.train_rms])
}

/// Whether the loop's physics leaves clearly more than the mistake mended does.
fn beats_physics(case: &Case, found: &Found) -> bool {
    let left = |case: &Case| by_physics(case).map(|[_, after]| after);
    let Some(mended) = case.with(&found.named.edits).ok().and_then(|mended| left(&mended)) else {
        return false;
    };
    let is_mild = MILD.contains(&found.named.effect);
    let share = if is_mild { PHYSICS_LEAVES } else { PHYSICS_IMITATES };
    left(case).is_none_or(|physics| physics >= share * mended)
}

/// The first rival of every other sort, and where there is none, the first ones.
fn told<'r>(named: &Hypothesis, rivals: &'r [Hypothesis]) -> Vec<&'r str> {
    let is_first = |i: usize| {
        let effect = rivals[i].effect;
        effect != named.effect && rivals[..i].iter().all(|r| r.effect != effect)
    };
    let mut told: Vec<&Hypothesis> =
        (0..rivals.len()).filter(|&i| is_first(i)).map(|i| &rivals[i]).collect();
    if told.is_empty() {
        told.extend(rivals.iter().take(MOST_TOLD));
    }
    told.iter().map(|r| r.description.as_str()).collect()
}

impl Suspect {
    fn of(found: &Found, before: Option<&Misfit>) -> Self {
        let Found { named, after, rivals, .. } = found;
        let mut description = named.description.clone();
        if !rivals.is_empty() {
            let told = told(named, rivals);
            description = format!("{description}; or as likely: {}", told.join("; or: "));
            if rivals.len() > told.len() {
                description = format!("{description}; and {} more", rivals.len() - told.len());
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let p_value = (before.zip(after.as_ref()))
            .map_or(0.0, |(before, after)| (after.share / before.share).powf(after.dof as f64));
        Self {
            effect: named.effect.to_owned(),
            subject: named.subject.clone(),
            description,
            rms_before: before.map(|m| m.rms),
            rms_after: after.map(|m| m.rms),
            unit: before.or(after.as_ref()).map_or("", |m| m.unit),
            p_value,
            indistinguishable_from: rivals.iter().map(Hypothesis::label).collect(),
        }
    }

    /// What to change, as a warning.
    pub(crate) fn warning(&self) -> String {
        let gain = match (self.rms_before, self.rms_after) {
            (Some(before), Some(after)) if after > 0.0 => format!(
                " (misfit {:.3e} {unit}, with that change {:.3e} {unit}: {:.0} times less)",
                before,
                after,
                before / after,
                unit = self.unit
            ),
            _ => String::new(),
        };
        format!("the input looks wrong: {}{gain}", self.description)
    }
}
