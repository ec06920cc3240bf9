//! Effects that move a single observation, tested on its rows alone.
//!
//! There is one such candidate per observation. What they leave in the rest of the data follows
//! from the rows of the basis that they touch, so that one test costs the same however many
//! observations there are.

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::{Estimability, estimability};
use crate::count::count;
use crate::levels::MIN_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::Significance;

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

    /// Tests the effect `values` (in the layout's units, one row per row of the observation).
    fn test(&self, observation: usize, values: &DMatrix<f64>) -> Option<LocalEstimability> {
        let rows = self.of_observation.get(observation)?;
        let first = self.first_row[observation];
        let lin = self.lin;
        let mut tangent = DMatrix::zeros(rows.len(), values.ncols());
        for (at, &i) in rows.iter().enumerate() {
            let row = lin.rows[i];
            tangent.row_mut(at).copy_from(&(values.row(row - first) / lin.sigma[i]));
        }
        let q = lin.basis.rows(rows);
        let along = q.transpose() * &tangent;
        let beside = tangent.transpose() * &tangent - along.transpose() * &along;
        let (parameters, factor) = independent(&tangent, &beside);
        let (directions, absorbed) = directions(&tangent, &q);
        if parameters.is_empty() {
            return Some(LocalEstimability::NotEstimable(absorbed));
        }
        let residual = self.residual.select_rows(rows);
        let score = tangent.select_columns(&parameters).transpose() * residual;
        let explained = factor.solve_lower_triangular(&score)?.norm_squared();
        let dof = lin.rows.len().checked_sub(lin.basis.dim() + parameters.len())?;
        if dof == 0 {
            return None;
        }
        let left = (self.square - explained).max(0.0);
        let variance = left / count(dof);
        let f_statistic = explained / count(parameters.len()) / variance;
        let test = Significance {
            f_statistic,
            directions: parameters.len(),
            dof,
            explained,
            variance,
            p_value: f_tail(f_statistic, count(parameters.len()), count(dof)),
        };
        let kept = parameters.iter().map(|&p| beside[(p, p)].max(0.0).sqrt()).collect();
        let reported = self.reported(rows, &directions);
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

/// Columns that keep enough of their norm beside the base and those before them, and the
/// Cholesky factor of their products beside the base.
fn independent(tangent: &DMatrix<f64>, beside: &DMatrix<f64>) -> (Vec<usize>, DMatrix<f64>) {
    let m = tangent.ncols();
    let mut kept: Vec<usize> = Vec::with_capacity(m);
    let mut factor: DMatrix<f64> = DMatrix::zeros(m, m);
    for j in 0..m {
        let row = kept.len();
        for k in 0..row {
            let known: f64 = (0..k).map(|l| factor[(row, l)] * factor[(k, l)]).sum();
            factor[(row, k)] = (beside[(j, kept[k])] - known) / factor[(k, k)];
        }
        let known: f64 = (0..row).map(|l| factor[(row, l)].powi(2)).sum();
        let left = (beside[(j, j)] - known).max(0.0).sqrt();
        let norm = tangent.column(j).norm();
        if left > MIN_KEPT * norm && left > f64::MIN_POSITIVE {
            factor[(row, row)] = left;
            kept.push(j);
        } else {
            factor.row_mut(row).fill(0.0);
        }
    }
    let n = kept.len();
    (kept, factor.view((0, 0), (n, n)).into_owned())
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
