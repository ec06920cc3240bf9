//! A folder as one input: each file below a line `>>> name`.

use std::fs;

use tempfile::TempDir;

/// What a line begins with that names a file.
const MARK: &[u8] = b">>> ";
/// Longest name; file systems take four times as much.
const MOST_NAME: usize = 64;

/// Writes the files of an input into a folder that vanishes with what is returned.
///
/// What is above the first mark, or below a name that leads out of the folder, is left out.
pub(super) fn unpack(bytes: &[u8]) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder can be made");
    let mut file: Option<(String, Vec<u8>)> = None;
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        match (line.strip_prefix(MARK), &mut file) {
            (Some(name), _) => {
                write(&folder, file.take());
                file = plain(name).map(|name| (name, Vec::new()));
            }
            (None, Some((_, content))) => content.extend_from_slice(line),
            (None, None) => {}
        }
    }
    write(&folder, file);
    folder
}

/// The name of a file in the folder itself.
fn plain(line: &[u8]) -> Option<String> {
    let name = str::from_utf8(line).ok()?.trim();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._- ".contains(c);
    let fits = (1..=MOST_NAME).contains(&name.len()) && !name.starts_with('.');
    (fits && name.chars().all(is_plain)).then(|| name.to_owned())
}

fn write(folder: &TempDir, file: Option<(String, Vec<u8>)>) {
    if let Some((name, content)) = file {
        fs::write(folder.path().join(name), content).expect("the folder can be written to");
    }
}
