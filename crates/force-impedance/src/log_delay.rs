//! A reference that is read late: block means of the record shifted in time.

use std::ops::Range;

use crate::LogSample;

/// The reference as a line through its samples, and the integral of that line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    time_s: Vec<f64>,
    value_n: Vec<f64>,
    /// From the first sample on.
    integral_ns: Vec<f64>,
    /// First sample in the log.
    first: usize,
}

impl Record {
    /// Of one segment whose first sample has this index; `None` without a reference.
    pub(crate) fn of(run: &[LogSample], first: usize) -> Option<Self> {
        let value_n: Vec<f64> = run.iter().map(|s| s.reference_n).collect::<Option<_>>()?;
        let time_s: Vec<f64> = run.iter().map(|s| s.time_s).collect();
        let mut integral_ns = vec![0.0];
        for i in 1..run.len() {
            let area = 0.5 * (value_n[i] + value_n[i - 1]) * (time_s[i] - time_s[i - 1]);
            integral_ns.push(integral_ns[i - 1] + area);
        }
        Some(Self { time_s, value_n, integral_ns, first })
    }

    /// Mean over a block's time, later by `delay_s`, and its derivative by the delay.
    pub(crate) fn mean(&self, block: &Range<usize>, delay_s: f64) -> (f64, f64) {
        let [from_s, to_s] = self.span(block);
        let length_s = to_s - from_s;
        if length_s <= 0.0 {
            return (self.value_n[0], 0.0);
        }
        let (a, b) = (self.at(from_s + delay_s), self.at(to_s + delay_s));
        ((b.integral_ns - a.integral_ns) / length_s, (b.value_n - a.value_n) / length_s)
    }

    /// Half an interval beyond the first and last sample of a block; half an interval within the
    /// record's own ends, beyond which there is nothing to shift to.
    fn span(&self, block: &Range<usize>) -> [f64; 2] {
        let (first, last) = (block.start - self.first, block.end - 1 - self.first);
        let end = self.time_s.len() - 1;
        let middle = |i: usize| {
            let next = (i + 1).min(end);
            0.5 * (self.time_s[i] + self.time_s[next])
        };
        [
            middle(first.saturating_sub(1)),
            middle(if last < end { last } else { end.saturating_sub(1) }),
        ]
    }

    /// Value and integral at a time; before the first and after the last sample nothing changes.
    fn at(&self, time_s: f64) -> At {
        let end = self.time_s.len() - 1;
        let i = self.time_s.partition_point(|t| *t <= time_s);
        if i == 0 || i > end {
            let edge = if i == 0 { 0 } else { end };
            let beyond_s = time_s - self.time_s[edge];
            let value_n = self.value_n[edge];
            return At { value_n, integral_ns: self.integral_ns[edge] + beyond_s * value_n };
        }
        let since_s = time_s - self.time_s[i - 1];
        let share = since_s / (self.time_s[i] - self.time_s[i - 1]);
        let before_n = self.value_n[i - 1];
        let value_n = before_n + share * (self.value_n[i] - before_n);
        let area = 0.5 * (before_n + value_n) * since_s;
        At { value_n, integral_ns: self.integral_ns[i - 1] + area }
    }
}

struct At {
    value_n: f64,
    integral_ns: f64,
}
