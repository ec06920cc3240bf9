use std::sync::Arc;

use model_discrepancy::{
    Closure, Effect, ErrorSummary, LoopError, Model, Options, Solution, Verdict, close_loop,
    open_loop,
};

use crate::Error;
use crate::measured::Prepared;

/// A loop closed on a model, and anew on the model about what each time was found.
#[derive(Debug)]
pub(crate) struct Settled {
    /// What was found before the last.
    on_the_way: Vec<Solution>,
    /// The last; what was before is that of the model about the declared solution.
    pub(crate) closure: Closure,
}

/// Times that a model is put about what was found at most. Each takes what is left of the way to its
/// square over the length of a beam: two do for what moves by a millimetre, four for a tenth of it.
pub(crate) const MOST_ROUNDS: usize = 5;

const NOT_SETTLED: &str = "what was found changes with what else is found, and the answer did not \
                           settle: correct the input by it and close the loop again";

/// Closes the loop; a model that is linear about one solution, anew about what was found.
///
/// What is chosen on all groups leads there; the choice is repeated at the end of the way, and where that
/// takes something back, at the end of what is left of it.
pub(crate) fn settled<'c>(
    prepared: Prepared<'c>,
    options: &Options,
) -> Result<(Settled, Prepared<'c>), LoopError> {
    let mut way = Way::default();
    let (mut closure, mut prepared) = way.settle(prepared, options)?;
    while let Some(there) = prepared.there(&closure.solution()).transpose() {
        if way.found.len() == MOST_ROUNDS {
            closure.warnings.push(NOT_SETTLED.to_owned());
            not_explained(&mut closure);
            break;
        }
        let before = || (closure.before.clone(), closure.residuals_before.clone());
        way.declared.get_or_insert_with(before);
        match there.map_err(|e| e.to_string()).and_then(|there| closed_anew(there, options)) {
            Ok((anew, there)) => {
                way.found.push(closure.solution());
                (closure, prepared) = (anew, there);
            }
            Err(why) => {
                not_anew(&mut closure, &why);
                break;
            }
        }
    }
    if let Some((before, residuals_before)) = way.declared {
        (closure.before, closure.residuals_before) = (before, residuals_before);
    }
    Ok((Settled { on_the_way: way.found, closure }, prepared))
}

/// The way from a model about the declared solution to one about what was found.
#[derive(Default)]
struct Way {
    /// What was found on each model but the last.
    found: Vec<Solution>,
    /// Error and residuals of the declared model on the first, where it is not the last.
    declared: Option<(ErrorSummary, Vec<f64>)>,
}

impl Way {
    /// Goes on from a model, and closes the loop on the last.
    fn settle<'c>(
        &mut self,
        prepared: Prepared<'c>,
        options: &Options,
    ) -> Result<(Closure, Prepared<'c>), LoopError> {
        let model = Arc::clone(&prepared.model);
        let opened = open_loop(&*model, &prepared.covariates, options)?;
        if self.found.len() == MOST_ROUNDS {
            return Ok((opened.close(), prepared));
        }
        let there = match prepared.there(&opened.solution()) {
            Ok(None) => return Ok((opened.close(), prepared)),
            Ok(Some(there)) => Ok(there),
            Err(why) => Err(why.to_string()),
        };
        let declared = || (opened.before(), opened.residuals_before());
        self.declared.get_or_insert_with(declared);
        self.found.push(opened.solution());
        let known = self.found.len();
        match there.and_then(|there| self.settle(there, options).map_err(|e| e.to_string())) {
            Ok((closure, there)) if keeps(&opened.solution(), &*model, &closure) => {
                Ok((closure, there))
            }
            // What led there was taken back: the way is gone from here, with what stands here.
            Ok(_) => {
                self.found.truncate(known - 1);
                Ok((opened.close(), prepared))
            }
            Err(why) => {
                self.found.pop();
                let mut closure = opened.close();
                not_anew(&mut closure, &why);
                Ok((closure, prepared))
            }
        }
    }
}

/// Whether a closure still names every effect of what was found on `model`.
fn keeps(found: &Solution, model: &dyn Model, closure: &Closure) -> bool {
    let effects = &model.declared().effects;
    found.amplitudes().iter().all(|&(effect, _)| {
        let Effect { id, subject, .. } = &effects[effect];
        closure.steps.iter().any(|step| step.effect == *id && step.subject == *subject)
    })
}

fn closed_anew<'c>(
    there: Prepared<'c>,
    options: &Options,
) -> Result<(Closure, Prepared<'c>), String> {
    let anew = close_loop(&*there.model, &there.covariates, options);
    anew.map(|anew| (anew, there)).map_err(|e| e.to_string())
}

/// Says that the loop could not be closed anew about what a closure found.
fn not_anew(closure: &mut Closure, why: &str) {
    closure.warnings.push(format!(
        "the loop could not be closed anew about what was found ({why}), so the answer is that of the \
         round before: correct the input by it and close the loop again"
    ));
    not_explained(closure);
}

/// What is not known about the place where it was found explains nothing.
fn not_explained(closure: &mut Closure) {
    if closure.verdict == Verdict::Explained {
        closure.verdict = Verdict::StructureRemains;
    }
}

impl Settled {
    /// The model on which the last loop was closed.
    pub(crate) fn on<'c>(&self, prepared: Prepared<'c>) -> Result<Prepared<'c>, Error> {
        (self.on_the_way.iter()).try_fold(prepared, |at, found| Ok(at.there(found)?.unwrap_or(at)))
    }
}

impl Prepared<'_> {
    /// What the loop needs, anew about what one has found.
    pub(crate) fn there(&self, found: &Solution) -> Result<Option<Self>, Error> {
        self.about.as_ref().map_or(Ok(None), |about| about(found))
    }
}
