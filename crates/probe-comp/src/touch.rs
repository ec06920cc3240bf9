use nalgebra::{Point2, Point3, Unit, Vector3};

/// One trigger of a ball probe, workpiece frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BallTouch {
    /// Ball's centre as read.
    pub center_mm: Point3<f64>,
    /// Standard uncertainty of each coordinate of it.
    pub sigma_mm: f64,
    /// Way the ball came, from the ball towards the part; `None`: along the normal.
    pub approach: Option<Unit<Vector3<f64>>>,
    /// Where the ball was sent to in xy, moving along z.
    pub guide_mm: Option<Point2<f64>>,
    /// Ball's centre at further touches around this one, for a measured normal.
    pub micro_mm: Vec<Point3<f64>>,
    /// Rotation of the probe about its stylus.
    pub spindle_rad: f64,
}

impl BallTouch {
    /// A touch of which nothing but the centre is known.
    #[must_use]
    pub fn new(center_mm: Point3<f64>, sigma_mm: f64) -> Self {
        let micro_mm = Vec::new();
        Self { center_mm, sigma_mm, approach: None, guide_mm: None, micro_mm, spindle_rad: 0.0 }
    }
}
