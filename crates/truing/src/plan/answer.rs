//! What the loop said of the case that a measurement is planned for.

use std::path::Path;

use model_discrepancy::Model;
use serde::Deserialize;

use super::problem::PlanProblem;
use crate::carry::CarryProblem;
use crate::file::{InputFile, MAX_BYTES, read_bytes};
use crate::{Case, Error, close_loop};

/// What `truing loop --json` prints, as far as a plan goes by it.
#[derive(Debug, Deserialize)]
pub(super) struct LoopAnswer {
    kind: String,
    inputs: Vec<Input>,
    pub(super) steps: Vec<Step>,
    pub(super) not_observable: Vec<Unseen>,
    residual: Scatter,
    /// The file that it was read from.
    #[serde(skip)]
    pub(super) input: Option<InputFile>,
}

#[derive(Debug, Deserialize)]
struct Input {
    file: String,
    sha256: String,
}

/// One accepted effect.
#[derive(Debug, Deserialize)]
pub(super) struct Step {
    pub(super) effect: String,
    #[serde(default)]
    pub(super) subject: Option<String>,
    pub(super) parameters: Vec<Amplitude>,
    /// Ids, with a subject only beside one of the same id.
    #[serde(default)]
    indistinguishable_from: Vec<String>,
    #[serde(default)]
    rivals: Vec<String>,
    #[serde(default)]
    pub(super) separate_by: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Amplitude {
    pub(super) name: String,
    pub(super) value: Option<f64>,
}

/// One effect that the data do not show.
#[derive(Debug, Deserialize)]
pub(super) struct Unseen {
    pub(super) effect: String,
    #[serde(default)]
    pub(super) aliased_with: Vec<String>,
    #[serde(default)]
    pub(super) separate_by: Option<String>,
}

impl Unseen {
    /// What would show it, or else what it does not differ from.
    pub(super) fn advice(&self) -> Option<String> {
        let same = || {
            let with = self.aliased_with.join(" and ");
            (!with.is_empty())
                .then(|| format!("{} does what {with} do, and is in these", self.effect))
        };
        self.separate_by.clone().or_else(same)
    }
}

#[derive(Debug, Deserialize)]
struct Scatter {
    rms: f64,
    n: usize,
    dof: usize,
}

impl Step {
    pub(super) fn label(&self) -> String {
        match &self.subject {
            Some(subject) => format!("{} [{subject}]", self.effect),
            None => self.effect.clone(),
        }
    }

    /// Rivals by label; of an answer that has none, by what it has.
    pub(super) fn rivals(&self) -> &[String] {
        if self.rivals.is_empty() { &self.indistinguishable_from } else { &self.rivals }
    }
}

impl LoopAnswer {
    /// The answer in a file, or that of a loop that is closed for it.
    pub(super) fn of(case: &Case, path: Option<&Path>) -> Result<Self, Error> {
        let answer = if let Some(path) = path {
            read(case, path)?
        } else {
            let closed = serde_json::to_value(close_loop(case)?);
            let closed = closed.expect("an answer is plain data");
            serde_json::from_value(closed).expect("an answer of the loop has what one reads")
        };
        match answer.steps.iter().find(|step| step.effect.starts_with("input:")) {
            Some(step) => {
                let effect = step.effect.clone();
                Err(Error::plan(&case.path, PlanProblem::WrongInput { effect }))
            }
            None => Ok(answer),
        }
    }

    /// Standard uncertainty of one scalar residual, found from what the final model leaves, where
    /// an observation has `components` of them.
    pub(super) fn noise(&self, model: &dyn Model) -> f64 {
        let rows = &model.declared().layout.rows;
        let components = rows.iter().filter(|row| row.reported).map(|row| row.component + 1).max();
        let components = components.unwrap_or(1);
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let [n, dof, components] =
            [self.residual.n, self.residual.dof.max(1), components.max(1)].map(|n| n as f64);
        (self.residual.rms * (n / dof / components).sqrt()).max(f64::MIN_POSITIVE)
    }
}

fn read(case: &Case, path: &Path) -> Result<LoopAnswer, Error> {
    let fail = |problem| Error::carry(path, problem);
    let text = read_bytes(path, MAX_BYTES)
        .map_err(|problem| fail(CarryProblem::Unreadable { problem }))?;
    let mut answer: LoopAnswer = serde_json::from_slice(&text).map_err(|source| {
        fail(if source.is_data() {
            CarryProblem::NotAnAnswer { source }
        } else {
            CarryProblem::NotJson { source }
        })
    })?;
    if answer.kind != case.kind {
        return Err(fail(CarryProblem::OtherKind { found: answer.kind, expected: case.kind }));
    }
    answer.input = Some(InputFile::given(path, &text));
    // Settings may change between a loop and a plan, the tables may not.
    let is_table = |file: &str| Path::new(file).extension().is_some_and(|e| e == "csv");
    let other = case.inputs.iter().filter(|input| is_table(&input.file)).find(|input| {
        !answer.inputs.iter().any(|i| i.file == input.file && i.sha256 == input.sha256)
    });
    match other {
        Some(input) => Err(Error::plan(path, PlanProblem::OtherData { file: input.file.clone() })),
        None => Ok(answer),
    }
}
