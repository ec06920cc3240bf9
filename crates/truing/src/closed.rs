use std::sync::Arc;
use std::time::Instant;

use model_discrepancy::{
    Closure, ErrorSummary, HoldOut, NotObservable, Options, Remaining, Stability, Step, Verdict,
};
use serde::Serialize;
use truing_report::by_sign;

use crate::carry::{CarriedEffect, Matched, carrying, matched};
use crate::conformity::{LimitDecision, decisions};
use crate::estimated::LoopParameter;
use crate::estimates::{self, Estimates};
use crate::measured::{Fitted, Prepared};
use crate::monte_carlo::{MonteCarlo, monte_carlo_of_loop};
use crate::noise_test::{Repeats, scatter_warning};
use crate::odd_check;
use crate::plausible::plausible;
use crate::residual::Residual;
use crate::settled::{Settled, settled};
use crate::suspect::{Examined, Suspect, examine, named_cause};
use crate::{Case, Error, Header, IntervalWidth};

/// Answer of `truing loop`; serialises as its JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Closed {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// How long it took; `None` leaves it out of the JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<LoopTiming>,
    /// What was taken over from another case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried: Option<Carried>,
    /// Error of the declared model, with what was carried.
    pub before: JudgedRms,
    /// Error with the accepted effects in the model.
    pub after: JudgedRms,
    /// Accepted effects, in the order accepted.
    pub steps: Vec<LoopStep>,
    /// The conclusion: `nothing-missing`, `explained`, `structure-remains`,
    /// `noise-larger-than-declared` or `input-wrong`.
    pub verdict: &'static str,
    /// Structure left in the residual.
    pub remaining: Vec<LoopRemaining>,
    /// Residual of the fitted observations with the accepted effects in the model.
    pub residual: Residual,
    /// Whether repeats agree better with each other than with the final model; `None` where no
    /// place is visited again.
    pub lack_of_fit: Option<Repeats>,
    /// Effects that this design cannot see.
    pub not_observable: Vec<LoopNotObservable>,
    /// What was solved for, with the accepted effects in the model.
    #[serde(serialize_with = "estimates::serialize")]
    pub estimates: Arc<dyn Estimates>,
    /// What makes 95 % intervals of its standard uncertainties.
    pub interval: IntervalWidth,
    /// How the numbers scatter where the data are drawn anew; `None` where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monte_carlo: Option<MonteCarlo>,
    /// What is decided of the results that `[conformity] limits` names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conformity: Vec<LimitDecision>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
    /// Mistakes in the input; the first steps are about them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub suspects: Vec<Suspect>,
    /// Everything the engine found, for Rust.
    #[serde(skip)]
    pub closure: Closure,
    /// The case with its input corrected, where that was wrong, and with a check reading that is off by itself among
    /// those that are fitted.
    #[serde(skip)]
    pub(crate) corrected: Option<Arc<Case>>,
}

/// Effects that were learnt on another case and count as declared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Carried {
    /// File that they come from.
    pub from: String,
    /// The effects, of fixed size.
    pub effects: Vec<CarriedEffect>,
    /// Error of the declared model without them.
    pub without: JudgedRms,
    /// Error of the declared model with them: the same as `before`.
    pub with: JudgedRms,
}

/// Wall-clock times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopTiming {
    /// Reading the case.
    pub read_s: f64,
    /// Closing the loop on it.
    pub loop_s: f64,
}

/// Error of one model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedRms {
    /// Root mean square residual per observation on fitted groups.
    pub train_rms: f64,
    /// The same on groups that were left out.
    pub held_out_rms: f64,
    /// Standard error of `held_out_rms`.
    pub held_out_std: f64,
    /// Unit of the three.
    pub unit: String,
    /// `check-groups`, `nested` or `leave-one-out`.
    pub hold_out: &'static str,
    /// χ² over degrees of freedom, where the noise was declared.
    pub chi2_per_dof: Option<f64>,
    /// Where `chi2_per_dof` lies 999 times in 1000 where the noise is as declared.
    pub chi2_interval: Option<[f64; 2]>,
}

/// One accepted effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopStep {
    /// Catalogue id, or `covariate:<column>`.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people; with a single amplitude it follows its sign.
    pub description: String,
    /// Amplitudes of the final model.
    pub parameters: Vec<LoopParameter>,
    /// Significance when it was accepted, before correction for the number of candidates.
    pub p_value: f64,
    /// Error on groups left out once this effect is in the model.
    pub held_out_rms: f64,
    /// Error on fitted groups once this effect is in the model.
    pub train_rms: f64,
    /// Other effects that explain the data as well.
    pub indistinguishable_from: Vec<String>,
    /// All of these with their subjects, as `id [subject]`.
    pub rivals: Vec<String>,
    /// The measurement that would tell them apart.
    pub separate_by: Option<String>,
    /// How often it, or a rival of it, is found again.
    pub stability: LoopStability,
}

/// Shares of the repetitions that find a step, or a rival of it, again; `None` where the choice was
/// not repeated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LoopStability {
    /// Of those without some groups.
    pub resampled: Option<f64>,
    /// Of those with every reading moved by up to half of its last recorded decimal.
    pub perturbed: Option<f64>,
}

/// Structure left in the residual.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopRemaining {
    /// Column along which it shows.
    pub covariate: String,
    /// Its shape.
    pub shape: String,
    /// Significance, before correction.
    pub p_value: f64,
}

/// An effect the design cannot see.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopNotObservable {
    /// Catalogue id.
    pub effect: String,
    /// Parameters of the declared model that absorb it.
    pub aliased_with: Vec<String>,
    /// The measurement that would make it visible.
    pub separate_by: Option<String>,
}

/// Closes the loop on a case: solves it, and finds what its declared model is missing.
///
/// # Errors
///
/// As [`solve`](crate::solve), and [`Error::Loop`].
pub fn close_loop(case: &Case) -> Result<Closed, Error> {
    let started = Instant::now();
    let declared = case.fit()?;
    let Examined { suspects, corrected, mut closed } = examine(case, &declared)?;
    if suspects.is_empty() {
        return close(case, &declared, (&case.loop_settings.options(), closed), started);
    }
    let mended = corrected.as_ref().unwrap_or(case);
    let mut options = mended.loop_settings.options();
    if corrected.is_none() || suspects.iter().any(Suspect::leaves_out_what_misfits) {
        // Physics would only be fitted to the mistake, or to what is left of it at the ends of the rows left out.
        options.max_steps = 0;
        closed = None;
    }
    let fitted = mended.measured.fit();
    let closed = fitted.and_then(|fitted| close(mended, &fitted, (&options, closed), started));
    let mut closed = closed.map_err(|source| {
        let suspect = suspects[0].clone();
        Error::Input { source: Box::new(source), suspect: Box::new(suspect) }
    })?;
    let steps = suspects.iter().map(|s| LoopStep::of_mistake(s, &closed.before)).collect();
    closed.steps = [steps, closed.steps].concat();
    closed.before = before_it(case, &closed.before);
    closed.verdict = INPUT_WRONG;
    let mut warnings = vec![doubt(corrected.is_some())];
    warnings.extend(suspects.iter().map(Suspect::warning));
    // What was said of the case as it stands may say it in other words.
    warnings.extend(declared.warnings.iter().filter(|w| !closed.warnings.contains(w)).cloned());
    closed.warnings = [warnings, closed.warnings].concat();
    closed.corrected = closed.corrected.or_else(|| corrected.map(Arc::new));
    closed.suspects = suspects;
    Ok(closed)
}

/// Closes the loop on a case, and fits what it ended with as often as asked for with the data drawn
/// anew: declared parameters and the amplitudes of the accepted effects. What was chosen stays chosen.
///
/// # Errors
///
/// As of [`close_loop`] and [`monte_carlo`](crate::monte_carlo()).
pub fn close_loop_drawn(case: &Case, draws: usize) -> Result<Closed, Error> {
    let mut closed = close_loop(case)?;
    let case = closed.corrected.as_deref().unwrap_or(case);
    let found = (&closed.closure, &*closed.estimates);
    let drawn = monte_carlo_of_loop(case, found, draws)?;
    closed.warnings.extend(drawn.warning());
    closed.monte_carlo = Some(drawn);
    Ok(closed)
}

/// The verdict where the input itself is wrong.
pub(crate) const INPUT_WRONG: &str = "input-wrong";

fn doubt(is_corrected: bool) -> String {
    if is_corrected {
        "the input is wrong: the error after, further steps, estimates and every file written are \
         of the data as corrected in the first steps; the files of the case are unchanged: \
         correct them before you use anything"
            .to_owned()
    } else {
        "the input is wrong, and the data do not tell what they should have been: estimates and \
         every file written are of the data as they stand; use none of them"
            .to_owned()
    }
}

/// Error of the case as it stands; nothing where that cannot be judged.
fn before_it(case: &Case, like: &JudgedRms) -> JudgedRms {
    let options = Options { max_steps: 0, ..case.loop_settings.options() };
    let closed = case.measured.prepare().ok().and_then(|prepared| {
        model_discrepancy::close_loop(&*prepared.model, &prepared.covariates, &options).ok()
    });
    closed.map_or_else(
        || JudgedRms {
            train_rms: f64::NAN,
            held_out_rms: f64::NAN,
            held_out_std: f64::NAN,
            chi2_per_dof: None,
            chi2_interval: None,
            ..like.clone()
        },
        |closed| JudgedRms::of(&closed.before),
    )
}

/// `made` is the loop as closed before on the case with nothing carried to it.
fn close(
    case: &Case,
    declared: &Fitted,
    (options, made): (&Options, Option<Settled>),
    started: Instant,
) -> Result<Closed, Error> {
    let closed = close_as_read(case, declared, (options, made), started)?;
    Ok(with_odd_check(case, &closed, options, started).unwrap_or(closed))
}

/// The loop closed with the one check reading that is off by itself named as such; `None` where there is none, or where
/// it is not what is named then.
fn with_odd_check(
    case: &Case,
    closed: &Closed,
    options: &Options,
    started: Instant,
) -> Option<Closed> {
    let odd_check::Fitted { case, name, said } =
        odd_check::Fitted::of(case, closed.closure.odd_check?)?;
    let declared = case.measured.fit().ok()?;
    let mut anew = close_as_read(&case, &declared, (options, None), started).ok()?;
    let is_it = |step: &LoopStep| {
        step.effect.starts_with("bad-")
            && step.subject.as_ref().is_some_and(|of| of.starts_with(&name))
    };
    let is_named = anew.steps.iter().any(is_it) && anew.closure.odd_check.is_none();
    if !is_named {
        return None;
    }
    anew.before = closed.before.clone();
    anew.warnings.insert(0, said);
    anew.corrected = Some(Arc::new(case));
    Some(anew)
}

fn close_as_read(
    case: &Case,
    declared: &Fitted,
    (options, made): (&Options, Option<Settled>),
    started: Instant,
) -> Result<Closed, Error> {
    let (prepared, matched) = case.prepare()?;
    let made = made.filter(|_| case.learnt.is_none());
    let (Settled { mut closure, .. }, prepared) = match made {
        Some(made) => {
            let prepared = made.on(prepared)?;
            (made, prepared)
        }
        None => settled(prepared, options).map_err(|source| case.loop_error(source))?,
    };
    let estimates = (prepared.estimates)(&closure);
    estimates.widen(&mut closure.steps);
    let before = JudgedRms::of(&closure.before);
    let (mut carried, mut doubts) = (None, Vec::new());
    if let Some((learnt, matched)) = case.learnt.as_ref().zip(matched) {
        let plain = case.measured.prepare()?;
        let options = Options { max_steps: 0, ..options.clone() };
        let plain = model_discrepancy::close_loop(&*plain.model, &plain.covariates, &options)
            .map_err(|source| case.loop_error(source))?;
        carried = Some(Carried {
            from: learnt.from.display().to_string(),
            effects: matched.effects,
            without: JudgedRms::of(&plain.before),
            with: before.clone(),
        });
        doubts = matched.warnings;
    }
    let residual = Residual::after(&*prepared.model, &closure, declared.unit);
    let doubtful = plausible(&*estimates, None).err().map(|e| e.to_string());
    let scatter = scatter_warning(residual.chi2_per_dof, residual.chi2_interval);
    let warnings = (case.warnings.iter())
        .chain(&doubts)
        .chain(&declared.warnings)
        .chain(&closure.warnings)
        .chain(&scatter)
        .chain(&doubtful)
        .cloned()
        .collect();
    let interval = IntervalWidth::new(closure.degrees_of_freedom);
    Ok(Closed {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/loop/1", case),
        timing: Some(LoopTiming { read_s: case.read_s, loop_s: started.elapsed().as_secs_f64() }),
        carried,
        before,
        after: JudgedRms::of(&closure.after),
        steps: closure.steps.iter().map(LoopStep::of).collect(),
        verdict: verdict(closure.verdict),
        remaining: closure.remaining.iter().map(LoopRemaining::of).collect(),
        residual,
        lack_of_fit: closure.lack_of_fit.as_ref().map(Repeats::of),
        not_observable: closure.not_observable.iter().map(LoopNotObservable::of).collect(),
        monte_carlo: None,
        conformity: decisions(case, &*estimates, interval)?,
        estimates,
        interval,
        warnings,
        suspects: Vec::new(),
        closure,
        corrected: None,
    })
}

impl Case {
    /// Fits the declared model; an error names the mistake in the input that would explain it.
    pub(crate) fn fit(&self) -> Result<Fitted, Error> {
        self.measured.fit().map_err(|source| named_cause(&self.files, source))
    }

    /// What the loop needs, with the effects that were carried to this case in it.
    pub(crate) fn prepare(&self) -> Result<(Prepared<'_>, Option<Matched>), Error> {
        let prepared = self.measured.prepare()?;
        let Some(learnt) = &self.learnt else { return Ok((prepared, None)) };
        let matched = matched(learnt, &*prepared.model)?;
        Ok((carrying(prepared, matched.amplitudes.clone()), Some(matched)))
    }
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing => "nothing-missing",
        Verdict::Explained => "explained",
        Verdict::StructureRemains => "structure-remains",
        Verdict::NoiseLargerThanDeclared => "noise-larger-than-declared",
    }
}

impl JudgedRms {
    pub(crate) fn of(summary: &ErrorSummary) -> Self {
        Self {
            train_rms: summary.train_rms,
            held_out_rms: summary.held_out_rms,
            held_out_std: summary.held_out_std,
            unit: summary.unit.clone(),
            hold_out: match summary.hold_out {
                HoldOut::CheckGroups => "check-groups",
                HoldOut::Nested => "nested",
                HoldOut::LeaveOneOut => "leave-one-out",
            },
            chi2_per_dof: summary.chi2_per_dof,
            chi2_interval: summary.chi2_interval,
        }
    }
}

impl LoopStep {
    /// A mistake in the input; `after` is the error of the declared model without it.
    fn of_mistake(suspect: &Suspect, after: &JudgedRms) -> Self {
        Self {
            effect: suspect.effect.clone(),
            subject: Some(suspect.subject.clone()),
            description: suspect.description.clone(),
            parameters: Vec::new(),
            p_value: suspect.p_value,
            held_out_rms: after.held_out_rms,
            train_rms: after.train_rms,
            indistinguishable_from: suspect.indistinguishable_from.clone(),
            rivals: suspect.indistinguishable_from.clone(),
            separate_by: None,
            stability: LoopStability::default(),
        }
    }

    pub(crate) fn of(step: &Step) -> Self {
        let values: Vec<f64> = step.parameters.iter().map(|p| p.value).collect();
        Self {
            effect: step.effect.clone(),
            subject: step.subject.clone(),
            description: by_sign(&step.description, &values),
            parameters: step.parameters.iter().map(LoopParameter::of).collect(),
            p_value: step.p_value,
            held_out_rms: step.held_out_rms,
            train_rms: step.train_rms,
            indistinguishable_from: step.indistinguishable_from.clone(),
            rivals: step.rivals.clone(),
            separate_by: step.separate_by.clone(),
            stability: LoopStability::of(step.stability),
        }
    }
}

impl LoopStability {
    fn of(stability: Stability) -> Self {
        let Stability { resampled, perturbed } = stability;
        Self { resampled, perturbed }
    }
}

impl LoopRemaining {
    fn of(remaining: &Remaining) -> Self {
        Self {
            covariate: remaining.covariate.clone(),
            shape: remaining.shape.clone(),
            p_value: remaining.p_value,
        }
    }
}

impl LoopNotObservable {
    fn of(unseen: &NotObservable) -> Self {
        Self {
            effect: unseen.effect.clone(),
            aliased_with: unseen.aliased_with.clone(),
            separate_by: unseen.separate_by.clone(),
        }
    }
}
