//! Checks of everything that comes from outside, once, before the loop starts.

use crate::error::LoopError;
use crate::levels::MIN_GROUPS;
use crate::{Covariate, Declared, Effect, Model, Role, Scope, State};

/// Checks layout, what is said beside it, and covariates.
pub(crate) fn validate(model: &dyn Model, covariates: &[Covariate]) -> Result<(), LoopError> {
    let layout = &model.declared().layout;
    for (row, r) in layout.rows.iter().enumerate() {
        let group = layout.observations.get(r.observation);
        if group.is_none_or(|&g| g >= layout.groups.len()) {
            return Err(LoopError::InconsistentLayout { row });
        }
        if !(r.sigma > 0.0 && r.sigma.is_finite()) {
            return Err(LoopError::InvalidSigma { row, sigma: r.sigma });
        }
    }
    fits_layout(model)?;
    let expected = layout.observations.len();
    for c in covariates {
        if c.values.len() != expected || c.values.iter().any(|v| !v.is_finite()) {
            return Err(LoopError::InvalidCovariate { name: c.name.clone(), expected });
        }
    }
    enough_groups(model)
}

/// Checks that what is declared beside the layout fits it.
pub(crate) fn fits_layout(model: &dyn Model) -> Result<(), LoopError> {
    let Declared { layout, base, start, effects, records, projected, directions, .. } =
        model.declared();
    let n = layout.observations.len();
    let fits = |field, needed, fits: bool| {
        if fits { Ok(()) } else { Err(LoopError::InconsistentModel { field, needed }) }
    };
    fits("start", "one value per base parameter", start.len() == base.len())?;
    let is_one = |e: &Effect| match e.scope {
        Scope::Observation(o) => o < n,
        Scope::Everywhere | Scope::SomeDesigns => true,
    };
    fits("effects", "observations that exist as their scope", effects.iter().all(is_one))?;
    let has_places = |e: &Effect| {
        let rows = e.by_place.iter().all(|by| by.nrows() == layout.rows.len());
        rows && [0, e.parameters.len()].contains(&e.by_place.len())
    };
    let needed = "a matrix per amplitude, with a row per row of the layout";
    fits("by_place", needed, effects.iter().all(has_places))?;
    let one_each = "one value per observation";
    fits("records", one_each, records.as_ref().is_none_or(|r| r.len() == n))?;
    fits("directions", one_each, directions.as_ref().is_none_or(|d| d.len() == n))?;
    let n_rows = layout.rows.len();
    let mut free_from = 0;
    let are_parts = projected.iter().all(|c| {
        let follows = c.first_row >= free_from;
        free_from = c.first_row.saturating_add(c.combination.nrows());
        let are_observations = c.readings.iter().all(|&(o, _)| o < n);
        follows && are_observations && c.combination.ncols() == c.readings.len()
    });
    let parts = "rows one after the other, of observations that exist, one per column";
    fits("projected", parts, are_parts && free_from <= n_rows)
}

/// Checks that every effect moves something, but for those that need not in every design.
pub(crate) fn no_empty_column(model: &dyn Model, at: &State) -> Result<(), LoopError> {
    for (e, effect) in model.declared().effects.iter().enumerate() {
        if effect.scope == Scope::SomeDesigns {
            continue;
        }
        let tangent = model.tangent(at, e);
        if let Some(i) = tangent.column_iter().position(|column| column.amax() == 0.0) {
            let (effect, parameter) = (effect.id.clone(), effect.parameters[i].name.clone());
            return Err(LoopError::EmptyColumn { effect, parameter });
        }
    }
    Ok(())
}

fn enough_groups(model: &dyn Model) -> Result<(), LoopError> {
    let layout = &model.declared().layout;
    let groups = layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    let fitted =
        |r: &&crate::Row| layout.groups[layout.observations[r.observation]].role != Role::Check;
    let rows = layout.rows.iter().filter(fitted).count();
    let parameters = model.declared().base.len();
    if groups < MIN_GROUPS || rows <= parameters {
        let per_group = rows.checked_div(groups.max(1)).unwrap_or(1).max(1);
        let needed = MIN_GROUPS.max(parameters / per_group + 1);
        return Err(LoopError::TooFewGroups { groups, rows, parameters, needed });
    }
    Ok(())
}
