use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// Where a ball really touched.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// Ball's centre as read, O'.
    pub center_mm: Point3<f64>,
    /// Contact, A' = O' − r n'.
    pub point_mm: Point3<f64>,
    /// Normal n' along which the ball was compensated, from the part to the ball.
    pub normal: Unit<Vector3<f64>>,
    /// Point of the nominal surface under the contact.
    pub nominal_mm: Point3<f64>,
    /// Normal of the nominal surface there, from the part to the ball.
    pub nominal_normal: Unit<Vector3<f64>>,
    /// How far the contact is above the nominal surface, along its normal.
    pub deviation_mm: f64,
    /// Covariance of the contact: of the ball's centre, and of a measured normal.
    pub covariance_mm2: Matrix3<f64>,
    /// Whether the nominal point is within the part's aperture.
    pub inside_aperture: bool,
    /// The same touch without any error, where the machine was sent to a guide point.
    pub planned: Option<PlannedContact>,
}

impl Contact {
    /// Standard uncertainty of the deviation.
    #[must_use]
    pub fn sigma_deviation_mm(&self) -> f64 {
        let n = self.nominal_normal.into_inner();
        n.dot(&(self.covariance_mm2 * n)).max(0.0).sqrt()
    }

    /// Standard uncertainty of the contact along the surface, root mean square over both ways.
    #[must_use]
    pub fn sigma_tangential_mm(&self) -> f64 {
        let along_normal = self.sigma_deviation_mm().powi(2);
        (0.5 * (self.covariance_mm2.trace() - along_normal)).max(0.0).sqrt()
    }
}

/// A touch of the nominal part at a guide point, the ball moving along z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlannedContact {
    /// Ball's centre, O.
    pub center_mm: Point3<f64>,
    /// Contact, A = O − r n.
    pub point_mm: Point3<f64>,
    /// Error vector A' − A of the contact that was measured.
    pub error_mm: Vector3<f64>,
    /// Its part along the nominal normal at A.
    pub normal_error_mm: f64,
}
