//! One channel of a record, and what it should have read.

/// Readings about a time from which the one at that time is worked out: with six, a signal of five
/// readings a period is known to a few hundredths of its height, with a straight line to a fifth.
const NODES: usize = 6;
/// A record on another clock: its column, its time, what it should have read, and the stretches
/// within which time runs on.
pub(crate) struct Record<'t> {
    pub(crate) file: &'static str,
    pub(crate) column: &'static str,
    pub(crate) time_s: &'t [f64],
    pub(crate) read: &'t [f64],
    pub(crate) expected: &'t [f64],
    /// One per reading.
    pub(crate) stretch: &'t [usize],
    /// Longest time by which a sound instrument reads late.
    pub(crate) latency_s: f64,
}

impl Record<'_> {
    /// Between two of its readings; `None` where its time does not run on.
    pub(super) fn interval_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = (1..self.time_s.len())
            .filter(|&i| self.stretch[i] == self.stretch[i - 1])
            .map(|i| self.time_s[i] - self.time_s[i - 1])
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0)
    }

    /// One of two courses this much later than at reading `i`, by a polynomial through the readings
    /// about that time; `None` beyond the ends of a stretch.
    pub(super) fn at(&self, values: &[f64], i: usize, offset_s: f64) -> Option<f64> {
        let at = self.time_s[i] + offset_s;
        let (mut first, mut last) = (i, i);
        let same = |j: usize| self.stretch[j] == self.stretch[i];
        while last + 1 < values.len() && same(last + 1) && self.time_s[last] < at {
            last += 1;
        }
        while first > 0 && same(first - 1) && self.time_s[first] > at {
            first -= 1;
        }
        if self.time_s[first] > at || self.time_s[last] < at {
            return None;
        }
        // The reading before that time or at it, and as many on either side.
        let mut middle = if offset_s < 0.0 { first } else { last };
        while middle > 0 && same(middle - 1) && self.time_s[middle] > at {
            middle -= 1;
        }
        let (mut low, mut high) = (middle, middle);
        while high - low + 1 < NODES {
            let down = low > 0 && same(low - 1);
            let up = high + 1 < values.len() && same(high + 1);
            match (down, up) {
                (true, true) if middle - low < high - middle => low -= 1,
                (_, true) => high += 1,
                (true, false) => low -= 1,
                (false, false) => break,
            }
        }
        let weight = |j: usize| -> f64 {
            let factor = |k: usize| (at - self.time_s[k]) / (self.time_s[j] - self.time_s[k]);
            (low..=high).filter(|k| *k != j).map(factor).product()
        };
        let value: f64 = (low..=high).map(|j| weight(j) * values[j]).sum();
        value.is_finite().then_some(value)
    }
}
