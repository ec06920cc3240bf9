//! Measurements that other programs wrote, as case folders.

mod heading;
mod planned_log;
mod probe_log;
mod step;
mod table;
mod target;

pub(crate) use heading::unit_of_coordinate;

use std::path::{Path, PathBuf};

use crate::Error;
use crate::file::write_new;

pub use planned_log::import_planned_log;
pub use probe_log::{ImportedTouches, ProbeLogKind, ProbeLogSettings, import_probe_log};
pub use step::{ImportedFace, StepImport, import_step};
pub use table::{ColumnMap, ImportProblem, ImportedTable, TableImport, import_table};

/// Writes the files of an imported case into `folder`, which is made if need be; nothing is
/// overwritten.
///
/// # Errors
///
/// [`Error::Exists`], [`Error::NotWritten`].
pub fn write_imported(
    files: &[(&'static str, String)],
    folder: &Path,
) -> Result<Vec<PathBuf>, Error> {
    let files: Vec<(&str, &str)> =
        files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    write_new(folder, &files)
}
