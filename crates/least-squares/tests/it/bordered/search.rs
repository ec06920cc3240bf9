//! How the search goes.

use least_squares::{BorderedOptions, BorderedProblem, SolveError, solve_bordered};

use super::problems::{GAUGE, Ranging};

fn held() -> BorderedOptions {
    BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() }
}

#[test]
fn readings_without_error_give_back_the_truth() {
    for seed in 0..50 {
        let (truth, mut problem, mut start) = Ranging::simulate(6, 20, 0.0, 1.0, seed);
        problem.sigma = 1e-3;
        // Hold the offsets, whose prior the truth does not meet.
        let options = BorderedOptions {
            held_shared: GAUGE.iter().copied().chain(18..24).collect(),
            ..BorderedOptions::default()
        };
        start.shared[18..].copy_from_slice(&truth.shared[18..]);
        let fit = solve_bordered(&problem, start, &options).unwrap();
        let pairs = fit.point.blocks.iter().zip(&truth.blocks);
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // 1e3 mm · 2⁻⁵², times a condition of some 1e3.
        assert!(worst < 1e-9, "seed {seed}: {worst:e}");
    }
}

/// Declared uncertainties far below rounding leave a residual that is rounding and nothing else,
/// which no step lowers as its derivatives promise.
#[test]
fn rounding_ends_a_search_that_leaves_nothing_else() {
    for (seed, targets) in (0..40).flat_map(|seed| [(seed, 12), (seed, 20), (seed, 90)]) {
        let (truth, mut problem, mut start) = Ranging::simulate(6, targets, 0.0, 1.0, seed);
        let options = BorderedOptions {
            held_shared: GAUGE.iter().copied().chain(18..24).collect(),
            ..BorderedOptions::default()
        };
        start.shared[18..].copy_from_slice(&truth.shared[18..]);
        for sigma in [1e-9, 1e-15] {
            problem.sigma = sigma;
            let fit = match solve_bordered(&problem, start, &options) {
                Ok(fit) => fit,
                Err(error) => panic!("seed {seed}, {targets} targets, sigma {sigma}: {error}"),
            };
            let pairs = fit.point.blocks.iter().zip(&truth.blocks);
            let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // 1e3 mm · 2⁻⁵², times a condition of some 1e3.
            assert!(worst < 1e-9, "seed {seed}: {worst:e}");
            start = fit.point;
        }
    }
}

/// Derivatives of the wrong sign for one coordinate of every target.
struct Misled(Ranging);

impl BorderedProblem for Misled {
    fn shared_dim(&self) -> usize {
        self.0.shared_dim()
    }

    fn block_dim(&self) -> usize {
        3
    }

    fn block_count(&self) -> usize {
        self.0.block_count()
    }

    fn patterns(&self) -> &[least_squares::Pattern] {
        self.0.patterns()
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        self.0.residuals(block, shared, point, out);
    }

    fn linearise(
        &self,
        block: usize,
        shared: &[f64],
        point: &[f64],
        rows: least_squares::BlockRows<'_>,
    ) {
        let least_squares::BlockRows { residuals, by_block, by_shared } = rows;
        let part = least_squares::BlockRows { residuals, by_block, by_shared };
        self.0.linearise(block, shared, point, part);
        for derivative in by_block.iter_mut().chain(by_shared) {
            *derivative = -*derivative;
        }
    }
}

#[test]
fn derivatives_of_the_wrong_sign_are_not_taken_for_rounding() {
    for seed in 0..20 {
        let (_, mut problem, start) = Ranging::simulate(6, 20, 0.0, 1e-6, seed);
        problem.sigma = 1e-6;
        let error = solve_bordered(&Misled(problem), start, &held()).unwrap_err();
        assert!(matches!(error, SolveError::Stalled { .. }), "seed {seed}: {error}");
    }
}

#[test]
fn a_start_at_the_minimum_stays_there() {
    let (_, problem, start) = Ranging::simulate(6, 20, 1e-3, 0.5, 7);
    let first = solve_bordered(&problem, start, &held()).unwrap();
    let second = solve_bordered(&problem, first.point.clone(), &held()).unwrap();
    assert!(second.report.jacobian_evaluations <= 2, "{}", second.report);
    let moved = first.point.shared.iter().zip(&second.point.shared);
    assert!(moved.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-8);
}

#[test]
fn a_good_start_takes_few_evaluations() {
    let (_, problem, start) = Ranging::simulate(6, 200, 1e-3, 0.5, 8);
    let report = solve_bordered(&problem, start, &held()).unwrap().report;
    assert!(report.jacobian_evaluations <= 4, "{report}");
    assert!(report.residual_evaluations <= 4, "{report}");
}

#[test]
fn a_poor_start_is_damped_into_the_minimum() {
    let mut same = 0;
    for seed in 0..20 {
        let (truth, problem, near) = Ranging::simulate(6, 15, 1e-3, 0.1, seed);
        let (_, _, far) = Ranging::simulate(6, 15, 1e-3, 60.0, seed);
        let expected = solve_bordered(&problem, near, &held()).unwrap().report.final_cost;
        let found = solve_bordered(&problem, far, &held()).unwrap().report.final_cost;
        same += usize::from((found / expected - 1.0).abs() < 1e-9);
        assert!(truth.shared.len() == 24);
    }
    // 60 mm off in all coordinates of a scene of 1 m, mirror images are near.
    assert!(same >= 18, "{same} of 20");
}

#[test]
fn absent_rows_are_as_if_they_were_not() {
    let (_, mut problem, start) = Ranging::simulate(6, 15, 1e-3, 0.5, 10);
    for k in [0, 13, 33, 50, 51] {
        problem.ranges[k] = f64::NAN;
    }
    let fit = solve_bordered(&problem, start.clone(), &held()).unwrap();
    assert_eq!(fit.report.residuals_given, 6 * 15 - 5 + 6);
    assert_eq!(fit.degrees_of_freedom, 91 - (24 - 6) - 45);
    // The same with an uncertainty so large that they tell nothing.
    let weak = Weakened(&problem);
    let same = solve_bordered(&weak, start, &held()).unwrap();
    let pairs = fit.point.shared.iter().zip(&same.point.shared);
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-8);
}

/// Absent ranges replaced by ones whose weight is next to nought.
struct Weakened<'a>(&'a Ranging);

impl BorderedProblem for Weakened<'_> {
    fn shared_dim(&self) -> usize {
        self.0.shared_dim()
    }

    fn block_dim(&self) -> usize {
        3
    }

    fn block_count(&self) -> usize {
        self.0.block_count()
    }

    fn patterns(&self) -> &[least_squares::Pattern] {
        self.0.patterns()
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        self.0.residuals(block, shared, point, out);
        for (i, out) in out.iter_mut().enumerate() {
            if self.0.ranges[block * 6 + i].is_nan() {
                *out = 1e-9 * (point[0] + shared[3 * i] - 7.0);
            }
        }
    }

    fn linearise(
        &self,
        block: usize,
        shared: &[f64],
        point: &[f64],
        rows: least_squares::BlockRows<'_>,
    ) {
        let least_squares::BlockRows { residuals, by_block, by_shared } = rows;
        let part = least_squares::BlockRows { residuals, by_block, by_shared };
        self.0.linearise(block, shared, point, part);
        self.residuals(block, shared, point, residuals);
        for i in 0..6 {
            if self.0.ranges[block * 6 + i].is_nan() {
                by_block[3 * i] = 1e-9;
                by_shared[4 * i] = 1e-9;
            }
        }
    }

    fn shared_residual_count(&self) -> usize {
        self.0.shared_residual_count()
    }

    fn linearise_shared(&self, shared: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) {
        self.0.linearise_shared(shared, residuals, jacobian);
    }
}
