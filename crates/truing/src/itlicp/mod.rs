//! The pose of a part by the method of document \[D\], beside the exact one.

mod answer;
mod text;

use std::time::Instant;

use nalgebra::{Isometry3, Point3};
use pose_icp::{Part, PoseFit, PoseStart, SampledMethod, SampledOptions, Tip, Touch};

use crate::{Case, Error, Header};

pub use answer::{Itlicp, ItlicpLevel, ItlicpPoint, ItlicpTiming, PoseBeside};

/// What both methods are given, and what the exact one finds.
pub(crate) struct SampledCase {
    pub(crate) part: Part,
    pub(crate) tip: Tip,
    pub(crate) touches: Vec<Touch>,
    pub(crate) start: PoseStart,
    pub(crate) exact: PoseFit,
    pub(crate) exact_s: f64,
    /// Centre of the ball at every point of the case, and whether it was only judged.
    pub(crate) points: Vec<(String, Point3<f64>, bool)>,
}

/// Finds the pose of a `pose-icp` case by ITLICP, or by the classical method, from where the exact one
/// starts.
///
/// # Errors
///
/// As [`solve`](crate::solve); [`Error::NoPose`] for another kind of case, [`Error::PoseIcp`] where the
/// method does not reach its tolerance or needs too many points, and for a part that is no asphere.
pub fn itlicp(case: &Case, options: &SampledOptions) -> Result<Itlicp, Error> {
    let of = case.measured.sampled()?.ok_or(Error::NoPose { kind: case.kind })?;
    let shape = of.part.shape().filter(|_| !of.part.has_form_map()).ok_or(Error::NoAsphere)?;
    let options = SampledOptions { tip: of.tip, ..*options };
    let started = Instant::now();
    let found = pose_icp::fit_pose_on_samples(shape, &of.touches, &of.start, &options);
    let sampled_s = started.elapsed().as_secs_f64();
    let found = found.map_err(|source| Error::PoseIcp {
        at: Box::new(crate::Location::file(&case.path)),
        source: Box::new(source),
    })?;
    let left = |pose: &Isometry3<f64>, center_mm: &Point3<f64>| {
        let foot = of.part.surface().closest_point(&pose.inverse_transform_point(center_mm));
        foot.ok().map(|foot| foot.signed_distance_mm - of.tip.signed_radius_mm())
    };
    let exact = of.exact.machine_from_workpiece;
    let points: Vec<ItlicpPoint> = (of.points.iter())
        .map(|(name, center_mm, is_check)| ItlicpPoint {
            point: name.clone(),
            usage: if *is_check { "check" } else { "fit" },
            residual_mm: left(&found.machine_from_workpiece, center_mm),
            exact_residual_mm: left(&exact, center_mm),
        })
        .collect();
    let coarse_and_fine = match options.method {
        SampledMethod::Classical { spacing_mm } => [None, Some(spacing_mm)],
        SampledMethod::TwoLevel { coarse_mm, fine_mm, .. } => [Some(coarse_mm), Some(fine_mm)],
    };
    let level = |of: &pose_icp::SampledPass| ItlicpLevel {
        model_points: of.model_points,
        iterations: of.iterations,
    };
    Ok(Itlicp {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/itlicp/1", case),
        coarse_mm: coarse_and_fine[0],
        fine_mm: coarse_and_fine[1],
        tolerance_mm: options.tolerance_mm,
        levels: found.levels.iter().map(level).collect(),
        itlicp: PoseBeside::of(&found.pose, points.iter().map(|p| p.residual_mm)),
        exact: PoseBeside::of(&of.exact.pose, points.iter().map(|p| p.exact_residual_mm)),
        points,
        timing: Some(ItlicpTiming { itlicp_s: sampled_s, exact_s: of.exact_s }),
        warnings: case.warnings.clone(),
    })
}

impl PoseBeside {
    fn of(pose: &PoseStart, residuals_mm: impl Iterator<Item = Option<f64>>) -> Self {
        let residuals: Vec<f64> = residuals_mm.flatten().collect();
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        Self {
            numbers: pose.into(),
            rms_mm: (squares / crate::count::count(residuals.len().max(1))).sqrt(),
            largest_mm: residuals.iter().fold(0.0, |largest, r| r.abs().max(largest)),
        }
    }
}
