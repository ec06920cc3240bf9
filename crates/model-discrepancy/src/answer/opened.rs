//! The loop as far as its choice on all groups goes, before anything of it is repeated.

use crate::algebra::silent::silent_components;
use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::contradiction::{chosen_instead, contradiction};
use crate::answer::separation::all_fitted;
use crate::answer::summary::summary_before;
use crate::choice::context::Context;
use crate::choice::select::select;
use crate::choice::selected::Selected;
use crate::choice::shapes::Shapes;
use crate::error::LoopError;
use crate::model::covariate::with_order;
use crate::model::validate::{no_empty_column, validate};
use crate::{Covariate, ErrorSummary, Model, Options, Remaining, Solution};

/// The declared model fitted, and what was chosen beside it on all groups.
///
/// What repetitions of the choice would take back is still in it. It costs a small part of
/// [`close`](Self::close), and tells where a model that is linear about one solution should be put
/// before the loop is closed on it.
pub struct OpenLoop<'m> {
    pub(crate) model: &'m dyn Model,
    pub(crate) options: &'m Options,
    /// Whether each group is fitted.
    pub(crate) keep: Vec<bool>,
    /// See [`Context`].
    pub(crate) silent: Vec<bool>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) shapes: Vec<Shapes>,
    /// The declared model, fitted.
    pub(crate) base: Estimate,
    /// Effects that the data contradict.
    pub(crate) banned: Vec<usize>,
    pub(crate) chosen: Selected<'m>,
    /// What is said of names that the data contradict.
    pub(crate) contradicted: Option<Remaining>,
}

impl std::fmt::Debug for OpenLoop<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OpenLoop").field("solution", &self.solution()).finish_non_exhaustive()
    }
}

/// Fits the declared model and chooses what it lacks, on all groups.
///
/// # Errors
///
/// As [`close_loop`](crate::close_loop).
pub fn open_loop<'m>(
    model: &'m dyn Model,
    covariates: &[Covariate],
    options: &'m Options,
) -> Result<OpenLoop<'m>, LoopError> {
    validate(model, covariates)?;
    let keep = all_fitted(model);
    let layout = &model.declared().layout;
    let declared = System::declared(model);
    let rows = rows_of(layout, &keep);
    let base = declared.fit_first(&rows).map_err(LoopError::declared)?;
    no_empty_column(model, &base.state)?;
    let silent = silent_components(&declared, &base, &rows);
    let covariates = with_order(layout, covariates);
    let shapes = Shapes::of_all(layout, &covariates);
    let open = Context::open(model, (&covariates, &shapes), options, &silent);
    let first = select(&open, &keep, &base);
    let against = contradiction(&open, &keep, &base, &first);
    let named = first.system.active.iter().map(|active| active.effect);
    let banned: Vec<usize> = named.filter(|_| against.is_some()).collect();
    let context = Context { banned: &banned, ..open };
    let (chosen, contradicted) = match against {
        Some(against) => chosen_instead(&context, &keep, &base, &first, against),
        None => (first, None),
    };
    let chosen = chosen.on(model);
    Ok(OpenLoop {
        model,
        options,
        keep,
        silent,
        covariates,
        shapes,
        base,
        banned,
        chosen,
        contradicted,
    })
}

impl OpenLoop<'_> {
    pub(crate) fn context(&self) -> Context<'_> {
        let along = (&self.covariates[..], &self.shapes[..]);
        let open = Context::open(self.model, along, self.options, &self.silent);
        Context { banned: &self.banned, ..open }
    }

    /// The model with what was chosen.
    #[must_use]
    pub fn solution(&self) -> Solution {
        let Selected { system, estimate, .. } = &self.chosen;
        let columns = system.columns().into_iter().chain(system.places()).collect();
        Solution { state: estimate.state.clone(), columns }
    }

    /// The error of the declared model, where groups are left out each predicted by it as fitted to the
    /// others.
    #[must_use]
    pub fn before(&self) -> ErrorSummary {
        summary_before(&self.context(), &self.keep, &self.base, &self.chosen)
    }

    /// Residual per row of the declared model, in report units, all groups.
    #[must_use]
    pub fn residuals_before(&self) -> Vec<f64> {
        System::declared(self.model).residuals(&self.base).iter().copied().collect()
    }
}
