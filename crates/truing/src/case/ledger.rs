use std::cell::RefCell;
use std::rc::Rc;

use super::Location;
use crate::InputFile;

/// What was read for a case, and what was understood on the way; clones write into one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger(Rc<RefCell<Entries>>);

#[derive(Debug, Default)]
struct Entries {
    inputs: Vec<InputFile>,
    /// File, and what is said of it.
    notes: Vec<(String, Vec<String>)>,
}

impl Ledger {
    /// A file that was read; one that is read again counts once.
    pub(crate) fn read(&self, input: InputFile) {
        let inputs = &mut self.0.borrow_mut().inputs;
        if inputs.iter().all(|known| known.file != input.file) {
            inputs.push(input);
        }
    }

    /// Something that was understood of the file at `at`, which could have been written otherwise.
    pub(crate) fn note(&self, at: &Location, note: String) {
        let file = at.file.file_name().unwrap_or(at.file.as_os_str()).to_string_lossy();
        let notes = &mut self.0.borrow_mut().notes;
        match notes.iter_mut().find(|(known, _)| *known == file) {
            Some((_, said)) if said.contains(&note) => {}
            Some((_, said)) => said.push(note),
            None => notes.push((file.into_owned(), vec![note])),
        }
    }

    pub(crate) fn inputs(&self) -> Vec<InputFile> {
        self.0.borrow().inputs.clone()
    }

    /// One line a file.
    pub(crate) fn notes(&self) -> Vec<String> {
        let line = |(file, said): &(String, Vec<String>)| format!("{file}: {}", said.join("; "));
        self.0.borrow().notes.iter().map(line).collect()
    }
}
