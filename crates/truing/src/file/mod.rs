//! Files: how they are read, what they are the same as, and how they are replaced.

mod identity;
mod input;
mod problem;
mod read;
mod signature;
mod write;

pub use identity::refuse_overlap;
pub use input::InputFile;
pub(crate) use input::digest;
pub use problem::FileProblem;
pub(crate) use read::{MAX_BYTES, read_bytes, read_text};
pub(crate) use signature::no_text;
pub(crate) use write::write_new;
pub use write::{OutputFile, write_files};
