//! A kind of case, and files that are read as one.

use crate::Error;
use crate::case::{Document, Edit, Folder};
use crate::measured::{Fitted, Reading};
use crate::suspect::{Hypothesis, Readings, Typed};
use crate::uncertain::Uncertain;

/// One kind of case.
#[derive(Debug)]
pub(crate) struct Kind {
    /// Name, as in `case.toml`.
    pub(crate) name: &'static str,
    /// What it is for, one line.
    pub(crate) summary: &'static str,
    /// Reads the tables and settings of such a case.
    pub(crate) read: fn(&Folder, &Document) -> Result<Reading, Error>,
    /// What may be wrong with the input of such a case, the likeliest first; the fit of the case
    /// as it stands, where it has one.
    pub(crate) mistakes: fn(&Files, Option<&Fitted>) -> Vec<Hypothesis>,
    /// The table that holds a record of many samples, and the column of what they are samples of, where
    /// it has one.
    pub(crate) record: Option<(&'static str, &'static str)>,
    /// The table of touches of a part, of which a refusal may name one.
    pub(crate) touches: Option<&'static str>,
    /// Its tables of readings of which a stretch of rows may be wrong.
    pub(crate) readings: &'static [Readings],
    /// Numbers of `case.toml` of which one may be typed wrong.
    pub(crate) typed: &'static [Typed],
    /// Numbers of its tables whose uncertainty may be declared.
    pub(crate) uncertain: &'static [Uncertain],
    /// Files of a small case that solves as it is: name and content.
    pub(crate) example: &'static [(&'static str, &'static str)],
}

/// The files of a case, to be read as they stand or with changes.
#[derive(Clone, Debug)]
pub(crate) struct Files {
    pub(crate) folder: Folder,
    pub(crate) document: Document,
    pub(crate) kind: &'static Kind,
}

impl Files {
    /// The files as they would be with these changes.
    pub(crate) fn with(&self, edits: &[Edit]) -> Self {
        let (folder, document) = (self.folder.with(edits), self.document.with(edits));
        Self { folder, document, kind: self.kind }
    }

    /// Reads them as their kind does.
    pub(crate) fn read(&self) -> Result<Reading, Error> {
        let reading = (self.kind.read)(&self.folder, &self.document)?;
        reading.loop_settings.columns.check(&self.folder, &reading.tables, &self.document)?;
        Ok(reading)
    }
}
