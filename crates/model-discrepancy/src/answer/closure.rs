//! What the loop found.

use nalgebra::DMatrix;

use crate::{Column, EmpiricalCorrection, LackOfFit, Remaining, State};

/// Result of closing the loop on one data set.
#[derive(Clone, Debug)]
pub struct Closure {
    /// The declared model alone.
    pub before: ErrorSummary,
    /// The model with every accepted effect.
    pub after: ErrorSummary,
    /// Accepted effects, in the order accepted.
    pub steps: Vec<Step>,
    /// How every candidate scored in every pass, for the report.
    pub passes: Vec<Pass>,
    /// The conclusion.
    pub verdict: Verdict,
    /// Structure left in the residual.
    pub remaining: Vec<Remaining>,
    /// Whether repeats agree better with each other than with the final model; `None` where no
    /// place is visited again.
    pub lack_of_fit: Option<LackOfFit>,
    /// The one observation of the check groups that lies far off what the fit predicts, where all others of at least
    /// three are predicted well: a bad reading, which the fit cannot name as it has not seen it.
    pub odd_check: Option<usize>,
    /// Effects that this design cannot see.
    pub not_observable: Vec<NotObservable>,
    /// Confusability of the candidates: `|cos|` of the largest principal angle between
    /// projected tangents; row and column order is `confusable_ids`.
    pub confusability: DMatrix<f64>,
    /// Ids (with subject) of the rows of `confusability`.
    pub confusable_ids: Vec<String>,
    /// Final base parameters and amplitudes.
    pub state: State,
    /// Covariance of `[base, amplitudes of the steps, empirical coefficients, places at which
    /// effects of the steps were found]`, internal units.
    ///
    /// Scaled by the variance factor where sigma was not declared, or was declared too small.
    pub covariance: DMatrix<f64>,
    /// What each row and column of `covariance` is about.
    pub columns: Vec<Column>,
    /// `∂ residuals_after / ∂ columns`, one row per row of the layout.
    pub jacobian: DMatrix<f64>,
    /// Factor from the declared variances to those that `covariance` goes by: 1 where sigma was
    /// declared and is large enough.
    pub variance_factor: f64,
    /// Degrees of freedom of `variance_factor`; `None` where it is 1 by declaration.
    pub degrees_of_freedom: Option<usize>,
    /// The final model with one step replaced by another name: one per effect that explains the data as
    /// well as a step.
    pub alternatives: Vec<Solution>,
    /// Empirical corrections of the final model, in the order added.
    pub empirical: Vec<EmpiricalCorrection>,
    /// Residual per row of the declared model, in report units, all groups.
    pub residuals_before: Vec<f64>,
    /// Residual per row of the final model, in report units, all groups.
    pub residuals_after: Vec<f64>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// A model with effects, fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Base parameters and amplitudes.
    pub state: State,
    /// What is free in it.
    pub columns: Vec<Column>,
}

impl Solution {
    /// Whether nothing but the declared parameters is free.
    #[must_use]
    pub fn is_declared(&self) -> bool {
        self.columns.iter().all(|column| matches!(column, Column::Base(_)))
    }

    /// Every free amplitude, as indices of the effect and of the parameter.
    #[must_use]
    pub fn amplitudes(&self) -> Vec<(usize, usize)> {
        let amplitude = |column: &Column| match *column {
            Column::Amplitude { effect, parameter } => Some((effect, parameter)),
            _ => None,
        };
        self.columns.iter().filter_map(amplitude).collect()
    }
}

impl Closure {
    /// The final model.
    #[must_use]
    pub fn solution(&self) -> Solution {
        Solution { state: self.state.clone(), columns: self.columns.clone() }
    }
}

/// Error of one model on the data that made it and on data it never saw.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSummary {
    /// Root mean square residual per observation on fitted groups.
    pub train_rms: f64,
    /// Root mean square residual per observation on groups left out.
    pub held_out_rms: f64,
    /// Standard error of `held_out_rms` from its spread over groups.
    pub held_out_std: f64,
    /// How the held-out error was obtained.
    pub hold_out: HoldOut,
    /// Unit of both.
    pub unit: String,
    /// χ² over degrees of freedom on what was fitted, when sigma was declared; of the readings where
    /// rows are means of several.
    pub chi2_per_dof: Option<f64>,
    /// Where `chi2_per_dof` lies 999 times in 1000 where the noise is as declared.
    pub chi2_interval: Option<[f64; 2]>,
}

/// How an error on unseen data was obtained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldOut {
    /// On the groups the user set aside.
    CheckGroups,
    /// Groups left out in turn, the choice of effects repeated without them.
    Nested,
    /// Groups left out in turn; too few to repeat the choice without them.
    LeaveOneOut,
}

/// One accepted effect.
#[derive(Clone, Debug)]
pub struct Step {
    /// Catalogue id, or `covariate:<column>`.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// Amplitudes of the final model, in report units.
    pub parameters: Vec<ParameterEstimate>,
    /// Significance at the time it was accepted, before correction for the catalogue's size.
    pub p_value: f64,
    /// Error on groups left out in turn once this effect is in the model.
    pub held_out_rms: f64,
    /// Error on fitted groups once this effect is in the model.
    pub train_rms: f64,
    /// Other effects that explain the data as well.
    pub indistinguishable_from: Vec<String>,
    /// All of these with their subjects, as `id [subject]`.
    pub rivals: Vec<String>,
    /// The measurement that would tell them apart.
    pub separate_by: Option<String>,
    /// How often this effect, or one of its rivals, is found again.
    pub stability: Stability,
}

/// Shares of the repetitions of a choice that find the same effect, or one of its rivals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stability {
    /// Of those without some groups; `None` where there are too few groups, or repetitions are off.
    pub resampled: Option<f64>,
    /// Of those with every reading moved within [`Declared::resolution`](crate::Declared::resolution);
    /// `None` where repetitions are off.
    pub perturbed: Option<f64>,
}

/// One amplitude, in report units.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimate {
    /// Name.
    pub name: String,
    /// Estimate.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty.
    pub std: f64,
}

/// How the candidates scored in one pass.
#[derive(Clone, Debug)]
pub struct Pass {
    /// All candidates, best first.
    pub scores: Vec<Score>,
}

/// How one candidate scored.
#[derive(Clone, Debug)]
pub struct Score {
    /// Id, with the subject in brackets where there is one.
    pub label: String,
    /// Share of its tangent that the base model absorbs, 0 to 1.
    pub absorbed: f64,
    /// F statistic at group level.
    pub f_statistic: f64,
    /// Significance, before correction.
    pub p_value: f64,
    /// Error on groups left out in turn, were it added.
    pub held_out_rms: f64,
    /// Smallest amplitude that the F test alone finds 9 times in 10, as rms residual in report units.
    pub detectable_rms: f64,
    /// Why it was not added, or that it was.
    pub outcome: Outcome,
}

/// What became of a candidate in a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Added to the model.
    Added,
    /// As good as the one added.
    Rival,
    /// Significant, but another one was better.
    Weaker,
    /// Not significant.
    NotSignificant,
    /// Significant, but the error on unseen groups did not fall.
    DidNotGeneralise,
    /// The design cannot see it.
    NotObservable,
}

/// What the loop concludes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The declared model explains the data.
    NothingMissing,
    /// The model with the added effects explains the data.
    Explained,
    /// Something is left that has no name here.
    StructureRemains,
    /// No structure, but more noise than declared.
    NoiseLargerThanDeclared,
}

/// An effect the design cannot see.
#[derive(Clone, Debug, PartialEq)]
pub struct NotObservable {
    /// Catalogue id.
    pub effect: String,
    /// Base parameters that absorb it.
    pub aliased_with: Vec<String>,
    /// The measurement that would make it visible.
    pub separate_by: Option<String>,
}
