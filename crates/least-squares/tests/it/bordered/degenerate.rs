//! Data that do not determine everything, and input that is no input.

use least_squares::{
    BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, Loss, Pattern, RobustRows,
    SolveError, bordered_covariance, solve_bordered,
};

use super::problems::{GAUGE, Ranging};

fn held() -> BorderedOptions {
    BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() }
}

#[test]
fn a_free_gauge_is_named_direction_by_direction() {
    let (_, problem, start) = Ranging::simulate(6, 15, 1e-3, 0.1, 1);
    let options = BorderedOptions::default();
    let refused = solve_bordered(&problem, start.clone(), &options).unwrap_err();
    let SolveError::Unobservable { directions, report, best } = &refused else {
        panic!("{refused}")
    };
    assert_eq!(directions.len(), 6, "{refused}");
    assert_eq!(report.rank, report.parameters - 6);
    assert!(refused.to_string().contains("of station"), "{refused}");
    // Moving along it changes no residual: to first order, over a step of 1e-4.
    for direction in directions {
        let step = 1e-4 / direction.step.amax() * &direction.step;
        let move_by = |old: &[f64], step: &[f64]| -> Vec<f64> {
            old.iter().zip(step).map(|(p, s)| p + s).collect()
        };
        let shared = move_by(&best.shared, &step.as_slice()[..24]);
        let blocks = move_by(&best.blocks, &step.as_slice()[24..]);
        let (mut before, mut after) = ([0.0; 6], [0.0; 6]);
        problem.residuals(3, &best.shared, &best.blocks[9..12], &mut before);
        problem.residuals(3, &shared, &blocks[9..12], &mut after);
        let change = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // A range of some 500 mm changes by (1e-4)²/500, over an uncertainty of 1e-3.
        assert!(change < 1e-6, "{change:e} along {direction}");
    }
    let refused = bordered_covariance(&problem, &start, &options).unwrap_err();
    assert!(
        matches!(refused, SolveError::Unobservable { directions, .. } if directions.len() == 6)
    );
}

#[test]
fn a_target_that_two_stations_see_is_named() {
    let (_, mut problem, start) = Ranging::simulate(6, 15, 1e-3, 0.1, 2);
    for i in 0..4 {
        problem.ranges[7 * 6 + i] = f64::NAN;
    }
    let refused = solve_bordered(&problem, start, &held()).unwrap_err();
    let SolveError::Unobservable { directions, .. } = &refused else { panic!("{refused}") };
    assert_eq!(directions.len(), 1);
    assert!(refused.to_string().contains("of target 7"), "{refused}");
}

#[test]
fn a_station_without_readings_is_named() {
    let (_, mut problem, start) = Ranging::simulate(6, 15, 1e-3, 0.1, 3);
    problem.ranges.iter_mut().skip(4).step_by(6).for_each(|l| *l = f64::NAN);
    let refused = solve_bordered(&problem, start, &held()).unwrap_err();
    let SolveError::Unobservable { directions, .. } = &refused else { panic!("{refused}") };
    assert_eq!(directions.len(), 3, "{refused}");
    assert!(refused.to_string().contains("x of station 4"), "{refused}");
}

#[test]
fn numbers_that_are_none_are_named() {
    let (_, mut problem, start) = Ranging::simulate(6, 100, 1e-3, 0.1, 4);
    problem.ranges[6 * 70 + 3] = f64::INFINITY;
    let refused = solve_bordered(&problem, start.clone(), &held()).unwrap_err();
    let expected = |e| matches!(e, SolveError::NonFiniteBlockResidual { block: 70, row: 3, .. });
    assert!(expected(refused));
    let (_, problem, mut start) = Ranging::simulate(6, 100, 1e-3, 0.1, 4);
    let station = start.shared[6..9].to_vec();
    start.blocks[30..33].copy_from_slice(&station);
    let refused = solve_bordered(&problem, start, &held()).unwrap_err();
    let expected = |e| matches!(e, SolveError::NonFiniteBlockJacobian { block: 10, row: 2, .. });
    assert!(expected(refused));
}

#[test]
fn input_that_does_not_fit_is_refused() {
    let (_, problem, start) = Ranging::simulate(6, 15, 1e-3, 0.1, 5);
    let solve = |options: BorderedOptions| solve_bordered(&problem, start.clone(), &options);
    let refused = solve(BorderedOptions { held_shared: vec![24], ..held() }).unwrap_err();
    let expected = SolveError::DirectionOutOfRange { index: 24, tangent_dim: 24 };
    assert_eq!(refused, expected);
    let refused = solve(BorderedOptions { held_blocks: vec![15], ..held() }).unwrap_err();
    assert_eq!(refused, SolveError::BlockOutOfRange { block: 15, block_count: 15 });
    let robust = vec![RobustRows::all(1, Loss::Tukey { scale: 0.0 })];
    let refused = solve(BorderedOptions { robust, ..held() }).unwrap_err();
    assert!(matches!(refused, SolveError::InvalidLoss { index: 0, .. }));
    let mut short = start.clone();
    short.blocks.pop();
    let refused = solve_bordered(&problem, short, &held()).unwrap_err();
    assert_eq!(refused, SolveError::InvalidBlocks { numbers: 44, blocks: 15 });
    let mut flat = start.clone();
    flat.blocks.truncate(2 * 15);
    assert_eq!(solve_bordered(&problem, flat, &held()).unwrap_err(), SolveError::InvalidStart);
    let mut short = start;
    short.shared.pop();
    assert_eq!(solve_bordered(&problem, short, &held()).unwrap_err(), SolveError::InvalidStart);
}

/// A problem that is nothing but its pattern.
struct Listed(Vec<Pattern>);

impl BorderedProblem for Listed {
    fn shared_dim(&self) -> usize {
        2
    }

    fn block_dim(&self) -> usize {
        1
    }

    fn block_count(&self) -> usize {
        3
    }

    fn patterns(&self) -> &[Pattern] {
        &self.0
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        out.fill(shared[0] + shared[1] + point[0] - block as f64);
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        self.residuals(block, shared, point, rows.residuals);
        rows.by_block.fill(1.0);
        rows.by_shared.fill(1.0);
    }
}

#[test]
fn patterns_that_are_wrong_are_refused() {
    let solve = |patterns: Vec<Pattern>| {
        let start = BorderedPoint { shared: vec![0.0; 2], blocks: vec![0.0; 3] };
        solve_bordered(&Listed(patterns), start, &BorderedOptions::default()).unwrap_err()
    };
    let mut pattern = Pattern::dense(1, 1, 2);
    pattern.push(&[0], &[1, 1]);
    let expected = SolveError::InvalidPattern { pattern: 0, row: 1, direction: 1 };
    assert_eq!(solve(vec![pattern]), expected);
    let mut pattern = Pattern::new();
    pattern.push(&[1], &[]);
    let expected = SolveError::InvalidPattern { pattern: 0, row: 0, direction: 1 };
    assert_eq!(solve(vec![pattern]), expected);
    assert!(matches!(solve(vec![]), SolveError::InvalidPattern { .. }));
}

#[test]
fn shared_parameters_that_blocks_imitate_are_named() {
    // Every residual is the sum of both shared numbers and the block's.
    let start = BorderedPoint { shared: vec![0.3; 2], blocks: vec![0.1; 3] };
    let problem = Listed(vec![Pattern::dense(4, 1, 2)]);
    let refused = solve_bordered(&problem, start, &BorderedOptions::default()).unwrap_err();
    let SolveError::Unobservable { directions, .. } = &refused else { panic!("{refused}") };
    assert_eq!(directions.len(), 2, "{refused}");
}
