use nalgebra::Point3;

/// One touch of the probe: where its ball's centre was.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Touch {
    /// Centre of the ball in the machine frame.
    pub center_mm: Point3<f64>,
    /// Standard uncertainty of the centre along the surface's normal.
    pub sigma_mm: f64,
}

impl Touch {
    /// A touch at machine coordinates.
    #[must_use]
    pub fn new(center_mm: impl Into<Point3<f64>>, sigma_mm: f64) -> Self {
        Self { center_mm: center_mm.into(), sigma_mm }
    }
}

/// The ball that touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tip {
    /// Radius of the ball; 0 where the points lie on the surface.
    pub radius_mm: f64,
    /// Side of the surface on which the ball's centre is.
    pub side: TipSide,
}

impl Tip {
    /// Distance of the ball's centre from the surface, positive on the normal's side.
    #[must_use]
    pub fn signed_radius_mm(self) -> f64 {
        match self.side {
            TipSide::Above => self.radius_mm,
            TipSide::Below => -self.radius_mm,
        }
    }
}

/// Side of the surface, in the workpiece frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum TipSide {
    /// The +z side, to which the normal points.
    #[default]
    Above,
    /// The −z side.
    Below,
}
