//! The declared model with a chosen set of effects and empirical corrections switched on.

use least_squares::{Problem, SolveError, between_variance, solve};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::algebra::product::gram;
use crate::model::whole_tangent;
use crate::{Column, EmpiricalCorrection, Layout, Model, Role, Row, State};

/// A correction that is linear in its coefficients and knows no physics.
#[derive(Clone, Debug)]
pub(crate) struct Empirical {
    /// Column it follows.
    pub(crate) covariate: String,
    /// Its shape in words.
    pub(crate) shape: String,
    /// One per column of `columns`.
    pub(crate) coefficients: Vec<String>,
    /// How many of the last columns are constants, which are no finding of their own.
    pub(crate) constants: usize,
    /// What one unit of each coefficient adds to the residual, in report units.
    pub(crate) columns: DMatrix<f64>,
}

/// An effect that is switched on, and which of its amplitudes are free.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Active {
    /// Index into [`Model::effects`].
    pub(crate) effect: usize,
    /// Amplitudes that the design can see; the others stay at zero.
    pub(crate) parameters: Vec<usize>,
}

/// A model and what is switched on in it.
#[derive(Clone)]
pub(crate) struct System<'a> {
    pub(crate) model: &'a dyn Model,
    /// In the order added.
    pub(crate) active: Vec<Active>,
    pub(crate) empirical: Vec<Empirical>,
}

/// Most rounds of weighing and fitting; each changes the weights tenfold less than the last.
const MAX_REWEIGHTINGS: usize = 4;

/// Relative change of the common variance that no longer matters: a hundredth of its own
/// uncertainty from a thousand rows.
const SETTLED: f64 = 5e-4;

/// Damping of the first step of a fit that starts beside its end: Gauss-Newton's own step but for
/// directions that are hardly determined.
const NEAR: f64 = 1e-6;

/// Steps of a fit that starts beside its end; where more are needed it was not beside it.
const MOST_NEAR_STEPS: usize = 6;

/// Share of the squared residual that a last step may promise: its error is that share of it.
const NEAR_ENOUGH: f64 = 1e-10;

/// Share of a column's length that must be new beside those before it for products of columns to
/// hold enough digits.
const WELL_DETERMINED: f64 = 1e-5;

/// Parameters of a [`System`].
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    pub(crate) state: State,
    /// One vector per empirical correction.
    pub(crate) coefficients: Vec<DVector<f64>>,
    /// Variance that reported rows share beyond their sigma, in report units squared.
    pub(crate) between_variance: f64,
}

impl Estimate {
    /// Standard uncertainty of a row, common scatter included.
    pub(crate) fn sigma(&self, row: &Row) -> f64 {
        if row.reported && self.between_variance > 0.0 {
            row.sigma.hypot(self.between_variance.sqrt())
        } else {
            row.sigma
        }
    }
}

impl<'a> System<'a> {
    pub(crate) fn declared(model: &'a dyn Model) -> Self {
        Self { model, active: Vec::new(), empirical: Vec::new() }
    }

    pub(crate) fn with_effect(&self, active: Active) -> Self {
        let mut next = self.clone();
        next.active.push(active);
        next
    }

    pub(crate) fn without_effect(&self, effect: usize) -> Self {
        let mut next = self.clone();
        next.active.retain(|a| a.effect != effect);
        next
    }

    pub(crate) fn without_empirical(&self, covariate: &str, shape: &str) -> Self {
        let mut next = self.clone();
        next.empirical.retain(|e| e.covariate != covariate || e.shape != shape);
        next
    }

    pub(crate) fn has_effect(&self, effect: usize) -> bool {
        self.active.iter().any(|a| a.effect == effect)
    }

    /// Whether the same is switched on in both.
    pub(crate) fn is_same(&self, other: &System<'_>) -> bool {
        self.active == other.active
            && self.empirical.len() == other.empirical.len()
            && (self.empirical.iter().zip(&other.empirical)).all(|(a, b)| {
                a.covariate == b.covariate && a.shape == b.shape && a.columns == b.columns
            })
    }

    pub(crate) fn with_empirical(&self, empirical: Empirical) -> Self {
        let mut next = self.clone();
        next.empirical.push(empirical);
        next
    }

    pub(crate) fn start(&self) -> Estimate {
        let base = self.model.declared().start.clone();
        self.warm_start(&Estimate {
            state: State::declared(base, &self.model.declared().effects),
            coefficients: Vec::new(),
            between_variance: 0.0,
        })
    }

    /// The estimate of a system with less, or more, switched on, as a start for this one.
    pub(crate) fn warm_start(&self, from: &Estimate) -> Estimate {
        let mut state = from.state.clone();
        for (e, amplitudes) in state.amplitudes.iter_mut().enumerate() {
            for (p, amplitude) in amplitudes.iter_mut().enumerate() {
                if !self.active.iter().any(|a| a.effect == e && a.parameters.contains(&p)) {
                    *amplitude = 0.0;
                }
            }
        }
        let coefficients = self
            .empirical
            .iter()
            .enumerate()
            .map(|(i, e)| match from.coefficients.get(i) {
                Some(known) if known.len() == e.columns.ncols() => known.clone(),
                _ => DVector::zeros(e.columns.ncols()),
            })
            .collect();
        Estimate { state, coefficients, between_variance: from.between_variance }
    }

    pub(crate) fn dim(&self) -> usize {
        self.model.declared().base.len()
            + self.active.iter().map(|a| a.parameters.len()).sum::<usize>()
            + self.empirical.iter().map(|e| e.columns.ncols()).sum::<usize>()
    }

    /// Residuals of all rows, in report units.
    pub(crate) fn residuals(&self, at: &Estimate) -> DVector<f64> {
        let mut r = self.model.residuals(&at.state);
        for (e, c) in self.empirical.iter().zip(&at.coefficients) {
            r.gemv(1.0, &e.columns, c, 1.0);
        }
        r
    }

    /// Jacobian of [`System::residuals`]: base, active effects, empirical corrections.
    pub(crate) fn jacobian(&self, at: &Estimate) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(self.model.declared().layout.rows.len(), self.dim());
        let mut column = 0;
        let mut put = |block: &DMatrix<f64>| {
            jacobian.columns_mut(column, block.ncols()).copy_from(block);
            column += block.ncols();
        };
        put(&self.model.base_jacobian(&at.state));
        for a in &self.active {
            put(&whole_tangent(self.model, &at.state, a.effect).select_columns(&a.parameters));
        }
        for e in &self.empirical {
            put(&e.columns);
        }
        jacobian
    }

    /// [`System::jacobian`] with a column for each of [`System::places`].
    pub(crate) fn jacobian_with_places(&self, at: &Estimate) -> DMatrix<f64> {
        let (known, places) = (self.dim(), self.places());
        let mut jacobian = self.jacobian(at).resize_horizontally(known + places.len(), 0.0);
        for (k, place) in places.iter().enumerate() {
            if let Some(column) = place.of_place(self.model, &at.state) {
                jacobian.set_column(known + k, &column);
            }
        }
        jacobian
    }

    fn stepped(&self, at: &Estimate, step: &DVector<f64>) -> Estimate {
        let mut next = at.clone();
        let base_len = next.state.base.len();
        let mut rest = step.iter().skip(base_len);
        next.state.base += step.rows(0, base_len);
        let amplitudes =
            self.active.iter().flat_map(|a| a.parameters.iter().map(|&p| (a.effect, p)));
        for ((effect, p), step) in amplitudes.zip(rest.by_ref()) {
            next.state.amplitudes[effect][p] += step;
        }
        for (c, step) in next.coefficients.iter_mut().flat_map(DVector::iter_mut).zip(rest) {
            *c += step;
        }
        next
    }

    /// Fits to the rows of `keep` from where the model says to start, be it far off, with the
    /// scatter that all rows share.
    pub(crate) fn fit_first(&self, keep: &[usize]) -> Result<Estimate, SolveError<Estimate>> {
        let at = self.fit_with(keep, &self.start(), &least_squares::Options::default())?;
        self.reweighed(keep, at)
    }

    /// Fits everything that is switched on to the rows of `keep`, weighed as at `start`, the fit of
    /// almost the same system to almost the same rows.
    pub(crate) fn fit(
        &self,
        keep: &[usize],
        start: &Estimate,
    ) -> Result<Estimate, SolveError<Estimate>> {
        if let Some(at) = self.fit_beside(keep, start) {
            return Ok(at);
        }
        let options =
            least_squares::Options { initial_damping: NEAR, ..least_squares::Options::default() };
        self.fit_with(keep, start, &options)
    }

    /// Gauss and Newton's steps by products of columns, from beside the end; `None` where these do
    /// not lead there at once.
    ///
    /// A step with the products of the point before, which the gradient there corrects, ends it:
    /// what the products lose in digits that step has back.
    fn fit_beside(&self, keep: &[usize], start: &Estimate) -> Option<Estimate> {
        let layout = &self.model.declared().layout;
        let mut at = self.warm_start(start);
        let mut known: Option<(Cholesky<f64, Dyn>, f64)> = None;
        for _ in 0..MOST_NEAR_STEPS {
            let mut jacobian = whitened(layout, &at, keep, &self.jacobian(&at));
            let all = self.residuals(&at);
            let sigma = keep.iter().map(|&row| all[row] / at.sigma(&layout.rows[row]));
            let residual = DVector::from_iterator(keep.len(), sigma);
            let lengths: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
            if lengths.iter().any(|length| !length.is_normal()) {
                return None;
            }
            for (mut column, length) in jacobian.column_iter_mut().zip(&lengths) {
                column.unscale_mut(*length);
            }
            let gradient = jacobian.tr_mul(&residual);
            let square = residual.norm_squared();
            let moved = |step: DVector<f64>| {
                let step = DVector::from_fn(step.len(), |i, _| -step[i] / lengths[i]);
                self.stepped(&at, &step)
            };
            if let Some((factor, before)) = &known {
                let step = factor.solve(&gradient);
                let promise = gradient.dot(&step);
                if promise <= NEAR_ENOUGH * square {
                    return Some(moved(step));
                }
                if square > *before {
                    return None;
                }
            }
            let factor = gram(&jacobian).cholesky()?;
            if factor.l_dirty().diagonal().iter().any(|d| *d < WELL_DETERMINED) {
                return None;
            }
            at = moved(factor.solve(&gradient));
            known = Some((factor, square));
        }
        None
    }

    fn fit_with(
        &self,
        keep: &[usize],
        start: &Estimate,
        options: &least_squares::Options,
    ) -> Result<Estimate, SolveError<Estimate>> {
        if self.dim() == 0 {
            return Ok(start.clone());
        }
        let kept = Kept { system: self, rows: keep };
        Ok(solve(&kept, self.warm_start(start), options)?.point)
    }

    /// [`System::fit`] with the scatter that all rows share estimated anew.
    pub(crate) fn fit_anew(
        &self,
        keep: &[usize],
        start: &Estimate,
    ) -> Result<Estimate, SolveError<Estimate>> {
        self.reweighed(keep, self.fit(keep, start)?)
    }

    /// The fit `at` with the scatter that all rows share estimated anew.
    pub(crate) fn reweighed(
        &self,
        keep: &[usize],
        mut at: Estimate,
    ) -> Result<Estimate, SolveError<Estimate>> {
        if !self.model.declared().between_variance {
            return Ok(at);
        }
        for _ in 0..MAX_REWEIGHTINGS {
            let before = at.between_variance;
            at.between_variance = self.between_variance(keep, &at);
            if (at.between_variance - before).abs() <= SETTLED * at.between_variance {
                break;
            }
            at = self.fit(keep, &at)?;
        }
        Ok(at)
    }

    fn between_variance(&self, keep: &[usize], at: &Estimate) -> f64 {
        let rows = &self.model.declared().layout.rows;
        let sigma: Vec<_> = keep.iter().map(|&row| rows[row].sigma).collect();
        let residual = self.residuals(at).select_rows(keep);
        let jacobian = self.jacobian(at).select_rows(keep);
        between_variance(&sigma, |kept| rows[keep[kept]].reported, &residual, &jacobian)
    }

    /// What the columns of [`System::jacobian`] are about.
    pub(crate) fn columns(&self) -> Vec<Column> {
        let base = (0..self.model.declared().base.len()).map(Column::Base);
        let amplitude = |a: &Active| {
            let effect = a.effect;
            let free = a.parameters.clone().into_iter();
            free.map(move |parameter| Column::Amplitude { effect, parameter })
        };
        let coefficient = |(correction, e): (usize, &Empirical)| {
            let all = 0..e.columns.ncols();
            all.map(move |coefficient| Column::Empirical { correction, coefficient })
        };
        let amplitudes = self.active.iter().flat_map(amplitude);
        base.chain(amplitudes)
            .chain(self.empirical.iter().enumerate().flat_map(coefficient))
            .collect()
    }

    /// Coordinates of the places at which effects that are switched on were found.
    pub(crate) fn places(&self) -> Vec<Column> {
        let effects = &self.model.declared().effects;
        let of = |a: &Active| {
            let effect = a.effect;
            (0..effects[effect].coordinates())
                .map(move |coordinate| Column::Place { effect, coordinate })
        };
        self.active.iter().flat_map(of).collect()
    }

    /// The empirical corrections as fitted.
    pub(crate) fn corrections(&self, at: &Estimate) -> Vec<EmpiricalCorrection> {
        let correction = |(e, c): (&Empirical, &DVector<f64>)| EmpiricalCorrection {
            covariate: e.covariate.clone(),
            shape: e.shape.clone(),
            coefficients: c.clone(),
            columns: e.columns.clone(),
        };
        self.empirical.iter().zip(&at.coefficients).map(correction).collect()
    }

    /// Names of the columns of [`System::jacobian`].
    pub(crate) fn parameter_names(&self) -> Vec<String> {
        let effects = &self.model.declared().effects;
        let base = self.model.declared().base.iter().map(|p| p.name.clone());
        let active = self
            .active
            .iter()
            .flat_map(|a| a.parameters.iter().map(move |&p| (a.effect, p)))
            .map(|(e, p)| format!("{} {}", effects[e].id, effects[e].parameters[p].name));
        let empirical = self.empirical.iter().flat_map(|e| e.coefficients.iter().cloned());
        base.chain(active).chain(empirical).collect()
    }
}

/// Least-squares view of some of the rows.
struct Kept<'a, 'm> {
    system: &'a System<'m>,
    rows: &'a [usize],
}

impl Problem for Kept<'_, '_> {
    type Point = Estimate;

    fn residual_count(&self) -> usize {
        self.rows.len()
    }

    fn tangent_dim(&self) -> usize {
        self.system.dim()
    }

    fn residuals(&self, at: &Estimate, out: &mut DVector<f64>) {
        let layout = &self.system.model.declared().layout;
        let all = self.system.residuals(at);
        for (out, &row) in out.iter_mut().zip(self.rows) {
            *out = all[row] / at.sigma(&layout.rows[row]);
        }
    }

    fn jacobian(&self, at: &Estimate, out: &mut DMatrix<f64>) {
        let layout = &self.system.model.declared().layout;
        out.copy_from(&whitened(layout, at, self.rows, &self.system.jacobian(at)));
    }

    fn retract(&self, at: &Estimate, step: &DVector<f64>) -> Estimate {
        self.system.stepped(at, step)
    }

    fn parameter_name(&self, index: usize) -> String {
        self.system.parameter_names().swap_remove(index)
    }
}

/// Rows of the groups for which `keep` is true, and of all priors.
pub(crate) fn rows_of(layout: &Layout, keep: &[bool]) -> Vec<usize> {
    let wanted = |row: &usize| {
        let group = layout.observations[layout.rows[*row].observation];
        keep[group] || layout.groups[group].role == Role::Prior
    };
    (0..layout.rows.len()).filter(wanted).collect()
}

/// The rows of `rows`, whitened.
pub(crate) fn whitened(
    layout: &Layout,
    at: &Estimate,
    rows: &[usize],
    all: &DMatrix<f64>,
) -> DMatrix<f64> {
    let sigma: Vec<_> = rows.iter().map(|&row| at.sigma(&layout.rows[row])).collect();
    let mut out = DMatrix::zeros(rows.len(), all.ncols());
    for (mut out, all) in out.column_iter_mut().zip(all.column_iter()) {
        for ((out, &row), sigma) in out.iter_mut().zip(rows).zip(&sigma) {
            *out = all[row] / sigma;
        }
    }
    out
}
