use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::MachineProblem;
use crate::case::{CASE_FILE, Document, Folder, ReadOptions};
use crate::file::InputFile;
use crate::{Case, Error, read_case_with};

/// Name of the file that makes a folder a machine.
const MACHINE_FILE: &str = "machine.toml";

/// What the axes of a machine do to whatever is measured on it.
const GEOMETRY: [&str; 2] = ["axis-scale", "squareness"];

/// Cases that were measured on one machine.
#[derive(Debug)]
pub struct Machine {
    pub(super) path: PathBuf,
    pub(super) name: Option<String>,
    /// Ids of effects that are the machine's.
    pub(super) shared: Vec<String>,
    /// Whether the user said so.
    pub(super) is_said: bool,
    pub(super) members: Vec<Member>,
    /// The file itself.
    pub(super) input: InputFile,
}

/// One case of a machine.
#[derive(Debug)]
pub(super) struct Member {
    /// Its folder, as written.
    pub(super) name: String,
    pub(super) case: Case,
    /// The axis that a positioning run is about.
    pub(super) axis: Option<Axis>,
}

/// A linear axis of the machine.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Axis {
    #[serde(alias = "X")]
    X,
    #[serde(alias = "Y")]
    Y,
    #[serde(alias = "Z")]
    Z,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    name: Option<String>,
    shared: Option<Vec<String>>,
    #[serde(default)]
    case: Vec<CaseSettings>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseSettings {
    folder: String,
    axis: Option<Axis>,
}

/// Whether a folder is a machine with cases, and not a case itself.
#[must_use]
pub fn is_machine(path: &Path) -> bool {
    path.join(MACHINE_FILE).is_file() && !path.join(CASE_FILE).exists()
}

/// Reads the cases that `machine.toml` of a folder lists.
///
/// # Errors
///
/// [`Error::Machine`], [`Error::Case`] with file and line; as [`read_case_with`].
pub fn read_machine(path: impl AsRef<Path>, options: ReadOptions) -> Result<Machine, Error> {
    let path = path.as_ref();
    let fail = |problem| Error::machine(&path.join(MACHINE_FILE), problem);
    let folder = Folder::open(path, options)?;
    let settings: Settings = Document::read(&folder, MACHINE_FILE)?.settings()?;
    if settings.case.len() < 2 {
        return Err(fail(MachineProblem::TooFewCases { found: settings.case.len() }));
    }
    let (mut seen, mut members) = (BTreeSet::new(), Vec::new());
    for CaseSettings { folder: name, axis } in settings.case {
        let is_inside = Path::new(&name).components().all(|c| matches!(c, Component::Normal(_)));
        if !(is_inside || options.allow_outside) {
            return Err(fail(MachineProblem::Outside { folder: name }));
        }
        let case = read_case_with(path.join(&name), options)?;
        let real = path.join(&name).canonicalize().unwrap_or_else(|_| path.join(&name));
        if !seen.insert(real) {
            return Err(fail(MachineProblem::Twice { folder: name }));
        }
        members.push(Member { name, case, axis });
    }
    let input = folder.ledger().inputs().remove(0);
    let is_said = settings.shared.is_some();
    let shared = settings.shared.unwrap_or_else(|| GEOMETRY.map(str::to_owned).to_vec());
    Ok(Machine { path: path.to_owned(), name: settings.name, shared, is_said, members, input })
}

impl Machine {
    /// Every file that was read for it, those of a case by its folder.
    #[must_use]
    pub fn inputs(&self) -> Vec<InputFile> {
        let own = |member: &Member| {
            let name = member.name.clone();
            let file = move |input: &InputFile| InputFile {
                file: format!("{name}/{}", input.file),
                ..input.clone()
            };
            member.case.inputs.iter().map(file).collect::<Vec<_>>()
        };
        std::iter::once(self.input.clone()).chain(self.members.iter().flat_map(own)).collect()
    }

    pub(super) fn fail(&self, problem: MachineProblem) -> Error {
        Error::machine(&self.path.join(MACHINE_FILE), problem)
    }
}

impl Axis {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}
