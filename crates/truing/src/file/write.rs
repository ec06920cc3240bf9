//! Files are written beside their place and renamed: whatever happens, the old one or the new one
//! is there, whole.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::identity::{follow, is_held_open};
use crate::Error;

/// A file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub content: String,
}

/// Writes files, replacing those that exist.
///
/// All of them are written and brought to the disk under temporary names in their own folders
/// before the first takes its place. Where one cannot be written, no place is touched and no
/// temporary file stays. A symbolic link stays one, and its target is replaced; permissions of a
/// file that exists are kept. Devices and pipes are written to as they are.
///
/// # Errors
///
/// [`Error::NotWritten`].
pub fn write_files(files: &[OutputFile]) -> Result<(), Error> {
    let staged: Vec<Staged<'_>> = files
        .iter()
        .map(|f| stage(f).map_err(|e| failed(&f.path, &e)))
        .collect::<Result<_, _>>()?;
    for (staged, file) in staged.into_iter().zip(files) {
        staged.take_place().map_err(|e| failed(&file.path, &e))?;
    }
    Ok(())
}

/// Writes files into a folder, which is made if need be; where one of them exists, none is written.
pub(crate) fn write_new(folder: &Path, named: &[(&str, &str)]) -> Result<Vec<PathBuf>, Error> {
    let files: Vec<PathBuf> = named.iter().map(|(name, _)| folder.join(name)).collect();
    if let Some(path) = files.iter().find(|path| path.symlink_metadata().is_ok()) {
        return Err(Error::Exists { path: path.clone() });
    }
    let is_new = folder.symlink_metadata().is_err();
    fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
    let written = write_all_new(folder, &files, named);
    if written.is_err() && is_new {
        // Only where it is empty: nobody else's files go with it.
        let _ = fs::remove_dir(folder);
    }
    written.map(|()| files)
}

fn write_all_new(folder: &Path, files: &[PathBuf], named: &[(&str, &str)]) -> Result<(), Error> {
    let staged: Vec<NamedTempFile> = (files.iter().zip(named))
        .map(|(path, (_, text))| filled(folder, None, text).map_err(|e| failed(path, &e)))
        .collect::<Result<_, _>>()?;
    for (n, (temporary, path)) in staged.into_iter().zip(files).enumerate() {
        if let Err(e) = temporary.persist_noclobber(path) {
            for done in &files[..n] {
                // What was put there just before; the error is the one to tell.
                let _ = fs::remove_file(done);
            }
            return Err(failed(path, &e.error));
        }
    }
    sync_folder(folder);
    Ok(())
}

/// Content that only has to take its place.
enum Staged<'f> {
    Beside { temporary: NamedTempFile, target: PathBuf },
    Stream { target: PathBuf, content: &'f str },
}

impl Staged<'_> {
    fn take_place(self) -> io::Result<()> {
        match self {
            Self::Beside { temporary, target } => {
                temporary.persist(&target).map_err(|e| e.error)?;
                sync_folder(folder_of(&target));
                Ok(())
            }
            Self::Stream { target, content } => {
                let mut stream = OpenOptions::new().write(true).open(target)?;
                stream.write_all(content.as_bytes()).and_then(|()| stream.flush())
            }
        }
    }
}

fn stage(file: &OutputFile) -> io::Result<Staged<'_>> {
    let target = follow(&file.path);
    let content = &file.content;
    let old = match fs::metadata(&target) {
        Ok(old) if old.is_dir() => return Err(ErrorKind::IsADirectory.into()),
        Ok(old) if !old.is_file() || is_held_open(&target) => {
            return Ok(Staged::Stream { target, content });
        }
        Ok(old) => {
            // A file that may not be written to may not be replaced either.
            OpenOptions::new().write(true).open(&target)?;
            Some(old.permissions())
        }
        Err(e) if e.kind() == ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    Ok(Staged::Beside { temporary: filled(folder_of(&target), old, content)?, target })
}

/// A temporary file in `folder` whose content is on the disk; it vanishes unless it is renamed.
fn filled(
    folder: &Path,
    permissions: Option<fs::Permissions>,
    content: &str,
) -> io::Result<NamedTempFile> {
    let mut temporary = builder().tempfile_in(folder)?;
    temporary.write_all(content.as_bytes())?;
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions)?;
    }
    temporary.as_file().sync_all()?;
    Ok(temporary)
}

/// Temporary files have the permissions of any new file, not those of a secret.
#[cfg(unix)]
fn builder() -> Builder<'static, 'static> {
    use std::os::unix::fs::PermissionsExt;
    /// Reading and writing for all, less what the user's mask takes away.
    const NEW_FILE: u32 = 0o666;
    let mut builder = Builder::new();
    builder.prefix(PREFIX).permissions(fs::Permissions::from_mode(NEW_FILE));
    builder
}

#[cfg(not(unix))]
fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX);
    builder
}

/// What a temporary file that was left behind by a kill is known by.
const PREFIX: &str = ".truing-";

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Brings the new name to the disk; where a folder cannot be opened for that, the system does it
/// in its own time.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = fs::File::open(folder) {
        let _ = folder.sync_all();
    }
}

fn failed(path: &Path, error: &io::Error) -> Error {
    match error.kind() {
        ErrorKind::AlreadyExists => Error::Exists { path: path.to_owned() },
        reason => Error::NotWritten { path: path.to_owned(), reason },
    }
}
