//! Results of the joint bundle.

use least_squares::{BorderedPoint, BorderedProblem, BorderedSolution};
use nalgebra::{DMatrix, Point3, Vector3, Vector6};

use crate::angle_spread::{Solved, Terms};
use crate::axes::{LocationSums, location, relation};
use crate::error_order::in_order;
use crate::joint::Joint;
use crate::network::Network;
use crate::perfect::{PerfectAxis, selected};
use crate::search::covariance;
use crate::weights::Weights;
use crate::{
    AxisError, AxisLocation, AxisModel, Calibration, DeadPathEstimate, ErrorOrder, MountEstimate,
    Options, RotaryAxis, SecondCalibration, StationEstimate, TrackerError,
};

pub(crate) fn result(
    joint: &Joint<'_>,
    solution: &BorderedSolution,
    weights: Weights,
    options: &Options,
) -> Result<Calibration, TrackerError> {
    let network = joint.network;
    let point = &solution.point;
    let held = joint.held();
    let covariance = covariance(joint, point, &held)?;
    let shared = covariance.shared();
    let fixed = |k: usize| Vector6::from_column_slice(&point.blocks[6 * k..6 * k + 6]);
    let angles_rad = network.angles_rad();
    let solved = Solved {
        problem: joint,
        covariance: &covariance,
        angles_rad: &angles_rad,
        nth_block: |k: usize, nth: usize| (nth == 0).then_some(k),
        references: &[],
        errors: |k: usize, terms: &mut Terms| {
            terms.identity();
            Ok(fixed(k))
        },
    };
    let sums = LocationSums::new(network);
    let mut rows = Rows::new(network, weights, joint.ranges_of.iter().flatten());
    let spread = solved.spread(sums.of_axis[0].as_ref(), |row| rows.take(row))?;
    let Rows { residuals_mm, redundancy, .. } = rows;
    let (stations, dead_paths) = stations(network, joint.chart, &point.shared, &shared);
    let second = match network.axis_count() {
        1 => None,
        _ => Some(SecondCalibration {
            axis_errors: errors_of(network, 1, &spread.errors, options.order),
            location: (solved.spread(sums.of_axis[1].as_ref(), |_| ())?.sums)
                .map(|sums| location(network, 1, sums)),
            relation: (solved.spread(sums.relation.as_ref(), |_| ())?.sums)
                .and_then(|sums| relation(network, sums)),
        }),
    };
    let of_axis = match network.axis_model {
        AxisModel::Free => OfAxis {
            mounts: mounts(joint, &point.shared, &shared),
            axis_errors: match network.axis_count() {
                1 => axis_errors(network.axis(0), spread.errors.into_iter(), options.order),
                _ => errors_of(network, 0, &spread.errors, options.order),
            },
            location: spread.sums.map(|sums| location(network, 0, sums)),
            motion: None,
        },
        AxisModel::Fixed | AxisModel::Located => perfect_axis(joint, point, &shared, options),
    };
    let OfAxis { mounts, axis_errors, location, motion } = of_axis;
    Ok(Calibration {
        stations,
        dead_paths,
        mounts,
        axis_errors,
        location,
        motion,
        second,
        residuals_mm,
        redundancy,
        n_points: network.point_count(),
        degrees_of_freedom: solution.degrees_of_freedom,
        variance_factor: solution.variance_factor.unwrap_or(1.0),
        displacement_mm: weights.displacement_mm,
        report: solution.report.clone(),
    })
}

/// What a calibration says of the axis and of what is on it.
pub(crate) struct OfAxis {
    pub(crate) mounts: Vec<MountEstimate>,
    pub(crate) axis_errors: Vec<AxisError>,
    pub(crate) location: Option<AxisLocation>,
    pub(crate) motion: Option<Vec<AxisError>>,
}

/// Residual and redundancy of every range, as they are handed on.
pub(crate) struct Rows<I> {
    pub(crate) residuals_mm: Vec<f64>,
    pub(crate) redundancy: Vec<f64>,
    displacement_mm: f64,
    ranges: I,
}

impl<'a, I: Iterator<Item = &'a u32>> Rows<I> {
    /// `ranges` are in the order of the rows.
    pub(crate) fn new(network: &Network<'_>, weights: Weights, ranges: I) -> Self {
        let zeros = || vec![0.0; network.survey.ranges.len()];
        let displacement_mm = weights.displacement_mm;
        Self { residuals_mm: zeros(), redundancy: zeros(), displacement_mm, ranges }
    }

    pub(crate) fn take(&mut self, [residual, share]: [f64; 2]) {
        let range = *self.ranges.next().expect("every row is of a range") as usize;
        self.residuals_mm[range] = self.displacement_mm * residual;
        self.redundancy[range] = share;
    }
}

/// Errors of one axis among those of all angles, fixed frame, as those asked for.
fn errors_of(
    network: &Network<'_>,
    axis: usize,
    all: &[AxisError],
    order: ErrorOrder,
) -> Vec<AxisError> {
    let of = |(k, angle_rad): (usize, f64)| AxisError { angle_rad, ..all[k].clone() };
    axis_errors(network.axis(axis), network.angles_of(axis).map(of), order)
}

/// Errors in the fixed frame as those asked for.
pub(crate) fn axis_errors(
    axis: &RotaryAxis,
    errors: impl Iterator<Item = AxisError>,
    order: ErrorOrder,
) -> Vec<AxisError> {
    errors.map(|error| in_order(axis, order, error)).collect()
}

fn perfect_axis(
    joint: &Joint<'_>,
    point: &BorderedPoint,
    covariance: &DMatrix<f64>,
    options: &Options,
) -> OfAxis {
    let network = joint.network;
    let angles_rad = network.angles_rad();
    let own: Vec<usize> = (joint.curve_start()..joint.shared_dim()).collect();
    let perfect = PerfectAxis {
        axis: &network.survey.axis,
        angles_rad: &angles_rad,
        curves: &joint.curves,
        amplitudes: &point.shared[joint.curve_start()..],
        covariance: selected(covariance, &own),
    };
    let mount = |mount: usize| {
        let at = joint.mount_start() + 3 * mount;
        let with: Vec<usize> = (at..at + 3).chain(own.iter().copied()).collect();
        let place = Vector3::from_column_slice(&point.shared[at..at + 3]);
        perfect.mount(&place, &selected(covariance, &with))
    };
    OfAxis {
        mounts: (0..network.survey.mounts.len()).map(mount).collect(),
        axis_errors: perfect.errors(options.order),
        location: perfect.location(),
        motion: Some(perfect.motion(options.order)),
    }
}

fn mounts(joint: &Joint<'_>, shared: &[f64], covariance: &DMatrix<f64>) -> Vec<MountEstimate> {
    (0..joint.network.survey.mounts.len())
        .map(|mount| {
            let at = joint.mount_start() + 3 * mount;
            MountEstimate {
                position_mm: Point3::new(shared[at], shared[at + 1], shared[at + 2]),
                covariance_mm2: covariance.fixed_view::<3, 3>(at, at).into_owned(),
            }
        })
        .collect()
}

/// Stations and dead paths, which are the first of the shared parameters in both formulations.
pub(crate) fn stations(
    network: &Network<'_>,
    chart: &crate::gauge::StationChart,
    shared: &[f64],
    covariance: &DMatrix<f64>,
) -> (Vec<StationEstimate>, Vec<DeadPathEstimate>) {
    let n = chart.dim();
    let of_stations = chart.basis() * covariance.view((0, 0), (n, n)) * chart.basis().transpose();
    let station = |i: usize| StationEstimate {
        position_mm: Point3::from(chart.position_mm(i, shared)),
        covariance_mm2: of_stations.fixed_view::<3, 3>(3 * i, 3 * i).into_owned(),
    };
    let dead_path = |(p, &(station, mount)): (usize, &(usize, Option<usize>))| DeadPathEstimate {
        station,
        mount,
        length_mm: shared[n + p],
        sigma_mm: covariance[(n + p, n + p)].max(0.0).sqrt(),
    };
    (
        (0..network.survey.stations.len()).map(station).collect(),
        network.dead_paths.iter().enumerate().map(dead_path).collect(),
    )
}
