use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use nalgebra::{Isometry3, Point3, Unit, Vector3, Vector6};

use crate::error::finite;
use crate::{GeometryError, Line};

/// Force and moment about the origin of the frame they are given in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wrench {
    /// Resultant force.
    pub force_n: Vector3<f64>,
    /// Resultant moment about the origin.
    pub torque_nmm: Vector3<f64>,
}

/// Central axis of a wrench: where a single force, with a couple along it, does the same.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LineOfAction {
    /// Axis in the direction of the force; its point is the one closest to the origin.
    pub line: Line,
    /// Magnitude of the force.
    pub force_n: f64,
    /// Moment along the force, which no choice of point removes; positive by the right-hand rule.
    pub free_torque_nmm: f64,
}

impl Wrench {
    /// Wrench of a single force through a point: `M = p × F`.
    #[must_use]
    pub fn of_force(force_n: Vector3<f64>, point_mm: &Point3<f64>) -> Self {
        Self { force_n, torque_nmm: point_mm.coords.cross(&force_n) }
    }

    /// From `[fx, fy, fz, mx, my, mz]`, N and N·mm.
    #[must_use]
    pub fn from_vector(force_and_torque: &Vector6<f64>) -> Self {
        Self {
            force_n: force_and_torque.fixed_rows::<3>(0).into_owned(),
            torque_nmm: force_and_torque.fixed_rows::<3>(3).into_owned(),
        }
    }

    /// As `[fx, fy, fz, mx, my, mz]`, N and N·mm.
    #[must_use]
    pub fn to_vector(self) -> Vector6<f64> {
        let (f, m) = (self.force_n, self.torque_nmm);
        Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z)
    }

    /// The same wrench with its moment about another point; axes stay parallel.
    ///
    /// `M' = M − p × F` with `p` the new reference point in the present frame.
    #[must_use]
    pub fn about(self, reference_mm: &Point3<f64>) -> Self {
        let torque_nmm = self.torque_nmm - reference_mm.coords.cross(&self.force_n);
        Self { torque_nmm, ..self }
    }

    /// The same wrench in another frame, its moment about that frame's origin.
    ///
    /// `F' = R F`, `M' = R M + t × R F`, that is `Ad(T⁻¹)ᵀ` on the six-vector: power is the same
    /// in both frames.
    #[must_use]
    pub fn in_frame(self, target_from_source: &Isometry3<f64>) -> Self {
        let force_n = target_from_source.rotation * self.force_n;
        let lever = target_from_source.translation.vector;
        let torque_nmm = target_from_source.rotation * self.torque_nmm + lever.cross(&force_n);
        Self { force_n, torque_nmm }
    }

    /// Power on a body that moves with a twist, in N·mm/s (mW).
    ///
    /// `twist` is `[vx, vy, vz, ωx, ωy, ωz]` in mm/s and rad/s in the wrench's frame, the
    /// velocity being that of the body's point at the origin.
    #[must_use]
    pub fn power_nmm_per_s(self, twist: &Vector6<f64>) -> f64 {
        self.to_vector().dot(twist)
    }

    /// Central axis, force and free moment.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NoForce`] for a pure couple, [`GeometryError::NonFinite`]. Any force above
    /// zero has an axis; whether it is one to be trusted is for the caller's force gate to say.
    pub fn line_of_action(self) -> Result<LineOfAction, GeometryError> {
        finite(self.force_n.iter().chain(self.torque_nmm.iter()), "wrench")?;
        let (direction, force_n) = Unit::try_new_and_get(self.force_n, 0.0)
            .ok_or(GeometryError::NoForce { force_n: self.force_n.norm() })?;
        // p = F × M / |F|², with the lever arm formed first so that tiny forces do not overflow.
        let point_mm = Point3::from(direction.cross(&(self.torque_nmm / force_n)));
        finite(point_mm.iter().chain([&force_n]), "wrench")?;
        let free_torque_nmm = direction.dot(&self.torque_nmm);
        Ok(LineOfAction { line: Line { point_mm, direction }, force_n, free_torque_nmm })
    }
}

impl Add for Wrench {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            force_n: self.force_n + other.force_n,
            torque_nmm: self.torque_nmm + other.torque_nmm,
        }
    }
}

impl AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Neg for Wrench {
    type Output = Self;
    fn neg(self) -> Self {
        Self { force_n: -self.force_n, torque_nmm: -self.torque_nmm }
    }
}

impl Sub for Wrench {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl SubAssign for Wrench {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Mul<f64> for Wrench {
    type Output = Self;
    fn mul(self, ratio: f64) -> Self {
        Self { force_n: self.force_n * ratio, torque_nmm: self.torque_nmm * ratio }
    }
}
