use ft_center::{
    Center, Handedness, HandednessSource, Located, PressRole, SensorFrame, SolvedPress,
};
use nalgebra::{Matrix2x3, Vector2};
use serde::Serialize;

use crate::estimates::Estimated;
use crate::text_table::TextTable;

/// What presses are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FtCenterEstimates {
    /// The sensor in the machine.
    pub frame: FrameEstimate,
    /// One per press.
    pub centers: Vec<CenterEstimate>,
}

/// `sensor = Rot(angle) · Mirror · machine + t`, planar.
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
    /// `same` or `opposed`: whether the sensor's z points the way the machine's does.
    pub handedness: &'static str,
    /// `measured`, `given` or `assumed`.
    pub handedness_source: &'static str,
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
    /// Found − commanded position, machine frame.
    pub offset_x_mm: f64,
    /// Its y component.
    pub offset_y_mm: f64,
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

impl FtCenterEstimates {
    pub(crate) fn of(located: &Located, presses: &[SolvedPress]) -> Self {
        let centers = (located.centers.iter().zip(presses))
            .map(|(center, press)| CenterEstimate::of(center, press))
            .collect();
        Self { frame: FrameEstimate::of(&located.frame), centers }
    }

    pub(crate) fn parameters(&self) -> Vec<Estimated> {
        let f = &self.frame;
        vec![
            Estimated::new("frame angle", "°", f.angle_deg, Some(f.std_angle_deg)),
            Estimated::new("frame tx", "mm", f.tx_mm, Some(f.std_tx_mm)),
            Estimated::new("frame ty", "mm", f.ty_mm, Some(f.std_ty_mm)),
        ]
    }

    pub(crate) fn table(&self) -> TextTable {
        let columns = [
            "press",
            "use",
            "x mm",
            "y mm",
            "machine x mm",
            "machine y mm",
            "offset x mm",
            "offset y mm",
            "std x mm",
            "std y mm",
        ];
        let mut table = TextTable::new("centres (offset = found − commanded)", &columns);
        for c in &self.centers {
            let numbers = [
                c.x_mm,
                c.y_mm,
                c.machine_x_mm,
                c.machine_y_mm,
                c.offset_x_mm,
                c.offset_y_mm,
                c.std_x_mm,
                c.std_y_mm,
            ];
            let names = [c.press.clone().into(), c.usage.into()];
            table.push(names.into_iter().chain(numbers.map(Into::into)).collect());
        }
        table
    }
}

impl FrameEstimate {
    fn of(frame: &SensorFrame) -> Self {
        let std = translation_std(frame);
        Self {
            angle_deg: frame.angle_rad.to_degrees(),
            tx_mm: frame.translation_mm.x,
            ty_mm: frame.translation_mm.y,
            std_angle_deg: frame.covariance[(0, 0)].sqrt().to_degrees(),
            std_tx_mm: std.x,
            std_ty_mm: std.y,
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

/// The covariance is about the pivot's image; the translation is the image of the origin.
fn translation_std(frame: &SensorFrame) -> Vector2<f64> {
    let linear = frame.sensor_from_machine().linear;
    let arm = -(linear * frame.pivot_mm.coords);
    // A small angle moves the end of an arm by its perpendicular.
    let jacobian = Matrix2x3::new(-arm.y, 1.0, 0.0, arm.x, 0.0, 1.0);
    (jacobian * frame.covariance * jacobian.transpose()).diagonal().map(f64::sqrt)
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
            spin_hz: orbit.wobble.map(|w| w.spin_hz),
            wobble_radius_mm: orbit.wobble.map(|w| w.radius_mm),
            free_moment_nmm: orbit.free_moment_nmm,
            contact_samples: orbit.contact_samples,
            gated_samples: orbit.gated_samples,
        }
    }
}
