use geometry::Foot;
use nalgebra::{Point3, Vector6};

use super::aperture;
use super::chart::Chart;
use super::rows::{Equations, Free, Whitened};
use super::search::{Failed, Found, search};
use super::weak::{Spectrum, covariance};
use crate::error::InvalidTouch;
use crate::{Part, PoseError, PoseFit, PoseOptions, PoseParameter, PoseStart, Tip, TipSide, Touch};

/// Coordinates beyond this are slips: a kilometre.
const LARGEST_MM: f64 = 1e6;
/// Standard uncertainty of a tilt beyond which the linearised covariance means nothing.
const LARGEST_TILT_RAD: f64 = 0.25;

/// Residual over the distance of the touches from the origin, root mean squares, below which they lie on the part.
const ON_THE_PART: f64 = 1e-3;

/// Finds the pose from which the touches lie on the surface, best in the sense of
/// `Σ ((distance − tip radius)/σ)²` over the touches, and the prior on the axis.
///
/// # Errors
///
/// See [`PoseError`]; every variant means that no pose is available.
pub fn fit_pose(
    part: &Part,
    touches: &[Touch],
    start: &PoseStart,
    options: &PoseOptions,
) -> Result<PoseFit, PoseError> {
    check_touches(touches, start, options.tip)?;
    let free = Free::of(|i| !options.held.contains(&PoseParameter::ALL[i]));
    let lateral = options.lateral.as_ref().map(Whitened::new).transpose()?;
    let prior_rows = if lateral.is_some() { 2 } else { 0 };
    let parameters = free.as_slice().len();
    if touches.len() + prior_rows < parameters {
        return Err(PoseError::TooFewTouches { got: touches.len(), prior_rows, parameters });
    }
    let equations = Equations { part, touches, tip: options.tip, lateral, free };
    let position_free = free.as_slice().starts_with(&[0, 1, 2]);
    let pivot_mm = if position_free { part.pivot_mm() } else { 0.0 };
    let at = Chart::new(start, pivot_mm);
    match search(&equations, at) {
        Ok(found) => conclude(&equations, options, found),
        Err(failed) => {
            // A ball in a hollow that is too narrow has no single closest point.
            for (index, touch) in touches.iter().enumerate() {
                check_tip(part, options.tip, index, &at.in_workpiece(&touch.center_mm))?;
            }
            Err(match failed {
                Failed::NoFoot(index, source) => PoseError::NoFoot { index, source },
                Failed::OutOfRounds(found) => unsettled(&equations, &found),
            })
        }
    }
}

/// A motion that changes nothing is the usual cause of a search without end.
fn unsettled(equations: &Equations<'_>, found: &Found) -> PoseError {
    let contacts = &found.feet;
    let at_origin = equations.reduce(&found.at.at_origin(), contacts);
    let free = equations.free.as_slice();
    let arm_mm = travel_mm(contacts);
    let spectrum = Spectrum::of(&at_origin.triangle, free, arm_mm);
    if !spectrum.free.is_empty() {
        return PoseError::Undetermined { directions: spectrum.free };
    }
    let residual = |c: &Foot| c.signed_distance_mm - equations.tip.signed_radius_mm();
    let squares: f64 = contacts.iter().map(|c| residual(c).powi(2)).sum();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let rms_mm = (squares / contacts.len().max(1) as f64).sqrt();
    // Where the touches lie on the part wherever the search goes, a motion that they hardly show leads it astray.
    if rms_mm <= ON_THE_PART * arm_mm && !spectrum.weak.is_empty() {
        return PoseError::Undetermined { directions: spectrum.weak };
    }
    PoseError::NotConverged { iterations: found.iterations, rms_mm }
}

fn conclude(
    equations: &Equations<'_>,
    options: &PoseOptions,
    found: Found,
) -> Result<PoseFit, PoseError> {
    let Equations { part, touches, tip, free, .. } = *equations;
    let mut contacts = found.feet;
    for contact in &mut contacts {
        contact.inside_aperture = part.contains(contact);
    }
    let at_origin = equations.reduce(&found.at.at_origin(), &contacts);
    let spectrum = Spectrum::of(&at_origin.triangle, free.as_slice(), travel_mm(&contacts));
    let in_chart = covariance(&found.linearised.triangle, free.as_slice());
    let (Some(in_chart), true) = (in_chart, spectrum.free.is_empty()) else {
        let directions = if spectrum.free.is_empty() { spectrum.weak } else { spectrum.free };
        return Err(PoseError::Undetermined { directions });
    };
    let to_pose = found.at.pose_jacobian();
    let prior_rows = if equations.lateral.is_some() { 2 } else { 0 };
    let degrees_of_freedom = touches.len() + prior_rows - free.as_slice().len();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let variance_factor =
        (degrees_of_freedom > 0).then(|| 2.0 * found.linearised.cost / degrees_of_freedom as f64);
    let pose = found.at.pose();
    let mut fit = PoseFit {
        machine_from_workpiece: pose.machine_from_workpiece(),
        pose,
        covariance: to_pose * in_chart * to_pose.transpose(),
        residuals_mm: (contacts.iter())
            .map(|c| c.signed_distance_mm - tip.signed_radius_mm())
            .collect(),
        contacts,
        degrees_of_freedom,
        variance_factor,
        noise: options.noise,
        singular_values: spectrum.singular_values,
        weak_directions: Vec::new(),
        iterations: found.iterations,
        evaluations: found.evaluations,
    };
    let sigmas = fit.standard_uncertainties();
    let sigma_of = |p: PoseParameter| sigmas.map(|s| s[p as usize]);
    fit.weak_directions = spectrum.weak.into_iter().map(|w| w.with_sigmas(sigma_of)).collect();
    check_tilts(&fit)?;
    check_contacts(part, &fit, options)?;
    Ok(fit)
}

/// How far the touches travel when the part turns by 1 rad about its own origin: root mean square.
fn travel_mm(contacts: &[Foot]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = contacts.len().max(1) as f64;
    let sum: f64 = contacts.iter().map(|c| c.point_mm.coords.norm_squared()).sum();
    (sum / n).sqrt().max(f64::MIN_POSITIVE)
}

/// Refuses numbers that no machine gives.
pub(crate) fn check_touches(
    touches: &[Touch],
    start: &PoseStart,
    tip: Tip,
) -> Result<(), PoseError> {
    for (index, touch) in touches.iter().enumerate() {
        let bad = |v: &&f64| v.is_nan() || v.abs() >= LARGEST_MM;
        if let Some(&value) = touch.center_mm.iter().find(bad) {
            let reason = InvalidTouch::Coordinate { value, limit: LARGEST_MM };
            return Err(PoseError::InvalidTouch { index, reason });
        }
        let sigma_mm = touch.sigma_mm;
        if !(sigma_mm > 0.0 && sigma_mm.is_finite()) {
            let reason = InvalidTouch::Sigma { sigma_mm };
            return Err(PoseError::InvalidTouch { index, reason });
        }
    }
    let radius_mm = tip.radius_mm;
    if !(radius_mm >= 0.0 && radius_mm.is_finite()) {
        let (name, needed) = ("tip radius", "zero or positive");
        return Err(PoseError::InvalidOption { name, needed, value: radius_mm });
    }
    let angles = [start.angles.alpha_rad, start.angles.beta_rad, start.angles.gamma_rad];
    for value in start.position_mm.iter().copied().chain(angles) {
        if value.is_nan() || value.abs() >= LARGEST_MM {
            let (name, needed) = ("start", "finite and below 1e6 mm");
            return Err(PoseError::InvalidOption { name, needed, value });
        }
    }
    Ok(())
}

fn check_tilts(fit: &PoseFit) -> Result<(), PoseError> {
    let unknown = |sigmas: Vector6<f64>| sigmas.rows(3, 3).amax() > LARGEST_TILT_RAD;
    if fit.standard_uncertainties().is_some_and(unknown) && !fit.weak_directions.is_empty() {
        return Err(PoseError::Undetermined { directions: fit.weak_directions.clone() });
    }
    Ok(())
}

fn check_contacts(part: &Part, fit: &PoseFit, options: &PoseOptions) -> Result<(), PoseError> {
    for (index, contact) in fit.contacts.iter().enumerate() {
        check_tip(part, options.tip, index, &contact.point_mm)?;
    }
    aperture::check(part, fit)
}

/// Fails where the surface below a point is hollow and too narrow for the ball.
fn check_tip(part: &Part, tip: Tip, index: usize, point_mm: &Point3<f64>) -> Result<(), PoseError> {
    if tip.radius_mm == 0.0 {
        return Ok(());
    }
    // Beside the surface, and on the edges of a mesh, there is no curvature to be too large.
    let Ok(curvature) = part.surface().curvature(point_mm) else { return Ok(()) };
    let towards_per_mm = match tip.side {
        TipSide::Above => curvature.major_per_mm,
        TipSide::Below => -curvature.minor_per_mm,
    };
    if tip.radius_mm * towards_per_mm < 1.0 {
        return Ok(());
    }
    let (radius_mm, curvature_radius_mm) = (tip.radius_mm, 1.0 / towards_per_mm);
    Err(PoseError::TipTooLarge { index, radius_mm, curvature_radius_mm })
}
