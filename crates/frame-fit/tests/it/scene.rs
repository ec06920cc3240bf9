//! Random frames and points for the tests.

use frame_fit::{FrameMap, PointPair, Transform, Uncertainty};
use nalgebra::{DMatrix, Point, Rotation3, SMatrix, SVector, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A member of the family, anywhere and turned anyhow.
pub(crate) fn random_map<const D: usize>(
    rng: &mut ChaCha8Rng,
    transform: Transform,
) -> FrameMap<D> {
    let mut map = FrameMap::identity();
    if transform.has_translation() {
        map.translation_mm = uniform(rng, 1000.0);
    }
    if transform.has_rotation() {
        let axis = if D == 2 { Vector3::z() * 3.0 } else { Vector3::repeat(1.7) };
        let vector =
            axis.map(|limit| if limit > 0.0 { rng.random_range(-limit..limit) } else { 0.0 });
        let rotation = Rotation3::from_scaled_axis(vector);
        map.linear = SMatrix::from_fn(|i, j| rotation[(i, j)]);
    }
    match transform {
        Transform::Similarity => map.linear *= rng.random_range(0.5..2.0),
        Transform::Affine => {
            map.linear += SMatrix::from_fn(|_, _| rng.random_range(-0.2..0.2));
        }
        _ => {}
    }
    map
}

/// Each coordinate uniform within ± `half_mm`.
pub(crate) fn uniform<const D: usize>(rng: &mut ChaCha8Rng, half_mm: f64) -> SVector<f64, D> {
    SVector::from_fn(|_, _| rng.random_range(-half_mm..half_mm))
}

pub(crate) fn gauss<const D: usize>(rng: &mut ChaCha8Rng) -> SVector<f64, D> {
    SVector::from_fn(|_, _| StandardNormal.sample(rng))
}

/// `n` points within ± `half_mm`.
pub(crate) fn cloud<const D: usize>(
    rng: &mut ChaCha8Rng,
    n: usize,
    half_mm: f64,
) -> Vec<Point<f64, D>> {
    (0..n).map(|_| Point::from(uniform::<D>(rng, half_mm))).collect()
}

/// The points and their images, free of noise, at the given uncertainty.
pub(crate) fn exact<const D: usize>(
    points: &[Point<f64, D>],
    truth: &FrameMap<D>,
    uncertainty: Uncertainty<D>,
) -> Vec<PointPair<D>> {
    let pair =
        |p: &Point<f64, D>| PointPair { target_mm: truth.apply(p), source_mm: *p, uncertainty };
    points.iter().map(pair).collect()
}

/// Adds noise of each pair's own covariance.
pub(crate) fn disturb<const D: usize>(rng: &mut ChaCha8Rng, pairs: &mut [PointPair<D>]) {
    for pair in pairs {
        let covariance = pair.uncertainty.covariance_mm2();
        let covariance = DMatrix::from_column_slice(D, D, covariance.as_slice());
        let lower = covariance.cholesky().unwrap().l();
        let lower = SMatrix::<f64, D, D>::from_column_slice(lower.as_slice());
        pair.target_mm += lower * gauss::<D>(rng);
    }
}

/// Any of the three ways to state an uncertainty, of about `sigma_mm`.
pub(crate) fn random_uncertainty<const D: usize>(
    rng: &mut ChaCha8Rng,
    sigma_mm: f64,
) -> Uncertainty<D> {
    let sigmas = SVector::<f64, D>::from_fn(|_, _| sigma_mm * rng.random_range(0.3..3.0));
    match rng.random_range(0..3) {
        0 => Uncertainty::Isotropic { sigma_mm: sigmas[0] },
        1 => Uncertainty::PerAxis { sigma_mm: sigmas },
        _ => {
            let mixing = SMatrix::<f64, D, D>::from_fn(|i, j| {
                let off = if i == j { 1.0 } else { rng.random_range(-0.6..0.6) };
                sigmas[i] * off
            });
            Uncertainty::Full { covariance_mm2: mixing * mixing.transpose() }
        }
    }
}

/// Largest distance between the images of the corners of a cube of side 2 `half_mm`.
pub(crate) fn map_distance_mm<const D: usize>(
    a: &FrameMap<D>,
    b: &FrameMap<D>,
    half_mm: f64,
) -> f64 {
    let corner =
        |bits: usize| {
            Point::from(SVector::<f64, D>::from_fn(|k, _| {
                if bits >> k & 1 == 1 { half_mm } else { -half_mm }
            }))
        };
    let distance = |bits| (a.apply(&corner(bits)) - b.apply(&corner(bits))).norm();
    (0..1 << D).map(distance).fold(0.0, f64::max)
}
