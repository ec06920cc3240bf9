use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Tilt angles of a machine pose: `R = Rz(γ) Ry(β) Rx(α)` (document \[D\], with its signs).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EulerAngles {
    /// First rotation, about x.
    pub alpha_rad: f64,
    /// Second rotation, about the fixed y.
    pub beta_rad: f64,
    /// Third rotation, about the fixed z.
    pub gamma_rad: f64,
}

/// Angles read from a rotation, and whether they are the only ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EulerReading {
    /// The only angles with β from −π/2 to π/2.
    Unique(EulerAngles),
    /// Gimbal lock: β is ±π/2 and only `γ ∓ α` is determined; α is set to zero.
    GimbalLock(EulerAngles),
}

/// Below this `cos β` the round-off of a rotation (some 2⁻⁵²) moves α and γ by over 1e-4 rad.
const GIMBAL_LOCK_COS: f64 = 1e-12;

impl EulerAngles {
    /// The rotation `Rz(γ) Ry(β) Rx(α)`.
    #[must_use]
    pub fn to_rotation(self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(self.alpha_rad, self.beta_rad, self.gamma_rad)
    }

    /// Reads the angles of a rotation.
    ///
    /// `β = −asin r31`, `α = atan2(r32, r33)`, `γ = atan2(r21, r11)`, in forms that keep full
    /// accuracy near β = ±π/2: put together, the angles give the rotation back to round-off, in
    /// gimbal lock, where α is dropped, to `π cos β` < 4e-12 rad.
    #[must_use]
    pub fn from_rotation(rotation: &UnitQuaternion<f64>) -> EulerReading {
        let r = rotation.to_rotation_matrix().into_inner();
        let cos_beta = r[(2, 1)].hypot(r[(2, 2)]);
        let beta_rad = (-r[(2, 0)]).atan2(cos_beta);
        let locked = cos_beta < GIMBAL_LOCK_COS;
        let alpha_rad = if locked { 0.0 } else { r[(2, 1)].atan2(r[(2, 2)]) };
        // Second column of R Rx(α)ᵀ = Rz Ry is (−sin γ, cos γ, 0).
        let (sin, cos) = alpha_rad.sin_cos();
        let gamma_rad =
            (sin * r[(0, 2)] - cos * r[(0, 1)]).atan2(cos * r[(1, 1)] - sin * r[(1, 2)]);
        let angles = Self { alpha_rad, beta_rad, gamma_rad };
        if locked { EulerReading::GimbalLock(angles) } else { EulerReading::Unique(angles) }
    }

    /// `∂φ/∂(α, β, γ)`, `3 × 3`: the small rotation on the left that a change of the angles makes.
    ///
    /// Its inverse takes the covariance of a rotation to that of the angles; singular in gimbal
    /// lock (determinant `cos β`).
    #[must_use]
    pub fn left_jacobian(self) -> Matrix3<f64> {
        let about_z = Rotation3::from_axis_angle(&Vector3::z_axis(), self.gamma_rad);
        let about_y = Rotation3::from_axis_angle(&Vector3::y_axis(), self.beta_rad);
        let y_axis = about_z * Vector3::y();
        let x_axis = about_z * (about_y * Vector3::x());
        Matrix3::from_columns(&[x_axis, y_axis, Vector3::z()])
    }
}

impl EulerReading {
    /// The angles, whether unique or not.
    #[must_use]
    pub fn angles(self) -> EulerAngles {
        match self {
            Self::Unique(angles) | Self::GimbalLock(angles) => angles,
        }
    }
}
