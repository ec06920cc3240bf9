use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Location;
use crate::InputFile;

/// What was read for a case, and what was understood on the way; clones write into one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger(Arc<Mutex<Entries>>);

#[derive(Debug, Default)]
struct Entries {
    inputs: Vec<InputFile>,
    /// File, and what is said of it.
    notes: Vec<(String, Vec<String>)>,
}

impl Ledger {
    fn entries(&self) -> MutexGuard<'_, Entries> {
        // Every entry is whole before the next is begun.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A file that was read; one that is read again counts once.
    pub(crate) fn read(&self, input: InputFile) {
        let inputs = &mut self.entries().inputs;
        if inputs.iter().all(|known| known.file != input.file) {
            inputs.push(input);
        }
    }

    /// Something that was understood of the file at `at`, which could have been written otherwise.
    pub(crate) fn note(&self, at: &Location, note: String) {
        let file = at.file.file_name().unwrap_or(at.file.as_os_str()).to_string_lossy();
        let notes = &mut self.entries().notes;
        match notes.iter_mut().find(|(known, _)| *known == file) {
            Some((_, said)) if said.contains(&note) => {}
            Some((_, said)) => said.push(note),
            None => notes.push((file.into_owned(), vec![note])),
        }
    }

    pub(crate) fn inputs(&self) -> Vec<InputFile> {
        self.entries().inputs.clone()
    }

    /// One line a file.
    pub(crate) fn notes(&self) -> Vec<String> {
        let line = |(file, said): &(String, Vec<String>)| format!("{file}: {}", said.join("; "));
        self.entries().notes.iter().map(line).collect()
    }
}
