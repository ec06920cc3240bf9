//! Moré, Garbow and Hillstrom (1981), least-squares problems 1 to 19.

use least_squares::Problem;
use nalgebra::{DMatrix, DVector};

use super::dual::Dual;

/// Factors on the paper's starts.
pub(crate) const START_SCALES: [f64; 3] = [1.0, 10.0, 100.0];
/// Starts to solve; Ceres with its defaults solves 41 of its 57.
pub(crate) const GOAL_SOLVED: usize = 45;

/// One test problem.
pub(crate) struct Mgh {
    pub(crate) name: &'static str,
    residual_count: usize,
    start: &'static [f64],
    /// `Σ r²` at the known minimum.
    pub(crate) optimum: f64,
    residuals: fn(&[Dual], &mut Vec<Dual>),
}

impl Mgh {
    /// The paper's start times `scale`.
    pub(crate) fn start(&self, scale: f64) -> DVector<f64> {
        DVector::from_row_slice(self.start) * scale
    }

    /// Whether `Σ r²` is right to 1e-4, relative or, where the optimum is nought, absolute.
    ///
    /// The criterion of Ceres, `examples/more_garbow_hillstrom.cc`: a log relative error of 4.
    pub(crate) fn solved(&self, sum_of_squares: f64) -> bool {
        let unit = if self.optimum > 0.0 { self.optimum } else { 1.0 };
        (sum_of_squares - self.optimum).abs() / unit <= 1e-4
    }

    fn evaluate(&self, at: &DVector<f64>) -> Vec<Dual> {
        let mut out = Vec::with_capacity(self.residual_count);
        (self.residuals)(&Dual::parameters(at.as_slice()), &mut out);
        out
    }
}

impl Problem for Mgh {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.residual_count
    }

    fn tangent_dim(&self) -> usize {
        self.start.len()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (r, dual) in out.iter_mut().zip(self.evaluate(at)) {
            *r = dual.value;
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (row, dual) in self.evaluate(at).into_iter().enumerate() {
            for column in 0..at.len() {
                out[(row, column)] = dual.slope[column];
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        format!("x{}", index + 1)
    }
}

/// The problems, in the paper's order and with its starts.
pub(crate) const PROBLEMS: [Mgh; 19] = [
    Mgh {
        name: "Rosenbrock",
        residual_count: 2,
        start: &[-1.2, 1.0],
        optimum: 0.0,
        residuals: |x, out| {
            out.push((x[1] - x[0] * x[0]) * 10.0);
            out.push(-x[0] + 1.0);
        },
    },
    Mgh {
        name: "Freudenstein-Roth",
        residual_count: 2,
        start: &[0.5, -2.0],
        optimum: 0.0,
        residuals: |x, out| {
            out.push(x[0] - 13.0 + ((-x[1] + 5.0) * x[1] - 2.0) * x[1]);
            out.push(x[0] - 29.0 + ((x[1] + 1.0) * x[1] - 14.0) * x[1]);
        },
    },
    Mgh {
        name: "Powell badly scaled",
        residual_count: 2,
        start: &[0.0, 1.0],
        optimum: 0.0,
        residuals: |x, out| {
            out.push(x[0] * x[1] * 1e4 - 1.0);
            out.push((-x[0]).exp() + (-x[1]).exp() - 1.0001);
        },
    },
    Mgh {
        name: "Brown badly scaled",
        residual_count: 3,
        start: &[1.0, 1.0],
        optimum: 0.0,
        residuals: |x, out| out.extend([x[0] - 1e6, x[1] - 2e-6, x[0] * x[1] - 2.0]),
    },
    Mgh {
        name: "Beale",
        residual_count: 3,
        start: &[1.0, 1.0],
        optimum: 0.0,
        residuals: |x, out| {
            for (i, y) in (1..).zip([1.5, 2.25, 2.625]) {
                out.push(-x[0] * (-x[1].powi(i) + 1.0) + y);
            }
        },
    },
    Mgh {
        name: "Jennrich-Sampson",
        residual_count: 10,
        start: &[0.3, 0.4],
        optimum: 124.362,
        residuals: |x, out| {
            for i in (1..=10).map(f64::from) {
                out.push(-(x[0] * i).exp() - (x[1] * i).exp() + 2.0 + 2.0 * i);
            }
        },
    },
    Mgh {
        name: "Helical valley",
        residual_count: 3,
        start: &[-1.0, 0.0, 0.0],
        optimum: 0.0,
        residuals: |x, out| {
            let half = if x[0].value > 0.0 { 0.0 } else { 0.5 };
            let theta = (x[1] / x[0]).atan() / (2.0 * std::f64::consts::PI) + half;
            out.push((x[2] - theta * 10.0) * 10.0);
            out.push(((x[0].square() + x[1].square()).sqrt() - 1.0) * 10.0);
            out.push(x[2]);
        },
    },
    Mgh {
        name: "Bard",
        residual_count: 15,
        start: &[1.0, 1.0, 1.0],
        optimum: 8.214_87e-3,
        residuals: |x, out| {
            for (u, y) in (1..).zip(BARD) {
                let (u, v) = (f64::from(u), f64::from(16 - u));
                out.push(-x[0] - Dual::from(u) / (x[1] * v + x[2] * u.min(v)) + y);
            }
        },
    },
    Mgh {
        name: "Gaussian",
        residual_count: 15,
        start: &[0.4, 1.0, 0.0],
        optimum: 1.127_93e-8,
        residuals: |x, out| {
            for (i, y) in (1..).zip(GAUSSIAN) {
                let t = (8.0 - f64::from(i)) / 2.0;
                out.push(x[0] * (-x[1] * (-x[2] + t).square() / 2.0).exp() - y);
            }
        },
    },
    Mgh {
        name: "Meyer",
        residual_count: 16,
        start: &[0.02, 4000.0, 250.0],
        optimum: 87.9458,
        residuals: |x, out| {
            for (i, y) in (1..).zip(MEYER) {
                out.push(x[0] * (x[1] / (x[2] + 45.0 + 5.0 * f64::from(i))).exp() - y);
            }
        },
    },
    Mgh {
        name: "Gulf",
        residual_count: 100,
        start: &[5.0, 2.5, 0.15],
        optimum: 0.0,
        residuals: |x, out| {
            for i in (1..=100).map(f64::from) {
                let t = i / 100.0;
                let y = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
                out.push((-(-x[1] + y).abs().powd(x[2]) / x[0]).exp() - t);
            }
        },
    },
    Mgh {
        name: "Box 3-D",
        residual_count: 3,
        start: &[0.0, 10.0, 20.0],
        optimum: 0.0,
        residuals: |x, out| {
            for t in [0.1_f64, 0.2, 0.3] {
                let known = (-t).exp() - (-10.0 * t).exp();
                out.push((-x[0] * t).exp() - (-x[1] * t).exp() - x[2] * known);
            }
        },
    },
    Mgh {
        name: "Powell singular",
        residual_count: 4,
        start: &[3.0, -1.0, 0.0, 1.0],
        optimum: 0.0,
        residuals: |x, out| {
            out.push(x[0] + x[1] * 10.0);
            out.push((x[2] - x[3]) * 5_f64.sqrt());
            out.push((x[1] - x[2] * 2.0).square());
            out.push((x[0] - x[3]).square() * 10_f64.sqrt());
        },
    },
    Mgh {
        name: "Wood",
        residual_count: 6,
        start: &[-3.0, -1.0, -3.0, -1.0],
        optimum: 0.0,
        residuals: |x, out| {
            out.push((x[1] - x[0].square()) * 10.0);
            out.push(-x[0] + 1.0);
            out.push((x[3] - x[2].square()) * 90_f64.sqrt());
            out.push(-x[2] + 1.0);
            out.push((x[1] + x[3] - 2.0) * 10_f64.sqrt());
            out.push((x[1] - x[3]) / 10_f64.sqrt());
        },
    },
    Mgh {
        name: "Kowalik-Osborne",
        residual_count: 11,
        start: &[0.25, 0.39, 0.415, 0.39],
        optimum: 3.075_05e-4,
        residuals: |x, out| {
            for (u, y) in KOWALIK_U.into_iter().zip(KOWALIK_Y) {
                out.push(-x[0] * (x[1] * u + u * u) / (x[2] * u + x[3] + u * u) + y);
            }
        },
    },
    Mgh {
        name: "Brown-Dennis",
        residual_count: 20,
        start: &[25.0, 5.0, -5.0, -1.0],
        optimum: 85_822.2,
        residuals: |x, out| {
            for t in (1..=20).map(|i| f64::from(i) / 5.0) {
                let first = x[0] + x[1] * t - t.exp();
                let second = x[2] + x[3] * t.sin() - t.cos();
                out.push(first.square() + second.square());
            }
        },
    },
    Mgh {
        name: "Osborne 1",
        residual_count: 33,
        start: &[0.5, 1.5, -1.0, 0.01, 0.02],
        optimum: 5.464_89e-5,
        residuals: |x, out| {
            for (i, y) in (0..).zip(OSBORNE_1) {
                let t = 10.0 * f64::from(i);
                out.push(-(x[0] + x[1] * (-x[3] * t).exp() + x[2] * (-x[4] * t).exp()) + y);
            }
        },
    },
    Mgh {
        name: "Biggs EXP6",
        residual_count: 13,
        start: &[1.0, 2.0, 1.0, 1.0, 1.0, 1.0],
        optimum: 0.0,
        residuals: |x, out| {
            for t in (1..=13).map(|i| 0.1 * f64::from(i)) {
                let y = (-t).exp() - 5.0 * (-10.0 * t).exp() + 3.0 * (-4.0 * t).exp();
                let (a, b) = ((-x[0] * t).exp(), (-x[1] * t).exp());
                out.push(x[2] * a - x[3] * b + x[5] * (-x[4] * t).exp() - y);
            }
        },
    },
    Mgh {
        name: "Osborne 2",
        residual_count: 65,
        start: &[1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5],
        optimum: 4.013_77e-2,
        residuals: |x, out| {
            for (i, y) in (0..).zip(OSBORNE_2) {
                let t = f64::from(i) / 10.0;
                let peak = |k: usize| x[k] * (-(-x[k + 7] + t).square() * x[k + 4]).exp();
                out.push(-(x[0] * (-x[4] * t).exp() + peak(1) + peak(2) + peak(3)) + y);
            }
        },
    },
];

/// Two problems as Ceres has them: Gulf with the product that the paper misprints for a
/// difference (which leaves it without a zero), Jennrich-Sampson from another start.
pub(crate) const AS_IN_CERES: [Mgh; 2] = [
    Mgh {
        name: "Gulf",
        residual_count: 100,
        start: &[5.0, 2.5, 0.15],
        optimum: 0.0,
        residuals: |x, out| {
            for i in (1..=100).map(f64::from) {
                let t = i / 100.0;
                let y = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
                out.push((-(x[1] * (y * 100.0 * i)).abs().powd(x[2]) / x[0]).exp() - t);
            }
        },
    },
    Mgh {
        name: "Jennrich-Sampson",
        residual_count: 10,
        start: &[1.0, 1.0],
        optimum: 124.362,
        residuals: PROBLEMS[5].residuals,
    },
];

const BARD: [f64; 15] =
    [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];

const GAUSSIAN: [f64; 15] = [
    0.0009, 0.0044, 0.0175, 0.0540, 0.1295, 0.2420, 0.3521, 0.3989, 0.3521, 0.2420, 0.1295, 0.0540,
    0.0175, 0.0044, 0.0009,
];

const MEYER: [f64; 16] = [
    34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0,
    5147.0, 4427.0, 3820.0, 3307.0, 2872.0,
];

const KOWALIK_Y: [f64; 11] =
    [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];

const KOWALIK_U: [f64; 11] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];

const OSBORNE_1: [f64; 33] = [
    0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685,
    0.658, 0.628, 0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448,
    0.438, 0.431, 0.424, 0.420, 0.414, 0.411, 0.406,
];

const OSBORNE_2: [f64; 65] = [
    1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608,
    0.655, 0.616, 0.606, 0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661,
    0.612, 0.558, 0.533, 0.495, 0.500, 0.423, 0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428,
    0.429, 0.523, 0.562, 0.607, 0.653, 0.672, 0.708, 0.633, 0.668, 0.645, 0.632, 0.591, 0.559,
    0.597, 0.625, 0.739, 0.710, 0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098, 0.054,
];
