//! Does an effect that was named have the size that its name promises, everywhere?

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::system::Active;
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::count::count;
use crate::levels::{NOT_ADDITIVE, PLAINLY_NOT_ADDITIVE};
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test;
use crate::tests::significance::{Reach, significance};
use crate::{Covariate, Model, Remaining};

/// A named effect that is not what its name promises.
pub(crate) struct Departure {
    pub(crate) remaining: Remaining,
    /// What it takes from the squared residual, whitened.
    pub(crate) explained: f64,
}

/// Tests, for each named effect, whether the residual still follows its trace where it should not:
/// odd powers of the trace itself, or the trace growing along a covariate.
///
/// A cubic distortion looks like a scale error first; what gives it away is a residual that
/// grows with the third power of the scale's trace. An error of the load cell that is not linear
/// looks like a gain; what gives it away is a gain that changes with the load. In the spirit of
/// Tukey's (1949) one degree of freedom for non-additivity: few directions, so that little
/// data suffice. Bonferroni over all that is tested.
pub(crate) fn not_additive(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Vec<Departure> {
    departures(context, chosen, lin, NOT_ADDITIVE, |tangent, level| {
        Some(significance(lin, &lin.basis, tangent, Reach::Many, level)?.p_value)
    })
}

/// As [`not_additive`], as though the noise had no memory: where it scatters more than declared
/// anyway, memory that swallows what an effect leaves says nothing for its name.
pub(crate) fn plainly_not_additive(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Vec<Departure> {
    let residual = lin.basis.reject(&lin.residual);
    departures(context, chosen, lin, PLAINLY_NOT_ADDITIVE, |tangent, _| {
        let beside = Basis::of(&lin.basis.reject_columns(tangent), NEW_DIRECTION);
        Some(f_test(&residual, lin.basis.dim(), &beside)?.p_value)
    })
}

/// Departures whose p-value by `test`, given a tangent and its level, is below `all` shared by all.
fn departures(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
    all: f64,
    test: impl Fn(&DMatrix<f64>, f64) -> Option<f64>,
) -> Vec<Departure> {
    let traces: Vec<_> =
        chosen.system.active.iter().filter_map(|a| trace(context.model, chosen, lin, a)).collect();
    let along: Vec<_> = context.covariates.iter().map(|c| (&c.name, centred(lin, c))).collect();
    let level = all / count(traces.len() * (1 + along.len())).max(1.0);
    let mut found = Vec::new();
    for (name, share) in traces {
        let powers = DMatrix::from_columns(&[share.map(|f| f * f * f), share.map(|f| f * f.abs())]);
        let mut ask = |shape: String, tangent: &DMatrix<f64>| {
            let Some(p_value) = test(tangent, level).filter(|p| *p <= level) else { return };
            let beside = Basis::of(&lin.basis.reject_columns(tangent), NEW_DIRECTION);
            let remaining = Remaining { covariate: name.to_owned(), shape, p_value };
            found.push(Departure { remaining, explained: beside.explained(&lin.residual) });
        };
        ask("not proportional to the effect named".to_owned(), &powers);
        for (column, values) in &along {
            let growing = DMatrix::from_columns(&[share.component_mul(values)]);
            ask(format!("of another size along {column}"), &growing);
        }
    }
    found
}

/// Whitened trace of a named effect as a share of its largest entry, under its id; `None` for one
/// that lives in one group.
fn trace<'a>(
    model: &'a dyn Model,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
    active: &Active,
) -> Option<(&'a str, DVector<f64>)> {
    let tangent = lin.tangent(&whole_tangent(model, &chosen.estimate.state, active.effect));
    let trace = tangent * &chosen.estimate.state.amplitudes[active.effect];
    let largest = trace.amax();
    let many = largest > 0.0 && !touches_one(lin, &trace);
    many.then(|| (model.declared().effects[active.effect].id.as_str(), trace / largest))
}

/// Values of a covariate on the rows of `lin`, from their mean, the largest distance being one.
pub(crate) fn centred(lin: &Linear<'_>, covariate: &Covariate) -> DVector<f64> {
    let value = |row: &usize| covariate.values[lin.layout.rows[*row].observation];
    let values = DVector::from_iterator(lin.rows.len(), lin.rows.iter().map(value));
    let from_mean = values.add_scalar(-values.mean());
    let largest = from_mean.amax();
    if largest > 0.0 { from_mean / largest } else { from_mean }
}

fn touches_one(lin: &Linear<'_>, trace: &DVector<f64>) -> bool {
    lin.clusters.iter().filter(|c| c.iter().any(|&i| trace[i] != 0.0)).count() < 2
}
