use nalgebra::{Matrix3, Matrix3x4, Point3, Vector3, Vector4};

use crate::cofactor::{orthogonal, shortest};
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
    /// Contact force per load-cell reading.
    columns: [Vector3<f64>; 4],
    /// What the head's weight adds to the contact force.
    of_weight_n: Vector3<f64>,
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
        let per_reach = 1.0 / reach_mm;
        // u × (p × d) = p (u·d) − d (u·p), and every joint has u·p = l4.
        let column = |joint_mm: &Point3<f64>, leg: &Vector3<f64>, cosine: f64| {
            (joint_mm.coords * cosine - leg * axial_mm) * per_reach - u * cosine
        };
        let [p1, p2, p3] = &pose.joints_mm;
        let [d1, d2, d3] = &pose.legs_axis;
        let leg_cosines = [d1.dot(&u), d2.dot(&u), d3.dot(&u)];
        let [c1, c2, c3] = leg_cosines;
        // The centre of gravity slides with the head.
        let arm_mm =
            self.geometry.center_of_gravity_mm + axial_mm - self.geometry.plane_to_joint_mm;
        let weight_n = self.geometry.gravity_direction * self.geometry.weight_n;
        let along_n = u * u.dot(&weight_n);
        Balance {
            columns: [column(p1, d1, c1), column(p2, d2, c2), column(p3, d3, c3), -u],
            of_weight_n: (along_n - weight_n) * (arm_mm * per_reach) - along_n,
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
    /// Friction over normal force, finite; `None` while nothing presses.
    pub friction_ratio: Option<f64>,
}

impl Balance {
    /// Contact force per load-cell reading, `3×4`, N per N.
    #[must_use]
    pub fn influence(&self) -> Matrix3x4<f64> {
        Matrix3x4::from_columns(&self.columns)
    }

    #[inline]
    pub(crate) const fn columns(&self) -> &[Vector3<f64>; 4] {
        &self.columns
    }

    /// What the head's weight adds to the contact force.
    #[must_use]
    pub const fn of_weight_n(&self) -> Vector3<f64> {
        self.of_weight_n
    }

    /// Force of the workpiece on the tool from the four cells (compression positive).
    #[inline]
    #[must_use]
    pub fn force_n(&self, cells_n: &[f64; 4]) -> Vector3<f64> {
        let ([a, b, c, d], [f1, f2, f3, f4]) = (&self.columns, *cells_n);
        a * f1 + b * f2 + c * f3 + d * f4 + self.of_weight_n
    }

    /// Readings of the four cells under a contact force and a preload of the legs: the inverse of
    /// [`Balance::force_n`] and [`Balance::preload_n`].
    ///
    /// `None` where legs and axis do not hold the head, or for what is not finite.
    #[must_use]
    pub fn cells_n(&self, force_n: &Vector3<f64>, preload_n: f64) -> Option<[f64; 4]> {
        let [a, b, c, d] = shortest(&self.columns, &(force_n - self.of_weight_n));
        let cells_n = Vector4::new(a, b, c, d) + orthogonal(&self.columns) * preload_n;
        cells_n.iter().all(|f| f.is_finite()).then_some(cells_n.into())
    }

    /// The same, split along the outward unit normal of the surface.
    #[inline]
    #[must_use]
    pub fn contact(&self, cells_n: &[f64; 4], normal: &Vector3<f64>) -> ContactForce {
        let force_n = self.force_n(cells_n);
        let normal_n = force_n.dot(normal);
        let tangential_n = norm(&across(&force_n, normal));
        // Next to nothing presses: the ratio may be no number.
        let ratio = tangential_n / normal_n;
        let friction_ratio = (normal_n > 0.0 && ratio.is_finite()).then_some(ratio);
        ContactForce { force_n, normal_n, tangential_n, friction_ratio }
    }

    /// Covariance of the force for independent cells of standard uncertainty `sigma_n`, N².
    #[must_use]
    pub fn covariance_n2(&self, sigma_n: &[f64; 4]) -> Matrix3<f64> {
        let mut scaled = self.influence();
        for (mut column, sigma) in scaled.column_iter_mut().zip(sigma_n) {
            column *= *sigma;
        }
        scaled * scaled.transpose()
    }

    /// Coefficients of the four cells in the normal force.
    #[inline]
    #[must_use]
    pub fn normal_weights(&self, normal: &Vector3<f64>) -> [f64; 4] {
        self.columns.map(|column| column.dot(normal))
    }

    /// Internal force of the cells that no contact force balances: the preload of the legs.
    ///
    /// The component of the readings along the one direction that gives no contact force, a unit
    /// vector; at the straight head `(1, 1, 1, 0)/√3`.
    #[inline]
    #[must_use]
    pub fn preload_n(&self, cells_n: &[f64; 4]) -> f64 {
        orthogonal(&self.columns).dot(&Vector4::from(*cells_n))
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
