use std::fmt;

use geometry::EulerAngles;
use nalgebra::{Matrix3, Matrix6};
use pose_icp::Registration;
use serde::Serialize;

/// Answer of `truing register`; serialises as its JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Registered {
    /// Version of this crate.
    pub version: &'static str,
    /// Where the source lies: `p_target = Rz(γ) Ry(β) Rx(α) p + d`.
    pub pose: RegisteredPose,
    /// The same as rows of a 4 × 4 matrix, target from source.
    pub matrix: [[f64; 4]; 4],
    /// Root-mean-square residual of the points used.
    pub rms_mm: f64,
    /// Standard uncertainty of one residual, estimated from them.
    pub sigma_mm: f64,
    /// Points of the source, and those that took part in the end.
    pub points: usize,
    /// Points that took part in the end.
    pub used: usize,
    /// Passes over the points, at all levels of detail.
    pub iterations: usize,
    /// Whether the passes ended by themselves.
    pub converged: bool,
    /// How long it took.
    pub timing: RegisterTiming,
    /// Motions that the shape shows little of.
    pub weak_directions: Vec<String>,
    /// Singular values of the rows along the surface's normals, the largest first.
    pub singular_values: Vec<f64>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// Pose of the source in the target's frame, with standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "coordinates and angles of `p_target = Rz(γ) Ry(β) Rx(α) p + d`")]
pub struct RegisteredPose {
    pub x_mm: f64,
    pub y_mm: f64,
    pub z_mm: f64,
    pub alpha_deg: f64,
    pub beta_deg: f64,
    pub gamma_deg: f64,
    pub std_x_mm: f64,
    pub std_y_mm: f64,
    pub std_z_mm: f64,
    /// `None` where the angles are not unique.
    pub std_alpha_deg: Option<f64>,
    pub std_beta_deg: Option<f64>,
    pub std_gamma_deg: Option<f64>,
}

/// Wall-clock times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegisterTiming {
    /// Reading both files.
    pub read_s: f64,
    /// Normals and search tree of the target.
    pub build_s: f64,
    /// Registration.
    pub align_s: f64,
}

impl RegisteredPose {
    pub(super) fn of(found: &Registration) -> Self {
        let pose = &found.target_from_source;
        let at = pose.translation.vector;
        let angles = EulerAngles::from_rotation(&pose.rotation).angles();
        // The source's origin is d; a small rotation about the pivot moves it by ω × (d − pivot).
        let mut origin = Matrix6::identity();
        let arm = at - found.pivot_mm.coords;
        origin.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
        let covariance = origin * found.covariance * origin.transpose();
        let std_mm = |k: usize| covariance[(k, k)].sqrt();
        let rotation: Matrix3<f64> = covariance.fixed_view::<3, 3>(3, 3).into_owned();
        let inverse = angles.left_jacobian().try_inverse();
        let of_angles = inverse.map(|inverse| inverse * rotation * inverse.transpose());
        let std_deg = |k: usize| of_angles.map(|c| c[(k, k)].sqrt().to_degrees());
        Self {
            x_mm: at.x,
            y_mm: at.y,
            z_mm: at.z,
            alpha_deg: angles.alpha_rad.to_degrees(),
            beta_deg: angles.beta_rad.to_degrees(),
            gamma_deg: angles.gamma_rad.to_degrees(),
            std_x_mm: std_mm(0),
            std_y_mm: std_mm(1),
            std_z_mm: std_mm(2),
            std_alpha_deg: std_deg(0),
            std_beta_deg: std_deg(1),
            std_gamma_deg: std_deg(2),
        }
    }
}

impl fmt::Display for Registered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pose = &self.pose;
        writeln!(f, "pose of the source in the target's frame, standard uncertainty")?;
        for (name, value, std) in [
            ("x", pose.x_mm, pose.std_x_mm),
            ("y", pose.y_mm, pose.std_y_mm),
            ("z", pose.z_mm, pose.std_z_mm),
        ] {
            writeln!(f, "  {name:<5} {value:>16.6} mm  ± {std:.2e}")?;
        }
        for (name, value, std) in [
            ("alpha", pose.alpha_deg, pose.std_alpha_deg),
            ("beta", pose.beta_deg, pose.std_beta_deg),
            ("gamma", pose.gamma_deg, pose.std_gamma_deg),
        ] {
            let std = std.map_or_else(|| "not unique".to_owned(), |std| format!("± {std:.2e}"));
            writeln!(f, "  {name:<5} {value:>16.6} deg {std}")?;
        }
        writeln!(
            f,
            "rms {:.3e} mm over {} of {} points, {} passes",
            self.rms_mm, self.used, self.points, self.iterations
        )?;
        for weak in &self.weak_directions {
            writeln!(f, "weakly determined: {weak}")?;
        }
        Ok(())
    }
}
