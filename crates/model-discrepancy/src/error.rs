use least_squares::{FreeDirection, Report, SolveError};

/// Why the loop could not be closed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoopError {
    /// The data leave parameters of the declared model free.
    #[error(
        "the data do not determine the declared model; free: {}; add data that see it",
        directions.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
    )]
    Unobservable {
        /// One per free direction.
        directions: Vec<FreeDirection>,
    },
    /// The search for the declared model's parameters did not converge.
    #[error("the fit of the declared model did not converge: {report}")]
    NotConverged {
        /// How far it came.
        report: Box<Report>,
    },
    /// No step lowers the cost of the declared model although its derivatives promise it.
    #[error(
        "the fit of the declared model stalled: its residuals do not follow their derivatives \
         ({report}); check the data for values that fit no model, or start closer"
    )]
    Stalled {
        /// How far it came.
        report: Box<Report>,
    },
    /// A residual of the declared model, or a derivative of it, is not finite.
    #[error(
        "residual {} of the declared model is {value} where its fit starts, or a derivative of \
         it: check the data for huge values, and for what lies beyond the model's reach",
        row + 1
    )]
    NotFinite {
        /// Among the fitted rows, from 0.
        row: usize,
        /// What it is.
        value: f64,
    },
    /// The solver does not take the fit in the form it was given: a mistake of the model.
    #[error("the declared model makes no least-squares problem; please report the case")]
    NoProblem,
    /// There is nothing left to judge a model by.
    #[error(
        "{groups} fitted groups with {rows} residuals cannot judge a model of {parameters} parameters; measure at least {needed} groups"
    )]
    TooFewGroups {
        /// Groups with the role `Fit`.
        groups: usize,
        /// Their residuals.
        rows: usize,
        /// Parameters of the declared model.
        parameters: usize,
        /// Fewest groups for which the loop makes sense.
        needed: usize,
    },
    /// A row refers to an observation, or an observation to a group, that does not exist.
    #[error("row {} refers to an observation or group that does not exist", row + 1)]
    InconsistentLayout {
        /// Index of the row.
        row: usize,
    },
    /// What a model says beside its layout does not fit it.
    #[error("the model's `{field}` does not fit its layout; it needs {needed}")]
    InconsistentModel {
        /// Field of [`Declared`](crate::Declared).
        field: &'static str,
        /// What it must give.
        needed: &'static str,
    },
    /// An effect that is to be seen in every design moves nothing.
    #[error(
        "the effect `{effect}` moves no residual by its parameter `{parameter}`; give its tangent, or say with `Scope::SomeDesigns` that some designs do not show it"
    )]
    EmptyColumn {
        /// Id of the effect.
        effect: String,
        /// Name of the parameter.
        parameter: String,
    },
    /// A standard uncertainty is not positive and finite.
    #[error("row {} has a standard uncertainty of {sigma}; it must be positive and finite", row + 1)]
    InvalidSigma {
        /// Index of the row.
        row: usize,
        /// Its value.
        sigma: f64,
    },
    /// A covariate has the wrong number of values or one that is not finite.
    #[error("covariate {name} needs {expected} finite values, one per observation")]
    InvalidCovariate {
        /// Its name.
        name: String,
        /// Number of observations.
        expected: usize,
    },
}

impl LoopError {
    pub(crate) fn declared<P>(error: SolveError<P>) -> Self {
        match error {
            SolveError::Unobservable { directions, .. } => Self::Unobservable { directions },
            SolveError::NotConverged { report, .. } => Self::NotConverged { report },
            SolveError::Stalled { report, .. } => Self::Stalled { report },
            SolveError::NonFiniteResidual { row, value }
            | SolveError::NonFiniteJacobian { row, value, .. } => Self::NotFinite { row, value },
            // Blocks, held directions, priors and losses, none of which the loop uses.
            _ => Self::NoProblem,
        }
    }
}
