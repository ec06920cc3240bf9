use std::io::ErrorKind;

/// Why a file was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileProblem {
    /// The system refuses to hand it over.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// What the system says.
        reason: ErrorKind,
    },
    /// A folder, a device or a pipe: it could be read for ever.
    #[error("expected an ordinary file, found {found}")]
    NotAFile {
        /// What it is.
        found: &'static str,
    },
    /// More than is read of such a file.
    #[error("the file has {bytes} bytes; at most {limit} can be read")]
    TooLarge {
        /// Its size.
        bytes: u64,
        /// Largest size accepted.
        limit: u64,
    },
    /// What a program saved in a form of its own.
    #[error("this is {found}, not a text file; save it as text")]
    NotText {
        /// What it is.
        found: &'static str,
    },
    /// Not text.
    #[error("line {line}: expected UTF-8 text, found byte 0x{byte:02x}; save the file as UTF-8")]
    NotUtf8 {
        /// From 1.
        line: usize,
        /// The first byte that is not part of a character.
        byte: u8,
    },
}
