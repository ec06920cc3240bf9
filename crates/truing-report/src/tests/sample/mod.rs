//! Cases with the numbers and sizes of real ones; residuals are simulated, scores are made up.

mod four_displacements;
mod long_log;
mod photogrammetry;

use model_discrepancy::{
    Closure, Covariate, ErrorSummary, HoldOut, Layout, Outcome, ParameterEstimate, Quantity, Role,
    Row, Score, State,
};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{Evidence, ExtraPlot, Fact, ParameterRow, Published, ReportInput};

pub(crate) use four_displacements::four_displacements;
pub(crate) use long_log::long_log;
pub(crate) use photogrammetry::{nothing_missing, photogrammetry};

/// A case that owns what [`ReportInput`] borrows.
pub(crate) struct Sample {
    pub(crate) title: String,
    pub(crate) kind: &'static str,
    pub(crate) source: Option<String>,
    pub(crate) description: Vec<String>,
    pub(crate) measured: Vec<Fact>,
    pub(crate) declared: Vec<String>,
    pub(crate) parameters: Vec<ParameterRow>,
    pub(crate) layout: Layout,
    pub(crate) components: Vec<String>,
    pub(crate) residual: &'static str,
    pub(crate) group_noun: String,
    pub(crate) closure: Closure,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) plots: Vec<ExtraPlot>,
    pub(crate) published: Option<Published>,
    pub(crate) warnings: Vec<String>,
}

impl Sample {
    pub(crate) fn closed(&self) -> ReportInput<'_> {
        self.input(Evidence::Closed(&self.closure))
    }

    pub(crate) fn solved(&self) -> ReportInput<'_> {
        self.input(Evidence::Solved { residuals: &self.closure.residuals_before })
    }

    fn input<'a>(&'a self, evidence: Evidence<'a>) -> ReportInput<'a> {
        ReportInput {
            as_read: None,
            title: &self.title,
            kind: self.kind,
            source: self.source.as_deref(),
            mistakes: &[],
            description: &self.description,
            measured: &self.measured,
            declared: &self.declared,
            parameters: &self.parameters,
            layout: &self.layout,
            components: &self.components,
            residual: self.residual,
            group_noun: &self.group_noun,
            evidence,
            covariates: &self.covariates,
            plots: &self.plots,
            form: None,
            budget: None,
            published: self.published.as_ref(),
            story: None,
            simulated: false,
            warnings: &self.warnings,
        }
    }
}

/// Standard normal, near enough for a picture.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
}

fn strings(lines: &[&str]) -> Vec<String> {
    lines.iter().map(|l| (*l).to_string()).collect()
}

fn fact(name: &str, value: &str) -> Fact {
    Fact { name: name.into(), value: value.into() }
}

fn parameter(name: &str, unit: &str, value: f64, std: f64, after: (f64, f64)) -> ParameterRow {
    ParameterRow { name: name.into(), unit: unit.into(), value, std: Some(std), after: Some(after) }
}

fn estimate(name: &str, unit: &str, value: f64, std: f64) -> ParameterEstimate {
    ParameterEstimate { name: name.into(), unit: unit.into(), value, std }
}

fn score(label: &str, (f, p): (f64, f64), held_out: f64, absorbed: f64, outcome: Outcome) -> Score {
    Score {
        label: label.into(),
        absorbed,
        f_statistic: f,
        p_value: p,
        held_out_rms: held_out,
        detectable_rms: 0.3 * held_out / (1.0 - absorbed).max(1e-3).sqrt(),
        outcome,
    }
}

fn covariate(name: &str, values: Vec<f64>) -> Covariate {
    Covariate::recorded(name, Quantity::Other, values)
}

/// Similarities that fall off with the distance in the list.
fn confusability(n: usize, closeness: f64) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| {
        let apart = i32::try_from(i.abs_diff(j)).expect("few candidates");
        closeness.powi(apart)
    })
}

fn rms(layout: &Layout, residuals: &[f64], role: Role) -> f64 {
    let of_role = |row: &Row| layout.groups[layout.observations[row.observation]].role == role;
    let squares: Vec<f64> =
        layout.rows.iter().zip(residuals).filter(|(r, _)| of_role(r)).map(|(_, v)| v * v).collect();
    let observations = layout.observations.iter().filter(|g| layout.groups[**g].role == role);
    #[expect(clippy::cast_precision_loss, reason = "few observations")]
    let n = observations.count() as f64;
    (squares.iter().sum::<f64>() / n).sqrt()
}

fn error(train_rms: f64, held_out_rms: f64, hold_out: HoldOut, unit: &str) -> ErrorSummary {
    ErrorSummary {
        train_rms,
        held_out_rms,
        held_out_std: 0.11 * held_out_rms,
        hold_out,
        unit: unit.into(),
        chi2_per_dof: None,
        chi2_interval: None,
    }
}

fn no_state() -> State {
    State { base: DVector::zeros(0), amplitudes: Vec::new() }
}
