use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::problem::CarryProblem;
use crate::Error;
use crate::file::{InputFile, read_bytes};

/// Largest answer read: one of a million touches has half of it.
const MAX_ANSWER_BYTES: u64 = 1 << 29;

/// Effects that the loop found on another case.
#[derive(Clone, Debug)]
pub struct Learnt {
    pub(crate) from: PathBuf,
    pub(crate) input: InputFile,
    pub(crate) kind: String,
    pub(crate) steps: Vec<LearntStep>,
}

/// What `truing loop --json` prints, as far as it is carried.
#[derive(Deserialize)]
struct Answer {
    kind: String,
    steps: Vec<LearntStep>,
}

/// One effect.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct LearntStep {
    pub(crate) effect: String,
    #[serde(default)]
    pub(crate) subject: Option<String>,
    /// Names the conditions under which the amplitudes count.
    #[serde(default)]
    pub(crate) description: Option<String>,
    pub(crate) parameters: Vec<LearntParameter>,
    #[serde(default)]
    pub(crate) indistinguishable_from: Vec<String>,
}

/// One amplitude, in report units.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct LearntParameter {
    pub(crate) name: String,
    pub(crate) value: Option<f64>,
    pub(crate) unit: String,
    #[serde(default)]
    pub(crate) std: Option<f64>,
}

/// Reads what `truing loop --json` printed for another case.
///
/// # Errors
///
/// [`Error::Carry`] for a file that cannot be read or holds something else.
pub fn read_learnt(path: impl AsRef<Path>) -> Result<Learnt, Error> {
    let from = path.as_ref().to_owned();
    let fail = |problem: CarryProblem| Error::carry(&from, problem);
    let text = read_bytes(&from, MAX_ANSWER_BYTES)
        .map_err(|problem| fail(CarryProblem::Unreadable { problem }))?;
    let input = InputFile::given(&from, &text);
    let answer: Answer = serde_json::from_slice(&text).map_err(|source| {
        fail(if source.is_data() {
            CarryProblem::NotAnAnswer { source }
        } else {
            CarryProblem::NotJson { source }
        })
    })?;
    Ok(Learnt { kind: answer.kind, steps: answer.steps, from, input })
}
