use std::sync::Arc;
use std::time::Instant;

use model_discrepancy::Model;
use serde::Serialize;

use crate::conformity::{LimitDecision, decisions};
use crate::estimates::{self, Estimates};
use crate::measured::{Fitted, Observation};
use crate::monte_carlo::{MonteCarlo, monte_carlo};
use crate::noise_test::{Repeats, repeats, scatter_warning};
use crate::plausible::plausible;
use crate::residual::Residual;
use crate::suspect::{Suspect, examine};
use crate::{Case, Error, Header, IntervalWidth};

/// Answer of `truing solve`; serialises as its JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Solved {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// How long it took; `None` leaves it out of the JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<SolveTiming>,
    /// What was solved for.
    #[serde(serialize_with = "estimates::serialize")]
    pub estimates: Arc<dyn Estimates>,
    /// What makes 95 % intervals of its standard uncertainties.
    pub interval: IntervalWidth,
    /// Residual of the observations that were fitted.
    pub residual: Residual,
    /// Residual of those that were only judged; `None` where there are none.
    pub check: Option<Residual>,
    /// Whether repeats agree better with each other than with the model; `None` where no place is
    /// visited again.
    pub lack_of_fit: Option<Repeats>,
    /// How the numbers scatter where the data are drawn anew; `None` where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monte_carlo: Option<MonteCarlo>,
    /// What is decided of the results that `[conformity] limits` names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conformity: Vec<LimitDecision>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
    /// Mistakes in the input that the data bear out; the warnings tell them.
    #[serde(skip)]
    pub suspects: Vec<Suspect>,
    #[serde(skip)]
    observations: Vec<Observation>,
}

/// Wall-clock times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SolveTiming {
    /// Reading the case.
    pub read_s: f64,
    /// Solving it.
    pub solve_s: f64,
}

/// Fits the declared model of a case.
///
/// # Errors
///
/// [`Error`] of the kind; [`Error::is_undetermined`] where the data leave something free.
pub fn solve(case: &Case) -> Result<Solved, Error> {
    let started = Instant::now();
    let fitted = case.fit()?;
    let suspects = examine(case, &fitted)?.suspects;
    let Fitted { estimates, observations, unit, degrees_of_freedom, chi2_per_dof, warnings } =
        fitted;
    let components = case.measured.words().components.len().max(1);
    let of = |fitted: bool| {
        Residual::of(observations.iter().filter(|o| o.fitted == fitted), components, unit)
    };
    let check = Some(of(false)).filter(|check| check.n > 0);
    let residual = of(true).judged(degrees_of_freedom, chi2_per_dof, &observations);
    let (lack_of_fit, doubt) = repeats(case, observations.len());
    let doubtful = plausible(&*estimates, None).err().map(|e| e.to_string());
    let scatter = scatter_warning(residual.chi2_per_dof, residual.chi2_interval);
    let estimated = (case.measured.known_before())
        .or_else(|| Some(degrees_of_freedom).filter(|_| chi2_per_dof.is_none()));
    let interval = IntervalWidth::new(estimated);
    Ok(Solved {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/solve/1", case),
        timing: Some(SolveTiming { read_s: case.read_s, solve_s: started.elapsed().as_secs_f64() }),
        residual,
        check,
        conformity: decisions(case, &*estimates, interval)?,
        estimates,
        interval,
        observations,
        monte_carlo: None,
        lack_of_fit,
        warnings: (suspects.iter().map(Suspect::warning))
            .chain(case.warnings.iter().cloned())
            .chain(warnings)
            .chain(scatter)
            .chain(doubt)
            .chain(doubtful)
            .collect(),
        suspects,
    })
}

/// Fits the declared model, and as often as asked for with its data drawn anew.
///
/// # Errors
///
/// As of [`solve`] and [`monte_carlo`](crate::monte_carlo()).
pub fn solve_drawn(case: &Case, draws: usize) -> Result<Solved, Error> {
    let mut solved = solve(case)?;
    let drawn = monte_carlo(case, draws)?;
    solved.warnings.extend(drawn.warning());
    solved.monte_carlo = Some(drawn);
    Ok(solved)
}

impl Solved {
    /// Residual per row of the layout of the loop's model.
    pub(crate) fn residual_rows(&self, model: &dyn Model) -> Vec<f64> {
        let residual = |row: &model_discrepancy::Row| {
            let observation = self.observations.get(row.observation);
            observation.and_then(|o| o.residual.get(row.component)).copied().unwrap_or(0.0)
        };
        model.declared().layout.rows.iter().map(residual).collect()
    }
}
