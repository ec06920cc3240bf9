//! From points to the six errors.

use least_squares::{BorderedPoint, BorderedSolution, Report};
use nalgebra::{DMatrix, Isometry3, Matrix3, Point3, Vector3, Vector6};

use super::bundle::{Added, Bundle};
use super::check::{check, check_count};
use crate::angle_spread::{Solved, Terms};
use crate::angle_steps::angles;
use crate::frame::{Frame, Motion};
use crate::joint::held;
use crate::joint_result::{OfAxis, axis_errors};
use crate::location::{angle_fit, located};
use crate::perfect::{PerfectAxis, selected};
use crate::search::{MOST_STEPS, covariance, settle};
use crate::{
    AxisError, AxisLocation, AxisModel, ErrorOrder, MountEstimate, TargetNoise, TargetOptions,
    TargetSurvey, TrackerError,
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
    /// Location of the axis, where the angles show it; of a perfect axis, where it was fitted.
    pub location: Option<AxisLocation>,
    /// Errors of a perfect axis about where it was found, angle by angle, as far as effects were
    /// accepted; `None` of an axis with six errors at every angle.
    pub motion: Option<Vec<AxisError>>,
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
    let Placed { options, frame } = Placed::of(survey, options)?;
    Ok(fitted(survey, &options, &Added { frame, ..Added::default() })?.0)
}

/// How a perfect axis is held against its declared place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Options to calibrate with.
    pub(super) options: TargetOptions,
    /// The frame that the axis is in, where that is not exact.
    pub(super) frame: Option<Frame>,
}

impl Placed {
    /// The nominal places of the reflectors say where the axis should be, as well as they agree with
    /// those found. Where the axis is not off by more than that, its location is fitted.
    pub(super) fn of(survey: &TargetSurvey, options: &TargetOptions) -> Result<Self, TrackerError> {
        if options.axis == AxisModel::Free {
            return Ok(Self { options: *options, frame: None });
        }
        let located = TargetOptions { axis: AxisModel::Located, ..*options };
        let (found, point) = fitted(survey, &located, &Added::default())?;
        let bundle = Bundle::new(survey, &located, 1.0, Added::default())?;
        let off = |(j, mount): (usize, &crate::Mount)| {
            (bundle.body_mm(j, &point.shared) - mount.nominal_mm.coords).norm_squared()
        };
        let squares: f64 = survey.mounts.iter().enumerate().map(off).sum();
        let dof = 3 * survey.mounts.len() - 6;
        #[expect(clippy::cast_precision_loss, reason = "a handful of reflectors")]
        let sigma_mm = (squares / dof as f64).sqrt();
        let places: Vec<Vector3<f64>> = survey.mounts.iter().map(|m| m.nominal_mm.coords).collect();
        let frame = Frame::of_places(&survey.axis, &places, sigma_mm, Some(dof));
        let free = TargetOptions { axis: AxisModel::Free, order: ErrorOrder::Fixed, ..*options };
        let free = fitted(survey, &free, &Added::default()).ok().map(|(free, _)| free);
        let motion = free.as_ref().and_then(|f| Motion::of(&f.axis_errors, f.location.as_ref()?));
        // Free errors leave a motion no way to look like a place.
        let location = free.and_then(|free| free.location).or(found.location);
        let is_off = match (&frame, &location) {
            (Some(frame), Some(location)) => frame.is_exceeded(location, motion),
            _ => true,
        };
        let axis = if is_off { options.axis } else { AxisModel::Located };
        Ok(Self { options: TargetOptions { axis, ..*options }, frame })
    }
}

/// The calibration with effects in the model, and the point: their amplitudes come last among its
/// shared parameters.
pub(super) fn fitted(
    survey: &TargetSurvey,
    options: &TargetOptions,
    added: &Added,
) -> Result<(TargetCalibration, BorderedPoint), TrackerError> {
    check(survey, options)?;
    let n_angles = angles(&survey.steps).0.len();
    check_count(survey, n_angles, options.axis)?;
    let held = held(options.axis, n_angles);
    let with = |sigma_mm: f64| Bundle::new(survey, options, sigma_mm, added.clone());
    let mut bundle = with(FIRST_GUESS_MM)?;
    let mut solution = settle(&bundle, bundle.start(), &held, MOST_STEPS)?;
    let mut point_mm = None;
    if options.noise == TargetNoise::Estimated {
        let factor = solution.variance_factor.unwrap_or(1.0);
        let sigma_mm = (FIRST_GUESS_MM * factor.sqrt()).max(LEAST_NOISE_MM);
        point_mm = Some(sigma_mm);
        bundle = with(sigma_mm)?;
        solution = settle(&bundle, solution.point, &held, MOST_STEPS)?;
    }
    let calibration = result(&bundle, &solution, options, (point_mm, added.frame.as_ref()))?;
    Ok((calibration, solution.point))
}

fn result(
    bundle: &Bundle<'_>,
    solution: &BorderedSolution,
    options: &TargetOptions,
    (point_mm, frame): (Option<f64>, Option<&Frame>),
) -> Result<TargetCalibration, TrackerError> {
    let (survey, point) = (bundle.survey, &solution.point);
    let held = held(options.axis, bundle.angles.len());
    let covariance = covariance(bundle, point, &held)?;
    let shared = covariance.shared();
    let angles_rad = bundle.angles_rad();
    let solved = Solved {
        problem: bundle,
        covariance: &covariance,
        angles_rad: &angles_rad,
        nth_block: |k: usize, nth: usize| (nth == 0).then_some(k),
        references: &[],
        errors: |k: usize, terms: &mut Terms| {
            terms.identity();
            Ok(Vector6::from_column_slice(&point.blocks[6 * k..6 * k + 6]))
        },
    };
    let fit = angle_fit(&survey.axis, angles_rad.iter().copied().enumerate(), angles_rad.len());
    let mut rows: Vec<[f64; 2]> = Vec::new();
    let spread = solved.spread(fit.as_ref(), |row| rows.push(row))?;
    let n = survey.targets.len();
    let (mut residuals_mm, mut redundancy) = (vec![Vector3::zeros(); n], vec![Vector3::zeros(); n]);
    let (rows, _) = rows.as_chunks::<3>();
    for (&target, rows) in bundle.targets_of.iter().flatten().zip(rows) {
        let whitened = Vector3::from(rows.map(|[residual, _]| residual));
        residuals_mm[target] = whitened.component_mul(&bundle.weights[target].sigma_mm);
        redundancy[target] = Vector3::from(rows.map(|[_, share]| share));
    }
    let of_axis = match options.axis {
        AxisModel::Free => OfAxis {
            mounts: mounts(bundle, &point.shared, &shared),
            axis_errors: axis_errors(&survey.axis, spread.errors.into_iter(), options.order),
            location: (spread.sums).map(|(errors, covariance)| {
                located(survey.axis, angles_rad[0], errors, covariance)
            }),
            motion: None,
        },
        AxisModel::Fixed | AxisModel::Located => {
            perfect_axis(bundle, point, &shared, (options.order, frame))
        }
    };
    let OfAxis { mounts, axis_errors, location, motion } = of_axis;
    let mut points: Vec<_> = survey.targets.iter().map(|t| (t.step, t.mount)).collect();
    points.sort_unstable();
    points.dedup();
    Ok(TargetCalibration {
        stations: stations(bundle, &point.shared, &shared, frame),
        mounts,
        axis_errors,
        location,
        motion,
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

fn perfect_axis(
    bundle: &Bundle<'_>,
    point: &BorderedPoint,
    covariance: &DMatrix<f64>,
    (order, frame): (ErrorOrder, Option<&Frame>),
) -> OfAxis {
    let angles_rad = bundle.angles_rad();
    let own: Vec<usize> = (bundle.curve_start()..bundle.extra_start()).collect();
    let perfect = PerfectAxis {
        axis: &bundle.survey.axis,
        angles_rad: &angles_rad,
        curves: &bundle.curves,
        amplitudes: &point.shared[bundle.curve_start()..bundle.extra_start()],
        covariance: selected(covariance, &own),
    };
    let perfect = match frame {
        Some(frame) => perfect.in_frame(frame),
        None => perfect,
    };
    // The places of the reflectors and the amplitudes, in the parameters of the bundle.
    let (first, n) = (bundle.mount_start(), bundle.chart.dim());
    let of_places = bundle.chart.basis();
    let mount = |j: usize| {
        let mut follows = DMatrix::zeros(3 + own.len(), n + own.len());
        follows.view_mut((0, 0), (3, n)).copy_from(&of_places.rows(3 * j, 3));
        for i in 0..own.len() {
            follows[(3 + i, n + i)] = 1.0;
        }
        let all = covariance.view((first, first), (n + own.len(), n + own.len()));
        let of_mount = &follows * all * follows.transpose();
        let mut mount = perfect.mount(&bundle.body_mm(j, &point.shared), &of_mount);
        if let Some(frame) = frame {
            let (axis, place_mm) = (&bundle.survey.axis, &mount.position_mm.coords);
            mount.covariance_mm2 += frame.of_mount(axis, angles_rad[0], place_mm);
        }
        mount
    };
    OfAxis {
        mounts: (0..bundle.survey.mounts.len()).map(mount).collect(),
        axis_errors: perfect.errors(order),
        location: perfect.location(),
        motion: Some(perfect.motion(order)),
    }
}

fn stations(
    bundle: &Bundle<'_>,
    shared: &[f64],
    covariance: &DMatrix<f64>,
    frame: Option<&Frame>,
) -> Vec<StationPose> {
    let origin_mm = bundle.survey.axis.origin_mm.coords;
    let station = |i: usize| {
        let machine_from_station = bundle.station(i, shared);
        let from_origin_mm = machine_from_station.translation.vector - origin_mm;
        let own: Matrix3<f64> = covariance.fixed_view::<3, 3>(6 * i, 6 * i).into_owned();
        let of_frame = frame.map_or_else(Matrix3::zeros, |frame| frame.of_place(&from_origin_mm));
        StationPose { machine_from_station, covariance_mm2: own + of_frame }
    };
    (0..bundle.survey.stations.len()).map(station).collect()
}

fn mounts(bundle: &Bundle<'_>, shared: &[f64], covariance: &DMatrix<f64>) -> Vec<MountEstimate> {
    let (first, n) = (bundle.mount_start(), bundle.chart.dim());
    let basis = bundle.chart.basis();
    let all = basis * covariance.view((first, first), (n, n)) * basis.transpose();
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
