//! Evenly spaced places along one axis, out of a table.

/// Share of the spacing by which the decimals of a file may put a place beside its own.
const UNEVEN_SHARE: f64 = 1e-3;

/// Evenly spaced places along one axis.
pub(super) struct Axis {
    pub(super) first: f64,
    pub(super) step: f64,
    pub(super) count: usize,
}

/// First place, least step and number of steps; a single place has no step.
pub(super) fn axis(values: &[f64]) -> Axis {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    let rounding = UNEVEN_SHARE * UNEVEN_SHARE * (last - first);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > rounding);
    let step = steps.fold(last - first, f64::min);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded just before; too uneven a grid has too many places"
    )]
    let count = if step > 0.0 { ((last - first) / step).round().min(1e9) as usize + 1 } else { 1 };
    // The mean step, as rounding spreads over all of them.
    let even = if count > 1 { (last - first) / as_f64(count - 1) } else { 0.0 };
    Axis { first, step: even, count }
}

impl Axis {
    pub(super) fn last(&self) -> f64 {
        self.first + self.step * as_f64(self.count.saturating_sub(1))
    }

    pub(super) fn at(&self, index: usize) -> f64 {
        self.first + self.step * as_f64(index)
    }

    /// Index of the place next to a value.
    pub(super) fn nearest(&self, value: f64) -> usize {
        let place = ((value - self.first) / self.step).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of places"
        )]
        let index = place.clamp(0.0, as_f64(self.count.saturating_sub(1))) as usize;
        index
    }

    pub(super) fn slot(&self, value: f64) -> Option<usize> {
        let place = if self.step > 0.0 { (value - self.first) / self.step } else { 0.0 };
        let near = place.round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of places"
        )]
        let index = near as usize;
        ((place - near).abs() <= UNEVEN_SHARE).then_some(index)
    }
}

#[expect(clippy::cast_precision_loss, reason = "places of a grid are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
