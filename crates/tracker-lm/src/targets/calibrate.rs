//! From points to the six errors.

use least_squares::{BorderedPoint, BorderedProblem, BorderedSolution, Report};
use nalgebra::{DMatrix, Isometry3, Matrix3, Point3, Vector3, Vector6};

use super::bundle::Bundle;
use super::check::{check, check_count};
use crate::joint_result::{in_order, location, square};
use crate::network::angles;
use crate::search::{covariance, settle};
use crate::spread::{Spread, dense_block};
use crate::{
    AxisError, AxisLocation, MountEstimate, TargetNoise, TargetOptions, TargetSurvey, TrackerError,
};

/// Standard uncertainty of a coordinate that the first fit takes where none is declared.
const FIRST_GUESS_MM: f64 = 1e-2;
/// Estimates of the noise below this are rounding, and no reason to weigh anything by.
const LEAST_NOISE_MM: f64 = 1e-9;

/// An axis calibrated from points: everything with its standard uncertainty.
///
/// Uncertainties are a priori where the noise was declared; otherwise they rest on
/// [`TargetCalibration::point_mm`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TargetCalibration {
    /// In the order of the survey.
    pub stations: Vec<StationPose>,
    /// In the order of the survey.
    pub mounts: Vec<MountEstimate>,
    /// One per angle, in the order in which the angles were first measured.
    pub axis_errors: Vec<AxisError>,
    /// Location of the axis, where the angles show it.
    pub location: Option<AxisLocation>,
    /// Predicted minus measured, in the order of the survey: along the beam and across it twice
    /// where the noise is polar, else along the axes of the station's frame.
    pub residuals_mm: Vec<Vector3<f64>>,
    /// Standard uncertainty of these components.
    pub sigmas_mm: Vec<Vector3<f64>>,
    /// Share of an error of each component that its own residual shows, 0 to 1.
    pub redundancy: Vec<Vector3<f64>>,
    /// Target points measured, from however many stations.
    pub n_points: usize,
    /// Equations minus unknowns.
    pub degrees_of_freedom: usize,
    /// Mean whitened square residual, near 1 when the declared noise is honest.
    pub variance_factor: f64,
    /// Standard uncertainty of a coordinate where it was estimated from the residual.
    pub point_mm: Option<f64>,
    /// How the search went.
    pub report: Report,
}

/// Where a tracker stood.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StationPose {
    /// Machine frame from that of the station.
    pub machine_from_station: Isometry3<f64>,
    /// Covariance of the tracker's place, machine frame.
    pub covariance_mm2: Matrix3<f64>,
}

/// Finds poses of stations, reflectors, and the axis' six errors at every angle, from points.
///
/// Minimises `Σ |Q·(Rᵀ·(o + e + exp(ω)·Rot(b)·t − c) − p)|²`, whitened along the beam and
/// across it, over the stations' poses (c, R), reflectors t and errors `[e, ω]`. The machine frame
/// is the fit of the reflectors to their nominal places.
///
/// # Errors
///
/// See [`TrackerError`]: every variant means that there is no calibration to rely on.
pub fn calibrate_targets(
    survey: &TargetSurvey,
    options: &TargetOptions,
) -> Result<TargetCalibration, TrackerError> {
    Ok(fitted(survey, options, &[])?.0)
}

/// The calibration with columns of effects in the model, three rows per reading, and the point:
/// their amplitudes come last among its shared parameters.
pub(super) fn fitted(
    survey: &TargetSurvey,
    options: &TargetOptions,
    extras: &[Vec<f64>],
) -> Result<(TargetCalibration, BorderedPoint), TrackerError> {
    check(survey, options)?;
    check_count(survey, angles(&survey.steps).0.len())?;
    let with = |sigma_mm: f64| Bundle::new(survey, options, sigma_mm, extras.to_vec());
    let mut bundle = with(FIRST_GUESS_MM)?;
    let mut solution = settle(&bundle, bundle.start(), &[0])?;
    let mut point_mm = None;
    if options.noise == TargetNoise::Estimated {
        let factor = solution.variance_factor.unwrap_or(1.0);
        let sigma_mm = (FIRST_GUESS_MM * factor.sqrt()).max(LEAST_NOISE_MM);
        point_mm = Some(sigma_mm);
        bundle = with(sigma_mm)?;
        solution = settle(&bundle, solution.point, &[0])?;
    }
    let calibration = result(&bundle, &solution, options, point_mm)?;
    Ok((calibration, solution.point))
}

fn result(
    bundle: &Bundle<'_>,
    solution: &BorderedSolution,
    options: &TargetOptions,
    point_mm: Option<f64>,
) -> Result<TargetCalibration, TrackerError> {
    let (survey, point) = (bundle.survey, &solution.point);
    let covariance = covariance(bundle, point, &[0])?;
    let spread = Spread::new(bundle, point, covariance.shared(), &[0]);
    let n = survey.targets.len();
    let (mut residuals_mm, mut redundancy) = (vec![Vector3::zeros(); n], vec![Vector3::zeros(); n]);
    for block in 0..bundle.block_count() {
        let rows = dense_block(bundle, point, block);
        let leverages = covariance.leverages(block);
        for (i, &target) in bundle.targets_of[block].iter().enumerate() {
            let sigma_mm = bundle.weights[target].sigma_mm;
            let whitened = rows.residual.fixed_rows::<3>(3 * i);
            residuals_mm[target] = whitened.component_mul(&sigma_mm);
            redundancy[target] =
                Vector3::from_fn(|c, _| (1.0 - leverages[3 * i + c]).clamp(0.0, 1.0));
        }
    }
    let fixed: Vec<Vector6<f64>> =
        point.blocks.chunks_exact(6).map(Vector6::from_column_slice).collect();
    let error = |k: usize| AxisError {
        angle_rad: bundle.angles[k].angle_rad,
        error: fixed[k],
        covariance: square(&spread.of(&[(k, DMatrix::identity(6, 6))], None)),
    };
    let axis = &survey.axis;
    let mut points: Vec<_> = survey.targets.iter().map(|t| (t.step, t.mount)).collect();
    points.sort_unstable();
    points.dedup();
    Ok(TargetCalibration {
        stations: stations(bundle, &point.shared, &spread),
        mounts: mounts(bundle, &point.shared, &spread),
        axis_errors: (0..fixed.len()).map(|k| in_order(axis, options.order, error(k))).collect(),
        location: location(axis, &bundle.angles_rad(), &fixed, &spread, |k, a| vec![(k, a)]),
        residuals_mm,
        sigmas_mm: bundle.weights.iter().map(|w| w.sigma_mm).collect(),
        redundancy,
        n_points: points.len(),
        degrees_of_freedom: solution.degrees_of_freedom,
        variance_factor: solution.variance_factor.unwrap_or(1.0),
        point_mm,
        report: solution.report.clone(),
    })
}

fn stations(bundle: &Bundle<'_>, shared: &[f64], spread: &Spread) -> Vec<StationPose> {
    (0..bundle.survey.stations.len())
        .map(|i| StationPose {
            machine_from_station: bundle.station(i, shared),
            covariance_mm2: spread.shared.fixed_view::<3, 3>(6 * i, 6 * i).into_owned(),
        })
        .collect()
}

fn mounts(bundle: &Bundle<'_>, shared: &[f64], spread: &Spread) -> Vec<MountEstimate> {
    let (first, n) = (bundle.mount_start(), bundle.chart.dim());
    let basis = bundle.chart.basis();
    let all = basis * spread.shared.view((first, first), (n, n)) * basis.transpose();
    (0..bundle.survey.mounts.len())
        .map(|j| MountEstimate {
            position_mm: Point3::from(bundle.body_mm(j, shared)),
            covariance_mm2: all.fixed_view::<3, 3>(3 * j, 3 * j).into_owned(),
        })
        .collect()
}

impl TargetCalibration {
    /// Root-mean-square distance between predicted and measured points.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = self.residuals_mm.len() as f64;
        (self.residuals_mm.iter().map(Vector3::norm_squared).sum::<f64>() / n).sqrt()
    }
}
