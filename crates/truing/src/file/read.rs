use std::fs::{self, FileType};
use std::io::Read;
use std::path::Path;

use super::{FileProblem, no_text};

/// Largest file read: beyond it, the copies a solve makes would not fit into common memories.
pub(crate) const MAX_BYTES: u64 = 2 << 30;

/// What an ordinary file of at most `limit` bytes holds.
pub(crate) fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, FileProblem> {
    let unreadable = |e: std::io::Error| FileProblem::Unreadable { reason: e.kind() };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    // Asked before the file is opened: to open a pipe is to wait for somebody who writes to it.
    if !metadata.is_file() {
        return Err(FileProblem::NotAFile { found: noun(metadata.file_type()) });
    }
    if metadata.len() > limit {
        return Err(FileProblem::TooLarge { bytes: metadata.len(), limit });
    }
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(unreadable)?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(unreadable)?;
    // It may have grown meanwhile, and some files of the system have no size to ask for.
    match u64::try_from(bytes.len()) {
        Ok(read) if read <= limit => Ok(bytes),
        _ => Err(FileProblem::TooLarge { bytes: limit.saturating_add(1), limit }),
    }
}

/// The text of an ordinary file, without its byte order mark.
pub(crate) fn read_text(path: &Path, limit: u64) -> Result<String, FileProblem> {
    let bytes = read_bytes(path, limit)?;
    if let Some(found) = no_text(&bytes) {
        return Err(FileProblem::NotText { found });
    }
    let mut text = String::from_utf8(bytes).map_err(|e| {
        let (before, rest) = e.as_bytes().split_at(e.utf8_error().valid_up_to());
        let line = before.split(|b| *b == b'\n').count();
        FileProblem::NotUtf8 { line, byte: rest.first().copied().unwrap_or_default() }
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

fn noun(file_type: FileType) -> &'static str {
    if file_type.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if file_type.is_fifo() {
            return "a pipe";
        }
        if file_type.is_char_device() || file_type.is_block_device() {
            return "a device";
        }
        if file_type.is_socket() {
            return "a socket";
        }
    }
    "something else"
}
