//! NIST StRD non-linear regression: 27 problems, two starts each, certified to 11 digits.

use std::f64::consts::PI;
use std::path::PathBuf;

use least_squares::Problem;
use nalgebra::{DMatrix, DVector};

use super::dual::Dual;

/// Correct digits of the worst parameter from which a start counts as solved.
pub(crate) const GOAL_DIGITS: f64 = 6.0;
/// Mean of those digits over all starts: the best peer measured, `SciPy`'s `trf`, reaches it.
pub(crate) const GOAL_MEAN: f64 = 9.3;

/// Prediction from parameters and predictors.
type Model = fn(&[Dual], &[f64]) -> Dual;

/// Every problem in NIST's order of difficulty, with its model.
pub(crate) const MODELS: [(&str, Model); 27] = [
    ("Misra1a", |b, x| b[0] * (-(-b[1] * x[0]).exp() + 1.0)),
    ("Chwirut2", |b, x| (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])),
    ("Chwirut1", |b, x| (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])),
    ("Lanczos3", lanczos),
    ("Gauss1", gauss),
    ("Gauss2", gauss),
    ("DanWood", |b, x| b[0] * Dual::from(x[0]).powd(b[1])),
    ("Misra1b", |b, x| b[0] * (-(b[1] * x[0] / 2.0 + 1.0).powi(-2) + 1.0)),
    ("Kirby2", |b, x| polynomial(&b[..3], x[0]) / denominator(&b[3..], x[0])),
    ("Hahn1", |b, x| polynomial(&b[..4], x[0]) / denominator(&b[4..], x[0])),
    ("Nelson", |b, x| b[0] - b[1] * x[0] * (-b[2] * x[1]).exp()),
    ("MGH17", |b, x| b[0] + b[1] * (-b[3] * x[0]).exp() + b[2] * (-b[4] * x[0]).exp()),
    ("Lanczos1", lanczos),
    ("Lanczos2", lanczos),
    ("Gauss3", gauss),
    ("Misra1c", |b, x| b[0] * (-(b[1] * 2.0 * x[0] + 1.0).powd(Dual::from(-0.5)) + 1.0)),
    ("Misra1d", |b, x| b[0] * b[1] * x[0] / (b[1] * x[0] + 1.0)),
    ("Roszman1", |b, x| b[0] - b[1] * x[0] - (b[2] / (-b[3] + x[0])).atan() / PI),
    ("ENSO", enso),
    ("MGH09", |b, x| b[0] * (b[1] * x[0] + x[0] * x[0]) / (b[2] * x[0] + b[3] + x[0] * x[0])),
    ("Thurber", |b, x| polynomial(&b[..4], x[0]) / denominator(&b[4..], x[0])),
    ("BoxBOD", |b, x| b[0] * (-(-b[1] * x[0]).exp() + 1.0)),
    ("Rat42", |b, x| b[0] / ((b[1] - b[2] * x[0]).exp() + 1.0)),
    ("MGH10", |b, x| b[0] * (b[1] / (b[2] + x[0])).exp()),
    ("Eckerle4", |b, x| b[0] / b[1] * (((-b[2] + x[0]) / b[1]).square() * -0.5).exp()),
    ("Rat43", |b, x| b[0] / ((b[1] - b[2] * x[0]).exp() + 1.0).powd(Dual::from(1.0) / b[3])),
    ("Bennett5", |b, x| b[0] * (b[1] + x[0]).powd(Dual::from(-1.0) / b[2])),
];

fn lanczos(b: &[Dual], x: &[f64]) -> Dual {
    let term = |k: usize| b[k] * (-b[k + 1] * x[0]).exp();
    term(0) + term(2) + term(4)
}

fn gauss(b: &[Dual], x: &[f64]) -> Dual {
    let peak = |k: usize| b[k] * (-((-b[k + 1] + x[0]) / b[k + 2]).square()).exp();
    b[0] * (-b[1] * x[0]).exp() + peak(2) + peak(5)
}

fn enso(b: &[Dual], x: &[f64]) -> Dual {
    let turn = 2.0 * PI * x[0];
    let wave = |period: Dual, c: Dual, s: Dual| {
        let angle = Dual::from(turn) / period;
        c * angle.cos() + s * angle.sin()
    };
    b[0] + wave(Dual::from(12.0), b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])
}

fn polynomial(b: &[Dual], x: f64) -> Dual {
    b.iter().rev().fold(Dual::from(0.0), |sum, c| sum * x + *c)
}

fn denominator(b: &[Dual], x: f64) -> Dual {
    polynomial(b, x) * x + 1.0
}

/// One data set with what NIST certifies about it.
pub(crate) struct Nist {
    model: Model,
    /// Start 1 and start 2.
    pub(crate) starts: [DVector<f64>; 2],
    pub(crate) certified: DVector<f64>,
    pub(crate) certified_sigma: DVector<f64>,
    response: Vec<f64>,
    predictors: Vec<Vec<f64>>,
}

impl Nist {
    /// Reads `fixtures/least-squares/nist-strd/<name>.dat`.
    pub(crate) fn read(name: &'static str, model: Model) -> Self {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("../../fixtures/least-squares/nist-strd")
            .join(format!("{name}.dat"));
        let text = std::fs::read_to_string(&path).expect("fixture is committed");
        let lines: Vec<&str> = text.lines().collect();
        let section = |title: &str| {
            let header = lines.iter().find(|l| l.contains(title)).expect("header names its parts");
            let numbers: Vec<usize> = header[header.find("(lines").expect("line range")..]
                .split(|c: char| !c.is_ascii_digit())
                .filter_map(|s| s.parse().ok())
                .collect();
            &lines[numbers[0] - 1..numbers[1]]
        };
        let parameters: Vec<Vec<f64>> = section("Starting Values")
            .iter()
            .map(|l| numbers(l.split_once('=').expect("b = values").1))
            .collect();
        let column =
            |k: usize| DVector::from_iterator(parameters.len(), parameters.iter().map(|p| p[k]));
        let data: Vec<Vec<f64>> = section("Data   ").iter().map(|l| numbers(l)).collect();
        let logarithmic = name == "Nelson";
        Self {
            model,
            starts: [column(0), column(1)],
            certified: column(2),
            certified_sigma: column(3),
            response: data.iter().map(|d| if logarithmic { d[0].ln() } else { d[0] }).collect(),
            predictors: data.iter().map(|d| d[1..].to_vec()).collect(),
        }
    }

    fn predict(&self, at: &DVector<f64>) -> impl Iterator<Item = Dual> {
        let parameters = Dual::parameters(at.as_slice());
        self.predictors.iter().map(move |x| (self.model)(&parameters, x))
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|t| t.parse().expect("a number")).collect()
}

impl Problem for Nist {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.response.len()
    }

    fn tangent_dim(&self) -> usize {
        self.certified.len()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (row, predicted) in self.predict(at).enumerate() {
            out[row] = self.response[row] - predicted.value;
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (row, predicted) in self.predict(at).enumerate() {
            for column in 0..at.len() {
                out[(row, column)] = -predicted.slope[column];
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        format!("b{}", index + 1)
    }
}

/// Digits NIST certifies.
const CERTIFIED_DIGITS: f64 = 11.0;

/// Correct digits of the worst parameter: `−log₁₀ |b − c| / |c|`, from 0 to 11.
pub(crate) fn log_relative_error(estimate: &DVector<f64>, certified: &DVector<f64>) -> f64 {
    estimate
        .iter()
        .zip(certified.iter())
        .map(|(b, c)| -((b - c) / c).abs().log10())
        .map(|digits| if digits.is_nan() { 0.0 } else { digits.clamp(0.0, CERTIFIED_DIGITS) })
        .fold(CERTIFIED_DIGITS, f64::min)
}
