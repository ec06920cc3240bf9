//! Live monitor: one wrench at a time, no allocation.

use geometry::Surface;
use nalgebra::{Isometry3, Point3, Vector3};

use crate::error::require_positive;
use crate::pressure::pressure_point;
use crate::surface_contact::contact_on_surface;
use crate::{CoupleAxis, FtCenterError, Sample};

/// What the head touches.
#[derive(Debug)]
pub enum Platform {
    /// The plane `z = z0` of the sensor frame.
    Plane {
        /// Height above the sensor's reference point.
        z0_mm: f64,
    },
    /// A workpiece on top of the sensor.
    Workpiece {
        /// Its surface, workpiece frame.
        surface: Box<dyn Surface>,
        /// Where it stands.
        workpiece_from_sensor: Isometry3<f64>,
        /// Which way the pad's couple points.
        couple_axis: CoupleAxis,
    },
}

/// Settings of a [`Monitor`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MonitorOptions {
    /// `|Fz|` from which the head counts as touching.
    pub touch_fz_n: f64,
    /// `|Fz|` under which it counts as lifted; not above `touch_fz_n`.
    pub lift_fz_n: f64,
    /// Time constant of the centre's low pass: several turns of the spindle.
    pub filter_s: f64,
    /// Longest time between samples; a longer gap starts the filter afresh.
    pub max_gap_s: f64,
}

impl Default for MonitorOptions {
    /// Touch at 5 N and lift at 4 N, polishing loads being tens of N; 2 s and 0.5 s.
    fn default() -> Self {
        Self { touch_fz_n: 5.0, lift_fz_n: 4.0, filter_s: 2.0, max_gap_s: 0.5 }
    }
}

/// State of the contact after a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactStatus {
    /// Touching.
    Contact,
    /// Not touching, and not touching before.
    NoContact,
    /// Touching until this sample.
    ContactLost,
    /// Touching, but the line of action misses the workpiece.
    OffWorkpiece,
    /// A number is not finite or time did not increase; the sample is ignored.
    InvalidSample,
}

/// What the monitor knows after a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MonitorReading {
    /// State of the contact.
    pub status: ContactStatus,
    /// Contact point of this sample: sensor frame on a plane, workpiece frame on a workpiece.
    /// `None` unless touching.
    pub point_mm: Option<Point3<f64>>,
    /// Filtered contact point, the centre of the orbit once the filter has settled; the last one
    /// is held while there is no contact.
    pub center_mm: Option<Point3<f64>>,
    /// Couple that the force does not explain; zero unless touching.
    pub free_moment_nmm: f64,
    /// Time since the head touched.
    pub contact_time_s: f64,
}

/// Follows the contact of a head, sample by sample.
#[derive(Debug)]
pub struct Monitor {
    platform: Platform,
    options: MonitorOptions,
    touching: bool,
    touched_s: f64,
    last_s: Option<f64>,
    /// Decayed sums of `Fz²` and of `Fz²` times the point.
    weight: f64,
    weighted_mm: Vector3<f64>,
    center_mm: Option<Point3<f64>>,
}

impl Monitor {
    /// A monitor that has seen nothing yet.
    ///
    /// # Errors
    ///
    /// [`FtCenterError::NotPositive`] for a setting, [`FtCenterError::LiftAboveTouch`],
    /// [`FtCenterError::InvalidHeight`].
    pub fn new(platform: Platform, options: MonitorOptions) -> Result<Self, FtCenterError> {
        require_positive(options.touch_fz_n, "touch_fz_n")?;
        require_positive(options.lift_fz_n, "lift_fz_n")?;
        require_positive(options.filter_s, "filter_s")?;
        require_positive(options.max_gap_s, "max_gap_s")?;
        let MonitorOptions { touch_fz_n, lift_fz_n, .. } = options;
        if lift_fz_n > touch_fz_n {
            return Err(FtCenterError::LiftAboveTouch { lift_fz_n, touch_fz_n });
        }
        match platform {
            Platform::Plane { z0_mm } if !z0_mm.is_finite() => {
                return Err(FtCenterError::InvalidHeight { z0_mm });
            }
            _ => {}
        }
        Ok(Self {
            platform,
            options,
            touching: false,
            touched_s: 0.0,
            last_s: None,
            weight: 0.0,
            weighted_mm: Vector3::zeros(),
            center_mm: None,
        })
    }

    /// Takes one sample. Never fails, never allocates: what is wrong is in the status.
    pub fn update(&mut self, sample: &Sample) -> MonitorReading {
        let time_s = sample.time_s;
        let w = &sample.wrench;
        let sum = w.force_n.sum() + w.torque_nmm.sum();
        let step_s = self.last_s.map_or(f64::INFINITY, |last| time_s - last);
        // One NaN or infinity makes the sum one (or, of both signs, NaN).
        if !(sum.is_finite() && time_s.is_finite() && step_s > 0.0) {
            return self.reading(ContactStatus::InvalidSample, time_s, None);
        }
        self.last_s = Some(time_s);
        let load_n = w.force_n.z.abs();
        let was_touching = self.touching;
        let gate = if was_touching { self.options.lift_fz_n } else { self.options.touch_fz_n };
        self.touching = load_n >= gate;
        if !self.touching {
            let status =
                if was_touching { ContactStatus::ContactLost } else { ContactStatus::NoContact };
            return self.reading(status, time_s, None);
        }
        if !was_touching || step_s > self.options.max_gap_s {
            (self.touched_s, self.weight, self.weighted_mm) = (time_s, 0.0, Vector3::zeros());
        }
        let Some(found) = self.locate(sample) else {
            return self.reading(ContactStatus::OffWorkpiece, time_s, None);
        };
        self.filter(found.0, load_n, step_s);
        self.reading(ContactStatus::Contact, time_s, Some(found))
    }

    fn locate(&self, sample: &Sample) -> Option<(Point3<f64>, f64)> {
        match &self.platform {
            Platform::Plane { z0_mm } => {
                let at = pressure_point(&sample.wrench, *z0_mm);
                let point_mm = Point3::new(at.position_mm.x, at.position_mm.y, *z0_mm);
                Some((point_mm, at.free_moment_nmm))
            }
            Platform::Workpiece { surface, workpiece_from_sensor, couple_axis } => {
                let contact = contact_on_surface(
                    &sample.wrench,
                    surface.as_ref(),
                    workpiece_from_sensor,
                    *couple_axis,
                    self.options.lift_fz_n,
                );
                contact.ok().map(|c| (c.point_mm, c.couple_nmm))
            }
        }
    }

    /// First-order low pass with weights `Fz²`, as the orbit's centre is fitted; a running mean
    /// until the time constant has passed.
    fn filter(&mut self, point_mm: Point3<f64>, load_n: f64, step_s: f64) {
        // A first sample has an infinite step before it, and nothing to keep.
        let keep = (-step_s / self.options.filter_s).exp();
        let weight = load_n * load_n;
        self.weight = keep * self.weight + weight;
        self.weighted_mm = self.weighted_mm * keep + point_mm.coords * weight;
        self.center_mm = Some(Point3::from(self.weighted_mm / self.weight));
    }

    fn reading(
        &self,
        status: ContactStatus,
        time_s: f64,
        found: Option<(Point3<f64>, f64)>,
    ) -> MonitorReading {
        let touching = self.touching && status != ContactStatus::InvalidSample;
        MonitorReading {
            status,
            point_mm: found.map(|(point_mm, _)| point_mm),
            center_mm: self.center_mm,
            free_moment_nmm: found.map_or(0.0, |(_, moment)| moment),
            contact_time_s: if touching { time_s - self.touched_s } else { 0.0 },
        }
    }
}
