//! Results of the free points: six errors from the points, angle by angle.

use least_squares::{BorderedProblem, BorderedSolution};
use nalgebra::{DMatrix, Matrix3, MatrixXx3, Point3, Vector3, Vector6};

use crate::count::count;
use crate::error_order::in_order;
use crate::free_points::{FreePoints, point_of};
use crate::joint_result::{location, square, stations};
use crate::motion::error_at_angle;
use crate::network::{MIN_MOUNTS, Network, check_collinear};
use crate::search::covariance;
use crate::spread::{Spread, dense_block};
use crate::weights::Weights;
use crate::{AxisError, Calibration, MountEstimate, Options, TrackerError};

pub(crate) fn result(
    points: &FreePoints<'_>,
    solution: BorderedSolution,
    weights: Weights,
    options: &Options,
) -> Result<Calibration, TrackerError> {
    let network = points.network;
    let BorderedSolution { point, degrees_of_freedom, variance_factor, report } = solution;
    let covariance = covariance(points, &point, &[])?;
    let spread = Spread::new(points, &point, covariance.shared(), &[]);
    let blocks: Vec<&[f64]> = point.blocks.chunks_exact(points.block_dim()).collect();
    let reference = Reference::new(network, &blocks)?;
    let motions = (0..network.angles.len())
        .map(|k| reference.motion(network, &blocks, k))
        .collect::<Result<Vec<_>, _>>()?;
    let axis_errors = motions
        .iter()
        .enumerate()
        .map(|(k, motion)| AxisError {
            angle_rad: network.angles[k].angle_rad,
            error: motion.error,
            covariance: square(&spread.of(&motion.terms, None)),
        })
        .map(|error| in_order(&network.survey.axis, options.order, error))
        .collect();
    let fixed: Vec<_> = motions.iter().map(|m| m.error).collect();
    let linear = |k: usize, a: DMatrix<f64>| {
        motions[k].terms.iter().map(|(block, own)| (*block, &a * own)).collect()
    };
    let mut residuals_mm = vec![0.0; network.survey.ranges.len()];
    let mut redundancy = vec![0.0; residuals_mm.len()];
    for step in 0..blocks.len() {
        let rows = dense_block(points, &point, step);
        let leverages = covariance.leverages(step);
        for (row, &range) in network.ranges_of_step[step].iter().enumerate() {
            residuals_mm[range] = weights.displacement_mm * rows.residual[row];
            redundancy[range] = (1.0 - leverages[row]).clamp(0.0, 1.0);
        }
    }
    let (stations, dead_paths) = stations(network, points.chart, &point.shared, &spread);
    Ok(Calibration {
        stations,
        dead_paths,
        mounts: reference.mounts(network, &spread),
        location: location(&network.survey.axis, &network.angles_rad(), &fixed, &spread, linear),
        motion: None,
        axis_errors,
        residuals_mm,
        redundancy,
        n_points: network.points().len(),
        degrees_of_freedom,
        variance_factor: variance_factor.unwrap_or(1.0),
        displacement_mm: weights.displacement_mm,
        report,
    })
}

/// Reflectors as the points of the first angle show them.
struct Reference {
    rotation: Matrix3<f64>,
    /// Steps at the first angle that show each mount.
    steps: Vec<Vec<usize>>,
    /// `t`: place in the frame that turns with the axis; `None` where it was not seen.
    body_mm: Vec<Option<Vector3<f64>>>,
}

/// Six errors at an angle, and what they are made of.
struct Motion {
    error: Vector6<f64>,
    /// `error = Σ A·block` for small changes.
    terms: Vec<(usize, DMatrix<f64>)>,
}

impl Reference {
    fn new(network: &Network<'_>, blocks: &[&[f64]]) -> Result<Self, TrackerError> {
        let axis = &network.survey.axis;
        let rotation = axis.rotation(network.angles[0].angle_rad).to_rotation_matrix().into_inner();
        let n_mounts = network.survey.mounts.len();
        let mut steps = vec![Vec::new(); n_mounts];
        for &step in &network.angles[0].steps {
            for mount in network.mounts_at(step) {
                steps[mount].push(step);
            }
        }
        let body_mm: Vec<_> = (0..n_mounts)
            .map(|mount| {
                let seen = &steps[mount];
                let sum: Vector3<f64> = seen.iter().map(|&s| point_of(blocks[s], mount)).sum();
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

    fn mounts(&self, network: &Network<'_>, spread: &Spread) -> Vec<MountEstimate> {
        let block_len = 3 * self.body_mm.len();
        let estimate = |mount: usize| {
            let nominal = network.survey.mounts[mount].nominal_mm;
            let Some(body) = self.body_mm[mount] else {
                // Not seen at the first angle: nothing refers to it.
                let covariance_mm2 = Matrix3::from_diagonal_element(f64::INFINITY);
                return MountEstimate { position_mm: nominal, covariance_mm2 };
            };
            let share = self.rotation.transpose() / count(self.steps[mount].len());
            let terms: Vec<_> = (self.steps[mount].iter())
                .map(|&step| (step, at_mount(block_len, mount, &share)))
                .collect();
            let covariance = spread.of(&terms, None);
            let covariance_mm2 = Matrix3::from_iterator(covariance.iter().copied());
            MountEstimate { position_mm: Point3::from(body), covariance_mm2 }
        };
        (0..self.body_mm.len()).map(estimate).collect()
    }

    /// Six errors at angle `k`, by least squares over its points.
    fn motion(
        &self,
        network: &Network<'_>,
        blocks: &[&[f64]],
        k: usize,
    ) -> Result<Motion, TrackerError> {
        let axis = &network.survey.axis;
        let angle = &network.angles[k];
        let rotation = axis.rotation(angle.angle_rad).to_rotation_matrix().into_inner();
        if k == 0 {
            return Ok(Motion {
                error: Vector6::zeros(),
                terms: vec![(0, DMatrix::zeros(6, 3 * self.body_mm.len()))],
            });
        }
        let mut seen = Vec::new();
        let (mut arms, mut displacements) = (Vec::new(), Vec::new());
        for &step in &angle.steps {
            for mount in network.mounts_at(step) {
                let Some(body) = self.body_mm[mount] else { continue };
                let arm = rotation * body;
                seen.push((step, mount));
                arms.push(arm);
                displacements.push(point_of(blocks[step], mount) - axis.origin_mm.coords - arm);
            }
        }
        let (error, inverse) = error_at_angle(&arms, &displacements).ok_or_else(|| {
            let free = axis.letter.error_names()[3..].to_vec();
            TrackerError::UndeterminedAngle { angle_deg: angle.angle_rad.to_degrees(), free }
        })?;
        Ok(Motion {
            error,
            terms: self.terms(&seen, &inverse, &(rotation * self.rotation.transpose())),
        })
    }

    /// `error = inverse · (point − turned · point at the first angle)`, block by block.
    fn terms(
        &self,
        seen: &[(usize, usize)],
        inverse: &DMatrix<f64>,
        turned: &Matrix3<f64>,
    ) -> Vec<(usize, DMatrix<f64>)> {
        let block_len = 3 * self.body_mm.len();
        let mut terms: Vec<(usize, DMatrix<f64>)> = Vec::new();
        let mut add = |step: usize, mount: usize, share: &MatrixXx3<f64>| {
            let at = terms.iter().position(|(known, _)| *known == step).unwrap_or_else(|| {
                terms.push((step, DMatrix::zeros(6, block_len)));
                terms.len() - 1
            });
            let mut view = terms[at].1.columns_mut(3 * mount, 3);
            view += share;
        };
        for (i, &(step, mount)) in seen.iter().enumerate() {
            let own = inverse.fixed_columns::<3>(3 * i).into_owned();
            let first = -(&own * turned) / count(self.steps[mount].len());
            add(step, mount, &own);
            for &step in &self.steps[mount] {
                add(step, mount, &first);
            }
        }
        terms
    }
}

/// A matrix on the coordinates of one mount as one on its whole block.
fn at_mount(block_len: usize, mount: usize, share: &Matrix3<f64>) -> DMatrix<f64> {
    let mut wide = DMatrix::zeros(3, block_len);
    wide.fixed_view_mut::<3, 3>(0, 3 * mount).copy_from(share);
    wide
}
