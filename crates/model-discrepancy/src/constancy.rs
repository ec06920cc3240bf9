//! Does an effect that was named have the size that its name promises, everywhere?

use nalgebra::{DMatrix, DVector};

use crate::linear::Linear;
use crate::select::Selected;
use crate::significance::{Reach, significance};
use crate::{Model, Remaining};

/// Significance from which on a named effect is not what its name says.
const LEVEL: f64 = 0.01;

/// Tests, for each named effect, whether the residual still follows odd powers of its own trace.
///
/// A cubic distortion looks like a scale error first; what gives it away is a residual that
/// grows with the third power of the scale's trace. In the spirit of Tukey's (1949) one degree
/// of freedom for non-additivity: few directions, so that little data suffice.
pub(crate) fn not_proportional(
    model: &dyn Model,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Vec<Remaining> {
    let mut found = Vec::new();
    for active in &chosen.system.active {
        let effect = &model.effects()[active.effect];
        let tangent = lin.tangent(&model.tangent(&chosen.estimate.state, active.effect));
        let trace = tangent * &chosen.estimate.state.amplitudes[active.effect];
        let largest = trace.amax();
        if largest == 0.0 || touches_one(lin, &trace) {
            continue;
        }
        let share = trace / largest;
        let powers = DMatrix::from_columns(&[share.map(|f| f * f * f), share.map(|f| f * f.abs())]);
        let test = significance(lin, &lin.basis, &powers, Reach::Many, LEVEL);
        if let Some(test) = test.filter(|t| t.p_value <= LEVEL) {
            found.push(Remaining {
                covariate: effect.id.clone(),
                shape: "not proportional to the effect named".to_owned(),
                p_value: test.p_value,
            });
        }
    }
    found
}

fn touches_one(lin: &Linear<'_>, trace: &DVector<f64>) -> bool {
    lin.clusters.iter().filter(|c| c.iter().any(|&i| trace[i] != 0.0)).count() < 2
}
