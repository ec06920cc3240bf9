//! Uncertainty of the six errors of every angle and of the location that they show, and what the
//! residuals of all rows say.

use std::ops::Range;

use least_squares::{BlockParts, BorderedCovariance};
use nalgebra::{DMatrix, Matrix4, Matrix6, SMatrix, Vector3, Vector4, Vector6};

use crate::location::AngleFit;
use crate::readings::Readings;
use crate::{AxisError, TrackerError};

const SIX: usize = 6;

/// How the six errors of an angle follow blocks, `error = Σ A·block`, in room that is used again.
#[derive(Debug)]
pub(crate) struct Terms {
    block_dim: usize,
    /// `A` of the angle's own blocks, by rows and in their order.
    pub(crate) own: Vec<f64>,
    /// `A` of the blocks of the reference, likewise.
    pub(crate) reference: Vec<f64>,
    /// For whoever works out the errors.
    pub(crate) room: Room,
}

/// Points of one angle.
#[derive(Debug, Default)]
pub(crate) struct Room {
    /// Which of the angle's blocks, and mount.
    pub(crate) seen: Vec<(usize, usize)>,
    pub(crate) arms: Vec<Vector3<f64>>,
    pub(crate) displacements: Vec<Vector3<f64>>,
    pub(crate) inverse: Vec<f64>,
}

impl Terms {
    /// The errors follow none of so many blocks.
    pub(crate) fn clear(&mut self, blocks: usize) {
        self.own.clear();
        self.own.resize(blocks * SIX * self.block_dim, 0.0);
        self.reference.fill(0.0);
    }

    /// The errors are the angle's only block.
    pub(crate) fn identity(&mut self) {
        self.clear(1);
        for i in 0..SIX {
            self.own[i * self.block_dim + i] = 1.0;
        }
    }
}

/// A solved problem, angle by angle.
pub(crate) struct Solved<'a, P, B, E> {
    pub(crate) problem: &'a P,
    pub(crate) covariance: &'a BorderedCovariance<'a, P>,
    pub(crate) angles_rad: &'a [f64],
    /// The blocks of an angle, counted; no block is of two.
    pub(crate) nth_block: B,
    /// Blocks that the errors of every angle may follow.
    pub(crate) references: &'a [usize],
    /// The six errors of an angle, and how they follow blocks.
    pub(crate) errors: E,
}

/// What is known of all angles.
pub(crate) struct AngleSpread {
    /// The six errors of every angle with their covariance, fixed frame.
    pub(crate) errors: Vec<AxisError>,
    /// The sums of the fit asked for, with their covariance.
    pub(crate) sums: Option<(Vector4<f64>, Matrix4<f64>)>,
}

/// What a range of angles gives.
struct Part {
    errors: Vec<AxisError>,
    /// Whitened residual and redundancy of every range.
    rows: Vec<[f64; 2]>,
    sums: Sums,
}

/// Location as a sum over angles.
#[derive(Clone)]
struct Sums {
    errors: Vector4<f64>,
    /// Covariance that comes from the angles' own blocks where the shared parameters are known.
    own: [f64; 16],
    /// How it follows the shared parameters, by rows.
    along: Vec<f64>,
    /// How it follows the blocks of the reference, block by block.
    by_reference: DMatrix<f64>,
}

impl Sums {
    fn add_all(&mut self, other: &Self) {
        self.errors += other.errors;
        self.own.iter_mut().zip(other.own).for_each(|(a, b)| *a += b);
        self.along.iter_mut().zip(&other.along).for_each(|(a, b)| *a += b);
        self.by_reference += &other.by_reference;
    }
}

/// What one angle is made of.
struct OfAngle {
    terms: Terms,
    covariance: [f64; SIX * SIX],
    along: Vec<f64>,
    /// `A` of the location.
    fitted: Vec<f64>,
}

impl<P, B, E> Solved<'_, P, B, E>
where
    P: Readings,
    B: Fn(usize, usize) -> Option<usize> + Sync + Send,
    E: Fn(usize, &mut Terms) -> Result<Vector6<f64>, TrackerError> + Sync + Send,
{
    /// Hands on whitened residual and redundancy of every range, block by block in the order of the
    /// angles.
    pub(crate) fn spread(
        &self,
        axis_fit: Option<&AngleFit>,
        mut take_row: impl FnMut([f64; 2]),
    ) -> Result<AngleSpread, TrackerError> {
        let reference = |&block: &usize| {
            let mut parts = self.covariance.parts();
            self.covariance.fill(&[block], &mut parts);
            parts
        };
        let references: Vec<BlockParts> = self.references.iter().map(reference).collect();
        let count = self.angles_rad.len();
        let mut errors = Vec::with_capacity(count);
        let mut sums: Option<Sums> = None;
        let mut failed = None;
        let work =
            |angles: Range<usize>, parts: &mut _| self.part(angles, parts, &references, axis_fit);
        self.covariance.in_chunks(count, work, |part| match part {
            Ok(part) => {
                errors.extend(part.errors);
                part.rows.into_iter().for_each(&mut take_row);
                match &mut sums {
                    Some(sums) => sums.add_all(&part.sums),
                    None => sums = Some(part.sums),
                }
            }
            Err(error) => failed = failed.take().or(Some(error)),
        });
        if let Some(error) = failed {
            return Err(error);
        }
        let sums = sums.filter(|_| axis_fit.is_some());
        Ok(AngleSpread { errors, sums: sums.map(|sums| self.located(sums, &references)) })
    }

    fn part(
        &self,
        angles: Range<usize>,
        parts: &mut BlockParts,
        references: &[BlockParts],
        fit: Option<&AngleFit>,
    ) -> Result<Part, TrackerError> {
        let block_dim = self.problem.block_dim();
        let n = parts.width();
        let length = SIX * block_dim;
        let mut room = OfAngle {
            terms: Terms {
                block_dim,
                own: Vec::new(),
                reference: vec![0.0; references.len() * length],
                room: Room::default(),
            },
            covariance: [0.0; SIX * SIX],
            along: vec![0.0; SIX * n],
            fitted: Vec::new(),
        };
        let sums = Sums {
            errors: Vector4::zeros(),
            own: [0.0; 16],
            along: vec![0.0; 4 * n],
            by_reference: DMatrix::zeros(references.len() * block_dim, 4),
        };
        let blocks: Vec<usize> = angles
            .clone()
            .flat_map(|k| (0..).map_while(move |nth| (self.nth_block)(k, nth)))
            .collect();
        let rows = blocks.iter().map(|&block| self.problem.range_count(block)).sum();
        let mut in_turn = self.covariance.in_turn(&blocks, parts);
        let mut part =
            Part { errors: Vec::with_capacity(angles.len()), rows: Vec::with_capacity(rows), sums };
        for k in angles {
            let error = (self.errors)(k, &mut room.terms)?;
            room.covariance.fill(0.0);
            room.along.fill(0.0);
            let mut nth = 0;
            while let Some(block) = (self.nth_block)(k, nth) {
                let Some(of_block) = in_turn.next() else { break };
                let a = &room.terms.own[nth * length..][..length];
                of_block.add_combined(a, &mut room.covariance, &mut room.along);
                let rows = of_block.residuals().iter().zip(of_block.leverages());
                let rows = rows.take(self.problem.range_count(block));
                part.rows.extend(rows.map(|(r, h)| [*r, (1.0 - h).clamp(0.0, 1.0)]));
                nth += 1;
            }
            if let Some(fit) = fit {
                part.sums.add(&fit[k], error, &mut room, block_dim);
            }
            for (a, reference) in room.terms.reference.chunks_exact(length).zip(references) {
                reference.nth(0).add_combined(a, &mut room.covariance, &mut room.along);
            }
            let mut covariance = Matrix6::from_row_slice(&room.covariance);
            for i in 0..SIX {
                for j in 0..=i {
                    let (a, b) = (&room.along[i * n..][..n], &room.along[j * n..][..n]);
                    covariance[(i, j)] += dot(a, b);
                    covariance[(j, i)] = covariance[(i, j)];
                }
            }
            part.errors.push(AxisError { angle_rad: self.angles_rad[k], error, covariance });
        }
        Ok(part)
    }

    fn located(&self, mut sums: Sums, references: &[BlockParts]) -> (Vector4<f64>, Matrix4<f64>) {
        let block_dim = self.problem.block_dim();
        for (r, reference) in references.iter().enumerate() {
            let a = sums.by_reference.rows(r * block_dim, block_dim).into_owned();
            reference.nth(0).add_combined(a.as_slice(), &mut sums.own, &mut sums.along);
        }
        let along = DMatrix::from_vec(sums.along.len() / 4, 4, sums.along);
        let shared = along.tr_mul(&along);
        (sums.errors, Matrix4::from_row_slice(&sums.own) + shared.fixed_view::<4, 4>(0, 0))
    }
}

impl Sums {
    /// Adds an angle of which the blocks of the reference are still to come.
    fn add(
        &mut self,
        fit: &SMatrix<f64, 4, 6>,
        error: Vector6<f64>,
        angle: &mut OfAngle,
        block_dim: usize,
    ) {
        let OfAngle { terms, covariance, along, fitted } = angle;
        self.errors += fit * error;
        let own = fit * Matrix6::from_row_slice(covariance) * fit.transpose();
        self.own.iter_mut().zip(own.as_slice()).for_each(|(sum, value)| *sum += value);
        add_fitted(fit, along, &mut self.along);
        for (r, a) in terms.reference.chunks_exact(SIX * block_dim).enumerate() {
            fitted.clear();
            fitted.resize(4 * block_dim, 0.0);
            add_fitted(fit, a, fitted);
            let rows = fitted.chunks_exact(block_dim);
            for (row, mut sum) in rows.zip(self.by_reference.column_iter_mut()) {
                let sum = &mut sum.as_mut_slice()[r * block_dim..][..block_dim];
                sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
            }
        }
    }
}

/// Product of two rows, in sums side by side that do not wait for each other.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, mut last) = ([0.0; 8], 0.0);
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        last += a * b;
    }
    sums.iter().sum::<f64>() + last
}

/// Adds `fit · a`, all by rows.
fn add_fitted(fit: &SMatrix<f64, 4, 6>, a: &[f64], sums: &mut [f64]) {
    let width = a.len() / SIX;
    for (sums, fit) in sums.chunks_exact_mut(width.max(1)).zip(fit.row_iter()) {
        for (row, factor) in a.chunks_exact(width.max(1)).zip(fit.iter()) {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += factor * value);
        }
    }
}
