use nalgebra::{Point3, Vector3};

use crate::Head;
use crate::scalar::norm;

/// Direction of the straight tool, joint to tip.
pub(crate) const STRAIGHT: Vector3<f64> = Vector3::new(0.0, -1.0, 0.0);

/// Where the head is, frame Y.
///
/// A constant-velocity joint does not twist: the head is turned from straight by the smallest
/// rotation that brings its axis to `O_Y M1`, and slid along that axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeadPose {
    /// Contact point of the tool.
    pub tip_mm: Point3<f64>,
    /// Unit vector from the joint to the tip.
    pub axis: Vector3<f64>,
    /// Joints of the legs on the head.
    pub joints_mm: [Point3<f64>; 3],
    /// Unit vectors along the legs, bracket to head.
    pub legs_axis: [Vector3<f64>; 3],
    /// `l1, l2, l3` and the axial `l4 = |O_T O_Y|`.
    pub lengths_mm: [f64; 4],
}

impl HeadPose {
    /// The pose with the tip at a point, whatever the limits say.
    #[expect(clippy::inline_always, reason = "a call copies 200 bytes to and fro, twice a cycle")]
    #[inline(always)]
    pub(crate) fn of(head: &Head, tip_mm: &Vector3<f64>) -> Self {
        let reach_mm = norm(tip_mm);
        let axis = tip_mm * (1.0 / reach_mm);
        let axial_mm = reach_mm - head.geometry.tip_to_plane_mm;
        let middle_mm = axis * axial_mm;
        // 1/(1 + c) without waiting for the axis.
        let turn = Turn { axis: &axis, share: reach_mm / (reach_mm - tip_mm.y) };
        let [p1, p2, p3] = &head.arms_mm;
        let joints_mm =
            [middle_mm + turn.apply(p1), middle_mm + turn.apply(p2), middle_mm + turn.apply(p3)];
        let [q1, q2, q3] = &head.brackets_mm;
        let (v1, v2, v3) = (joints_mm[0] - q1, joints_mm[1] - q2, joints_mm[2] - q3);
        let (l1, l2, l3) = (norm(&v1), norm(&v2), norm(&v3));
        Self {
            tip_mm: Point3::from(*tip_mm),
            axis,
            joints_mm: joints_mm.map(Point3::from),
            legs_axis: [v1 * (1.0 / l1), v2 * (1.0 / l2), v3 * (1.0 / l3)],
            lengths_mm: [l1, l2, l3, axial_mm],
        }
    }

    /// Tilt of the tool from straight.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        libm::atan2(norm(&STRAIGHT.cross(&self.axis)), STRAIGHT.dot(&self.axis))
    }

    /// Gradients of the four lengths with respect to the tip.
    ///
    /// When the axis moves by δ, the head turns by `u × δ − u (w·δ)/(1 + c)`, see [`Turn`]: a leg
    /// `d` at the joint `p` changes by that turn about `p × d`, and by the slide along `u`.
    #[inline]
    pub(crate) fn length_gradients(&self, head: &Head) -> [Vector3<f64>; 4] {
        let u = &self.axis;
        let axial_mm = self.lengths_mm[3];
        let per_reach = 1.0 / (axial_mm + head.geometry.tip_to_plane_mm);
        let twist = per_reach / (1.0 - u.y);
        let row = |d: &Vector3<f64>, joint_mm: &Point3<f64>| {
            let p = &joint_mm.coords;
            let along = u.dot(d);
            let push = u * along + (d * axial_mm - p * along) * per_reach;
            let held = u.dot(&p.cross(d)) * twist;
            Vector3::new(push.x + u.z * held, push.y, push.z - u.x * held)
        };
        let [d1, d2, d3] = &self.legs_axis;
        let [p1, p2, p3] = &self.joints_mm;
        [row(d1, p1), row(d2, p2), row(d3, p3), *u]
    }
}

/// Smallest rotation from straight to an axis `u`, `R v = c v + w × v + w (w·v)/(1 + c)` with
/// `w = straight × u = (−u_z, 0, u_x)` and `c = straight · u = −u_y`.
///
/// It is only asked to turn arms, which have no y component.
struct Turn<'a> {
    axis: &'a Vector3<f64>,
    /// `1/(1 + c)`.
    share: f64,
}

impl Turn<'_> {
    #[inline]
    fn apply(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        let (wx, wz, c) = (-self.axis.z, self.axis.x, -self.axis.y);
        let along = (wx * arm.x + wz * arm.z) * self.share;
        Vector3::new(c * arm.x + wx * along, wz * arm.x - wx * arm.z, c * arm.z + wz * along)
    }
}
