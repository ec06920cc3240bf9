use model_discrepancy::{Assessment, LoopError, MOST_SIMULATED, Role, Visibility, assess};
use serde::Serialize;

use crate::noise_test::Repeats;
use crate::residual::Residual;
use crate::solved::solve;
use crate::{Case, Error, Header, Suspect};

/// Answer of `truing check`; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checked {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// What there is.
    pub counts: Counts,
    /// Parameters of the declared model, which the data determine.
    pub parameters: Vec<Determined>,
    /// Columns that the loop searches for structure.
    pub covariates: Vec<String>,
    /// Whether the noise was declared.
    pub noise_declared: bool,
    /// Mistakes in the input that the data bear out.
    pub suspects: Vec<Suspect>,
    /// Residual of the observations that are fitted.
    pub residual: Residual,
    /// Whether repeats agree better with each other than with the model; `None` where no place is
    /// visited again.
    pub lack_of_fit: Option<Repeats>,
    /// Effects that would be found, and how large they must be.
    pub observable: Vec<ObservableEffect>,
    /// Effects that would not.
    pub not_observable: Vec<HiddenEffect>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// How much there is of everything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Observations: points, presses, poses.
    pub observations: usize,
    /// Groups that are fitted.
    pub fit_groups: usize,
    /// Groups that are only judged.
    pub check_groups: usize,
    /// Scalar equations of the fitted groups.
    pub equations: usize,
    /// Parameters of the declared model.
    pub parameters: usize,
    /// Equations minus parameters.
    pub dof: usize,
}

/// One parameter of the declared model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Determined {
    /// Name.
    pub name: String,
    /// Estimate.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// Standard uncertainty; `None` where the noise is unknown and nothing is redundant.
    pub std: Option<f64>,
}

/// An effect that would be found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObservableEffect {
    /// Catalogue id.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// Share of it that the declared model absorbs, 0 to 1.
    pub absorbed: f64,
    /// Smallest sizes that the loop names 9 times in 10.
    pub detectable: Vec<Detectable>,
    /// The same as rms residual over the observations, in the residual's unit.
    pub detectable_rms: f64,
    /// Effects that look exactly alike in these data.
    pub same_as: Vec<String>,
}

/// Smallest size of one amplitude that the loop names 9 times in 10.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detectable {
    /// Name of the amplitude.
    pub name: String,
    /// Its smallest detectable size.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// An effect that would not be found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HiddenEffect {
    /// Catalogue id.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// Parameters of the declared model that absorb it; empty where it leaves no trace at all.
    pub aliased_with: Vec<String>,
    /// The measurement that would make it visible.
    pub separate_by: Option<String>,
}

/// Says what a case can determine and what it cannot.
///
/// # Errors
///
/// As [`solve`](crate::solve): a declared model that the data leave free is an error that names
/// the free direction. Too few groups for the loop are a warning here.
pub fn check(case: &Case) -> Result<Checked, Error> {
    let solved = solve(case)?;
    let prepared = case.measured.prepare()?;
    let model = &*prepared.model;
    let mut warnings = solved.warnings;
    let assessments = match assess(model, &case.loop_settings.options()) {
        Ok(assessments) => assessments,
        Err(e @ LoopError::TooFewGroups { .. }) => {
            warnings.push(format!("the loop cannot be closed: {e}"));
            Vec::new()
        }
        Err(source) => return Err(case.loop_error(source)),
    };
    let mut checked = Checked {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/check/1", case),
        counts: Counts::of(model),
        parameters: (solved.estimates.parameters().into_iter())
            .map(|p| Determined { name: p.name, value: p.value, unit: p.unit, std: p.std })
            .collect(),
        covariates: prepared.covariates.iter().map(|c| c.name.clone()).collect(),
        noise_declared: model.declared().layout.sigma_declared,
        suspects: solved.suspects,
        residual: solved.residual,
        lack_of_fit: solved.lack_of_fit,
        observable: Vec::new(),
        not_observable: Vec::new(),
        warnings,
    };
    if checked.counts.equations > MOST_SIMULATED && !assessments.is_empty() {
        checked.warnings.push(NOT_SIMULATED.to_owned());
    }
    for assessment in assessments {
        checked.sort_in(assessment);
    }
    Ok(checked)
}

const NOT_SIMULATED: &str = "more equations than are simulated: smallest sizes are what the F test alone finds 9 times in \
                             10; the loop names an effect from a somewhat larger one on";

impl Checked {
    fn sort_in(&mut self, assessment: Assessment) {
        let Assessment { effect, subject, description, absorbed, sight } = assessment;
        match sight {
            Visibility::Visible { detectable, detectable_rms, same_as } => {
                let detectable = (detectable.into_iter())
                    .map(|(name, value, unit)| Detectable { name, value, unit })
                    .collect();
                self.observable.push(ObservableEffect {
                    effect,
                    subject,
                    description,
                    absorbed,
                    detectable,
                    detectable_rms,
                    same_as,
                });
            }
            Visibility::Hidden { aliased_with, separate_by } => {
                self.not_observable.push(HiddenEffect {
                    effect,
                    subject,
                    description,
                    aliased_with,
                    separate_by,
                });
            }
        }
    }
}

impl Counts {
    fn of(model: &dyn model_discrepancy::Model) -> Self {
        let layout = &model.declared().layout;
        let groups = |role: Role| layout.groups.iter().filter(|g| g.role == role).count();
        let role =
            |row: &model_discrepancy::Row| layout.groups[layout.observations[row.observation]].role;
        let equations = layout.rows.iter().filter(|row| role(row) != Role::Check).count();
        let parameters = model.declared().base.len();
        Self {
            observations: layout.observations.len(),
            fit_groups: groups(Role::Fit),
            check_groups: groups(Role::Check),
            equations,
            parameters,
            dof: equations.saturating_sub(parameters),
        }
    }
}
