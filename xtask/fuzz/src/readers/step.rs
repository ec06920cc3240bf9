//! STEP files, for `truing import step`.

use std::fs;

use tempfile::TempDir;
use truing::{ProbeLogKind, StepImport, import_step, read_step};

/// Faces that are made into cases: more of them take the same ways.
const FACES: usize = 8;

pub(super) fn read(bytes: &[u8]) {
    let folder = TempDir::new().expect("a temporary folder can be made");
    let path = folder.path().join("part.step");
    fs::write(&path, bytes).expect("the folder can be written to");
    let n_faces = match read_step(&path) {
        Ok(step) => step.faces.len(),
        Err(error) => return assert_eq!(error.exit_code(), 2, "{error}"),
    };
    for number in 1..=n_faces.min(FACES) {
        let kind = ProbeLogKind::ProbeComp;
        let import = StepImport { face: Some(number), kind, tip_radius_mm: 3.0 };
        if let Err(error) = import_step(&path, &import) {
            assert_eq!(error.exit_code(), 2, "{error}");
        }
    }
}
