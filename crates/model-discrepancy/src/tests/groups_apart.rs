//! Groups that lie apart from each other by more than their readings scatter.

use nalgebra::DMatrix;

use crate::Remaining;
use crate::algebra::linearised::groups_are_runs;
use crate::levels::GROUPS_APART;
use crate::noise::linear::Linear;
use crate::tests::significance::{Asked, Reach, significance_beside};

/// What is said to be left where groups differ from each other.
pub const GROUP: &str = "group";

/// Fewest groups that can lie apart: of two, nobody knows how far groups lie from each other.
const MIN_GROUPS: usize = 3;

/// Fewest readings of a group, on the mean, that show how far the noise reaches inside it.
const MIN_READINGS: usize = 4;

/// A value of its own in every group, beside everything in the model, under every colour of the noise.
///
/// Where groups are runs of readings, an effect has to show between groups, and groups that differ
/// from each other refuse it; without declared noise nothing else says that they do. Here the readings
/// inside the groups say how far the noise goes and how far it remembers: the restricted likelihood of
/// each kind of memory is that of the residual with the groups' own values taken out.
pub(crate) fn groups_apart(lin: &Linear<'_>) -> Option<Remaining> {
    let n_groups = lin.clusters.len();
    if n_groups < MIN_GROUPS || !groups_are_runs(lin) {
        return None;
    }
    let row = |i: usize| &lin.layout.rows[lin.rows[i]];
    let components = (0..lin.rows.len()).filter(|&i| row(i).reported).map(|i| row(i).component + 1);
    let components = components.max()?;
    let mut own = DMatrix::zeros(lin.rows.len(), n_groups * components);
    for (group, rows) in lin.clusters.iter().enumerate() {
        for &i in rows.iter().filter(|&&i| row(i).reported) {
            own[(i, group * components + row(i).component)] = 1.0 / lin.sigma[i];
        }
    }
    if lin.rows.len() < MIN_READINGS * own.ncols() {
        return None;
    }
    let asked = Asked { reach: Reach::One, searched: 1.0, level: GROUPS_APART };
    let residual = lin.clean_residual();
    let beside = lin.basis.reject_columns(&own);
    let test = significance_beside(lin, &lin.basis, &residual, &beside, asked)?;
    (test.p_value <= GROUPS_APART).then(|| Remaining {
        covariate: GROUP.to_owned(),
        shape: "groups lie apart by more than their readings scatter".to_owned(),
        p_value: test.p_value,
    })
}
