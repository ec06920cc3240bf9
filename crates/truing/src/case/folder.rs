use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::nearest::nearest;
use super::table::Table;
use super::{Location, Problem};
use crate::Error;

/// Largest file read: beyond it, the copies a solve makes would not fit into common memories.
const MAX_BYTES: u64 = 2 << 30;

/// A case folder that exists.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    path: PathBuf,
}

impl Folder {
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let at = Location::file(path);
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => Ok(Self { path: path.to_owned() }),
            Ok(_) => Err(Error::case(at, Problem::NotAFolder)),
            Err(e) if e.kind() == ErrorKind::NotFound => Err(Error::case(at, Problem::NoFolder)),
            Err(e) => Err(Error::case(at, Problem::Unreadable { reason: e.kind() })),
        }
    }

    pub(crate) fn location(&self, file: &str) -> Location {
        Location::file(self.path.join(file))
    }

    /// The table in `file`, which must exist and have at least one row.
    pub(crate) fn table(&self, file: &'static str, columns: &[&str]) -> Result<Table, Error> {
        let text = self.text(file)?;
        Table::read(self.location(file), &text, columns)
    }

    /// Whether there is anything by the name `file`.
    pub(crate) fn has(&self, file: &str) -> bool {
        self.path.join(file).symlink_metadata().is_ok()
    }

    /// The text of `file` without its byte order mark.
    pub(crate) fn text(&self, file: &str) -> Result<String, Error> {
        let at = self.location(file);
        let fail = |problem| Error::case(at.clone(), problem);
        let metadata = fs::metadata(&at.file).map_err(|e| {
            fail(match e.kind() {
                ErrorKind::NotFound => Problem::MissingFile { nearest: self.nearest_file(file) },
                reason => Problem::Unreadable { reason },
            })
        })?;
        // A pipe or a device could be read for ever.
        if !metadata.is_file() {
            return Err(fail(Problem::NotAFile));
        }
        if metadata.len() > MAX_BYTES {
            return Err(fail(Problem::TooLargeFile { bytes: metadata.len(), limit: MAX_BYTES }));
        }
        let mut bytes = Vec::new();
        fs::File::open(&at.file)
            .and_then(|file| file.take(MAX_BYTES).read_to_end(&mut bytes))
            .map_err(|e| fail(Problem::Unreadable { reason: e.kind() }))?;
        let mut text = String::from_utf8(bytes).map_err(|e| not_utf8(&at, &e))?;
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        Ok(text)
    }

    /// Tables of the folder other than `read`, sorted by name.
    pub(crate) fn tables_besides(&self, read: &[&str]) -> Vec<String> {
        let mut names = self.names();
        names.retain(|name| {
            let is_table =
                Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
            is_table && !read.contains(&name.as_str())
        });
        names.sort();
        names
    }

    fn nearest_file(&self, file: &str) -> Option<String> {
        let names = self.names();
        nearest(file, names.iter().map(String::as_str)).map(str::to_owned)
    }

    fn names(&self) -> Vec<String> {
        let Ok(entries) = fs::read_dir(&self.path) else { return Vec::new() };
        entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect()
    }
}

fn not_utf8(at: &Location, error: &std::string::FromUtf8Error) -> Error {
    let valid = error.utf8_error().valid_up_to();
    let (before, rest) = error.as_bytes().split_at(valid);
    let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    let line = before.split(|b| *b == b'\n').count();
    let column = 1 + String::from_utf8_lossy(&before[line_start..]).chars().count();
    let byte = rest.first().copied().unwrap_or_default();
    Error::case(at.clone().line(line).column(column), Problem::NotUtf8 { byte })
}
