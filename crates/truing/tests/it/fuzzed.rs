//! Every reader of foreign files on the inputs that `cargo xtask fuzz` starts from: cases thinned out
//! of fixtures, and whatever once was a finding.

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use readers::{READERS, Reader};

#[path = "../../../../xtask/fuzz/src/readers/mod.rs"]
mod readers;

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../xtask/fuzz/corpus")
}

/// Names of the inputs on which a reader panics, and how many there are.
fn findings(folder: &Path, reader: Reader) -> (Vec<PathBuf>, usize) {
    let inputs: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let n_inputs = inputs.len();
    let panics = |input: &PathBuf| {
        let bytes = fs::read(input).unwrap();
        catch_unwind(|| reader(&bytes)).is_err()
    };
    (inputs.into_iter().filter(panics).collect(), n_inputs)
}

#[test]
fn every_reader_ends_on_every_committed_input() {
    let threads: Vec<_> = READERS
        .into_iter()
        .map(|(name, reader)| {
            std::thread::spawn(move || (name, findings(&corpus().join(name), reader)))
        })
        .collect();
    for thread in threads {
        let (name, (findings, n_inputs)) = thread.join().unwrap();
        assert!(n_inputs > 0, "{name} has no inputs");
        assert!(findings.is_empty(), "{name} panics on {findings:?}");
    }
}

#[test]
fn every_folder_of_inputs_has_its_reader() {
    let mut folders: Vec<String> = fs::read_dir(corpus())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    folders.sort();
    assert_eq!(folders, READERS.map(|(name, _)| name));
}
