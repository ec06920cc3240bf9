//! Errors of the sensor and of the platform, and the centre of pressure without them.

use geometry::Wrench;
use nalgebra::{Matrix2, Vector2, Vector3};

/// What is wrong with a reading, as amplitudes of effects; all zero in the declared model.
///
/// With the true wrench on the right, `(Mx, My)` reads
///
/// ```text
/// gain·(I + shear)·(M + fz_into_moment·Fz + lateral_into_moment·(Fx, Fy)) + bias + drift·elapsed
/// ```
///
/// and `Fz` reads `gain·(Fz + moment_into_fz·M) + bias + drift·elapsed`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorErrors {
    pub(crate) moment_bias_nmm: Vector2<f64>,
    pub(crate) fz_bias_n: f64,
    pub(crate) moment_drift_nmm: Vector2<f64>,
    pub(crate) fz_drift_n: f64,
    pub(crate) moment_gain: f64,
    /// Gain of Mx more, of My less than `moment_gain`.
    pub(crate) moment_gain_difference: f64,
    pub(crate) fz_gain: f64,
    /// What Mx reads of My and My of Mx.
    pub(crate) shear: f64,
    pub(crate) moment_into_fz_per_mm: Vector2<f64>,
    pub(crate) fz_into_moment_mm: Vector2<f64>,
    pub(crate) lateral_into_moment_mm: Matrix2<f64>,
    /// True height of the contact plane over the declared one.
    pub(crate) height_mm: f64,
    /// Slope of the contact plane along x and y.
    pub(crate) slope: Vector2<f64>,
    /// What the head slips along x and y of the sensor, the way that friction drags it.
    pub(crate) slip_mm: Vector2<f64>,
    /// The same in a round guide: along the friction, whatever its direction.
    pub(crate) slip_along_mm: f64,
    /// The same per ratio of the friction to the load as read.
    pub(crate) slip_by_ratio_mm: f64,
    /// What the head gives way along a lateral force.
    pub(crate) give_mm_per_n: f64,
}

/// One reading: the wrench, and the share of the session that had passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) wrench: Wrench,
    /// Lateral force that effects follow: that of the wrench, as far as it is more than noise.
    pub(crate) drag_n: Vector2<f64>,
    pub(crate) elapsed_ratio: f64,
}

/// One amplitude of [`SensorErrors`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SensorError {
    MomentBias(usize),
    FzBias,
    MomentDrift(usize),
    FzDrift,
    MomentGain,
    MomentGainDifference,
    FzGain,
    Shear,
    MomentIntoFz(usize),
    FzIntoMoment(usize),
    LateralIntoMoment(usize, usize),
    Height,
    Slope(usize),
    Slip(usize),
    SlipAlong,
    SlipByRatio,
    Give,
}

/// A reading with the errors taken out, step by step: the way back to the true wrench.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corrected {
    reading: Reading,
    errors: SensorErrors,
    gains: Vector3<f64>,
    /// Mx, My, Fz after bias and gain.
    ungained: Vector3<f64>,
    /// Mx, My after shear; Fz after what it reads of them.
    unsheared: Vector3<f64>,
    plane: Matrix2<f64>,
    /// Centre of pressure in the sensor frame.
    pressure_mm: Vector2<f64>,
    /// The same without what the head slipped.
    pub(crate) center_mm: Vector2<f64>,
}

impl Corrected {
    pub(crate) fn of(reading: &Reading, errors: &SensorErrors, z0_mm: f64) -> Self {
        let (e, u) = (errors, reading.elapsed_ratio);
        let (f, m) = (reading.wrench.force_n, reading.wrench.torque_nmm);
        let drag = reading.drag_n;
        let gains = Vector3::new(
            1.0 + e.moment_gain + e.moment_gain_difference,
            1.0 + e.moment_gain - e.moment_gain_difference,
            1.0 + e.fz_gain,
        );
        let moment = m.xy() - e.moment_bias_nmm - e.moment_drift_nmm * u;
        let fz = f.z - e.fz_bias_n - e.fz_drift_n * u;
        let ungained = Vector3::new(moment.x, moment.y, fz).component_div(&gains);
        let moment = unshear(e.shear) * ungained.xy();
        let fz = ungained.z - e.moment_into_fz_per_mm.dot(&moment);
        let unsheared = Vector3::new(moment.x, moment.y, fz);
        let moment = moment - e.fz_into_moment_mm * fz - e.lateral_into_moment_mm * drag;
        let plane = Matrix2::identity() * fz - drag * e.slope.transpose();
        let q = Vector2::new(z0_mm * f.x - moment.y, moment.x + z0_mm * f.y) + e.height_mm * drag;
        let pressure_mm = plane.try_inverse().map_or(Vector2::repeat(f64::NAN), |inv| inv * q);
        let slipped = e.slip_mm.component_mul(&drag.map(sense))
            + e.slip_along_mm * along(drag)
            + e.slip_by_ratio_mm * over_load(reading);
        let center_mm = pressure_mm - slipped - e.give_mm_per_n * drag;
        let (reading, errors) = (*reading, *errors);
        Self { reading, errors, gains, ungained, unsheared, plane, pressure_mm, center_mm }
    }

    /// Derivative of the centre by one amplitude.
    pub(crate) fn derivative(&self, by: SensorError) -> Vector2<f64> {
        let lateral = self.reading.drag_n;
        match by {
            SensorError::Height => self.solve(lateral),
            SensorError::Slope(axis) => self.solve(lateral * self.pressure_mm[axis]),
            SensorError::Slip(axis) => Vector2::ith(axis, -sense(lateral[axis])),
            SensorError::SlipAlong => -along(lateral),
            SensorError::SlipByRatio => -over_load(&self.reading),
            SensorError::Give => -lateral,
            _ => {
                let d = self.wrench_derivative(by);
                self.solve(Vector2::new(-d.y, d.x) - self.pressure_mm * d.z)
            }
        }
    }

    /// Derivative of the true `Fz` by one amplitude.
    pub(crate) fn fz_derivative(&self, by: SensorError) -> f64 {
        match by {
            SensorError::Height
            | SensorError::Slope(_)
            | SensorError::Slip(_)
            | SensorError::SlipAlong
            | SensorError::SlipByRatio
            | SensorError::Give => 0.0,
            _ => self.wrench_derivative(by).z,
        }
    }

    pub(crate) fn fz_n(&self) -> f64 {
        self.unsheared.z
    }

    fn solve(&self, q: Vector2<f64>) -> Vector2<f64> {
        self.plane.try_inverse().map_or(Vector2::repeat(f64::NAN), |inv| inv * q)
    }

    /// Derivative of the true (Mx, My, Fz) by one amplitude, step by step.
    fn wrench_derivative(&self, by: SensorError) -> Vector3<f64> {
        let u = self.reading.elapsed_ratio;
        let axis = |k: usize| Vector3::from_fn(|i, _| f64::from(u8::from(i == k)));
        let part = |k: usize| axis(k) * -(self.ungained[k] / self.gains[k]);
        match by {
            SensorError::MomentBias(k) => self.after_bias(-axis(k)),
            SensorError::FzBias => self.after_bias(-axis(2)),
            SensorError::MomentDrift(k) => self.after_bias(-axis(k) * u),
            SensorError::FzDrift => self.after_bias(-axis(2) * u),
            SensorError::MomentGain => self.after_gain(part(0) + part(1)),
            SensorError::MomentGainDifference => self.after_gain(part(0) - part(1)),
            SensorError::FzGain => self.after_gain(part(2)),
            SensorError::Shear => {
                // d(I + kX)⁻¹ = −(I + kX)⁻¹ X (I + kX)⁻¹
                let moment = unshear(self.errors.shear) * self.unsheared.xy().yx();
                self.after_shear(-moment, 0.0)
            }
            SensorError::MomentIntoFz(k) => self.after_shear(Vector2::zeros(), -self.unsheared[k]),
            SensorError::FzIntoMoment(k) => axis(k) * -self.unsheared.z,
            SensorError::LateralIntoMoment(row, column) => axis(row) * -self.reading.drag_n[column],
            SensorError::Height
            | SensorError::Slope(_)
            | SensorError::Slip(_)
            | SensorError::SlipAlong
            | SensorError::SlipByRatio
            | SensorError::Give => Vector3::zeros(),
        }
    }

    fn after_bias(&self, d: Vector3<f64>) -> Vector3<f64> {
        self.after_gain(d.component_div(&self.gains))
    }

    fn after_gain(&self, d: Vector3<f64>) -> Vector3<f64> {
        self.after_shear(unshear(self.errors.shear) * d.xy(), d.z)
    }

    fn after_shear(&self, moment: Vector2<f64>, fz: f64) -> Vector3<f64> {
        let fz = fz - self.errors.moment_into_fz_per_mm.dot(&moment);
        let moment = moment - self.errors.fz_into_moment_mm * fz;
        Vector3::new(moment.x, moment.y, fz)
    }
}

/// Unit vector along a force; nothing where there is none.
fn along(force_n: Vector2<f64>) -> Vector2<f64> {
    force_n.try_normalize(0.0).unwrap_or_else(Vector2::zeros)
}

/// Lateral force over the load, as read; nothing where there is no load.
fn over_load(reading: &Reading) -> Vector2<f64> {
    let load_n = reading.wrench.force_n.z.abs();
    if load_n > 0.0 { reading.drag_n / load_n } else { Vector2::zeros() }
}

/// Way that a force drags: its sign, and neither way where nothing drags.
fn sense(force_n: f64) -> f64 {
    if force_n == 0.0 { 0.0 } else { force_n.signum() }
}

/// Inverse of `[1 k; k 1]`.
fn unshear(k: f64) -> Matrix2<f64> {
    Matrix2::new(1.0, -k, -k, 1.0) / (1.0 - k * k)
}
