use ft_center::{
    Center, Handedness, HandednessSource, Located, PressRole, SavedFrame, SolvedPress,
};
use serde::Serialize;

use super::affine::AffineEstimate;
use super::repeatability::RepeatabilityEstimate;

use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::kinds::ft_center::settings::ToleranceSettings;
use crate::text_table::{Cell, TextTable};

/// Largest distance between where a head presses and where it was sent that is an error of the
/// machine: as for the location of an axis.
const MAX_CONTACT_MM: f64 = 50.0;

/// What presses are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FtCenterEstimates {
    /// The sensor in the machine.
    pub frame: FrameEstimate,
    /// What frame and centres leave to the corrections of the presses.
    pub conditions: Vec<String>,
    /// One per press.
    pub centers: Vec<CenterEstimate>,
    /// The general map of \[A\]; `None` of fewer than three presses at known positions off one line.
    pub affine: Option<AffineEstimate>,
    /// How well the head comes back; `None` where no place was pressed twice.
    pub repeatability: Option<RepeatabilityEstimate>,
}

/// What a case says that goes into its estimates.
#[derive(Clone, Copy)]
pub(super) struct Setting {
    pub(super) z0_mm: f64,
    pub(super) tolerance: ToleranceSettings,
}

/// `sensor = scale · Rot(angle) · Mirror · machine + t`, planar, machine as it says that it is.
///
/// Mirror is diag(1, −1) where the z axes oppose each other, else the identity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameEstimate {
    /// Angle of the map.
    pub angle_deg: f64,
    /// Translation of the map: the machine's origin in the sensor frame.
    pub tx_mm: f64,
    /// Its y component.
    pub ty_mm: f64,
    /// Standard uncertainty of `angle_deg`.
    pub std_angle_deg: f64,
    /// Standard uncertainty of `tx_mm`.
    pub std_tx_mm: f64,
    /// Standard uncertainty of `ty_mm`.
    pub std_ty_mm: f64,
    /// How far the machine moves over how far it says; 1 unless the loop found otherwise.
    pub scale: f64,
    /// Standard uncertainty of `scale`; 0 where it is not estimated.
    pub std_scale: f64,
    /// Point of the machine to which a scale error refers.
    pub reference_mm: [f64; 2],
    /// `same` or `opposed`: whether the sensor's z points the way the machine's does.
    pub handedness: &'static str,
    /// `measured`, `given` or `assumed`.
    pub handedness_source: &'static str,
    /// Where the sensor has `reference_mm`.
    pub image_mm: [f64; 2],
    /// Covariance of `[angle, image x, image y, scale]`; angle in rad, image in mm.
    pub covariance: [[f64; 4]; 4],
    /// Scatter from press to press along each axis, beyond the noise of the records.
    pub seat_mm: f64,
    /// Factor by which the variances of single presses are scaled.
    pub variance_factor: f64,
    /// Degrees of freedom of these variances.
    pub degrees_of_freedom: usize,
    /// Farthest press, from the reference, that the frame was fitted to.
    pub reach_mm: f64,
    /// Height of the contact plane on which it was found.
    pub z0_mm: f64,
}

/// Where one press was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CenterEstimate {
    /// Name of the press.
    pub press: String,
    /// `frame`, `check` or `locate`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Centre of the orbit, sensor frame.
    pub x_mm: f64,
    /// Its y coordinate.
    pub y_mm: f64,
    /// The same point, machine frame.
    pub machine_x_mm: f64,
    /// Its y coordinate.
    pub machine_y_mm: f64,
    /// Standard uncertainty of `offset_x_mm`.
    pub std_x_mm: f64,
    /// Standard uncertainty of `offset_y_mm`.
    pub std_y_mm: f64,
    /// Found − commanded position − correction, machine frame.
    pub offset_x_mm: f64,
    /// Its y component.
    pub offset_y_mm: f64,
    /// What the accepted effects of the machine move the head by.
    pub correction_x_mm: f64,
    /// Its y component.
    pub correction_y_mm: f64,
    /// Wrench that stands for the whole press, as read: force, and moment that puts it at the
    /// centre of the orbit.
    pub mean_wrench: MeanWrench,
    /// Spin of the head, where it rises above the noise.
    pub spin_hz: Option<f64>,
    /// Radius of the orbit, where there is one.
    pub wobble_radius_mm: Option<f64>,
    /// Mean moment about z that the force does not explain.
    pub free_moment_nmm: f64,
    /// Samples in contact.
    pub contact_samples: usize,
    /// Samples under the force gate.
    pub gated_samples: usize,
}

/// A wrench on the sensor, moments about its reference point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "force and moment components in the sensor's axes, as named")]
pub struct MeanWrench {
    pub fx_n: f64,
    pub fy_n: f64,
    pub fz_n: f64,
    pub mx_nmm: f64,
    pub my_nmm: f64,
    pub mz_nmm: f64,
}

impl FtCenterEstimates {
    pub(super) fn of(located: &Located, presses: &[SolvedPress], setting: Setting) -> Self {
        let centers = (located.centers.iter().zip(presses))
            .map(|(center, press)| CenterEstimate::of(center, press))
            .collect();
        let conditions = located.conditions.clone();
        let repeatability = RepeatabilityEstimate::of(presses, &located.centers, setting.tolerance);
        let frame = FrameEstimate::of(located, setting.z0_mm);
        let affine = AffineEstimate::of(presses, frame.seat_mm);
        Self { frame, conditions, centers, affine, repeatability }
    }
}

impl Estimates for FtCenterEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let f = &self.frame;
        let mut all = vec![
            Estimated::new("frame angle", "°", f.angle_deg, Some(f.std_angle_deg)),
            Estimated::new("frame tx", "mm", f.tx_mm, Some(f.std_tx_mm)),
            Estimated::new("frame ty", "mm", f.ty_mm, Some(f.std_ty_mm)),
        ];
        if let Some(r) = &self.repeatability {
            all.push(Estimated::new("repeatability x", "mm", r.x_mm, None));
            all.push(Estimated::new("repeatability y", "mm", r.y_mm, None));
        }
        if f.std_scale > 0.0 {
            all.push(Estimated::new("frame scale", "", f.scale, Some(f.std_scale)));
        }
        all
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = [
            "press",
            "use",
            "x mm",
            "y mm",
            "machine x mm",
            "machine y mm",
            "offset x mm",
            "offset y mm",
            "U x (k = 2)",
            "U y (k = 2)",
            "correction x mm",
            "correction y mm",
        ];
        let corrected =
            self.centers.iter().any(|c| c.correction_x_mm != 0.0 || c.correction_y_mm != 0.0);
        let shown = if corrected { columns.len() } else { columns.len() - 2 };
        let title = if corrected {
            "centres (offset = found − commanded − correction)"
        } else {
            "centres (offset = found − commanded)"
        };
        let mut table = TextTable::new(title, &columns[..shown]);
        for c in &self.centers {
            let known = [c.machine_x_mm, c.machine_y_mm, c.offset_x_mm, c.offset_y_mm];
            let stds = [c.std_x_mm, c.std_y_mm];
            let corrections = [c.correction_x_mm, c.correction_y_mm];
            let numbers = [Cell::from(c.x_mm), c.y_mm.into()]
                .into_iter()
                .chain((0..4).map(|i| Cell::Known(known[i], Some(stds[i % 2]))))
                .chain(stds.map(|std| Cell::Expanded(Some(std))))
                .chain(corrections.map(Cell::from));
            let names = [c.press.clone().into(), c.usage.into()];
            table.push(names.into_iter().chain(numbers).take(shown).collect());
        }
        let affine = self.affine.iter().map(AffineEstimate::table);
        std::iter::once(table).chain(affine).collect()
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        let off = |c: &&CenterEstimate| c.offset_x_mm.hypot(c.offset_y_mm);
        let worst = self.centers.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let (press, found_mm, limit_mm) = (worst.press.clone(), off(&worst), MAX_CONTACT_MM);
        (found_mm > limit_mm).then_some(ImplausibleResult::Contact { press, found_mm, limit_mm })
    }
}

impl FrameEstimate {
    fn of(located: &Located, z0_mm: f64) -> Self {
        let (frame, commanded) = (&located.frame, &located.commanded);
        let saved = SavedFrame::of(located);
        let row = |i: usize| [0, 1, 2, 3].map(|j| saved.covariance[(i, j)]);
        Self {
            image_mm: [saved.image_mm.x, saved.image_mm.y],
            covariance: [row(0), row(1), row(2), row(3)],
            seat_mm: saved.seat_mm,
            variance_factor: saved.variance_factor,
            degrees_of_freedom: saved.degrees_of_freedom,
            reach_mm: saved.reach_mm,
            z0_mm,
            angle_deg: frame.angle_rad.to_degrees(),
            tx_mm: commanded.translation_mm.x,
            ty_mm: commanded.translation_mm.y,
            std_angle_deg: frame.covariance[(0, 0)].sqrt().to_degrees(),
            std_tx_mm: commanded.std_translation_mm.x,
            std_ty_mm: commanded.std_translation_mm.y,
            scale: commanded.scale,
            std_scale: commanded.std_scale,
            reference_mm: [frame.pivot_mm.x, frame.pivot_mm.y],
            handedness: match frame.handedness {
                Handedness::Same => "same",
                Handedness::Opposed => "opposed",
            },
            handedness_source: match frame.handedness_source {
                HandednessSource::Measured => "measured",
                HandednessSource::Given => "given",
                HandednessSource::Assumed => "assumed",
            },
        }
    }
}

impl CenterEstimate {
    fn of(center: &Center, press: &SolvedPress) -> Self {
        let orbit = &press.orbit;
        Self {
            press: center.press.clone(),
            usage: match center.role {
                PressRole::Frame => "frame",
                PressRole::Check => "check",
                PressRole::Locate => "locate",
            },
            x_mm: center.sensor_mm.x,
            y_mm: center.sensor_mm.y,
            machine_x_mm: center.machine_mm.x,
            machine_y_mm: center.machine_mm.y,
            std_x_mm: center.covariance_mm2[(0, 0)].sqrt(),
            std_y_mm: center.covariance_mm2[(1, 1)].sqrt(),
            offset_x_mm: center.offset_mm.x,
            offset_y_mm: center.offset_mm.y,
            correction_x_mm: center.correction_mm.x,
            correction_y_mm: center.correction_mm.y,
            mean_wrench: mean_wrench(press),
            spin_hz: orbit.wobble.map(|w| w.spin_hz),
            wobble_radius_mm: orbit.wobble.map(|w| w.radius_mm),
            free_moment_nmm: orbit.free_moment_nmm,
            contact_samples: orbit.contact_samples,
            gated_samples: orbit.gated_samples,
        }
    }
}

fn mean_wrench(press: &SolvedPress) -> MeanWrench {
    let (force, moment) = (press.orbit.mean_wrench.force_n, press.orbit.mean_wrench.torque_nmm);
    MeanWrench {
        fx_n: force.x,
        fy_n: force.y,
        fz_n: force.z,
        mx_nmm: moment.x,
        my_nmm: moment.y,
        mz_nmm: moment.z,
    }
}
