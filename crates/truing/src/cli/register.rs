//! Arguments of `truing register`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use geometry::EulerAngles;
use least_squares::Loss;
use nalgebra::{Isometry3, Translation3};
use pose_icp::{Freedom, Holes, Objective, RegisterOptions};
use truing::RegisterSettings;

use super::number::{MAX_ANGLE_DEG, MAX_LENGTH_MM, positive, share, within};

/// What the six numbers of a pose are, in order.
const COMPONENTS: [&str; 6] = ["x", "y", "z", "alpha", "beta", "gamma"];

#[derive(Args, Debug)]
pub(crate) struct Register {
    /// Cloud or mesh that is moved: .ply, .stl, .obj, .xyz, .txt, .csv, .asc, .pts, in mm
    pub(crate) source: PathBuf,
    /// Cloud or mesh that it is moved onto
    pub(crate) target: PathBuf,
    /// Distance that is minimised
    #[arg(long, value_enum, default_value_t = Method::PointToPlane)]
    method: Method,
    /// Pose to start from: six numbers "x,y,z mm, alpha,beta,gamma deg"
    #[arg(long, value_name = "POSE", value_parser = pose, allow_hyphen_values = true)]
    initial: Option<Isometry3<f64>>,
    /// Nothing is known of the start: look for one
    #[arg(long, conflicts_with_all = ["initial", "hold"])]
    global: bool,
    /// Components that stay as they are at the start, such as "x,y,gamma"; rotations are about the
    /// middle of the source
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = COMPONENTS)]
    hold: Vec<String>,
    /// Robust loss, scaled by the median residual
    #[arg(long, value_enum)]
    loss: Option<LossName>,
    /// Share of the matches to keep, those of the least residual
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    keep: f64,
    /// Ignore points further than this from the target
    #[arg(long, value_name = "MM", value_parser = positive)]
    max_distance: Option<f64>,
    /// Ends when a pass moves no point further than this
    #[arg(long, value_name = "MM", default_value_t = 1e-6, value_parser = positive)]
    tolerance: f64,
    /// Passes at each level of detail, at most
    #[arg(long, value_name = "N", default_value_t = 100)]
    max_iterations: usize,
    /// Ignore points over holes of a target mesh; without it such a mesh is refused
    #[arg(long)]
    skip_holes: bool,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Method {
    PointToPlane,
    PointToPoint,
    Symmetric,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LossName {
    Huber,
    Cauchy,
    Tukey,
}

impl Register {
    pub(crate) fn settings(&self) -> RegisterSettings {
        let held = |k: usize| self.hold.iter().any(|name| name == COMPONENTS[k]);
        RegisterSettings {
            options: RegisterOptions {
                objective: match self.method {
                    Method::PointToPlane => Objective::PointToPlane,
                    Method::PointToPoint => Objective::PointToPoint,
                    Method::Symmetric => Objective::Symmetric,
                },
                start: self.initial.unwrap_or_else(Isometry3::identity),
                freedoms: std::array::from_fn(
                    |k| {
                        if held(k) { Freedom::Held } else { Freedom::Free }
                    },
                ),
                loss: self.loss.map(|loss| match loss {
                    LossName::Huber => Loss::huber_95(),
                    LossName::Cauchy => Loss::cauchy_95(),
                    LossName::Tukey => Loss::tukey_95(),
                }),
                keep_share: self.keep,
                max_distance_mm: self.max_distance,
                tolerance_mm: self.tolerance,
                max_iterations: self.max_iterations,
                ..RegisterOptions::default()
            },
            start_unknown: self.global,
            holes: if self.skip_holes { Holes::Skip } else { Holes::Refuse },
        }
    }
}

pub(crate) fn pose(text: &str) -> Result<Isometry3<f64>, String> {
    let expected = || {
        format!(
            "expected six numbers {}, lengths within {MAX_LENGTH_MM:e} mm and angles within \
             {MAX_ANGLE_DEG}°",
            COMPONENTS.join(",")
        )
    };
    // Units may be written behind the numbers, as the help shows them.
    let number = |(k, cell): (usize, &str)| {
        let bare = cell.trim().trim_end_matches("mm").trim_end_matches("deg").trim();
        let limit = if k < 3 { MAX_LENGTH_MM } else { MAX_ANGLE_DEG };
        within(bare, &(-limit..=limit)).ok()
    };
    let numbers: Option<Vec<f64>> = text.split(',').enumerate().map(number).collect();
    let [x, y, z, alpha, beta, gamma] =
        <[f64; 6]>::try_from(numbers.ok_or_else(expected)?).map_err(|_| expected())?;
    let angles = EulerAngles {
        alpha_rad: alpha.to_radians(),
        beta_rad: beta.to_radians(),
        gamma_rad: gamma.to_radians(),
    };
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), angles.to_rotation()))
}
