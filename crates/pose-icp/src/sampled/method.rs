use geometry::{Asphere, AsphereShape, EulerAngles, EulerReading};
use nalgebra::{Isometry3, Point3};

use super::counts::{Patch, disc_points, patch_points};
use super::iteration::{Level, iterate};
use super::model_cloud::{ModelCloud, POINT_BYTES};
use crate::{PoseError, PoseStart, Tip, Touch};

/// How the model is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SampledMethod {
    /// The whole aperture at once.
    Classical {
        /// Distance of neighbours, Δw1 of (17).
        spacing_mm: f64,
    },
    /// The whole aperture coarsely, then finely around the touches (ITLICP).
    TwoLevel {
        /// Δw: spacing of the first level, and distance at which it ends, (12).
        coarse_mm: f64,
        /// Δw1: spacing of the second level.
        fine_mm: f64,
        /// What the second level samples around each touch.
        patch: Patch,
    },
}

/// What the method of document \[D\] is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledOptions {
    /// How the model is sampled; the paper's 1 mm and 1 µm by default.
    pub method: SampledMethod,
    /// The ball; the model is sampled at its radius from the surface.
    pub tip: Tip,
    /// `δ_set`: the method ends when all touches are nearer to a model point; the paper takes 7 µm.
    pub tolerance_mm: f64,
    /// Passes per level before giving up.
    pub max_iterations: usize,
    /// Model points that a level may have; 10⁸ by default, 2.4 GB.
    pub max_points: usize,
}

impl Default for SampledOptions {
    fn default() -> Self {
        let patch = Patch::OneSpacing;
        Self {
            method: SampledMethod::TwoLevel { coarse_mm: 1.0, fine_mm: 1e-3, patch },
            tip: Tip::default(),
            tolerance_mm: 7e-3,
            max_iterations: 100,
            max_points: 100_000_000,
        }
    }
}

/// One level of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledPass {
    /// Points of the model that it went through for every touch.
    pub model_points: usize,
    /// Searches and fits.
    pub iterations: usize,
}

/// A pose by the method of document \[D\].
#[derive(Clone, Debug, PartialEq)]
pub struct SampledFit {
    /// Maps workpiece to machine coordinates: the inverse of the document's transform, (2).
    pub machine_from_workpiece: Isometry3<f64>,
    /// The same as position of the workpiece's origin and Euler angles, (21).
    pub pose: PoseStart,
    /// Distance of each touch from its model point, in input order.
    pub distances_mm: Vec<f64>,
    /// One per level.
    pub levels: Vec<SampledPass>,
}

impl SampledMethod {
    /// Model points of each level by (15)–(17), the whole aperture on its own.
    #[must_use]
    pub fn predicted_points(&self, diameter_mm: f64, touches: usize) -> Vec<f64> {
        match *self {
            Self::Classical { spacing_mm } => vec![disc_points(diameter_mm, spacing_mm)],
            Self::TwoLevel { coarse_mm, fine_mm, patch } => vec![
                disc_points(diameter_mm, coarse_mm),
                patch_points(touches, patch, coarse_mm, fine_mm),
            ],
        }
    }

    /// Memory that the larger level's points take.
    #[must_use]
    pub fn predicted_bytes(&self, diameter_mm: f64, touches: usize) -> f64 {
        let largest = self.predicted_points(diameter_mm, touches).into_iter().fold(0.0, f64::max);
        #[expect(clippy::cast_precision_loss, reason = "a point has 24 bytes")]
        let bytes = POINT_BYTES as f64;
        bytes * largest
    }
}

/// Finds a pose by the method of document \[D\]: every touch is taken to the nearest of the model's
/// points, (4)–(7), in one level or in two, (11)–(14), from `start` on, (10).
///
/// The five-point start (8)–(9) is [`EdgeTouches::locate`](crate::EdgeTouches::locate). Nothing is
/// held: γ, and whatever else the touches hardly show, stays near the start because each step is
/// small. No uncertainty is known.
///
/// # Errors
///
/// [`PoseError::TooFewTouches`] below the six of the document, [`PoseError::InvalidOption`],
/// [`PoseError::TooManyModelPoints`] before any memory is taken, [`PoseError::NotConverged`] where
/// a touch stays further away than the tolerance, [`PoseError::Surface`].
pub fn fit_pose_on_samples(
    shape: &AsphereShape,
    touches: &[Touch],
    start: &PoseStart,
    options: &SampledOptions,
) -> Result<SampledFit, PoseError> {
    crate::exact::check_touches(touches, start, options.tip)?;
    check(shape, touches.len(), options)?;
    let surface = Asphere::new(shape.clone())?;
    let offset_mm = options.tip.signed_radius_mm();
    let real_mm: Vec<Point3<f64>> = touches.iter().map(|t| t.center_mm).collect();
    let mut ideal_from_real = start.machine_from_workpiece().inverse();
    let mut levels = Vec::new();
    let mut run = |cloud: &ModelCloud, tolerance_mm: f64, from: Isometry3<f64>| {
        let level = iterate(cloud, &real_mm, from, tolerance_mm, options.max_iterations);
        levels.push(SampledPass { model_points: cloud.len(), iterations: level.iterations });
        if level.reached { Ok(level) } else { Err(unsettled(&level)) }
    };
    let last = match options.method {
        SampledMethod::Classical { spacing_mm } => {
            let cloud = ModelCloud::of_disc(&surface, offset_mm, spacing_mm)?;
            run(&cloud, options.tolerance_mm, ideal_from_real)?
        }
        SampledMethod::TwoLevel { coarse_mm, fine_mm, patch } => {
            let cloud = ModelCloud::of_disc(&surface, offset_mm, coarse_mm)?;
            ideal_from_real = run(&cloud, coarse_mm, ideal_from_real)?.ideal_from_real;
            let mapped: Vec<_> = real_mm.iter().map(|m| ideal_from_real * m).collect();
            let side_mm = patch.spacings() * coarse_mm;
            let cloud = ModelCloud::around(&surface, offset_mm, &mapped, side_mm, fine_mm)?;
            run(&cloud, options.tolerance_mm, ideal_from_real)?
        }
    };
    let machine_from_workpiece = last.ideal_from_real.inverse();
    let angles = match EulerAngles::from_rotation(&machine_from_workpiece.rotation) {
        EulerReading::Unique(angles) | EulerReading::GimbalLock(angles) => angles,
    };
    let pose = PoseStart { position_mm: machine_from_workpiece.translation.vector, angles };
    Ok(SampledFit { machine_from_workpiece, pose, distances_mm: last.distances_mm, levels })
}

/// Points that the document asks for.
const MIN_TOUCHES: usize = 6;

fn check(shape: &AsphereShape, touches: usize, options: &SampledOptions) -> Result<(), PoseError> {
    if touches < MIN_TOUCHES {
        let (got, prior_rows, parameters) = (touches, 0, MIN_TOUCHES);
        return Err(PoseError::TooFewTouches { got, prior_rows, parameters });
    }
    let spacings = match options.method {
        SampledMethod::Classical { spacing_mm } => [spacing_mm; 2],
        SampledMethod::TwoLevel { coarse_mm, fine_mm, .. } => [coarse_mm, fine_mm],
    };
    for value in spacings.into_iter().chain([options.tolerance_mm]) {
        if !(value > 0.0 && value.is_finite()) {
            let (name, needed) = ("spacing or tolerance", "positive");
            return Err(PoseError::InvalidOption { name, needed, value });
        }
    }
    let predicted = options.method.predicted_points(shape.diameter_mm, touches);
    let points = predicted.into_iter().fold(0.0, f64::max);
    #[expect(clippy::cast_precision_loss, reason = "a limit of memory is far below 2^53")]
    let limit = options.max_points as f64;
    if points > limit {
        let gigabytes = 1e-9 * options.method.predicted_bytes(shape.diameter_mm, touches);
        return Err(PoseError::TooManyModelPoints { points, gigabytes, limit });
    }
    Ok(())
}

fn unsettled(level: &Level) -> PoseError {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = level.distances_mm.len().max(1) as f64;
    let squares: f64 = level.distances_mm.iter().map(|d| d * d).sum();
    PoseError::NotConverged { iterations: level.iterations, rms_mm: (squares / n).sqrt() }
}
