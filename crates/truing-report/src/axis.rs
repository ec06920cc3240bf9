//! Ranges, ticks and the map from data to drawing.

use super::number::{decade, fixed, real, significant};

/// Values beyond it are not drawn: their differences overflow.
const DRAWABLE: f64 = 1e150;

/// An interval of data, `low < high`, both drawable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Range {
    /// The smallest range that holds every drawable value; `None` where there is none.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in values.into_iter().filter(|v| drawable(*v)) {
            low = low.min(v);
            high = high.max(v);
        }
        (low <= high).then(|| Self { low, high }.opened())
    }

    /// Wider on both sides by a share of the span.
    pub(crate) fn padded(self, share: f64) -> Self {
        let margin = share * self.span();
        Self { low: self.low - margin, high: self.high + margin }
    }

    pub(crate) fn span(self) -> f64 {
        self.high - self.low
    }

    pub(crate) fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    pub(crate) fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    pub(crate) fn clamp(self, value: f64) -> f64 {
        value.clamp(self.low, self.high)
    }

    /// A range with an inside, also where all values are the same.
    fn opened(self) -> Self {
        let size = self.low.abs().max(self.high.abs());
        // Narrower than this, ticks would differ only in digits that f64 does not hold.
        let narrowest = (1e-9 * size).max(f64::MIN_POSITIVE * 1e20);
        if self.span() > narrowest {
            return self;
        }
        let half = if size > 0.0 { 0.05 * size } else { 1.0 };
        Self { low: self.low - half, high: self.high + half }
    }
}

pub(crate) fn drawable(value: f64) -> bool {
    value.abs() < DRAWABLE
}

/// More than any axis has; ends the search where steps drown in round-off.
const MOST_TICKS: usize = 40;

/// A tick and what is written at it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) at: f64,
    pub(crate) label: String,
}

/// Two or more ticks at round values, about `most` at most.
pub(crate) fn ticks(range: Range, most: usize) -> Vec<Tick> {
    let found = ticks_every(round_step(range.span() / real(most.max(1))), range);
    // A rounded step is up to 5/2 of what was asked: a fifth leaves room for two.
    if found.len() < 2 { ticks_every(round_step(range.span() / 5.0), range) } else { found }
}

fn ticks_every(step: f64, range: Range) -> Vec<Tick> {
    let first = (range.low / step).ceil();
    let mut found = Vec::new();
    for i in 0..MOST_TICKS {
        let at = (first + real(i)) * step;
        // Half a millionth of a step: a tick that round-off pushed over the edge.
        if at > range.high + 5e-7 * step {
            break;
        }
        found.push(Tick { at, label: tick_label(at, step, range) });
    }
    found
}

/// 1, 2 or 5 times a power of ten, not below `least`.
pub(crate) fn round_step(least: f64) -> f64 {
    let power = 10f64.powi(decade(least));
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| least <= f * power * (1.0 + 1e-9));
    factor.unwrap_or(10.0) * power
}

fn tick_label(at: f64, step: f64, range: Range) -> String {
    if at.abs() < 1e-6 * step {
        return "0".to_string();
    }
    let largest = decade(range.low.abs().max(range.high.abs()));
    let smallest = decade(step);
    if (-4..7).contains(&largest) && smallest >= -6 {
        fixed(at, (-smallest).max(0))
    } else {
        significant(at, (largest - smallest + 1).clamp(1, 13))
    }
}

/// Maps a range of data to a stretch of the drawing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) range: Range,
    pub(crate) from_px: f64,
    pub(crate) to_px: f64,
}

impl Scale {
    /// Where a value is drawn; values outside the range land on its edge.
    pub(crate) fn px(&self, value: f64) -> f64 {
        let share = (self.range.clamp(value) - self.range.low) / self.range.span();
        self.from_px + share * (self.to_px - self.from_px)
    }
}
