//! What a drift leaves in a residual along any course of time.

use nalgebra::DMatrix;

use crate::algebra::looked_through::LookedThrough;
use crate::{Effect, Model, State, whole_tangent};

/// Readings on either side of a break, at least: a level and a slope, and as many again to judge them.
/// Fewer are readings far off, which have a name of their own.
const MIN_SIDE: usize = 4;

/// A residual in which drifts are looked for.
pub(crate) struct Drifts<'a> {
    pub(crate) residual: LookedThrough,
    /// Of each row.
    observations: Vec<usize>,
    /// Tangent of the drift that goes on evenly.
    pub(crate) even: DMatrix<f64>,
    elapsed: &'a [f64],
}

impl<'a> Drifts<'a> {
    /// Of a model at a solution of its declared part. `drift` is the effect that goes on evenly,
    /// `elapsed` what its amplitudes are multiplied by, one value per observation; `None` where no
    /// time passes.
    pub(crate) fn of(
        model: &dyn Model,
        at: &State,
        drift: usize,
        elapsed: &'a [f64],
    ) -> Option<Self> {
        if elapsed.iter().any(|t| *t < 0.0) {
            return None;
        }
        let residual = LookedThrough::of(model, at);
        let rows = &model.declared().layout.rows;
        let observations = residual.rows().iter().map(|&row| rows[row].observation).collect();
        let even = whole_tangent(model, at, drift).select_rows(residual.rows());
        let drifts = Self { residual, observations, even, elapsed };
        let span = drifts.span();
        (span > 0.0 && span.is_finite()).then_some(drifts)
    }

    /// Time that passes, from the start of the series.
    pub(crate) fn span(&self) -> f64 {
        self.elapsed.iter().copied().fold(0.0, f64::max)
    }

    /// What the fitted parameters leave of the drift along a course.
    pub(crate) fn left_along(&self, course: impl Fn(f64) -> f64) -> DMatrix<f64> {
        let mut columns = self.even.clone();
        for (mut row, &observation) in columns.row_iter_mut().zip(&self.observations) {
            // What has no time, as prior knowledge, no drift moves.
            let passed = self.elapsed.get(observation).copied().filter(|t| *t > 0.0);
            row *= passed.map_or(0.0, |t| course(t) / t);
        }
        self.residual.left_of(self.residual.whitened(columns))
    }

    /// The same along each of some courses, with amplitudes of its own.
    pub(crate) fn left_along_each(&self, courses: &[&dyn Fn(f64) -> f64]) -> DMatrix<f64> {
        let columns = self.even.ncols();
        let mut all = DMatrix::zeros(self.even.nrows(), courses.len() * columns);
        for (k, course) in courses.iter().enumerate() {
            all.columns_mut(k * columns, columns).copy_from(&self.left_along(course));
        }
        all
    }

    /// Times at which a drift may break off.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let mut seen = self.observations.clone();
        seen.sort_unstable();
        seen.dedup();
        let mut times: Vec<f64> =
            seen.iter().filter_map(|&observation| self.elapsed.get(observation).copied()).collect();
        times.sort_by(f64::total_cmp);
        breaks(&times)
    }
}

/// One between each two successive values of an ascending series, with enough of it on either side.
pub(crate) fn breaks(ascending: &[f64]) -> Vec<f64> {
    let last = ascending.len().saturating_sub(MIN_SIDE);
    (MIN_SIDE..=last)
        .map(|after| [ascending[after - 1], ascending[after]])
        .filter(|[before, after]| before < after)
        .map(|[before, after]| f64::midpoint(before, after))
        .collect()
}

/// The effect of a drift that goes on in another way, found by looking at so many.
pub(crate) fn along(even: &Effect, how: &str, searched: usize) -> Effect {
    let of = even.subject.as_ref().map_or_else(String::new, |subject| format!("{subject}, "));
    Effect { subject: Some(format!("{of}{how}")), searched, ..even.clone() }
}
