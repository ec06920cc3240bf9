//! The reference in force: a number that follows another within rate, acceleration and jerk.

use crate::motion::MotionLimits;
use crate::scalar::between;

/// [`Motion`](crate::motion::Motion) of one number, with the action in closed form: in one
/// dimension the bounds are intervals, and stopping is in all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ramp {
    pub(crate) value: f64,
    step: f64,
    change: f64,
}

impl Ramp {
    pub(crate) const fn at(value: f64) -> Self {
        Self { value, step: 0.0, change: 0.0 }
    }

    /// One interval towards `asked`; `share` of the rate may be used.
    #[inline]
    pub(crate) fn follow(&mut self, limits: &MotionLimits, asked: f64, share: f64) {
        let over = limits.over();
        // `r` at once at what is asked: the value follows as a weighted mean, never past it.
        let wanted = (asked - self.value - self.step * (over + limits.lag)) / (over * over);
        let stop = self.stopping(limits);
        let most = limits.step * share;
        let low = ((-most - self.step) / over).min(stop);
        let high = ((most - self.step) / over).max(stop);
        self.go(limits, between(wanted, low, high));
        if (self.value - asked).abs() <= f64::EPSILON * asked.abs() {
            self.value = asked;
        }
    }

    /// One interval towards standing still.
    #[inline]
    pub(crate) fn stop(&mut self, limits: &MotionLimits) {
        self.go(limits, self.stopping(limits));
    }

    #[inline]
    fn stopping(&self, limits: &MotionLimits) -> f64 {
        let share = 1.0 / limits.over();
        let led = self.step + self.change * limits.lag;
        (self.change * limits.lag - led * share) * share
    }

    #[inline]
    fn go(&mut self, limits: &MotionLimits, wanted: f64) {
        let [change, jolt] = limits.change_and_jolt();
        let low = (-change).max(self.change - jolt);
        let high = change.min(self.change + jolt);
        self.change = between(wanted, low, high);
        self.step += self.change;
        self.value += self.step;
    }
}
