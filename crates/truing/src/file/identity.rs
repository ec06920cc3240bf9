//! What a path leads to, whatever it is called.

use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;

/// Symbolic links followed before they count as a circle, as on Linux.
const MAX_LINKS: usize = 40;

/// The same for all names of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Identity {
    /// Device and number on it.
    #[cfg(unix)]
    Inode(u64, u64),
    /// Path without links: of a file that does not exist, or where files have no number.
    Path(PathBuf),
}

/// Refuses outputs that are inputs of the run or one another, by whatever name or link.
///
/// # Errors
///
/// [`Error::OutputIsInput`], [`Error::OutputTwice`].
pub fn refuse_overlap(outputs: &[&Path], inputs: &[&Path]) -> Result<(), Error> {
    let inputs: Vec<(&Path, Identity)> =
        inputs.iter().filter_map(|path| Some((*path, identity(path)?))).collect();
    let mut seen: Vec<(&Path, Identity)> = Vec::new();
    for output in outputs {
        let Some(identity) = identity(output) else { continue };
        if let Some((input, _)) = inputs.iter().find(|(_, other)| *other == identity) {
            let (path, input) = (output.to_path_buf(), input.to_path_buf());
            return Err(Error::OutputIsInput { path, input });
        }
        if let Some((other, _)) = seen.iter().find(|(_, other)| *other == identity) {
            let (path, other) = (output.to_path_buf(), other.to_path_buf());
            return Err(Error::OutputTwice { path, other });
        }
        seen.push((output, identity));
    }
    Ok(())
}

/// What `path` is; `None` for devices and pipes, into which many may write, and for what is out of
/// reach.
fn identity(path: &Path) -> Option<Identity> {
    let target = follow(path);
    match fs::metadata(&target) {
        Ok(metadata) if metadata.is_file() || metadata.is_dir() => of_file(&target, &metadata),
        Ok(_) => None,
        Err(_) => {
            let folder = target.parent().filter(|p| !p.as_os_str().is_empty());
            let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
            Some(Identity::Path(folder.join(target.file_name()?)))
        }
    }
}

#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "elsewhere the path may be out of reach")]
fn of_file(_: &Path, metadata: &fs::Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some(Identity::Inode(metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn of_file(path: &Path, _: &fs::Metadata) -> Option<Identity> {
    fs::canonicalize(path).ok().map(Identity::Path)
}

/// Where symbolic links lead, whether or not anything is there; what a process holds open is not
/// followed, as its link is no path.
pub(super) fn follow(path: &Path) -> PathBuf {
    let mut at = path.to_owned();
    for _ in 0..MAX_LINKS {
        let Ok(link) = fs::read_link(&at) else { return at };
        if is_held_open(&at) {
            return at;
        }
        at = at.parent().unwrap_or(Path::new("")).join(link);
    }
    path.to_owned()
}

/// Whether a path is that of something a process holds open, such as `/dev/stdout` or `/dev/fd/3`.
pub(super) fn is_held_open(path: &Path) -> bool {
    let folder = path.parent().and_then(|folder| fs::canonicalize(folder).ok());
    folder.is_some_and(|folder| folder.starts_with("/proc"))
}
