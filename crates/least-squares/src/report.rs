use std::fmt;

/// How a solution was reached, or how far the search came.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// Why the search stopped; `None` when it did not converge.
    pub termination: Option<Termination>,
    /// Searches made; more than one where the first gave no usable answer.
    pub searches: usize,
    /// Steps accepted, over all searches.
    pub iterations: usize,
    /// Calls of [`Problem::residuals`](crate::Problem::residuals).
    pub residual_evaluations: usize,
    /// Calls of [`Problem::jacobian`](crate::Problem::jacobian).
    pub jacobian_evaluations: usize,
    /// `½ Σ ρ` at the start.
    pub initial_cost: f64,
    /// `½ Σ ρ` at the end.
    pub final_cost: f64,
    /// Largest correlation of a Jacobian column with the residual, 0 to 1.
    pub gradient: f64,
    /// Independent directions among the free columns.
    pub rank: usize,
    /// Condition number of the whitened, column-scaled Jacobian.
    pub condition: f64,
    /// Residuals given.
    pub residuals_given: usize,
    /// Residuals that a robust loss did not reject.
    pub residuals_used: usize,
    /// Free tangent directions.
    pub parameters: usize,
}

/// Ways to succeed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Termination {
    /// The residual is orthogonal to every column of the Jacobian.
    Gradient,
    /// The full step is too short to matter.
    Step,
    /// The cost cannot fall any further.
    Cost,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.termination {
            Some(Termination::Gradient) => write!(f, "converged (gradient)")?,
            Some(Termination::Step) => write!(f, "converged (step)")?,
            Some(Termination::Cost) => write!(f, "converged (cost)")?,
            None => write!(f, "not converged")?,
        }
        writeln!(
            f,
            " after {} iterations in {} search{}, {} residual and {} Jacobian evaluations",
            self.iterations,
            self.searches,
            if self.searches == 1 { "" } else { "es" },
            self.residual_evaluations,
            self.jacobian_evaluations
        )?;
        writeln!(
            f,
            "cost {:.6e} -> {:.6e}, gradient correlation {:.1e}",
            self.initial_cost, self.final_cost, self.gradient
        )?;
        write!(
            f,
            "rank {} of {}, condition {:.1e}, {} of {} residuals used",
            self.rank, self.parameters, self.condition, self.residuals_used, self.residuals_given
        )
    }
}
