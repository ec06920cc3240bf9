//! What a drift leaves in a residual along any course of time.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use crate::algebra::looked_through::{LookedThrough, Sums};
use crate::{Effect, Model, State, whole_tangent};

/// Readings on either side of a break, at least: a level and a slope, and as many again to judge them.
/// Fewer are readings far off, which have a name of their own.
const MIN_SIDE: usize = 4;

/// Share of the square of a shift by one amplitude that parameters leave which do not take it up: of the first reading,
/// where no time has passed, more is left the fewer they are.
const LEFT_OF_A_ZERO: f64 = 0.2;

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
        self.residual.left_of(self.residual.whitened(self.along(course)))
    }

    /// Whether the fitted parameters leave hardly anything of one of the drift's amplitudes, the same at all times.
    pub(crate) fn has_zero_of_its_own(&self) -> bool {
        let whole = self.residual.whitened(self.along(|_| 1.0));
        let left = self.left_along(|_| 1.0);
        let is_left = |(left, whole): (_, _)| left > LEFT_OF_A_ZERO * whole;
        let squares = |columns: &DMatrix<f64>| -> Vec<f64> {
            columns.column_iter().map(|column| column.norm_squared()).collect()
        };
        !squares(&left).into_iter().zip(squares(&whole)).any(is_left)
    }

    /// Tangent of the drift along a course.
    fn along(&self, course: impl Fn(f64) -> f64) -> DMatrix<f64> {
        let mut columns = self.even.clone();
        for (mut row, &observation) in columns.row_iter_mut().zip(&self.observations) {
            // What has no time, as prior knowledge, no drift moves.
            let passed = self.elapsed.get(observation).copied().filter(|t| *t > 0.0);
            row *= passed.map_or(0.0, |t| course(t) / t);
        }
        columns
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

    /// What a shift by the drift's amplitudes from each of some ascending times on takes of the sum of
    /// squares; `None` where the amplitudes depend on each other.
    pub(crate) fn explained_by_shifts(&self, ascending: &[f64]) -> Vec<Option<f64>> {
        self.of_sums_after(ascending, Sums::explained)
    }

    /// The products of shifts from each of some ascending times on.
    pub(crate) fn sums_after(&self, ascending: &[f64]) -> Vec<Sums> {
        self.of_sums_after(ascending, Sums::clone)
    }

    /// All that comes after a time is summed up once, from the last reading on, so that many times cost no more than one.
    fn of_sums_after<T>(&self, ascending: &[f64], of: impl Fn(&Sums) -> T) -> Vec<T> {
        let shift = self.residual.whitened(self.along(|_| 1.0));
        let passed = |row: usize| self.elapsed.get(self.observations[row]).copied().unwrap_or(0.0);
        let mut left: Vec<usize> = (0..shift.nrows()).collect();
        left.sort_by(|&a, &b| passed(a).total_cmp(&passed(b)));
        let mut after = self.residual.nothing(shift.ncols());
        let mut of_each = Vec::with_capacity(ascending.len());
        for begins in ascending.iter().rev() {
            while let Some(row) = left.pop_if(|row| passed(*row) > *begins) {
                after.add(&self.residual, row, &shift);
            }
            of_each.push(of(&after));
        }
        of_each.reverse();
        of_each
    }

    /// Share of what the drift takes along a course that it takes of one reading.
    pub(crate) fn most_of_one_reading(&self, course: impl Fn(f64) -> f64) -> f64 {
        let left = self.left_along(course);
        let Some(amplitudes) = self.residual.amplitudes(&left) else { return 1.0 };
        let mut of_each: BTreeMap<usize, f64> = BTreeMap::new();
        let taken = &left * amplitudes;
        let rows = self.residual.values().iter().zip(&taken);
        for ((before, taken), &observation) in rows.zip(&self.observations) {
            *of_each.entry(observation).or_default() += taken * (2.0 * before - taken);
        }
        let whole: f64 = of_each.values().sum();
        of_each.values().copied().fold(0.0, f64::max) / whole
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
    // A course that stands out needs no two others whose place it takes.
    Effect { subject: Some(format!("{of}{how}")), searched, only_instead: false, ..even.clone() }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::count::count;
    use crate::{Declared, Group, Layout, LinearModel, Parameter, Role, Row};

    const READINGS: usize = 30;
    /// Of sums over as many products as there are readings, over the share of a shift that the base
    /// leaves.
    const ROUND_OFF: f64 = 1e-11;

    fn wave(i: usize, j: usize) -> f64 {
        (1.3 * count(i) + 0.7 * count(j * j) + 0.9 * count(i * j)).sin()
    }

    /// Two components a reading, times in no order and two of them equal, one reading without any time
    /// passed; against the columns of every shift themselves.
    #[test]
    fn shifts_by_sums_take_what_their_columns_take() {
        let elapsed: Vec<f64> = (0..READINGS).map(|i| count((7 * i) % READINGS / 2 * 2)).collect();
        let row = |i: usize| {
            let sigma = 1.0 + 0.1 * count(i % 4);
            Row { observation: i / 2, component: i % 2, sigma, reported: true }
        };
        let layout = Layout {
            rows: (0..2 * READINGS).map(row).collect(),
            observations: (0..READINGS).collect(),
            groups: (0..READINGS).map(|i| Group { name: i.to_string(), role: Role::Fit }).collect(),
            unit: "mm".to_owned(),
            sigma_declared: true,
        };
        let parameter = |name: &str| Parameter::new(name, "mm", 1.0);
        let drift = Effect::new("drift", "", vec![parameter("x"), parameter("y")]);
        let base = DMatrix::from_fn(2 * READINGS, 4, wave);
        let even = DMatrix::from_fn(2 * READINGS, 2, |i, j| {
            f64::from(u8::from(i % 2 == j)) * elapsed[i / 2]
        });
        let model = LinearModel {
            declared: Declared::new(
                layout,
                (0..4).map(|i| parameter(&i.to_string())).collect(),
                vec![drift],
            ),
            residual: DVector::from_fn(2 * READINGS, |i, _| wave(i, 9)),
            base,
            tangents: vec![even],
            extended: Vec::new(),
        };
        let drifts = Drifts::of(&model, &State::start(&model), 0, &elapsed).unwrap();
        let breaks = drifts.breaks();
        assert!(breaks.len() > READINGS / 4);
        for (begins, quick) in breaks.iter().zip(drifts.explained_by_shifts(&breaks)) {
            let left = drifts.left_along(|t| f64::from(u8::from(t > *begins)));
            let whole = drifts.residual.explained(&left).unwrap();
            assert!((quick.unwrap() - whole).abs() < ROUND_OFF, "{quick:?} {whole}");
        }
    }
}
