use std::borrow::Cow;
use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use geometry::{GeometryError, Nurbs};

use super::control_points::ControlPoints;
use super::edit::{Change, Edit};
use super::encoding::decode;
use super::ledger::Ledger;
use super::nearest::nearest;
use super::table::Table;
use super::{Location, Problem};
use crate::file::{MAX_BYTES, read_bytes};
use crate::{Error, FileProblem, InputFile};

/// What reading a case may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Whether `case.toml` may name files outside of the folder; not by default, as a case may come
    /// from anybody.
    pub allow_outside: bool,
}

/// A case folder that exists.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    allow_outside: bool,
    ledger: Ledger,
    /// Tables as they stand in the files, shared by every copy.
    read: Arc<Mutex<HashMap<&'static str, Arc<Table>>>>,
    /// The surface of the files as they stand, shared likewise.
    surface: Arc<OnceLock<(ControlPoints, Arc<Nurbs>)>>,
    /// Changes that are made to what is read.
    edits: Vec<Edit>,
}

impl Folder {
    pub(crate) fn open(path: &Path, options: ReadOptions) -> Result<Self, Error> {
        let at = Location::file(path);
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => Ok(Self {
                path: path.to_owned(),
                allow_outside: options.allow_outside,
                ledger: Ledger::default(),
                read: Arc::default(),
                surface: Arc::default(),
                edits: Vec::new(),
            }),
            Ok(_) => Err(Error::case(at, Problem::NotAFolder)),
            Err(e) if e.kind() == ErrorKind::NotFound => Err(Error::case(at, Problem::NoFolder)),
            Err(e) => Err(Error::case(at, Problem::Unreadable { reason: e.kind() })),
        }
    }

    /// The surface of these points. Where they are those of the case as it stands, it is made once,
    /// however often the case is read with other rows.
    pub(crate) fn surface(&self, of: ControlPoints) -> Result<Arc<Nurbs>, GeometryError> {
        if let Some((_, surface)) = self.surface.get().filter(|(known, _)| *known == of) {
            return Ok(Arc::clone(surface));
        }
        let surface = Arc::new(of.surface()?);
        // Of two that were made at once the other one stays, which is as good.
        let _ = self.surface.set((of, Arc::clone(&surface)));
        Ok(surface)
    }

    /// What was read and understood so far.
    pub(crate) fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    pub(crate) fn location(&self, file: &str) -> Location {
        Location::file(self.path.join(file))
    }

    /// The table in `file`, which must exist and have at least one row.
    pub(crate) fn table(&self, file: &'static str, columns: &[&str]) -> Result<Table, Error> {
        let table = self.unedited(file, columns)?;
        let edits = self.edits.iter().filter(|edit| edit.file == file);
        let table = Change::all_of_table(edits.map(|edit| &edit.change), Cow::Borrowed(&table));
        // A change may leave every row out, and a table without rows is none.
        if table.n_rows() == 0 {
            Err(Error::case(table.at_header(), Problem::NoRows))
        } else {
            Ok(table)
        }
    }

    /// A table that was read before, as it stands in its file.
    pub(crate) fn known(&self, file: &str) -> Option<Arc<Table>> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).get(file).map(Arc::clone)
    }

    fn unedited(&self, file: &'static str, columns: &[&str]) -> Result<Arc<Table>, Error> {
        if let Some(table) = self.known(file) {
            return Ok(table);
        }
        let table = Table::read(self.location(file), &self.text(file)?, columns, &self.ledger)?;
        let table = Arc::new(table);
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(file, Arc::clone(&table));
        Ok(table)
    }

    /// The folder as it would be with these changes on top of those it has.
    pub(crate) fn with(&self, edits: &[Edit]) -> Self {
        Self { edits: [&self.edits, edits].concat(), ..self.clone() }
    }

    /// Whether there is anything by the name `file`.
    pub(crate) fn has(&self, file: &str) -> bool {
        let is_omitted = |edit: &Edit| edit.file == file && matches!(edit.change, Change::Omit);
        !self.edits.iter().any(is_omitted) && self.path.join(file).symlink_metadata().is_ok()
    }

    /// The text of `file` without its byte order mark.
    pub(crate) fn text(&self, file: &str) -> Result<String, Error> {
        let at = self.location(file);
        let decoded = decode(self.bytes(file)?)
            .map_err(|e| Error::case(at.clone().line(e.line).column(e.column), *e.problem))?;
        if let Some(encoding) = decoded.encoding {
            self.ledger.note(&at, encoding.to_owned());
        }
        Ok(decoded.text)
    }

    /// What `file` holds, as one of the inputs of the case.
    pub(crate) fn bytes(&self, file: &str) -> Result<Vec<u8>, Error> {
        let at = self.location(file);
        let bytes = read_bytes(&at.file, MAX_BYTES).map_err(|problem| {
            let problem = match problem {
                FileProblem::Unreadable { reason: ErrorKind::NotFound } => self.missing(file),
                FileProblem::NotAFile { found } => Problem::NotAFile { found },
                FileProblem::TooLarge { bytes, limit } => Problem::TooLargeFile { bytes, limit },
                FileProblem::Unreadable { reason } => Problem::Unreadable { reason },
                FileProblem::NotUtf8 { byte, .. } => Problem::NotUtf8 { byte },
                FileProblem::NotText { found } => Problem::NotText { found },
            };
            Error::case(at.clone(), problem)
        })?;
        self.ledger.read(InputFile::new(file, &at.file, &bytes));
        Ok(bytes)
    }

    /// What a file that `case.toml` names at `at` holds: in the folder, wherever links lead, unless
    /// files outside of it are allowed.
    pub(crate) fn named(&self, file: &str, at: Location) -> Result<Vec<u8>, Error> {
        let path = self.path.join(file);
        let real = fs::canonicalize(&path);
        let is_inside = match (&real, fs::canonicalize(&self.path)) {
            (Ok(real), Ok(folder)) => real.starts_with(folder),
            // What is not there is inside if its name says so.
            _ => Path::new(file).components().all(|c| matches!(c, Component::Normal(_))),
        };
        if !(is_inside || self.allow_outside) {
            return Err(Error::case(at, Problem::OutsideFolder { file: file.to_owned() }));
        }
        let bytes =
            read_bytes(&path, MAX_BYTES).map_err(|problem| Error::not_read(&path, problem))?;
        self.ledger.read(InputFile::new(file, &path, &bytes));
        Ok(bytes)
    }

    /// Tables of the folder other than `read`, sorted by name.
    pub(crate) fn tables_besides(&self, read: &[&str]) -> Vec<String> {
        let mut names = self.names();
        names.retain(|name| has_extension(name, &["csv"]) && !read.contains(&name.as_str()));
        names.sort();
        names
    }

    /// Workbooks of the folder, sorted by name.
    pub(crate) fn workbooks(&self) -> Vec<String> {
        let mut names = self.names();
        names.retain(|name| is_workbook(name));
        names.sort();
        names
    }

    /// What is said of a file that is not there.
    fn missing(&self, file: &str) -> Problem {
        let names = self.names();
        let nearest = nearest(file, names.iter().map(String::as_str)).map(str::to_owned);
        let by_that_name = || {
            self.workbooks().into_iter().find(|name| stem(name).eq_ignore_ascii_case(stem(file)))
        };
        let workbook = match &nearest {
            _ if !has_extension(file, &["csv"]) => None,
            Some(name) if !is_workbook(name) => None,
            Some(_) => by_that_name().or_else(|| nearest.clone()),
            None => by_that_name().or_else(|| self.workbooks().into_iter().next()),
        };
        match workbook {
            Some(workbook) => Problem::WorkbookInstead { workbook, file: file.to_owned() },
            None => Problem::MissingFile { nearest },
        }
    }

    fn names(&self) -> Vec<String> {
        let Ok(entries) = fs::read_dir(&self.path) else { return Vec::new() };
        entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect()
    }
}

/// Endings of the workbooks of spreadsheet programs.
const WORKBOOKS: [&str; 6] = ["xlsx", "xlsm", "xlsb", "xls", "ods", "numbers"];

fn is_workbook(name: &str) -> bool {
    has_extension(name, &WORKBOOKS)
}

fn has_extension(name: &str, known: &[&str]) -> bool {
    let extension = Path::new(name).extension();
    extension.is_some_and(|e| known.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::{Change, Edit, Folder};
    use crate::case::ReadOptions;

    /// A change may leave every row out; nobody who reads the table finds an empty one.
    #[test]
    fn a_table_that_a_change_empties_is_refused_as_an_empty_one() {
        let place = tempfile::tempdir().unwrap();
        std::fs::write(place.path().join("t.csv"), "id,x\na,1\n").unwrap();
        let folder = Folder::open(place.path(), ReadOptions::default()).unwrap();
        let edit = Edit { file: "t.csv", change: Change::Keep { rows: Vec::new() } };
        let problem = folder.with(&[edit]).table("t.csv", &["id"]).unwrap_err().to_string();
        assert!(problem.contains("no rows"), "{problem}");
    }
}
