use nalgebra::{Matrix2, Point2, Point3, Vector3};

use crate::{LateralPrior, PoseError, PoseStart, Tip};

/// Four touches of the side of a round part, and one near its centre (document \[D\], (8)–(10)).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgeTouches {
    /// Balls' centres at the side: 1 and 3 apart along y, 2 and 4 along x, machine frame.
    pub sides_mm: [Point3<f64>; 4],
    /// Ball's centre on the surface near the part's centre.
    pub center_mm: Point3<f64>,
    /// Standard uncertainty of one side touch across the side, form of the side included.
    pub sigma_mm: f64,
}

/// Where the side touches put the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideTouches {
    /// Pose to start from: level, over the centre.
    pub start: PoseStart,
    /// The axis, with its uncertainty.
    pub prior: LateralPrior,
}

/// Opposite touches closer than this are slips.
const MIN_SPAN_MM: f64 = 1e-3;

impl EdgeTouches {
    /// Start and prior: `x = (x2 + x4)/2`, `y = (y1 + y3)/2`, in which the ball's radius cancels.
    ///
    /// The prior holds where the axis passes the mean height of the side touches, so that a tilt
    /// moves the origin as it should.
    ///
    /// # Errors
    ///
    /// [`PoseError::InvalidEdge`] where opposite touches are not apart,
    /// [`PoseError::InvalidOption`].
    pub fn locate(&self, tip: Tip, gamma_rad: f64) -> Result<SideTouches, PoseError> {
        let [first, second, third, fourth] = self.sides_mm;
        for (axis, name, [a, b]) in [(1, 'y', [0, 2]), (0, 'x', [1, 3])] {
            let apart = self.sides_mm[a] - self.sides_mm[b];
            let span_mm = apart[axis].abs();
            if !(span_mm > MIN_SPAN_MM && span_mm >= apart[1 - axis].abs()) {
                let (first, second) = (a + 1, b + 1);
                return Err(PoseError::InvalidEdge { axis: name, first, second, span_mm });
            }
        }
        let sigma_mm = self.sigma_mm;
        if !(sigma_mm > 0.0 && sigma_mm.is_finite()) {
            let (name, needed) = ("uncertainty of the side touches", "positive");
            return Err(PoseError::InvalidOption { name, needed, value: sigma_mm });
        }
        let center_mm = Point2::new(0.5 * (second.x + fourth.x), 0.5 * (first.y + third.y));
        let at_z_mm = 0.25 * self.sides_mm.iter().map(|p| p.z).sum::<f64>();
        let z_mm = self.center_mm.z - tip.signed_radius_mm();
        let start = PoseStart::level(Vector3::new(center_mm.x, center_mm.y, z_mm), gamma_rad);
        // Each coordinate is the mean of two touches.
        let covariance_mm2 = Matrix2::identity() * (0.5 * sigma_mm * sigma_mm);
        Ok(SideTouches { start, prior: LateralPrior { at_z_mm, center_mm, covariance_mm2 } })
    }
}
