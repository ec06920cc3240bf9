//! Effects that move a single observation, tested on its rows alone.
//!
//! There is one such candidate per observation. What they leave in the rest of the data follows
//! from the rows of the basis that they touch, so that one test costs the same however many
//! observations there are.

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::independent::Independent;
use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::{Estimability, estimability};
use crate::count::count;
use crate::levels::MIN_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test_of};

/// Rows of the data by observation, and what the fit left in them.
pub(crate) struct ObservationRows<'a> {
    lin: &'a Linear<'a>,
    /// Positions in `lin.rows` of each observation, and the component of each.
    of_observation: Vec<Vec<usize>>,
    /// First row of each observation in the layout.
    first_row: Vec<usize>,
    residual: DVector<f64>,
    /// Its square.
    square: f64,
}

/// The test of one effect on its own observation.
#[derive(Clone, Debug)]
pub(crate) struct LocalTest {
    /// Amplitudes that the design sees.
    pub(crate) parameters: Vec<usize>,
    /// Norm of each seen column beside the base, and of the part that is new beside those before.
    pub(crate) kept: Vec<f64>,
    pub(crate) absorbed: f64,
    pub(crate) test: Significance,
    /// Sum of squares, in report units, of a random unit combination of the tangent's directions.
    pub(crate) reported: f64,
}

/// What the design sees of an effect that moves one observation.
pub(crate) enum LocalEstimability {
    Estimable(LocalTest),
    /// Nothing: share absorbed.
    NotEstimable(f64),
}

impl<'a> ObservationRows<'a> {
    pub(crate) fn of(lin: &'a Linear<'a>) -> Self {
        let mut of_observation = vec![Vec::new(); lin.layout.observations.len()];
        for (i, &row) in lin.rows.iter().enumerate() {
            of_observation[lin.layout.rows[row].observation].push(i);
        }
        let mut first_row = vec![usize::MAX; lin.layout.observations.len()];
        for (row, r) in lin.layout.rows.iter().enumerate() {
            first_row[r.observation] = first_row[r.observation].min(row);
        }
        let residual = lin.clean_residual();
        let square = residual.norm_squared();
        Self { lin, of_observation, first_row, residual, square }
    }

    /// Rows of an observation, and the effect `values` (in the layout's units, one row per row of the
    /// observation) in them, whitened.
    pub(crate) fn whitened(
        &self,
        observation: usize,
        values: &DMatrix<f64>,
    ) -> Option<(&[usize], DMatrix<f64>)> {
        let rows = self.of_observation.get(observation)?;
        let first = self.first_row[observation];
        let mut tangent = DMatrix::zeros(rows.len(), values.ncols());
        for (at, &i) in rows.iter().enumerate() {
            let row = self.lin.rows[i];
            tangent.row_mut(at).copy_from(&(values.row(row - first) / self.lin.sigma[i]));
        }
        Some((rows, tangent))
    }

    /// Tests the effect `values` on an observation.
    fn test(&self, observation: usize, values: &DMatrix<f64>) -> Option<LocalEstimability> {
        let lin = self.lin;
        let (rows, tangent) = self.whitened(observation, values)?;
        let q = lin.basis.rows(rows);
        let residual = self.residual.select_rows(rows);
        let (directions, absorbed) = directions(&tangent, &q);
        let Some(seen) = SeenLocal::of(&tangent, &q) else {
            return Some(LocalEstimability::NotEstimable(absorbed));
        };
        let (explained, system) = (seen.explained(&tangent, &residual), lin.basis.dim());
        let test = f_test_of(explained, seen.directions(), self.square, lin.rows.len(), system)?;
        let reported = self.reported(rows, &directions);
        let SeenLocal { parameters, kept, .. } = seen;
        Some(LocalEstimability::Estimable(LocalTest { parameters, kept, absorbed, test, reported }))
    }

    fn reported(&self, rows: &[usize], directions: &DMatrix<f64>) -> f64 {
        let mut sum = 0.0;
        for (at, &i) in rows.iter().enumerate() {
            let row = self.lin.layout.rows[self.lin.rows[i]];
            if row.reported {
                sum += directions.row(at).norm_squared() * self.lin.sigma[i].powi(2);
            }
        }
        sum / count(directions.ncols().max(1))
    }
}

/// Every effect that is not in the system and moves one observation only, each tested when it is
/// asked for.
pub(crate) fn local_effects<'a>(
    system: &'a System<'_>,
    at: &'a Estimate,
    lin: &'a Linear<'_>,
) -> impl Iterator<Item = (usize, LocalEstimability)> + 'a {
    let readings = ObservationRows::of(lin);
    let effects = &system.model.declared().effects;
    let missing = (0..effects.len()).filter(|&e| !system.has_effect(e));
    missing.filter_map(move |e| {
        let Scope::Observation(observation) = effects[e].scope else { return None };
        let values = system.model.tangent(&at.state, e);
        Some((e, readings.test(observation, &values)?))
    })
}

/// The local effects whose test alone is below `level`, as full candidates.
pub(crate) fn promising(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
    level: f64,
) -> Vec<usize> {
    let below = |s: &LocalEstimability| matches!(s, LocalEstimability::Estimable(t) if t.test.p_value <= level);
    let local = local_effects(system, at, lin);
    local.filter(|(_, s)| below(s)).map(|(e, _)| e).collect()
}

/// A local effect as a full candidate.
pub(crate) fn full_candidate(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
    e: usize,
) -> Estimability {
    estimability(system.model, e, at, lin, &lin.basis)
}

/// Columns of an effect on one observation that keep enough of their norm beside the system and those
/// before them.
pub(crate) struct SeenLocal {
    parameters: Vec<usize>,
    /// Norm of each beside the system.
    kept: Vec<f64>,
    independent: Independent,
}

impl SeenLocal {
    /// From the rows of the effect, and those of the system's orthonormal columns; `None` where none
    /// of it is seen.
    pub(crate) fn of(tangent: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<Self> {
        let along = q.tr_mul(tangent);
        let beside = tangent.tr_mul(tangent) - along.tr_mul(&along);
        let least = |column: usize| MIN_KEPT * MIN_KEPT * tangent.column(column).norm_squared();
        let independent = Independent::of(&beside, least);
        let parameters = independent.kept.clone();
        let kept = parameters.iter().map(|&p| beside[(p, p)].max(0.0).sqrt()).collect();
        (!parameters.is_empty()).then_some(Self { parameters, kept, independent })
    }

    pub(crate) fn directions(&self) -> usize {
        self.parameters.len()
    }

    /// How much of what the system leaves of the data in these rows it explains.
    pub(crate) fn explained(&self, tangent: &DMatrix<f64>, residual: &DVector<f64>) -> f64 {
        self.independent.along_one(&tangent.tr_mul(residual)).norm_squared()
    }
}

/// Orthonormal directions of the tangent, and the share of them absorbed by the base.
fn directions(tangent: &DMatrix<f64>, q: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
    let directions = crate::algebra::basis::Basis::of(tangent, NEW_DIRECTION).matrix();
    if directions.ncols() == 0 {
        return (directions, 1.0);
    }
    let share = (q.transpose() * &directions).norm_squared() / directions.norm_squared();
    (directions, share.clamp(0.0, 1.0))
}
