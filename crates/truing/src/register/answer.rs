use std::fmt;

use geometry::EulerAngles;
use nalgebra::Matrix6;
use pose_icp::{PoseStart, Registration};
use serde::Serialize;

use crate::kinds::{PoseEstimate, stds};
use crate::{Header, Layout};

/// Answer of `truing register`; serialises as its JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Registered {
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// Where the source lies: `p_target = Rz(γ) Ry(β) Rx(α) p + d`.
    pub pose: PoseEstimate,
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
    /// How long it took; `None` leaves it out of the JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<RegisterTiming>,
    /// Motions that the shape shows little of.
    pub weak_directions: Vec<String>,
    /// Singular values of the rows along the surface's normals, the largest first.
    pub singular_values: Vec<f64>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
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

/// Pose of the source in the target's frame; without uncertainties of the angles where these are not
/// unique.
pub(super) fn pose_of(found: &Registration) -> PoseEstimate {
    let position_mm = found.target_from_source.translation.vector;
    let angles = EulerAngles::from_rotation(&found.target_from_source.rotation).angles();
    let of_angles = angles.left_jacobian().try_inverse();
    let mut to_pose = Matrix6::identity();
    // The source's origin is d; a small rotation about the pivot moves it by ω × (d − pivot).
    let arm = position_mm - found.pivot_mm.coords;
    to_pose.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
    if let Some(of_angles) = &of_angles {
        to_pose.fixed_view_mut::<3, 3>(3, 3).copy_from(of_angles);
    }
    let covariance = to_pose * found.covariance * to_pose.transpose();
    let mut pose = PoseEstimate::of(&PoseStart { position_mm, angles }, Some(stds(&covariance)));
    if of_angles.is_none() {
        (pose.std_alpha_deg, pose.std_beta_deg, pose.std_gamma_deg) = (None, None, None);
    }
    pose
}

impl Registered {
    /// The answer for people, the same in every layout.
    #[must_use]
    pub fn text(&self, _: Layout) -> String {
        self.to_string()
    }
}

impl fmt::Display for Registered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pose = &self.pose;
        let at = &pose.numbers;
        writeln!(f, "pose of the source in the target's frame, standard uncertainty")?;
        for (name, value, std) in [
            ("x", at.x_mm, pose.std_x_mm),
            ("y", at.y_mm, pose.std_y_mm),
            ("z", at.z_mm, pose.std_z_mm),
        ] {
            let std = std.map_or_else(String::new, |std| format!("± {std:.2e}"));
            writeln!(f, "  {name:<5} {value:>16.6} mm  {std}")?;
        }
        for (name, value, std) in [
            ("alpha", at.alpha_deg, pose.std_alpha_deg),
            ("beta", at.beta_deg, pose.std_beta_deg),
            ("gamma", at.gamma_deg, pose.std_gamma_deg),
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
