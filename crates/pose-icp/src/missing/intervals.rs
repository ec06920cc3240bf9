//! Intervals of a pose where the touches hardly show it.
//!
//! Nine touches of a near-sphere leave tilt against decentre to an asphericity that is no larger than
//! their noise, and how well they show it depends on the decentre itself. The linear uncertainty
//! then covers 84 % where it should cover 95 %. The profile does: a value belongs to the interval
//! where the best of all fits that hold it leaves no more χ² than k² times the noise's factor.

use least_squares::{Options, Problem, SolveError, solve};
use model_discrepancy::{Column, EmpiricalCorrection, Model, Role, State, whole_tangent};
use nalgebra::{DMatrix, DVector, Matrix2, RowDVector, Vector2, Vector6};

use super::model::PoseModel;
use super::setup::coordinates;

/// Where a fit ended, and what is free in it.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// Base parameters and amplitudes.
    pub state: &'a State,
    /// What is free.
    pub columns: &'a [Column],
    /// Corrections beside the model.
    pub empirical: &'a [EmpiricalCorrection],
    /// Factor from the declared variances to those of the noise.
    pub variance_factor: f64,
    /// Linear standard uncertainties of `[x y z α β γ]`, mm and rad.
    pub sigmas: Vector6<f64>,
}

/// A value is held to this share of its linear uncertainty.
const HELD_SHARE: f64 = 1e-4;
/// Tolerances from which on a value is not held: χ² pulls it by a thousandth of one.
const HOLDS: f64 = 100.0;
/// Steps of one fit: it starts beside its end, or there is none.
const MAX_STEPS: usize = 60;
/// Rounds of the search for an end; three to six are needed.
const MAX_ROUNDS: usize = 16;
/// Relative error of the root of χ² at an end.
const END_TOLERANCE: f64 = 1e-3;
/// Factor by which a round changes the distance at most.
const LONGEST_STRIDE: f64 = 3.0;
/// Index of the height among the coordinates of a pose.
const HEIGHT: usize = 2;
/// Index of the first of both tilts.
const TILTS: usize = 3;
/// Root of χ² that 5 % exceed with two degrees of freedom, over that with one: 2.448 / 1.960.
const LEVEL: f64 = 1.249;
/// Standard uncertainties away from level at which this is over. The Rice distribution has it at one
/// where both tilts are known alike; the touches of a near-sphere know one better than the other.
const LEVEL_REACH: f64 = 2.0;
/// Times its linear width at which an interval counts as without end.
const ENDLESS: f64 = 30.0;

impl PoseModel {
    /// How far the interval of each of `[x y z α β γ]` reaches below and above the estimate, mm and
    /// rad, at `coverage_factor`; zeros where held.
    ///
    /// `None` where the touches leave no noise to go by.
    #[must_use]
    pub fn profile(&self, fitted: &Fitted<'_>, coverage_factor: f64) -> Option<[[f64; 2]; 6]> {
        if fitted.variance_factor <= f64::EPSILON || !coverage_factor.is_finite() {
            return None;
        }
        let mut reach = [[0.0; 2]; 6];
        for (coordinate, reach) in reach.iter_mut().enumerate() {
            if fitted.sigmas[coordinate] > 0.0 {
                *reach = [-1.0, 1.0].map(|way| self.end(fitted, coordinate, way, coverage_factor));
            }
        }
        Some(reach)
    }

    /// Distance of one end of an interval from the estimate.
    ///
    /// A value that no pose has is outside: no tilt puts the vertex of a bowl lower than a level one.
    fn end(&self, fitted: &Fitted<'_>, coordinate: usize, way: f64, factor: f64) -> f64 {
        let sigma = fitted.sigmas[coordinate];
        let mut held = Held::new(self, fitted, coordinate, HELD_SHARE * sigma);
        let mut at = DVector::zeros(fitted.columns.len());
        let (least, estimate) = (held.chi2(&at), held.coordinate(&at));
        let cheapest = held.spread(&at).cheapest(coordinate);
        // Height is the only coordinate that both tilts change in second order alone.
        let factor_at = |held: &Held<'_>, point: &DVector<f64>| {
            if coordinate == HEIGHT { factor * held.beside_level(point) } else { factor }
        };
        let (mut inside, mut outside) = (0.0, f64::INFINITY);
        let mut distance = factor * sigma;
        let options = Options { max_iterations: MAX_STEPS, retry: false, ..Options::default() };
        for _ in 0..MAX_ROUNDS {
            held.target = estimate + way * distance;
            let start = &at + &cheapest * (held.target - held.coordinate(&at));
            let found = match solve(&held, start, &options) {
                Ok(solution) => Some(solution.point),
                Err(SolveError::NotConverged { best, .. } | SolveError::Stalled { best, .. }) => {
                    Some(*best)
                }
                Err(_) => None,
            };
            let found = found.filter(|point| held.holds(point));
            // χ²'s root over what it may be.
            let share = found
                .as_ref()
                .map(|point| (held.chi2(point) - least).max(0.0).sqrt() / factor_at(&held, point));
            if share.is_some_and(|share| share <= 1.0) {
                inside = distance;
            } else {
                outside = distance;
            }
            if share.is_some_and(|share| (share - 1.0).abs() <= END_TOLERANCE) {
                return distance;
            }
            // The root grows almost in proportion.
            let stride = share.map_or(0.0, f64::recip);
            let next = distance * stride.clamp(LONGEST_STRIDE.recip(), LONGEST_STRIDE);
            let between = share.is_some() && next > inside && next < outside;
            distance = if between { next } else { f64::midpoint(inside, outside) };
            if distance > ENDLESS * factor * sigma {
                return ENDLESS * factor * sigma;
            }
            at = found.unwrap_or(at);
        }
        f64::midpoint(inside, outside.min(distance))
    }
}

/// The fit with one coordinate of the pose held; parameters are steps from the end of the free one.
struct Held<'a> {
    model: &'a PoseModel,
    fitted: &'a Fitted<'a>,
    /// Rows that are fitted, with their weight.
    rows: Vec<(usize, f64)>,
    coordinate: usize,
    tolerance: f64,
    target: f64,
}

impl<'a> Held<'a> {
    fn new(
        model: &'a PoseModel,
        fitted: &'a Fitted<'a>,
        coordinate: usize,
        tolerance: f64,
    ) -> Self {
        let layout = &model.declared().layout;
        let scale = fitted.variance_factor.max(f64::MIN_POSITIVE).sqrt();
        let of = |(index, row): (usize, &model_discrepancy::Row)| {
            let group = layout.observations[row.observation];
            let is_fitted = layout.groups[group].role != Role::Check;
            is_fitted.then_some((index, 1.0 / (row.sigma * scale)))
        };
        let rows = layout.rows.iter().enumerate().filter_map(of).collect();
        Self { model, fitted, rows, coordinate, tolerance, target: 0.0 }
    }

    fn state(&self, steps: &DVector<f64>) -> State {
        let mut state = self.fitted.state.clone();
        for (column, step) in self.fitted.columns.iter().zip(steps.iter()) {
            match *column {
                Column::Base(index) => state.base[index] += step,
                Column::Amplitude { effect, parameter } => {
                    state.amplitudes[effect][parameter] += step;
                }
                Column::Empirical { .. } | Column::Place { .. } => {}
            }
        }
        state
    }

    /// Residuals of all rows.
    fn all(&self, steps: &DVector<f64>) -> DVector<f64> {
        let mut residuals = self.model.residuals(&self.state(steps));
        for correction in self.fitted.empirical {
            residuals += correction.added();
        }
        for (column, step) in self.fitted.columns.iter().zip(steps.iter()) {
            if let Some(moved) = self.moved_by(column) {
                residuals.axpy(*step, &moved, 1.0);
            }
        }
        residuals
    }

    /// What a unit of a column that is no part of a state adds to every row.
    fn moved_by(&self, column: &Column) -> Option<DVector<f64>> {
        match *column {
            Column::Empirical { correction, coefficient } => {
                let columns = &self.fitted.empirical[correction].columns;
                Some(columns.column(coefficient).into_owned())
            }
            _ => column.of_place(self.model, self.fitted.state),
        }
    }

    fn chi2(&self, steps: &DVector<f64>) -> f64 {
        let all = self.all(steps);
        self.rows.iter().map(|&(row, weight)| (all[row] * weight).powi(2)).sum()
    }

    fn coordinate(&self, steps: &DVector<f64>) -> f64 {
        coordinates(&self.model.pose_at(&self.state(steps)))[self.coordinate]
    }

    /// Whether the coordinate is where it is held.
    fn holds(&self, steps: &DVector<f64>) -> bool {
        (self.coordinate(steps) - self.target).abs() <= HOLDS * self.tolerance
    }

    /// How the noise of the rows spreads over the pose, to first order at `at`.
    fn spread(&self, at: &DVector<f64>) -> Spread {
        let all = self.by_steps(at);
        let mut rows = DMatrix::zeros(self.rows.len(), all.ncols());
        for (k, &(row, weight)) in self.rows.iter().enumerate() {
            rows.set_row(k, &(all.row(row) * weight));
        }
        let mut along = self.model.pose_by_columns(&self.state(at), self.fitted.columns);
        let lengths = DVector::from_iterator(
            rows.ncols(),
            rows.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)),
        );
        for (k, length) in lengths.iter().enumerate() {
            rows.column_mut(k).unscale_mut(*length);
            along.column_mut(k).unscale_mut(*length);
        }
        Spread { r: rows.qr().r(), along, lengths }
    }

    /// Factor by which an interval of the height is wider where the part may lie level.
    ///
    /// Tilts lift the vertex by `R (α² + β²) / 2`. Of a height at which both are zero χ² has two
    /// degrees of freedom instead of one, as the estimate may err in either tilt; farther from level
    /// the Rice distribution has the interval of one degree again. How well the touches show a tilt
    /// is taken where the height is held: a level near-sphere shows it worse than a tilted one, and
    /// the estimate is always too far from level.
    fn beside_level(&self, steps: &DVector<f64>) -> f64 {
        let Some(information) = self.spread(steps).tilt_information() else { return 1.0 };
        let angles = self.model.pose_at(&self.state(steps)).angles;
        let tilts = Vector2::new(angles.alpha_rad, angles.beta_rad);
        let away = tilts.dot(&(information * tilts)).max(0.0).sqrt();
        1.0 + (LEVEL - 1.0) * (1.0 - away / LEVEL_REACH).max(0.0)
    }

    fn by_steps(&self, steps: &DVector<f64>) -> DMatrix<f64> {
        let state = self.state(steps);
        let base = self.model.base_jacobian(&state);
        let mut all = DMatrix::zeros(base.nrows(), steps.len());
        for (k, column) in self.fitted.columns.iter().enumerate() {
            match *column {
                Column::Base(index) => all.set_column(k, &base.column(index)),
                Column::Amplitude { effect, parameter } => {
                    all.set_column(k, &whole_tangent(self.model, &state, effect).column(parameter));
                }
                Column::Empirical { .. } | Column::Place { .. } => {
                    if let Some(moved) = self.moved_by(column) {
                        all.set_column(k, &moved);
                    }
                }
            }
        }
        all
    }
}

/// First order of a fit: `r` is that of the rows with columns of length one, `along` the derivative
/// of the pose by the columns so scaled.
struct Spread {
    r: DMatrix<f64>,
    along: DMatrix<f64>,
    lengths: DVector<f64>,
}

impl Spread {
    /// Steps that move a coordinate by one and raise χ² least; zeros where nothing moves it.
    ///
    /// From a start along them the solver has little to do; from the estimate itself it would have
    /// to follow the valley in which tilt and decentre cancel, and stalls.
    fn cheapest(&self, coordinate: usize) -> DVector<f64> {
        let gradient = self.along.row(coordinate).transpose();
        let whitened = self.r.tr_solve_upper_triangular(&gradient);
        let steps = whitened.and_then(|whitened| {
            let square = whitened.norm_squared();
            let steps = self.r.solve_upper_triangular(&whitened)?;
            (square > f64::MIN_POSITIVE).then(|| steps.component_div(&self.lengths) / square)
        });
        steps.unwrap_or_else(|| DVector::zeros(self.lengths.len()))
    }

    /// Inverse covariance of both tilts, 1/rad²; `None` where one is held.
    fn tilt_information(&self) -> Option<Matrix2<f64>> {
        let whitened = self.r.tr_solve_upper_triangular(&self.along.rows(TILTS, 2).transpose())?;
        let covariance = whitened.tr_mul(&whitened).fixed_view::<2, 2>(0, 0).into_owned();
        covariance.try_inverse()
    }
}

impl Problem for Held<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.rows.len() + 1
    }

    fn tangent_dim(&self) -> usize {
        self.fitted.columns.len()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        let all = self.all(at);
        for (out, &(row, weight)) in out.iter_mut().zip(&self.rows) {
            *out = all[row] * weight;
        }
        out[self.rows.len()] = (self.coordinate(at) - self.target) / self.tolerance;
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        let all = self.by_steps(at);
        for (k, &(row, weight)) in self.rows.iter().enumerate() {
            out.set_row(k, &(all.row(row) * weight));
        }
        let state = self.state(at);
        let along = self.model.pose_by_columns(&state, self.fitted.columns);
        let held: RowDVector<f64> = along.row(self.coordinate) / self.tolerance;
        out.set_row(self.rows.len(), &held);
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}
