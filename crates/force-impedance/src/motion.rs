//! Motion of a point within speed, acceleration and jerk, cycle by cycle.
//!
//! Time is counted in nominal intervals: a step `v` is the way of one interval, a change `a` that
//! of a step, a jolt that of a change, each the difference of two commands. What is limited is
//! therefore what a drive sees, without an error of time steps.
//!
//! There is always a way to stop. With the lag σ behind the commanded point `p` stand two more,
//!
//! ```text
//! q = p + σ·v,    w = q − q_before = v + σ·a,    r = q + σ·w
//! ```
//!
//! and the action that keeps `r` where it is brings `q` to `r` and `p` to `q` by weighted means
//! with positive weights: `w ← σ/(1 + σ)·w`, `v ← (σ·v + w)/(1 + σ)`. So `|v|` and `|w|` stay
//! within any bound that they keep, and `p` within any convex set that holds `p`, `q` and `r`.
//! With `1 + σ ≥ V/A` changes stay within A under that action, and with `1 + σ ≥ 2·A/J` jolts
//! within J:
//!
//! ```text
//! a ← (σ·a − w/(1 + σ))/(1 + σ)         |a| ≤ (σ·A + V/(1 + σ))/(1 + σ) ≤ A
//! j = −(a + w/(1 + σ))/(1 + σ)          |j| ≤ (A + V/(1 + σ))/(1 + σ) ≤ 2·A/(1 + σ) ≤ J
//! ```
//!
//! All bounds are balls or half-spaces in the action, and stopping is within all of them: on the
//! way from stopping to what is wanted, the farthest point within them has a closed form.

use nalgebra::Vector3;

use crate::scalar::{norm, sqrt};

/// Bounds of a motion, per nominal interval and its powers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionLimits {
    /// Longest step.
    pub(crate) step: f64,
    /// Largest change of a step.
    change: f64,
    /// Largest change of a change.
    jolt: f64,
    /// σ, intervals.
    pub(crate) lag: f64,
}

impl MotionLimits {
    /// Speed, acceleration and jerk per second, within a range that is `span` long.
    pub(crate) fn new(
        speed_per_s: f64,
        acceleration_per_s2: f64,
        jerk_per_s3: f64,
        span: f64,
        interval_s: f64,
    ) -> Self {
        let t = interval_s;
        let (widest, jolt) = (acceleration_per_s2 * t * t, jerk_per_s3 * t * t * t);
        // Faster than this nothing gets that starts and stops within the range.
        let fastest = speed_per_s * t;
        let step = fastest.min(libm::sqrt(widest * span)).min(libm::cbrt(jolt * span * span));
        // More than this only makes the jolt the bound that counts.
        let change = widest.min(libm::sqrt(0.5 * step * jolt));
        let lag = (step / change).max(1.0) - 1.0;
        Self { step, change, jolt, lag }
    }

    /// `1 + σ`.
    #[inline]
    pub(crate) fn over(&self) -> f64 {
        1.0 + self.lag
    }

    /// Largest change and largest jolt.
    #[inline]
    pub(crate) fn change_and_jolt(&self) -> [f64; 2] {
        [self.change, self.jolt]
    }

    /// Factor on a gap between steps: the change with which the gap closes without overshooting,
    /// with jolts no larger than allowed.
    ///
    /// Falling by a jolt each cycle, a change of `m` jolts still adds `J·m·(m + 1)/2`.
    #[inline]
    fn share(&self, gap: f64) -> f64 {
        if gap <= self.jolt && gap <= self.change {
            return 1.0;
        }
        let jolts = gap / self.jolt;
        let whole = whole(0.5 * (sqrt(1.0 + 8.0 * jolts) - 1.0));
        let change = self.jolt * (jolts + 0.5 * whole * (whole + 1.0)) / (whole + 1.0);
        change.min(self.change).min(gap) / gap
    }

    /// The change that brings a step nearer to the one wanted.
    #[inline]
    pub(crate) fn toward(&self, gap: &Vector3<f64>) -> Vector3<f64> {
        gap * self.share(norm(gap))
    }

    /// The same along one direction.
    #[inline]
    pub(crate) fn toward_along(&self, gap: f64) -> f64 {
        gap * self.share(gap.abs())
    }
}

/// What is remembered of a motion: its last step, and the change that led to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Motion {
    pub(crate) step: Vector3<f64>,
    pub(crate) change: Vector3<f64>,
}

impl Motion {
    /// Nothing moves, nothing has to be decided.
    #[inline]
    pub(crate) fn is_at_rest(&self) -> bool {
        self.step == Vector3::zeros() && self.change == Vector3::zeros()
    }

    /// The action that keeps `r`.
    #[inline]
    pub(crate) fn stopping(&self, limits: &MotionLimits) -> Vector3<f64> {
        let share = 1.0 / limits.over();
        let led = self.step + self.change * limits.lag;
        (self.change * limits.lag - led * share) * share
    }

    /// `w` after an action.
    #[inline]
    pub(crate) fn led(&self, limits: &MotionLimits, change: &Vector3<f64>) -> Vector3<f64> {
        self.step + change * limits.over()
    }

    /// `r − p` after an action, with `p` from before it: where the motion can end.
    #[inline]
    pub(crate) fn end(&self, limits: &MotionLimits, change: &Vector3<f64>) -> Vector3<f64> {
        let over = limits.over();
        self.step * (over + limits.lag) + change * (over * over)
    }

    /// Whether an action keeps the bounds, `longest` that of `w`.
    #[inline]
    pub(crate) fn allows(
        &self,
        limits: &MotionLimits,
        change: &Vector3<f64>,
        longest: f64,
    ) -> bool {
        let jolt = change - self.change;
        let led = self.led(limits, change);
        change.dot(change) <= limits.change * limits.change
            && jolt.dot(&jolt) <= limits.jolt * limits.jolt
            && led.dot(&led) <= longest * longest
    }

    /// The share of `way` that may be added to the action `from`, which keeps the bounds.
    #[inline]
    pub(crate) fn reach(
        &self,
        limits: &MotionLimits,
        from: &Vector3<f64>,
        way: &Vector3<f64>,
        longest: f64,
    ) -> f64 {
        let of_jolt = within_ball(&(from - self.change), way, limits.jolt);
        let of_change = within_ball(from, way, limits.change);
        let led = self.led(limits, from) * (1.0 / limits.over());
        let of_step = within_ball(&led, way, longest / limits.over());
        of_jolt.min(of_change).min(of_step)
    }

    /// The state after an action.
    #[inline]
    pub(crate) fn after(&self, change: Vector3<f64>) -> Self {
        Self { step: self.step + change, change }
    }
}

/// The whole part of a number that is not negative; `libm`'s cannot be shown not to panic.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "truncation is wanted, and casts of floats saturate"
)]
fn whole(x: f64) -> f64 {
    f64::from(x as u32)
}

/// Largest share in `0..=1` of `way` from `from` on that stays within a ball about the origin.
#[inline]
fn within_ball(from: &Vector3<f64>, way: &Vector3<f64>, radius: f64) -> f64 {
    let length2 = way.dot(way);
    let along = from.dot(way);
    // From within, or from outside by round-off.
    let room = (radius * radius - from.dot(from)).max(0.0);
    let root = sqrt(along * along + length2 * room);
    // The larger root of `length2·s² + 2·along·s − room`, without cancellation.
    let share = if along > 0.0 { room / (along + root) } else { (root - along) / length2 };
    // NaN where the way has no length: then all of it.
    share.min(1.0)
}

/// Largest share in `0..=1` of `way` by which a number may grow from `from` on up to `most`.
#[inline]
pub(crate) fn up_to(from: f64, way: f64, most: f64) -> f64 {
    if way > 0.0 { ((most - from).max(0.0) / way).min(1.0) } else { 1.0 }
}
