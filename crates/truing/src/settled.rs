use model_discrepancy::{Closure, LoopError, Options, Verdict, close_loop};

use crate::Error;
use crate::measured::Prepared;

/// A loop closed on a model, and anew on the model about what each time was found.
#[derive(Debug)]
pub(crate) struct Settled {
    /// All but the last.
    on_the_way: Vec<Closure>,
    /// The last; what was before is that of the model about the declared solution.
    pub(crate) closure: Closure,
}

/// Times that a model is put about what was found at most. Each takes what is left of the way to its
/// square over the length of a beam: two do for what moves by a millimetre, four for a tenth of it.
pub(crate) const MOST_ROUNDS: usize = 5;

const NOT_SETTLED: &str = "what was found changes with what else is found, and the answer did not \
                           settle: correct the input by it and close the loop again";

/// Closes the loop; a model that is linear about one solution, anew about what was found.
pub(crate) fn settled<'c>(
    mut prepared: Prepared<'c>,
    options: &Options,
) -> Result<(Settled, Prepared<'c>), LoopError> {
    let mut closure = close_loop(&*prepared.model, &prepared.covariates, options)?;
    let (before, residuals_before) = (closure.before.clone(), closure.residuals_before.clone());
    let mut on_the_way = Vec::new();
    while let Some(there) = prepared.there(&closure).transpose() {
        if on_the_way.len() == MOST_ROUNDS {
            closure.warnings.push(NOT_SETTLED.to_owned());
            break;
        }
        match there.map_err(|e| e.to_string()).and_then(|there| closed_anew(there, options)) {
            Ok((anew, there)) => {
                on_the_way.push(std::mem::replace(&mut closure, anew));
                prepared = there;
            }
            Err(why) => {
                closure.warnings.push(not_anew(&why));
                if closure.verdict == Verdict::Explained {
                    closure.verdict = Verdict::StructureRemains;
                }
                break;
            }
        }
    }
    closure.before = before;
    closure.residuals_before = residuals_before;
    Ok((Settled { on_the_way, closure }, prepared))
}

fn closed_anew<'c>(
    there: Prepared<'c>,
    options: &Options,
) -> Result<(Closure, Prepared<'c>), String> {
    let anew = close_loop(&*there.model, &there.covariates, options);
    anew.map(|anew| (anew, there)).map_err(|e| e.to_string())
}

fn not_anew(why: &str) -> String {
    format!(
        "the loop could not be closed anew about what was found ({why}), so the answer is that of the \
         round before: correct the input by it and close the loop again"
    )
}

impl Settled {
    /// The model on which the last loop was closed.
    pub(crate) fn on<'c>(&self, prepared: Prepared<'c>) -> Result<Prepared<'c>, Error> {
        (self.on_the_way.iter())
            .try_fold(prepared, |at, closure| Ok(at.there(closure)?.unwrap_or(at)))
    }
}

impl Prepared<'_> {
    /// What the loop needs, anew about what a closure has found.
    pub(crate) fn there(&self, closure: &Closure) -> Result<Option<Self>, Error> {
        self.about.as_ref().map_or(Ok(None), |about| about(closure))
    }
}
