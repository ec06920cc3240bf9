//! Effects of the catalogue that may be there in another size from place to place or from time to time, so that none of
//! them is found.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::answer::without_tails::without_tails;
use crate::choice::additivity::centred;
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::count::count;
use crate::levels::ONLY_NOISE;
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test;
use crate::{Remaining, Scope};

/// Powers of a covariate that an effect may grow with.
const POWERS: [i32; 3] = [1, 2, 3];
/// Readings for each direction that is asked.
const LEAST_READINGS: usize = 5;

/// The effect that explains most of the residual with a size that goes with a covariate, where its probability, all that
/// were asked counted, is below that at which larger noise is called nothing but noise.
pub(crate) fn of_changing_size(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<Remaining> {
    let residual = without_tails(&lin.basis.reject(&lin.residual));
    let effects = &context.model.declared().effects;
    let is_asked = |e: &usize| {
        !matches!(effects[*e].scope, Scope::Observation(_)) && !chosen.system.has_effect(*e)
    };
    let along: Vec<_> = context.covariates.iter().map(|c| (&c.name, centred(lin, c))).collect();
    let mut best: Option<(f64, Remaining)> = None;
    let mut asked = 0;
    for e in (0..effects.len()).filter(is_asked) {
        let tangent = lin.tangent(&whole_tangent(context.model, &chosen.estimate.state, e));
        for (column, values) in &along {
            let directions = tangent.ncols() * POWERS.len();
            if directions == 0 || directions * LEAST_READINGS > lin.rows.len() {
                continue;
            }
            let growing = grown(&tangent, values);
            let beside = Basis::of(&lin.basis.reject_columns(&growing), NEW_DIRECTION);
            let Some(test) = f_test(&residual, lin.basis.dim(), &beside) else { continue };
            asked += 1;
            if best.as_ref().is_none_or(|(least, _)| test.p_value < *least) {
                let shape = format!("may be there in another size along {column}");
                let covariate = effects[e].id.clone();
                best = Some((test.p_value, Remaining { covariate, shape, p_value: test.p_value }));
            }
        }
    }
    best.filter(|(least, _)| *least <= ONLY_NOISE / count(asked)).map(|(_, remaining)| remaining)
}

/// The columns times powers of a covariate.
fn grown(tangent: &DMatrix<f64>, values: &DVector<f64>) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = POWERS
        .into_iter()
        .flat_map(|power| {
            let share = values.map(|v| v.powi(power));
            tangent.column_iter().map(move |column| column.component_mul(&share))
        })
        .collect();
    DMatrix::from_columns(&columns)
}
