//! Results of the joint bundle.

use least_squares::{BorderedPoint, BorderedProblem, BorderedSolution};
use nalgebra::{DMatrix, Matrix4, Matrix6, Point3, Vector3, Vector4, Vector6};

use crate::error_order::in_order;
use crate::joint::Joint;
use crate::location::{fit_matrices, located};
use crate::network::Network;
use crate::perfect::{PerfectAxis, selected};
use crate::search::covariance;
use crate::spread::{Spread, dense_block};
use crate::weights::Weights;
use crate::{
    AxisError, AxisLocation, AxisModel, Calibration, DeadPathEstimate, MountEstimate, Options,
    RotaryAxis, StationEstimate, TrackerError,
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
    let spread = Spread::new(joint, point, covariance.shared(), &held);
    let mut residuals_mm = vec![0.0; network.survey.ranges.len()];
    let mut redundancy = vec![0.0; residuals_mm.len()];
    for block in 0..joint.block_count() {
        let rows = dense_block(joint, point, block);
        let leverages = covariance.leverages(block);
        for (row, &range) in joint.ranges_of[block].iter().enumerate() {
            residuals_mm[range] = weights.displacement_mm * rows.residual[row];
            redundancy[range] = (1.0 - leverages[row]).clamp(0.0, 1.0);
        }
    }
    let (stations, dead_paths) = stations(network, joint.chart, &point.shared, &spread);
    let of_axis = match network.axis_model {
        AxisModel::Free => free_axis(joint, point, &spread, options),
        AxisModel::Fixed | AxisModel::Located => perfect_axis(joint, point, &spread, options),
    };
    let OfAxis { mounts, axis_errors, location, motion } = of_axis;
    Ok(Calibration {
        stations,
        dead_paths,
        mounts,
        axis_errors,
        location,
        motion,
        residuals_mm,
        redundancy,
        n_points: network.points().len(),
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

fn free_axis(
    joint: &Joint<'_>,
    point: &BorderedPoint,
    spread: &Spread,
    options: &Options,
) -> OfAxis {
    let network = joint.network;
    let fixed: Vec<Vector6<f64>> =
        point.blocks.chunks_exact(6).map(Vector6::from_column_slice).collect();
    let identity = DMatrix::identity(6, 6);
    let axis_errors = (0..fixed.len())
        .map(|k| AxisError {
            angle_rad: network.angles[k].angle_rad,
            error: fixed[k],
            covariance: square(&spread.of(&[(k, identity.clone())], None)),
        })
        .map(|error| in_order(&network.survey.axis, options.order, error))
        .collect();
    let linear = |k: usize, a: DMatrix<f64>| vec![(k, a)];
    OfAxis {
        mounts: mounts(joint, &point.shared, spread),
        axis_errors,
        location: location(&network.survey.axis, &network.angles_rad(), &fixed, spread, linear),
        motion: None,
    }
}

fn perfect_axis(
    joint: &Joint<'_>,
    point: &BorderedPoint,
    spread: &Spread,
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
        covariance: selected(&spread.shared, &own),
    };
    let mount = |mount: usize| {
        let at = joint.mount_start() + 3 * mount;
        let with: Vec<usize> = (at..at + 3).chain(own.iter().copied()).collect();
        let place = Vector3::from_column_slice(&point.shared[at..at + 3]);
        perfect.mount(&place, &selected(&spread.shared, &with))
    };
    OfAxis {
        mounts: (0..network.survey.mounts.len()).map(mount).collect(),
        axis_errors: perfect.errors(options.order),
        location: perfect.location(),
        motion: Some(perfect.motion(options.order)),
    }
}

fn mounts(joint: &Joint<'_>, shared: &[f64], spread: &Spread) -> Vec<MountEstimate> {
    (0..joint.network.survey.mounts.len())
        .map(|mount| {
            let at = joint.mount_start() + 3 * mount;
            MountEstimate {
                position_mm: Point3::new(shared[at], shared[at + 1], shared[at + 2]),
                covariance_mm2: spread.shared.fixed_view::<3, 3>(at, at).into_owned(),
            }
        })
        .collect()
}

/// Stations and dead paths, which are the first of the shared parameters in both formulations.
pub(crate) fn stations(
    network: &Network<'_>,
    chart: &crate::gauge::StationChart,
    shared: &[f64],
    spread: &Spread,
) -> (Vec<StationEstimate>, Vec<DeadPathEstimate>) {
    let n = chart.dim();
    let of_stations =
        chart.basis() * spread.shared.view((0, 0), (n, n)) * chart.basis().transpose();
    let station = |i: usize| StationEstimate {
        position_mm: Point3::from(chart.position_mm(i, shared)),
        covariance_mm2: of_stations.fixed_view::<3, 3>(3 * i, 3 * i).into_owned(),
    };
    let dead_path = |(p, &(station, mount)): (usize, &(usize, Option<usize>))| DeadPathEstimate {
        station,
        mount,
        length_mm: shared[n + p],
        sigma_mm: spread.shared[(n + p, n + p)].max(0.0).sqrt(),
    };
    (
        (0..network.survey.stations.len()).map(station).collect(),
        network.dead_paths.iter().enumerate().map(dead_path).collect(),
    )
}

/// Location of the axis from errors in the fixed frame; `linear` turns `A·error` of an angle into
/// the blocks it is made of.
pub(crate) fn location(
    axis: &RotaryAxis,
    angles_rad: &[f64],
    errors: &[Vector6<f64>],
    spread: &Spread,
    linear: impl Fn(usize, DMatrix<f64>) -> Vec<(usize, DMatrix<f64>)>,
) -> Option<AxisLocation> {
    let matrices = fit_matrices(axis, angles_rad)?;
    let mut sum = Vector4::zeros();
    let mut terms: Vec<(usize, DMatrix<f64>)> = Vec::new();
    for (k, matrix) in matrices.into_iter().enumerate() {
        sum += Vector4::from_iterator((&matrix * errors[k]).iter().copied());
        for (block, a) in linear(k, matrix) {
            match terms.iter_mut().find(|(known, _)| *known == block) {
                Some((_, total)) => *total += a,
                None => terms.push((block, a)),
            }
        }
    }
    let covariance = Matrix4::from_iterator(spread.of(&terms, None).iter().copied());
    Some(located(*axis, angles_rad[0], sum, covariance))
}

/// A 6 × 6 matrix of dynamic size as one of fixed size.
pub(crate) fn square(matrix: &DMatrix<f64>) -> Matrix6<f64> {
    Matrix6::from_iterator(matrix.iter().copied())
}
