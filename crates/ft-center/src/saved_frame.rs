//! A frame that was found before, and presses located in it: the frame is calibrated once.

use geometry::PlanarMap;
use nalgebra::{Matrix2, Matrix2x4, Matrix4, Point2, Vector2};

use crate::error::require_positive;
use crate::frame::MAX_ANGLE_STD_RAD;
use crate::press_noise::center_covariances;
use crate::{
    Center, CommandedFrame, Contact, FtCenterError, Handedness, HandednessSource, Located, Noise,
    PressRole, SensorFrame, SolvedPress, Table,
};

/// Share of a covariance's largest eigenvalue, in the units of its diagonal, that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// `sensor = image + scale · Rot(angle) · Mirror · (machine − reference)`, found before.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedFrame {
    /// Angle of the map.
    pub angle_rad: f64,
    /// Whether the map reflects.
    pub handedness: Handedness,
    /// Point of the machine about which the covariance is stated.
    pub reference_mm: Point2<f64>,
    /// Where the sensor has that point.
    pub image_mm: Point2<f64>,
    /// How far the machine moves over how far it says.
    pub scale: f64,
    /// Covariance of `[angle_rad, image x, image y, scale]`; rad, mm and 1.
    pub covariance: Matrix4<f64>,
    /// Scatter from press to press, along each axis, beyond the noise of the records.
    pub seat_mm: f64,
    /// Factor by which the variances of single presses were scaled.
    pub variance_factor: f64,
    /// Degrees of freedom of all of these variances.
    pub degrees_of_freedom: usize,
    /// Farthest press, from the reference, that the frame was fitted to.
    pub reach_mm: f64,
}

impl SavedFrame {
    /// The frame of presses that were located, to be used again.
    #[must_use]
    pub fn of(located: &Located) -> Self {
        let (frame, commanded) = (&located.frame, &located.commanded);
        Self {
            angle_rad: frame.angle_rad,
            handedness: frame.handedness,
            reference_mm: frame.pivot_mm,
            image_mm: commanded.image_mm,
            scale: commanded.scale,
            covariance: commanded.covariance,
            seat_mm: located.seat_mm,
            variance_factor: frame.variance_factor,
            degrees_of_freedom: frame.degrees_of_freedom,
            reach_mm: located.reach_mm,
        }
    }

    /// The map from what the machine says to sensor coordinates.
    #[must_use]
    pub fn sensor_from_machine(&self) -> PlanarMap {
        let reflected = self.handedness == Handedness::Opposed;
        let mut map = PlanarMap::rigid(self.angle_rad, reflected, Vector2::zeros());
        map.linear *= self.scale;
        map.translation_mm = self.image_mm.coords - map.linear * self.reference_mm.coords;
        map
    }

    /// Validates the frame.
    ///
    /// # Errors
    ///
    /// [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`],
    /// [`FtCenterError::InvalidFrameCovariance`].
    pub fn check(&self) -> Result<(), FtCenterError> {
        let places = self.reference_mm.iter().chain(self.image_mm.iter());
        let numbers = places.chain([&self.angle_rad]).chain(self.covariance.iter());
        if let Some(index) = numbers.into_iter().position(|v| !v.is_finite()) {
            return Err(FtCenterError::NotFinite { index });
        }
        require_positive(self.scale, "scale")?;
        require_positive(self.reach_mm, "reach_mm")?;
        for (value, setting) in
            [(self.variance_factor, "variance_factor"), (self.seat_mm, "seat_mm")]
        {
            // Both are zero where there was no noise.
            if !(value >= 0.0 && value.is_finite()) {
                return Err(FtCenterError::NotPositive { setting, value });
            }
        }
        let stds = self.covariance.diagonal().map(f64::sqrt);
        let fail = Err(FtCenterError::InvalidFrameCovariance { std_angle_rad: stds[0] });
        // NaN where a variance is negative.
        if !(stds[0] <= MAX_ANGLE_STD_RAD && stds.iter().all(|std| *std >= 0.0)) {
            return fail;
        }
        let unit = |i: usize| if stds[i] > 0.0 { stds[i] } else { 1.0 };
        let correlation = Matrix4::from_fn(|i, j| self.covariance[(i, j)] / (unit(i) * unit(j)));
        let least = correlation.symmetric_eigenvalues().min();
        if least < -ROUND_OFF || (correlation - correlation.transpose()).amax() > ROUND_OFF {
            return fail;
        }
        Ok(())
    }

    /// The rigid part, with nothing fitted to it.
    fn sensor_frame(&self) -> SensorFrame {
        let reflected = self.handedness == Handedness::Opposed;
        let turned = PlanarMap::rigid(self.angle_rad, reflected, Vector2::zeros()).linear;
        SensorFrame {
            angle_rad: self.angle_rad,
            translation_mm: self.image_mm.coords - turned * self.reference_mm.coords,
            handedness: self.handedness,
            handedness_source: HandednessSource::Given,
            other_handedness_rms_mm: 0.0,
            covariance: self.covariance.fixed_view::<3, 3>(0, 0).into_owned(),
            pivot_mm: self.reference_mm,
            residuals_mm: Vec::new(),
            degrees_of_freedom: self.degrees_of_freedom,
            variance_factor: self.variance_factor,
        }
    }

    /// Derivative of a machine position's image by what the covariance is about.
    fn position_jacobian(&self, machine_mm: &Point2<f64>) -> Matrix2x4<f64> {
        let arm = self.sensor_from_machine().linear * (machine_mm - self.reference_mm);
        let along = arm / self.scale;
        Matrix2x4::new(-arm.y, 1.0, 0.0, along.x, arm.x, 0.0, 1.0, along.y)
    }
}

/// Puts presses into the machine by a frame found before.
///
/// A position is uncertain by the noise of its own record, by how well the head seats, which the
/// frame's presses showed, and by the frame. Positions are those that the machine says; what was
/// found of its scale is in them.
///
/// # Errors
///
/// As [`SavedFrame::check`], [`FtCenterError::Empty`], [`FtCenterError::PressPosition`],
/// [`FtCenterError::FrameGiven`] for presses of role [`PressRole::Frame`], and
/// [`FtCenterError::NotPositive`] for the noise.
pub fn locate_in(
    saved: &SavedFrame,
    presses: &[SolvedPress],
    contact: &Contact,
    noise: Option<Noise>,
) -> Result<Located, FtCenterError> {
    saved.check()?;
    if presses.is_empty() {
        return Err(FtCenterError::Empty { of: Table::Presses });
    }
    if let Some(press) = presses.iter().find(|p| p.machine_mm.iter().any(|v| !v.is_finite())) {
        return Err(FtCenterError::PressPosition { name: press.name.clone() });
    }
    if let Some(press) = presses.iter().find(|p| p.role == PressRole::Frame) {
        return Err(FtCenterError::FrameGiven { name: press.name.clone() });
    }
    let there = saved.sensor_from_machine();
    let linear = there.linear.try_inverse().ok_or(FtCenterError::OutOfRange)?;
    let covariances_mm2 = center_covariances(presses, contact.z0_mm, noise)?;
    let center = |(press, covariance_mm2): (&SolvedPress, &Matrix2<f64>)| {
        let sensor_mm = press.orbit.center_mm;
        let machine_mm = Point2::from(linear * (sensor_mm.coords - there.translation_mm));
        let seat = Matrix2::identity() * saved.seat_mm.powi(2);
        let seen = saved.position_jacobian(&machine_mm);
        let of_frame = seen * saved.covariance * seen.transpose();
        let sum = (covariance_mm2 + seat) * saved.variance_factor + of_frame;
        Center {
            press: press.name.clone(),
            role: press.role,
            sensor_mm,
            machine_mm,
            correction_mm: Vector2::zeros(),
            offset_mm: machine_mm - press.machine_mm,
            covariance_mm2: linear * sum * linear.transpose(),
        }
    };
    let centers = presses.iter().zip(&covariances_mm2).map(center).collect();
    Ok(Located {
        frame: saved.sensor_frame(),
        commanded: CommandedFrame::saved(saved),
        conditions: Vec::new(),
        centers,
        degrees_of_freedom: crate::count(saved.degrees_of_freedom),
        seat_mm: saved.seat_mm,
        reach_mm: saved.reach_mm,
    })
}

impl CommandedFrame {
    /// Of a frame found before.
    #[must_use]
    pub fn saved(saved: &SavedFrame) -> Self {
        let origin = saved.position_jacobian(&Point2::origin());
        let covariance = origin * saved.covariance * origin.transpose();
        Self {
            scale: saved.scale,
            std_scale: saved.covariance[(3, 3)].sqrt(),
            translation_mm: saved.sensor_from_machine().translation_mm,
            std_translation_mm: covariance.diagonal().map(f64::sqrt),
            image_mm: saved.image_mm,
            covariance: saved.covariance,
        }
    }
}
