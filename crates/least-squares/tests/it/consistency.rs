//! Whether uncertainties predict what repeated measurements scatter.

use least_squares::{Loss, Options, Problem, RobustRows, Solution, solve};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, StudentT};

use crate::problems::{DECAY_TRUTH, Written, decay_data};
use crate::suites::dual::Dual;

const TRIALS: usize = 2000;
/// Standard deviation of one reading. Small enough for the model to be linear over it.
const SIGMA: f64 = 0.01;

fn truth() -> DVector<f64> {
    DVector::from_row_slice(&DECAY_TRUTH)
}

/// Fits `TRIALS` noisy decays, whitened with `declared_sigma`.
fn repeat(
    declared_sigma: f64,
    options: &Options,
    mut error: impl FnMut() -> f64,
    mut visit: impl FnMut(&Solution<DVector<f64>>),
) {
    for _ in 0..TRIALS {
        let data = decay_data(|_| error());
        let whitened = Written::new(&["a", "b", "c"], data.len(), |x: &[Dual]| {
            let predict = |t: f64| x[0] * (-x[1] * t).exp() + x[2];
            let row = |i: usize| (predict(0.4 * i as f64) - data[i]) / declared_sigma;
            (0..data.len()).map(row).collect()
        });
        assert_eq!(whitened.residual_count(), 12);
        visit(&solve(&whitened, truth(), options).unwrap());
    }
}

fn gaussian(sigma: f64, seed: u64) -> impl FnMut() -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, sigma).unwrap();
    move || noise.sample(&mut rng)
}

/// Of a χ² with 3 degrees of freedom the mean is 3; over 2000 trials its standard deviation is
/// √(6/2000) = 0.055. Of χ²/9 with 9, it is 1 and √(2/9/2000) = 0.0105. Bounds are 4 of them.
#[test]
fn covariance_predicts_the_scatter() {
    let (mut squared_error, mut variance_factor) = (0.0, 0.0);
    repeat(SIGMA, &Options::default(), gaussian(SIGMA, 1), |fit| {
        let error = &fit.point - truth();
        let factor = fit.covariance.clone().cholesky().unwrap();
        squared_error += error.dot(&factor.solve(&error));
        variance_factor += fit.variance_factor.unwrap();
        assert_eq!(fit.degrees_of_freedom, 9);
    });
    let trials = TRIALS as f64;
    assert!((squared_error / trials - 3.0).abs() < 0.22, "{}", squared_error / trials);
    assert!((variance_factor / trials - 1.0).abs() < 0.042, "{}", variance_factor / trials);
}

/// Over 2000 trials a coverage of 95 % has a standard deviation of 0.49 %; bounds are 4 of them.
fn assert_covers_95(covered: &[usize]) {
    for (i, &count) in covered.iter().enumerate() {
        let share = count as f64 / TRIALS as f64;
        assert!((share - 0.95).abs() < 0.02, "parameter {i}: {share}");
    }
}

#[test]
fn a_priori_intervals_cover_95_percent() {
    const NORMAL_95: f64 = 1.959_964;
    let mut covered = [0; 3];
    repeat(SIGMA, &Options::default(), gaussian(SIGMA, 2), |fit| {
        let sigma = fit.standard_uncertainties();
        for i in 0..3 {
            let inside = (fit.point[i] - DECAY_TRUTH[i]).abs() <= NORMAL_95 * sigma[i];
            covered[i] += usize::from(inside);
        }
    });
    assert_covers_95(&covered);
}

/// Sigma declared ten times too large: the variance factor puts it right, Student's t with 9
/// degrees of freedom allows for its own scatter.
#[test]
fn a_posteriori_intervals_cover_95_percent() {
    const STUDENT_9_95: f64 = 2.262_157;
    let mut covered = [0; 3];
    repeat(10.0 * SIGMA, &Options::default(), gaussian(SIGMA, 3), |fit| {
        let sigma = fit.standard_uncertainties() * fit.variance_factor.unwrap().sqrt();
        for i in 0..3 {
            let inside = (fit.point[i] - DECAY_TRUTH[i]).abs() <= STUDENT_9_95 * sigma[i];
            covered[i] += usize::from(inside);
        }
    });
    assert_covers_95(&covered);
}

/// Heavy tails (Student's t with 2 degrees of freedom): Huber's estimate scatters less than half
/// as much in variance as least squares, whose errors have no variance at all.
#[test]
fn a_robust_loss_pays_under_heavy_tails() {
    let tails = |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noise = StudentT::new(2.0).unwrap();
        move || SIGMA * noise.sample(&mut rng)
    };
    let huber =
        Options { robust: vec![RobustRows::all(1, Loss::huber_95())], ..Options::default() };
    let median_error = |options: &Options| {
        let mut errors = Vec::new();
        repeat(SIGMA, options, tails(4), |fit| errors.push((fit.point[1] - DECAY_TRUTH[1]).abs()));
        errors.sort_by(f64::total_cmp);
        errors[TRIALS / 2]
    };
    let (plain, robust) = (median_error(&Options::default()), median_error(&huber));
    assert!(robust < 0.9 * plain, "median error {robust} against {plain}");
}

/// Where there is nothing to reject, Huber's loss gives up 5 % of the variance; over 2000 trials
/// the ratio of two nearly equal variances scatters by about 1 %.
#[test]
fn a_robust_loss_costs_little_on_clean_data() {
    let huber =
        Options { robust: vec![RobustRows::all(1, Loss::huber_95())], ..Options::default() };
    let variance = |options: &Options| {
        let mut sum = 0.0;
        repeat(SIGMA, options, gaussian(SIGMA, 5), |fit| {
            sum += (fit.point[2] - DECAY_TRUTH[2]).powi(2);
        });
        sum / TRIALS as f64
    };
    let ratio = variance(&huber) / variance(&Options::default());
    assert!((1.0..1.12).contains(&ratio), "variance ratio {ratio}");
}
