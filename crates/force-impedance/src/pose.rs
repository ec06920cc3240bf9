use nalgebra::{Point3, Vector3};

use crate::Head;
use crate::scalar::{across, norm};

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
    #[inline]
    pub(crate) fn of(head: &Head, tip_mm: &Vector3<f64>) -> Self {
        let reach_mm = norm(tip_mm);
        let axis = tip_mm / reach_mm;
        let axial_mm = reach_mm - head.geometry.tip_to_plane_mm;
        let middle_mm = axis * axial_mm;
        let turn = Turn::to(&axis);
        let mut joints_mm = [Point3::origin(); 3];
        let mut legs_axis = [Vector3::zeros(); 3];
        let mut lengths_mm = [0.0, 0.0, 0.0, axial_mm];
        for i in 0..3 {
            let joint_mm = middle_mm + turn.apply(&head.arms_mm[i]);
            let leg_mm = joint_mm - head.brackets_mm[i];
            let length_mm = norm(&leg_mm);
            joints_mm[i] = Point3::from(joint_mm);
            legs_axis[i] = leg_mm / length_mm;
            lengths_mm[i] = length_mm;
        }
        Self { tip_mm: Point3::from(*tip_mm), axis, joints_mm, legs_axis, lengths_mm }
    }

    /// Tilt of the tool from straight.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        libm::atan2(norm(&STRAIGHT.cross(&self.axis)), STRAIGHT.dot(&self.axis))
    }

    /// Gradients of the three radial lengths with respect to the tip.
    #[inline]
    pub(crate) fn length_gradients(&self, head: &Head) -> [Vector3<f64>; 3] {
        let u = &self.axis;
        let axial_mm = self.lengths_mm[3];
        let reach_mm = axial_mm + head.geometry.tip_to_plane_mm;
        let turn = Turn::to(u);
        core::array::from_fn(|i| {
            let d = &self.legs_axis[i];
            let along = u * u.dot(d);
            let swing = turn.gradient(&head.arms_mm[i], d);
            along + ((d - along) * axial_mm + across(&swing, u)) / reach_mm
        })
    }
}

/// Smallest rotation from straight to an axis, `R v = c v + w × v + w (w·v)/(1 + c)`.
struct Turn {
    /// Straight × axis.
    w: Vector3<f64>,
    /// Straight · axis.
    c: f64,
}

impl Turn {
    #[inline]
    fn to(axis: &Vector3<f64>) -> Self {
        Self { w: STRAIGHT.cross(axis), c: STRAIGHT.dot(axis) }
    }

    #[inline]
    fn apply(&self, v: &Vector3<f64>) -> Vector3<f64> {
        v * self.c + self.w.cross(v) + self.w * (self.w.dot(v) / (1.0 + self.c))
    }

    /// Gradient of `d · R v` with respect to the axis, not yet projected across it.
    #[inline]
    fn gradient(&self, v: &Vector3<f64>, d: &Vector3<f64>) -> Vector3<f64> {
        let share = 1.0 / (1.0 + self.c);
        let (wv, wd) = (self.w.dot(v), self.w.dot(d));
        // dw = straight × du and dc = straight · du.
        let by_w = v.cross(d) + (d * wv + v * wd) * share;
        let by_c = d.dot(v) - wd * wv * share * share;
        STRAIGHT * by_c + by_w.cross(&STRAIGHT)
    }
}
