//! Time of a fit, with the accuracy it is bought for.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use frame_fit::{Options, PointPair, Transform, Uncertainty, fit_frame};
use nalgebra::{Point3, Rotation3, SVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Points in a cube of 1 m with 10 µm of noise; per-axis sigmas make the fit iterate.
fn pairs(n: usize, per_axis: bool) -> Vec<PointPair<3>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
    let sigma_mm = 0.01;
    (0..n)
        .map(|_| {
            let source = Vector3::from_fn(|_, _| rng.random_range(-500.0..500.0));
            let axes = SVector::from([1.0, 1.0, 3.0]) * sigma_mm;
            let sigmas = if per_axis { axes } else { SVector::repeat(sigma_mm) };
            let noise: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
            let target = rotation * source + Vector3::new(100.0, 20.0, -7.0);
            let uncertainty = if per_axis {
                Uncertainty::PerAxis { sigma_mm: sigmas }
            } else {
                Uncertainty::Isotropic { sigma_mm }
            };
            PointPair {
                target_mm: Point3::from(target + noise.component_mul(&sigmas)),
                source_mm: Point3::from(source),
                uncertainty,
            }
        })
        .collect()
}

fn fits(criterion: &mut Criterion) {
    for n in [8, 1000, 100_000] {
        for (transform, per_axis) in [
            (Transform::Rigid, false),
            (Transform::Rigid, true),
            (Transform::Similarity, false),
            (Transform::Affine, false),
        ] {
            let pairs = pairs(n, per_axis);
            let weights = if per_axis { "per axis" } else { "isotropic" };
            let options = Options::of(transform);
            criterion.bench_function(&format!("{transform}, {weights}, {n} pairs"), |bencher| {
                bencher.iter(|| fit_frame(black_box(&pairs), black_box(&options)));
            });
        }
    }
}

criterion_group!(benches, fits);
criterion_main!(benches);
