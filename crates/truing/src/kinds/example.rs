use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::KINDS;
use crate::Error;
use crate::case::nearest;

/// Cases of a kind whose data come in another form, by a name of their own.
const FURTHER: &[(&str, &[(&str, &str)])] = &[(
    "tracker-lm-targets",
    &[
        ("case.toml", include_str!("../../templates/tracker-lm-targets/case.toml")),
        ("stations.csv", include_str!("../../templates/tracker-lm-targets/stations.csv")),
        ("mounts.csv", include_str!("../../templates/tracker-lm-targets/mounts.csv")),
        ("targets.csv", include_str!("../../templates/tracker-lm-targets/targets.csv")),
    ],
)];

/// Writes a small commented case of `kind` into `folder`, which is made if need be.
///
/// `tracker-lm-targets` is a case of `tracker-lm` with points in place of displacements.
/// Returns the files written. Nothing is overwritten: if any of them exists, none is written.
///
/// # Errors
///
/// [`Error::UnknownKind`], [`Error::Exists`], [`Error::NotWritten`].
pub fn write_example(kind: &str, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    let known = || KINDS.iter().map(|k| (k.name, k.example)).chain(FURTHER.iter().copied());
    let (_, files) = known().find(|(name, _)| *name == kind).ok_or_else(|| {
        let names = known().map(|(name, _)| name);
        Error::UnknownKind {
            found: kind.to_owned(),
            nearest: nearest(kind, names.clone()),
            expected: names.collect(),
        }
    })?;
    write_new(folder, files)
}

/// Writes files into a folder, which is made if need be; where one of them exists, none is written.
pub(crate) fn write_new(folder: &Path, named: &[(&str, &str)]) -> Result<Vec<PathBuf>, Error> {
    let files: Vec<PathBuf> = named.iter().map(|(name, _)| folder.join(name)).collect();
    if let Some(path) = files.iter().find(|path| path.symlink_metadata().is_ok()) {
        return Err(Error::Exists { path: path.clone() });
    }
    let not_written = |path: &Path, e: &std::io::Error| match e.kind() {
        ErrorKind::AlreadyExists => Error::Exists { path: path.to_owned() },
        reason => Error::NotWritten { path: path.to_owned(), reason },
    };
    fs::create_dir_all(folder).map_err(|e| not_written(folder, &e))?;
    for (path, (_, content)) in files.iter().zip(named) {
        fs::File::create_new(path)
            .and_then(|mut file| file.write_all(content.as_bytes()))
            .map_err(|e| not_written(path, &e))?;
    }
    Ok(files)
}
