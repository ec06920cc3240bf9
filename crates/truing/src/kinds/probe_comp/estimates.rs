use nalgebra::{Point3, Unit, Vector3};
use probe_comp::{Contact, ContactChange};
use serde::Serialize;
use truing_report::Form;

use super::qualification::QualificationEstimate;
use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::{Cell, EXPANDED, TextTable};

/// Largest deviation of a part from its drawing that a probe meets: beyond it, the ball touched
/// something else.
const MAX_DEVIATION_MM: f64 = 50.0;

/// What a `probe-comp` case is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeCompEstimates {
    /// What the probe adds, where the case holds touches of an artefact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub qualification: Option<QualificationEstimate>,
    /// One per touch, in the order of the table.
    pub touches: Vec<TouchEstimate>,
}

/// Where a ball touched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchEstimate {
    /// Its name.
    pub touch: String,
    /// `fit` or `check`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Contact.
    pub x_mm: f64,
    /// Contact.
    pub y_mm: f64,
    /// Contact.
    pub z_mm: f64,
    /// Unit normal along which the ball was compensated, from the part to the ball.
    pub nx: f64,
    /// As `nx`.
    pub ny: f64,
    /// As `nx`.
    pub nz: f64,
    /// How far the contact is above the nominal surface, along its normal.
    pub deviation_mm: f64,
    /// Standard uncertainty of it; `None` where the noise is not known.
    pub std_deviation_mm: Option<f64>,
    /// Standard uncertainty of the contact along the surface.
    pub std_tangential_mm: Option<f64>,
    /// What corrections along a column without a known cause add to what is left of it after a
    /// loop; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical_mm: Option<f64>,
    /// What the touches around this one say of its normal, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredNormalEstimate>,
    /// The touch without any error, where a guide point says where it was to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planned: Option<PlannedContactEstimate>,
}

/// Contact by the normal that the touches around it give.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredNormalEstimate {
    /// Contact.
    pub x_mm: f64,
    /// Contact.
    pub y_mm: f64,
    /// Contact.
    pub z_mm: f64,
    /// Measured unit normal, from the part to the ball.
    pub nx: f64,
    /// As `nx`.
    pub ny: f64,
    /// As `nx`.
    pub nz: f64,
    /// Angle between measured and nominal normal.
    pub tilt_deg: f64,
    /// How far this contact is above the nominal surface, along its normal.
    pub deviation_mm: f64,
    /// Standard uncertainty of this contact along the surface.
    pub std_tangential_mm: Option<f64>,
}

/// A touch of the nominal part at its guide point, and the error of the measured contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlannedContactEstimate {
    /// Theoretical centre of the ball.
    pub center_x_mm: f64,
    /// Theoretical centre of the ball.
    pub center_y_mm: f64,
    /// Theoretical centre of the ball.
    pub center_z_mm: f64,
    /// Theoretical contact.
    pub x_mm: f64,
    /// Theoretical contact.
    pub y_mm: f64,
    /// Theoretical contact.
    pub z_mm: f64,
    /// Measured contact − theoretical contact.
    pub error_x_mm: f64,
    /// Measured contact − theoretical contact.
    pub error_y_mm: f64,
    /// Measured contact − theoretical contact.
    pub error_z_mm: f64,
    /// The part of it along the nominal normal.
    pub normal_error_mm: f64,
}

impl TouchEstimate {
    pub(super) fn of(name: &str, is_check: bool, contact: &Contact, known_noise: bool) -> Self {
        let mut estimate = Self {
            touch: name.to_owned(),
            usage: if is_check { "check" } else { "fit" },
            x_mm: 0.0,
            y_mm: 0.0,
            z_mm: 0.0,
            nx: 0.0,
            ny: 0.0,
            nz: 0.0,
            deviation_mm: 0.0,
            std_deviation_mm: known_noise.then(|| contact.sigma_deviation_mm()),
            std_tangential_mm: known_noise.then(|| contact.sigma_tangential_mm()),
            empirical_mm: None,
            measured: None,
            planned: contact.planned.map(|p| PlannedContactEstimate {
                center_x_mm: p.center_mm.x,
                center_y_mm: p.center_mm.y,
                center_z_mm: p.center_mm.z,
                x_mm: p.point_mm.x,
                y_mm: p.point_mm.y,
                z_mm: p.point_mm.z,
                error_x_mm: p.error_mm.x,
                error_y_mm: p.error_mm.y,
                error_z_mm: p.error_mm.z,
                normal_error_mm: p.normal_error_mm,
            }),
        };
        estimate.place(&contact.point_mm, &contact.normal, contact.deviation_mm);
        estimate
    }

    /// With what accepted effects change: the contacts move, whatever normal they go by.
    pub(super) fn change(&mut self, change: &ContactChange) {
        let moved = change.moved_mm;
        let raised_mm = change.deviation_mm - self.deviation_mm;
        (self.x_mm, self.y_mm, self.z_mm) =
            (self.x_mm + moved.x, self.y_mm + moved.y, self.z_mm + moved.z);
        self.deviation_mm = change.deviation_mm;
        self.std_deviation_mm = change.sigma_deviation_mm;
        self.std_tangential_mm = Some(change.sigma_tangential_mm);
        if let Some(measured) = &mut self.measured {
            (measured.x_mm, measured.y_mm, measured.z_mm) =
                (measured.x_mm + moved.x, measured.y_mm + moved.y, measured.z_mm + moved.z);
            measured.deviation_mm += raised_mm;
            measured.std_tangential_mm =
                measured.std_tangential_mm.map(|own_mm| own_mm.max(change.sigma_tangential_mm));
        }
        if let Some(planned) = &mut self.planned {
            let normal = planned.normal([self.nx, self.ny, self.nz]);
            (planned.error_x_mm, planned.error_y_mm, planned.error_z_mm) =
                (self.x_mm - planned.x_mm, self.y_mm - planned.y_mm, self.z_mm - planned.z_mm);
            let error = Vector3::new(planned.error_x_mm, planned.error_y_mm, planned.error_z_mm);
            planned.normal_error_mm = normal.dot(&error);
        }
    }

    pub(super) fn place(
        &mut self,
        point_mm: &Point3<f64>,
        normal: &Unit<Vector3<f64>>,
        deviation_mm: f64,
    ) {
        (self.x_mm, self.y_mm, self.z_mm) = (point_mm.x, point_mm.y, point_mm.z);
        (self.nx, self.ny, self.nz) = (normal.x, normal.y, normal.z);
        self.deviation_mm = deviation_mm;
    }
}

impl PlannedContactEstimate {
    /// Nominal normal at the theoretical contact: from it to the ball's centre, or `otherwise` for
    /// a ball without size.
    fn normal(&self, otherwise: [f64; 3]) -> Vector3<f64> {
        let arm = Vector3::new(
            self.center_x_mm - self.x_mm,
            self.center_y_mm - self.y_mm,
            self.center_z_mm - self.z_mm,
        );
        arm.try_normalize(f64::EPSILON).unwrap_or_else(|| Vector3::from(otherwise))
    }
}

impl MeasuredNormalEstimate {
    pub(super) fn of(contact: &Contact, known_noise: bool) -> Self {
        let (point, normal) = (&contact.point_mm, &contact.normal);
        Self {
            x_mm: point.x,
            y_mm: point.y,
            z_mm: point.z,
            nx: normal.x,
            ny: normal.y,
            nz: normal.z,
            tilt_deg: normal.angle(&contact.nominal_normal).to_degrees(),
            deviation_mm: contact.deviation_mm,
            std_tangential_mm: known_noise.then(|| contact.sigma_tangential_mm()),
        }
    }
}

impl Estimates for ProbeCompEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        self.qualification.as_ref().map_or_else(Vec::new, QualificationEstimate::parameters)
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = ["touch", "use", "x (mm)", "y (mm)", "z (mm)", "deviation (µm)", EXPANDED];
        let mut table = TextTable::new("contacts", &columns);
        for t in &self.touches {
            table.push(vec![
                t.touch.clone().into(),
                t.usage.into(),
                t.x_mm.into(),
                t.y_mm.into(),
                t.z_mm.into(),
                Cell::Known(t.deviation_mm * 1e3, t.std_deviation_mm.map(|s| s * 1e3)),
                Cell::Expanded(t.std_deviation_mm.map(|s| s * 1e3)),
            ]);
        }
        vec![table]
    }

    fn form(&self) -> Option<Form> {
        self.qualification.as_ref()?.probing_check.map(|check| check.form())
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        let off = |t: &&TouchEstimate| t.deviation_mm.abs();
        let worst = self.touches.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let (touch, found_mm, limit_mm) = (worst.touch.clone(), off(&worst), MAX_DEVIATION_MM);
        (found_mm > limit_mm).then_some(ImplausibleResult::Deviation { touch, found_mm, limit_mm })
    }
}
