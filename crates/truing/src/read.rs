//! A case, read.

use std::path::{Path, PathBuf};
use std::time::Instant;

use model_discrepancy::{LoopError, Progress};

use crate::Error;
use crate::carry::{CarryProblem, Learnt};
use crate::case::{
    CASE_FILE, ConformitySettings, Document, Edit, Folder, Location, LoopSettings, Problem,
    Provenance, ReadOptions, nearest, quote,
};
use crate::file::{InputFile, digest};
use crate::kind::{Files, Kind};
use crate::kinds::KINDS;
use crate::machine::{MachineProblem, is_machine};
use crate::measured::Measured;
use crate::suspect::named_cause;

/// A case that was read and found usable in form.
#[derive(Debug)]
pub struct Case {
    pub(crate) path: PathBuf,
    pub(crate) kind: &'static str,
    /// What it was read from.
    pub(crate) files: Files,
    pub(crate) measured: Box<dyn Measured>,
    pub(crate) loop_settings: LoopSettings,
    /// What results are held against.
    pub(crate) conformity: ConformitySettings,
    /// Effects of another case that count as declared.
    pub(crate) learnt: Option<Learnt>,
    pub(crate) provenance: Option<Provenance>,
    pub(crate) inputs: Vec<InputFile>,
    pub(crate) notes: Vec<String>,
    pub(crate) warnings: Vec<String>,
    pub(crate) read_s: f64,
}

impl Case {
    /// Kind of the case, e.g. `frame-fit`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// The case with effects that were learnt on another one, taken as declared and fixed.
    ///
    /// [`close_loop`](crate::close_loop) then judges the declared model with and without them.
    ///
    /// # Errors
    ///
    /// [`Error::Carry`] where the other case is of another kind.
    pub fn carrying(mut self, learnt: Learnt) -> Result<Self, Error> {
        if learnt.kind != self.kind {
            let problem =
                CarryProblem::OtherKind { found: learnt.kind.clone(), expected: self.kind };
            return Err(Error::carry(&learnt.from, problem));
        }
        self.inputs.push(learnt.input.clone());
        self.learnt = Some(learnt);
        Ok(self)
    }

    /// The case, whose loop `progress` tells how far it is.
    #[must_use]
    pub fn watched(mut self, progress: &Progress) -> Self {
        self.loop_settings.progress = progress.clone();
        self
    }

    /// The case as it would be read with these changes to its files.
    pub(crate) fn with(&self, edits: &[Edit]) -> Result<Self, Error> {
        let files = self.files.with(edits);
        let mut reading = files.read()?;
        reading.loop_settings.progress = self.loop_settings.progress.clone();
        Ok(Self {
            path: self.path.clone(),
            kind: self.kind,
            files,
            measured: reading.measured,
            loop_settings: reading.loop_settings,
            conformity: self.conformity.clone(),
            learnt: self.learnt.clone(),
            provenance: self.provenance.clone(),
            inputs: self.inputs.clone(),
            notes: self.notes.clone(),
            warnings: self.warnings.clone(),
            read_s: self.read_s,
        })
    }

    pub(crate) fn loop_error(&self, source: LoopError) -> Error {
        Error::Loop { at: Box::new(Location::file(&self.path)), source }
    }

    /// Every file that was read for it, in the order read.
    #[must_use]
    pub fn inputs(&self) -> &[InputFile] {
        &self.inputs
    }

    /// How tables were understood that are not written as the format says: one line a file.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// SHA-256 of the lines that `sha256sum` prints for the inputs, sorted by name.
    #[must_use]
    pub fn sha256(&self) -> String {
        let mut lines: Vec<(&str, &str)> =
            self.inputs.iter().map(|i| (i.file.as_str(), i.sha256.as_str())).collect();
        lines.sort_unstable();
        let text =
            lines.iter().fold(String::new(), |text, (file, sha)| text + sha + "  " + file + "\n");
        digest(text.as_bytes())
    }

    /// Notes from reading it: dropped covariates, doubtful columns, unused files.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Reads a case folder.
///
/// # Errors
///
/// [`Error::Case`] with file, line and column of the first thing that is wrong.
pub fn read_case(path: impl AsRef<Path>) -> Result<Case, Error> {
    read_case_with(path, ReadOptions::default())
}

/// Reads a case folder with options.
///
/// # Errors
///
/// As [`read_case`].
pub fn read_case_with(path: impl AsRef<Path>, options: ReadOptions) -> Result<Case, Error> {
    let started = Instant::now();
    if is_machine(path.as_ref()) {
        return Err(Error::machine(path.as_ref(), MachineProblem::NotOneCase));
    }
    let folder = Folder::open(path.as_ref(), options)?;
    let document = Document::read(&folder, CASE_FILE)?;
    let kind = kind_of(&document)?;
    let files = Files { folder: folder.clone(), document, kind };
    let mut reading = files.read().map_err(|source| named_cause(&files, source))?;
    for table in folder.tables_besides(&reading.tables) {
        let table = quote(&table);
        reading.warnings.push(format!("{table} is not read by a case of kind {}", kind.name));
    }
    for workbook in folder.workbooks() {
        let workbook = quote(&workbook);
        reading.warnings.push(format!("{workbook} is a workbook and is not read; tables are CSV"));
    }
    let conformity = files.document.conformity()?;
    let provenance = Provenance::read(&folder, &mut reading.warnings);
    Ok(Case {
        path: path.as_ref().to_owned(),
        kind: kind.name,
        files,
        measured: reading.measured,
        loop_settings: reading.loop_settings,
        conformity,
        learnt: None,
        provenance,
        inputs: folder.ledger().inputs(),
        notes: folder.ledger().notes(),
        warnings: reading.warnings,
        read_s: started.elapsed().as_secs_f64(),
    })
}

fn kind_of(document: &Document) -> Result<&'static Kind, Error> {
    let name = document.kind()?;
    KINDS.iter().find(|kind| kind.name == name.get_ref()).ok_or_else(|| {
        let expected: Vec<String> = KINDS.iter().map(|kind| kind.name.to_owned()).collect();
        let found = name.get_ref().clone();
        let nearest = nearest(&found, expected.iter().map(String::as_str)).map(str::to_owned);
        let problem = Problem::UnknownKind { found, nearest, expected };
        Error::case(document.at(&name.span()), problem)
    })
}
