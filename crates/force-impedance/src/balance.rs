use nalgebra::{Matrix3, Matrix3x4, Matrix4x3, Vector3, Vector4};

use crate::cofactor::orthogonal;
use crate::pose::HeadPose;
use crate::scalar::{across, norm};
use crate::{ForceImpedanceError, Head};

/// Beyond this angle between normal and axis the published formula divides by less than 0.1.
const MAX_PUBLISHED_RAD: f64 = 1.47;

/// Static equilibrium of the head at a pose: `force = influence · cells + of_weight`.
///
/// Axial balance and the two moments across the axis about the joint; what the joint itself
/// transmits (forces across the axis, the moment along it) takes no part. Friction in the spline
/// acts along the axis past the axial cell and cannot be told from contact force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Contact force per load-cell reading, `3×4`, N per N.
    pub influence: Matrix3x4<f64>,
    /// What the head's weight adds to the contact force.
    pub of_weight_n: Vector3<f64>,
    /// Direction of the tool, joint to tip.
    axis: Vector3<f64>,
    /// Cosines between legs and axis.
    leg_cosines: [f64; 3],
}

impl Head {
    /// Static equilibrium at a pose.
    #[inline]
    #[must_use]
    pub fn balance(&self, pose: &HeadPose) -> Balance {
        let u = pose.axis;
        let axial_mm = pose.lengths_mm[3];
        let reach_mm = axial_mm + self.geometry.tip_to_plane_mm;
        let mut columns = [-u; 4];
        let mut leg_cosines = [0.0; 3];
        for i in 0..3 {
            let leg = &pose.legs_axis[i];
            let moment_mm = pose.joints_mm[i].coords.cross(leg);
            leg_cosines[i] = leg.dot(&u);
            columns[i] = u.cross(&moment_mm) / reach_mm - u * leg_cosines[i];
        }
        // The centre of gravity slides with the head.
        let arm_mm =
            self.geometry.center_of_gravity_mm + axial_mm - self.geometry.plane_to_joint_mm;
        let weight_n = self.geometry.gravity_direction * self.geometry.weight_n;
        let along_n = u * u.dot(&weight_n);
        Balance {
            influence: Matrix3x4::from_columns(&columns),
            of_weight_n: (along_n - weight_n) * (arm_mm / reach_mm) - along_n,
            axis: u,
            leg_cosines,
        }
    }
}

/// Contact force split along a surface normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactForce {
    /// Force of the workpiece on the tool, frame Y.
    pub force_n: Vector3<f64>,
    /// Along the outward normal: positive presses.
    pub normal_n: f64,
    /// Across the normal: friction.
    pub tangential_n: f64,
    /// Friction over normal force; `None` while nothing presses.
    pub friction_ratio: Option<f64>,
}

impl Balance {
    /// Force of the workpiece on the tool from the four cells (compression positive).
    #[inline]
    #[must_use]
    pub fn force_n(&self, cells_n: &[f64; 4]) -> Vector3<f64> {
        self.influence * Vector4::from(*cells_n) + self.of_weight_n
    }

    /// The same, split along the outward unit normal of the surface.
    #[inline]
    #[must_use]
    pub fn contact(&self, cells_n: &[f64; 4], normal: &Vector3<f64>) -> ContactForce {
        let force_n = self.force_n(cells_n);
        let normal_n = force_n.dot(normal);
        let tangential_n = norm(&across(&force_n, normal));
        let friction_ratio = (normal_n > 0.0).then(|| tangential_n / normal_n);
        ContactForce { force_n, normal_n, tangential_n, friction_ratio }
    }

    /// Covariance of the force for independent cells of standard uncertainty `sigma_n`, N².
    #[must_use]
    pub fn covariance_n2(&self, sigma_n: &[f64; 4]) -> Matrix3<f64> {
        let mut scaled = self.influence;
        for (mut column, sigma) in scaled.column_iter_mut().zip(sigma_n) {
            column *= *sigma;
        }
        scaled * scaled.transpose()
    }

    /// Coefficients of the four cells in the normal force.
    #[inline]
    #[must_use]
    pub fn normal_weights(&self, normal: &Vector3<f64>) -> [f64; 4] {
        (self.influence.transpose() * normal).into()
    }

    /// Internal force of the cells that no contact force balances: the preload of the legs.
    ///
    /// The component of the readings along the one direction that gives no contact force, a unit
    /// vector; at the straight head `(1, 1, 1, 0)/√3`.
    #[inline]
    #[must_use]
    pub fn preload_n(&self, cells_n: &[f64; 4]) -> f64 {
        let columns: Matrix4x3<f64> = self.influence.transpose();
        orthogonal(&columns).dot(&Vector4::from(*cells_n))
    }

    /// Axial force as published: `Σ F_i cos γ_i + F4`, without weight.
    #[inline]
    #[must_use]
    pub fn published_axial_n(&self, cells_n: &[f64; 4]) -> f64 {
        let [f1, f2, f3, f4] = *cells_n;
        let [c1, c2, c3] = self.leg_cosines;
        f1 * c1 + f2 * c2 + f3 * c3 + f4
    }

    /// Normal force as published: axial force over the cosine between normal and axis.
    ///
    /// Exact without friction and without weight only.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::NormalAcrossAxis`] when the cosine is below 0.1.
    pub fn published_normal_n(
        &self,
        cells_n: &[f64; 4],
        normal: &Vector3<f64>,
    ) -> Result<f64, ForceImpedanceError> {
        let cosine = -self.axis.dot(normal);
        if cosine >= libm::cos(MAX_PUBLISHED_RAD) {
            return Ok(self.published_axial_n(cells_n) / cosine);
        }
        let angle_rad = libm::atan2(norm(&self.axis.cross(normal)), cosine);
        Err(ForceImpedanceError::NormalAcrossAxis { angle_rad, max_rad: MAX_PUBLISHED_RAD })
    }
}
