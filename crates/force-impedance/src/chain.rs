use nalgebra::{Point3, Vector3};

/// Linear axes between the workpiece fixture and the head.
///
/// The workpiece sits on Z, the head on Y: `Y{M} = (x + X, y − Y − d2, z + Z − d1)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MachineChain {
    /// Fixed offset along z between the frames of Z and Y, `d1`.
    pub offset_z_mm: f64,
    /// Fixed offset along y between the frames of Z and Y, `d2`.
    pub offset_y_mm: f64,
}

impl MachineChain {
    /// A point of the workpiece (frame Z) in the head's frame Y, at the given axis positions.
    #[must_use]
    pub fn head_from_workpiece(
        &self,
        point_mm: &Point3<f64>,
        axes_mm: &Vector3<f64>,
    ) -> Point3<f64> {
        Point3::new(
            point_mm.x + axes_mm.x,
            point_mm.y - axes_mm.y - self.offset_y_mm,
            point_mm.z + axes_mm.z - self.offset_z_mm,
        )
    }

    /// Axis positions X, Y, Z that bring a point of the workpiece to `tip_mm` in frame Y.
    ///
    /// With the tip of the straight head, `(0, −L1 − L2, 0)`, this is the document's start pose:
    /// `X = −x`, `Y = L1 + L2 + y − d2`, `Z = d1 − z`.
    #[must_use]
    pub fn axes_for(&self, point_mm: &Point3<f64>, tip_mm: &Point3<f64>) -> Vector3<f64> {
        Vector3::new(
            tip_mm.x - point_mm.x,
            point_mm.y - tip_mm.y - self.offset_y_mm,
            tip_mm.z - point_mm.z + self.offset_z_mm,
        )
    }
}
