//! Closed-form estimates: exact for isotropic uncertainties, the start for all others.
//!
//! Rigid and similarity: Kabsch (1976) with the sign rule and the scale of Umeyama (1991),
//! eqs. 40-43.

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::decompose::{determinant, singular};
use crate::{FrameMap, Handedness, PointPair, Transform};

/// Estimate with each point weighted by the mean variance of its coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosedForm<const D: usize> {
    pub(crate) map: FrameMap<D>,
    /// What the fit loses by turning about the least known axis, over what matching points
    /// would lose: 1 for matching points, 0 or NaN where two rotations fit equally well.
    pub(crate) relative_gap: f64,
}

/// Points about their weighted centroids.
struct Centred<const D: usize> {
    target_mean: SVector<f64, D>,
    source_mean: SVector<f64, D>,
    /// Square roots of the weights, their squares adding up to 1.
    root_weights: Vec<f64>,
}

impl<const D: usize> Centred<D> {
    fn new(pairs: &[PointPair<D>]) -> Self {
        let weights: Vec<f64> = pairs.iter().map(|p| p.uncertainty.mean_weight_per_mm2()).collect();
        let total: f64 = weights.iter().sum();
        let mut target_mean = SVector::zeros();
        let mut source_mean = SVector::zeros();
        for (pair, weight) in pairs.iter().zip(&weights) {
            target_mean += pair.target_mm.coords * (weight / total);
            source_mean += pair.source_mm.coords * (weight / total);
        }
        let root_weights = weights.iter().map(|w| (w / total).sqrt()).collect();
        Self { target_mean, source_mean, root_weights }
    }

    fn map(&self, linear: SMatrix<f64, D, D>) -> FrameMap<D> {
        FrameMap { linear, translation_mm: self.target_mean - linear * self.source_mean }
    }
}

pub(crate) fn estimate<const D: usize>(
    pairs: &[PointPair<D>],
    transform: Transform,
    handedness: Handedness,
) -> ClosedForm<D> {
    let certain = |map| ClosedForm { map, relative_gap: 1.0 };
    match transform {
        Transform::None => certain(FrameMap::identity()),
        Transform::Translation => certain(Centred::new(pairs).map(SMatrix::identity())),
        Transform::Rigid | Transform::Similarity => procrustes(pairs, transform, handedness),
        Transform::Affine => certain(affine(pairs)),
    }
}

/// Second moments of the centred points, weights included, in units of their overall size.
struct Moments<const D: usize> {
    cross: SMatrix<f64, D, D>,
    target: SMatrix<f64, D, D>,
    source: SMatrix<f64, D, D>,
    /// Root-mean-square distances from the centroids.
    target_size_mm: f64,
    source_size_mm: f64,
}

impl<const D: usize> Moments<D> {
    fn of(pairs: &[PointPair<D>], centred: &Centred<D>) -> Self {
        let mut cross = SMatrix::zeros();
        let (mut target_moment, mut source_moment) = (SMatrix::zeros(), SMatrix::zeros());
        for (pair, root_weight) in pairs.iter().zip(&centred.root_weights) {
            let target = (pair.target_mm.coords - centred.target_mean) * *root_weight;
            let source = (pair.source_mm.coords - centred.source_mean) * *root_weight;
            cross += target * source.transpose();
            target_moment += target * target.transpose();
            source_moment += source * source.transpose();
        }
        // Nothing to turn where the points coincide under their weights; the iteration names
        // the free direction.
        let size = |moment: &SMatrix<f64, D, D>| {
            let trace: f64 = (0..D).map(|k| moment[(k, k)]).sum();
            if trace > 0.0 { trace.sqrt() } else { 1.0 }
        };
        let (target_size_mm, source_size_mm) = (size(&target_moment), size(&source_moment));
        Self {
            cross: cross / (target_size_mm * source_size_mm),
            target: target_moment / target_size_mm.powi(2),
            source: source_moment / source_size_mm.powi(2),
            target_size_mm,
            source_size_mm,
        }
    }

    /// What turning about the longest axis (planar: about the centroid) costs when the points
    /// match: the two smallest moments.
    fn matching_gap(&self) -> f64 {
        let (target, source) = (singular(&self.target).values, singular(&self.source).values);
        (D - 2..D).map(|k| (target[k] * source[k]).sqrt()).sum()
    }
}

fn procrustes<const D: usize>(
    pairs: &[PointPair<D>],
    transform: Transform,
    handedness: Handedness,
) -> ClosedForm<D> {
    let centred = Centred::new(pairs);
    let moments = Moments::of(pairs, &centred);
    let svd = singular(&moments.cross);
    // The smallest singular value takes the sign that the handedness asks for.
    let wanted = if handedness == Handedness::Improper { -1.0 } else { 1.0 };
    let sign = (determinant(&svd.u) * determinant(&svd.v) * wanted).signum();
    let mut signed = svd.values;
    signed[D - 1] *= sign;
    let mut turned = svd.v;
    turned.column_mut(D - 1).scale_mut(sign);
    let rotation = svd.u * turned.transpose();

    let scale = match transform {
        Transform::Similarity if signed.sum() > 0.0 => {
            signed.sum() * moments.target_size_mm / moments.source_size_mm
        }
        _ => 1.0,
    };
    // The cost of turning about the axis of the largest singular value.
    let gap = signed[D - 2] + signed[D - 1];
    let relative_gap = gap / moments.matching_gap();
    ClosedForm { map: centred.map(rotation * scale), relative_gap }
}

fn affine<const D: usize>(pairs: &[PointPair<D>]) -> FrameMap<D> {
    let centred = Centred::new(pairs);
    let mut source = DMatrix::zeros(pairs.len(), D);
    let mut target = DMatrix::zeros(pairs.len(), D);
    for (row, (pair, root_weight)) in pairs.iter().zip(&centred.root_weights).enumerate() {
        for axis in 0..D {
            source[(row, axis)] = (pair.source_mm[axis] - centred.source_mean[axis]) * root_weight;
            target[(row, axis)] = (pair.target_mm[axis] - centred.target_mean[axis]) * root_weight;
        }
    }
    let qr = source.qr();
    qr.q_tr_mul(&mut target);
    let solved = qr.r().solve_upper_triangular(&target.rows(0, D));
    let linear = solved.map_or_else(SMatrix::identity, |transposed| {
        SMatrix::from_fn(|row, column| transposed[(column, row)])
    });
    centred.map(linear)
}
