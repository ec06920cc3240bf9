//! Results of the free points: six errors from the points, angle by angle.

use least_squares::{BorderedCovariance, BorderedProblem, BorderedSolution};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3, Vector6};

use crate::angle_spread::{Room, Solved, Terms};
use crate::axes::{LocationSums, location};
use crate::count::count;
use crate::free_points::{FreePoints, point_of};
use crate::joint_result::{Rows, axis_errors, stations};
use crate::motion::error_by;
use crate::network::{MIN_MOUNTS, Network, check_collinear};
use crate::search::covariance;
use crate::weights::Weights;
use crate::{Calibration, MountEstimate, Options, TrackerError};

pub(crate) fn result(
    points: &FreePoints<'_>,
    solution: BorderedSolution,
    weights: Weights,
    options: &Options,
) -> Result<Calibration, TrackerError> {
    let network = points.network;
    let BorderedSolution { point, degrees_of_freedom, variance_factor, report } = solution;
    let covariance = covariance(points, &point, &[])?;
    let shared = covariance.shared();
    let blocks = Blocks { block_dim: points.block_dim(), numbers: &point.blocks };
    let reference = Reference::new(network, blocks)?;
    let angles_rad = network.angles_rad();
    let solved = Solved {
        problem: points,
        covariance: &covariance,
        angles_rad: &angles_rad,
        nth_block: |k: usize, nth: usize| network.angles[k].steps.get(nth).copied(),
        references: &network.angles[0].steps,
        errors: |k: usize, terms: &mut Terms| reference.error(network, blocks, k, terms),
    };
    let sums = LocationSums::new(network);
    let steps = network.angles.iter().flat_map(|angle| &angle.steps);
    let ranges = steps.flat_map(|&step| network.ranges_of_step.at(step));
    let mut rows = Rows::new(network, weights, ranges);
    let spread = solved.spread(sums.of_axis[0].as_ref(), |row| rows.take(row))?;
    let Rows { residuals_mm, redundancy, .. } = rows;
    let (stations, dead_paths) = stations(network, points.chart, &point.shared, &shared);
    Ok(Calibration {
        stations,
        dead_paths,
        mounts: reference.mounts(network, &covariance),
        location: spread.sums.map(|sums| location(network, 0, sums)),
        second: None,
        motion: None,
        axis_errors: axis_errors(&network.survey.axis, spread.errors.into_iter(), options.order),
        residuals_mm,
        redundancy,
        n_points: network.point_count(),
        degrees_of_freedom,
        variance_factor: variance_factor.unwrap_or(1.0),
        displacement_mm: weights.displacement_mm,
        report,
    })
}

/// Points of all steps.
#[derive(Clone, Copy)]
struct Blocks<'a> {
    block_dim: usize,
    numbers: &'a [f64],
}

impl Blocks<'_> {
    fn point(self, step: usize, mount: usize) -> Vector3<f64> {
        point_of(&self.numbers[step * self.block_dim..][..self.block_dim], mount)
    }
}

/// Reflectors as the points of the first angle show them.
struct Reference {
    rotation: Matrix3<f64>,
    /// Steps at the first angle that show each mount.
    steps: Vec<Vec<usize>>,
    /// `t`: place in the frame that turns with the axis; `None` where it was not seen.
    body_mm: Vec<Option<Vector3<f64>>>,
}

impl Reference {
    fn new(network: &Network<'_>, blocks: Blocks<'_>) -> Result<Self, TrackerError> {
        let axis = &network.survey.axis;
        let rotation = axis.rotation(network.angles[0].angle_rad).to_rotation_matrix().into_inner();
        let n_mounts = network.survey.mounts.len();
        let mut steps = vec![Vec::new(); n_mounts];
        for &step in &network.angles[0].steps {
            for &mount in network.mounts_at(step) {
                steps[mount].push(step);
            }
        }
        let body_mm: Vec<_> = (0..n_mounts)
            .map(|mount| {
                let seen = &steps[mount];
                let sum: Vector3<f64> = seen.iter().map(|&s| blocks.point(s, mount)).sum();
                let mean = sum / count(seen.len());
                (!seen.is_empty()).then(|| rotation.tr_mul(&(mean - axis.origin_mm.coords)))
            })
            .collect();
        let known: Vec<_> = body_mm.iter().flatten().copied().collect();
        if known.len() < MIN_MOUNTS {
            return Err(TrackerError::TooFewAtReference { needed: MIN_MOUNTS, got: known.len() });
        }
        check_collinear(&known)?;
        Ok(Self { rotation, steps, body_mm })
    }

    fn mounts<P: BorderedProblem>(
        &self,
        network: &Network<'_>,
        covariance: &BorderedCovariance<'_, P>,
    ) -> Vec<MountEstimate> {
        let block_len = 3 * self.body_mm.len();
        let mut parts = covariance.parts();
        let n = parts.width();
        let mut estimate = |mount: usize| {
            let nominal = network.survey.mounts[mount].nominal_mm;
            let Some(body) = self.body_mm[mount] else {
                // Not seen at the first angle: nothing refers to it.
                let covariance_mm2 = Matrix3::from_diagonal_element(f64::INFINITY);
                return MountEstimate { position_mm: nominal, covariance_mm2 };
            };
            let share = self.rotation.transpose() / count(self.steps[mount].len());
            let mut a = vec![0.0; 3 * block_len];
            put(&mut a, 3 * mount, &share);
            let (mut own, mut along) = ([0.0; 9], vec![0.0; 3 * n]);
            let mut in_turn = covariance.in_turn(&self.steps[mount], &mut parts);
            while let Some(part) = in_turn.next() {
                part.add_combined(&a, &mut own, &mut along);
            }
            let along = DMatrix::from_vec(n, 3, along);
            let shared = along.tr_mul(&along);
            let covariance_mm2 = Matrix3::from_row_slice(&own) + shared.fixed_view::<3, 3>(0, 0);
            MountEstimate { position_mm: Point3::from(body), covariance_mm2 }
        };
        (0..self.body_mm.len()).map(&mut estimate).collect()
    }

    /// Six errors at angle `k`, by least squares over its points, and how they follow these and those
    /// of the first angle: `error = inverse · (point − turned · point at the first angle)`.
    fn error(
        &self,
        network: &Network<'_>,
        blocks: Blocks<'_>,
        k: usize,
        terms: &mut Terms,
    ) -> Result<Vector6<f64>, TrackerError> {
        let axis = &network.survey.axis;
        let angle = &network.angles[k];
        terms.clear(angle.steps.len());
        if k == 0 {
            return Ok(Vector6::zeros());
        }
        let rotation = axis.rotation(angle.angle_rad).to_rotation_matrix().into_inner();
        let Room { seen, arms, displacements, inverse } = &mut terms.room;
        seen.clear();
        arms.clear();
        displacements.clear();
        for (nth, &step) in angle.steps.iter().enumerate() {
            for &mount in network.mounts_at(step) {
                let Some(body) = self.body_mm[mount] else { continue };
                let arm = rotation * body;
                seen.push((nth, mount));
                arms.push(arm);
                displacements.push(blocks.point(step, mount) - axis.origin_mm.coords - arm);
            }
        }
        inverse.resize(18 * seen.len(), 0.0);
        let error = error_by(arms, displacements, inverse).ok_or_else(|| {
            let free = axis.letter.error_names()[3..].to_vec();
            TrackerError::UndeterminedAngle { angle_deg: angle.angle_rad.to_degrees(), free }
        })?;
        let turned = rotation * self.rotation.transpose();
        let length = 6 * blocks.block_dim;
        for (i, &(nth, mount)) in seen.iter().enumerate() {
            let at = |part: usize| {
                let row = |r: usize, c: usize| inverse[(3 * part + r) * 3 * seen.len() + 3 * i + c];
                Matrix3::from_fn(row)
            };
            for (part, own) in [at(0), at(1)].iter().enumerate() {
                let first = -(own * turned) / count(self.steps[mount].len());
                let to = |a: usize| a * length + part * 3 * blocks.block_dim;
                let rows = 3 * blocks.block_dim;
                put(&mut terms.own[to(nth)..][..rows], 3 * mount, own);
                for (at, step) in network.angles[0].steps.iter().enumerate() {
                    if self.steps[mount].contains(step) {
                        put(&mut terms.reference[to(at)..][..rows], 3 * mount, &first);
                    }
                }
            }
        }
        Ok(error)
    }
}

/// Adds a square to three rows from a column on.
fn put(rows: &mut [f64], column: usize, square: &Matrix3<f64>) {
    let width = rows.len() / 3;
    for (r, row) in rows.chunks_exact_mut(width).enumerate() {
        for c in 0..3 {
            row[column + c] += square[(r, c)];
        }
    }
}
