use std::fmt;
use std::path::{Path, PathBuf};

/// Where in a case something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file, with the case folder as the user wrote it.
    pub file: PathBuf,
    /// Line, from 1; absent where the whole file is meant.
    pub line: Option<usize>,
    /// From 1: the cell's number in a table, the character's in `case.toml`.
    pub column: Option<usize>,
    /// Name of the column or key.
    pub name: Option<String>,
}

impl Location {
    pub(crate) fn file(file: impl AsRef<Path>) -> Self {
        Self { file: file.as_ref().to_owned(), line: None, column: None, name: None }
    }

    pub(crate) fn line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    pub(crate) fn column(mut self, column: usize) -> Self {
        self.column = Some(column);
        self
    }

    pub(crate) fn name(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ", column {column}")?;
        }
        if let Some(name) = &self.name {
            write!(f, " ({})", super::quote(name))?;
        }
        Ok(())
    }
}
