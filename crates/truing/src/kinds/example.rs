use std::path::{Path, PathBuf};

use super::KINDS;
use crate::Error;
use crate::case::nearest;
use crate::file::write_new;

/// Names of files, and what they hold.
type Files = &'static [(&'static str, &'static str)];

/// Cases of a kind whose data come in another form, by a name of their own.
const FURTHER: &[(&str, &str, Files)] = &[(
    "tracker-lm-targets",
    "tracker-lm with points in place of displacements",
    &[
        ("case.toml", include_str!("../../templates/tracker-lm-targets/case.toml")),
        ("stations.csv", include_str!("../../templates/tracker-lm-targets/stations.csv")),
        ("mounts.csv", include_str!("../../templates/tracker-lm-targets/mounts.csv")),
        ("targets.csv", include_str!("../../templates/tracker-lm-targets/targets.csv")),
    ],
)];

/// Every name that [`write_example`] knows, with what it is for: the kinds, and further forms of them.
pub fn examples() -> impl Iterator<Item = (&'static str, &'static str)> {
    super::kinds().chain(FURTHER.iter().map(|(name, summary, _)| (*name, *summary)))
}

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
    let known = || {
        let further = FURTHER.iter().map(|(name, _, files)| (*name, *files));
        KINDS.iter().map(|k| (k.name, k.example)).chain(further)
    };
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
