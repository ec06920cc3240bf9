//! Levels a plate from heights: one bad reading, a tilt that one row of points cannot show, and
//! a prior that helps out.

#![expect(clippy::print_stdout, reason = "the output of an example")]

use least_squares::{
    Loss, Options, Prior, Problem, RobustRows, SolveError, check_jacobian, solve, with_vector_prior,
};
use nalgebra::{DMatrix, DVector};

const SIGMA_MM: f64 = 0.002;
/// Height in mm, slopes in mm/mm.
const TRUTH: [f64; 3] = [5.0, 1e-3, -2e-3];

/// Heights `z` over positions `x, y`, in mm.
struct Plate(Vec<[f64; 3]>);

impl Problem for Plate {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.0.len()
    }

    fn tangent_dim(&self) -> usize {
        3
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (row, [x, y, z]) in self.0.iter().enumerate() {
            out[row] = (at[0] + at[1] * x + at[2] * y - z) / SIGMA_MM;
        }
    }

    fn jacobian(&self, _: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (row, [x, y, _]) in self.0.iter().enumerate() {
            for (column, derivative) in [1.0, *x, *y].into_iter().enumerate() {
                out[(row, column)] = derivative / SIGMA_MM;
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        ["height [mm]", "slope along x", "slope along y"][index].to_owned()
    }
}

fn main() -> Result<(), SolveError> {
    let start = DVector::zeros(3);
    let mut plate = Plate(grid(&[0.0, 100.0, 200.0]));
    plate.0[4][2] += 0.5;
    let check = check_jacobian(&plate, &start);
    assert!(check.worst_relative_error() < 1e-9, "{check}");

    let robust = vec![RobustRows::all(1, Loss::tukey_95())];
    let near = solve(&plate, start.clone(), &Options::default())?.point;
    let huber =
        Options { robust: vec![RobustRows::all(1, Loss::huber_95())], ..Options::default() };
    let near = solve(&plate, near, &huber)?.point;
    let fit = solve(&plate, near, &Options { robust, ..Options::default() })?;
    println!("{}", fit.report);
    assert!((fit.point[0] - TRUTH[0]).abs() < 4.0 * fit.standard_uncertainties()[0]);
    assert_eq!(fit.report.residuals_used, 8);

    let row = Plate(grid(&[100.0]));
    let refused = solve(&row, start.clone(), &Options::default()).expect_err("one row of points");
    println!("{refused}");
    assert!(matches!(refused, SolveError::Unobservable { .. }));

    let levelled = with_vector_prior(&row, &[2], Prior::independent(&[(-2e-3, 1e-5)]))?;
    let fit = solve(&levelled, start, &Options::default())?;
    println!(
        "with a prior: height {:.4} ± {:.4} mm",
        fit.point[0],
        fit.standard_uncertainties()[0]
    );
    assert!((fit.point[0] - TRUTH[0]).abs() < 4.0 * fit.standard_uncertainties()[0]);
    Ok(())
}

/// Points at `x` = 0, 100, 200 for each `y`, with a small fixed error on each.
fn grid(ys: &[f64]) -> Vec<[f64; 3]> {
    let [height, along_x, along_y] = TRUTH;
    let height_at = |x: f64, y: f64| {
        let error = SIGMA_MM * (0.7 * x + 1.3 * y).sin();
        [x, y, height + along_x * x + along_y * y + error]
    };
    ys.iter().flat_map(|&y| [0.0, 100.0, 200.0].map(|x| height_at(x, y))).collect()
}
