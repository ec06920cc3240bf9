//! Time of one small fit, and of the parts it could be made of.
#![expect(clippy::print_stdout, reason = "says how many evaluations the time buys")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use least_squares::{Options, Problem, covariance, solve};
use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A rigid transform from 20 pairs of points: 60 residuals, 6 parameters.
struct RigidFit {
    source_mm: Vec<Point3<f64>>,
    target_mm: Vec<Point3<f64>>,
}

const SIGMA_MM: f64 = 0.01;

impl RigidFit {
    fn simulate(points: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut vector = |half: f64| Vector3::from_fn(|_, _| rng.random_range(-half..half));
        let truth = Isometry3::new(Vector3::new(300.0, -200.0, 50.0), Vector3::new(0.3, -0.2, 1.0));
        let source_mm: Vec<_> = (0..points).map(|_| Point3::from(vector(500.0))).collect();
        let target_mm = source_mm.iter().map(|p| truth * p + vector(SIGMA_MM)).collect();
        Self { source_mm, target_mm }
    }
}

impl Problem for RigidFit {
    type Point = Isometry3<f64>;

    fn residual_count(&self) -> usize {
        3 * self.source_mm.len()
    }

    fn tangent_dim(&self) -> usize {
        6
    }

    fn residuals(&self, at: &Isometry3<f64>, out: &mut DVector<f64>) {
        for (i, (source, target)) in self.source_mm.iter().zip(&self.target_mm).enumerate() {
            out.fixed_rows_mut::<3>(3 * i).copy_from(&((at * source - target) / SIGMA_MM));
        }
    }

    fn jacobian(&self, at: &Isometry3<f64>, out: &mut DMatrix<f64>) {
        for (i, source) in self.source_mm.iter().enumerate() {
            let moved = (at * source).coords / SIGMA_MM;
            let mut block = out.fixed_view_mut::<3, 6>(3 * i, 0);
            block.fixed_columns_mut::<3>(0).fill_diagonal(1.0 / SIGMA_MM);
            block.fixed_columns_mut::<3>(3).copy_from(&-moved.cross_matrix());
        }
    }

    fn retract(&self, at: &Isometry3<f64>, step: &DVector<f64>) -> Isometry3<f64> {
        let (shift, turn) = (step.fixed_rows::<3>(0), step.fixed_rows::<3>(3));
        Isometry3::new(shift.into_owned(), turn.into_owned()) * at
    }
}

fn dense(criterion: &mut Criterion) {
    let problem = RigidFit::simulate(20);
    let options = Options::default();
    let fit = solve(&problem, Isometry3::identity(), &options).expect("20 points fix a pose");
    println!("{}", fit.report);
    criterion.bench_function("solve 60x6", |b| {
        b.iter(|| solve(black_box(&problem), Isometry3::identity(), &options));
    });
    criterion.bench_function("covariance 60x6", |b| {
        b.iter(|| covariance(black_box(&problem), &fit.point, &options));
    });

    let mut jacobian = DMatrix::zeros(60, 6);
    problem.jacobian(&fit.point, &mut jacobian);
    criterion.bench_function("residuals and Jacobian 60x6", |b| {
        let mut residuals = DVector::zeros(60);
        b.iter(|| {
            problem.residuals(&fit.point, &mut residuals);
            problem.jacobian(&fit.point, black_box(&mut jacobian));
        });
    });
    criterion.bench_function("faer pivoted QR 60x6", |b| {
        b.iter(|| {
            let view = faer::MatRef::from_column_major_slice(jacobian.as_slice(), 60, 6);
            black_box(view).col_piv_qr()
        });
    });
    criterion.bench_function("faer SVD 6x6", |b| {
        b.iter(|| {
            let view = faer::MatRef::from_column_major_slice(&jacobian.as_slice()[..36], 6, 6);
            black_box(view).svd()
        });
    });
    criterion.bench_function("nalgebra SVD 6x6", |b| {
        let m = jacobian.rows(0, 6).into_owned();
        b.iter(|| black_box(&m).clone().svd(false, true));
    });
    criterion.bench_function("nalgebra QR 60x6", |b| {
        b.iter(|| black_box(&jacobian).clone().qr());
    });
    let large = RigidFit::simulate(2000);
    criterion.bench_function("solve 6000x6", |b| {
        b.iter(|| solve(black_box(&large), Isometry3::identity(), &options));
    });
}

criterion_group!(benches, dense);
criterion_main!(benches);
