use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

/// One file that an answer rests on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// Its name, in the case folder or as it was given.
    pub file: String,
    /// What `sha256sum` prints for it.
    pub sha256: String,
    /// Where it is.
    #[serde(skip)]
    pub path: PathBuf,
}

impl InputFile {
    pub(crate) fn new(file: &str, path: &Path, bytes: &[u8]) -> Self {
        Self { file: file.to_owned(), sha256: digest(bytes), path: path.to_owned() }
    }

    /// A file by the path that it was given by.
    pub(crate) fn given(path: &Path, bytes: &[u8]) -> Self {
        Self::new(&path.to_string_lossy(), path, bytes)
    }
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::digest;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn the_digest_is_that_of_the_standard() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(digest(b"abc"), expected);
    }
}
