//! The corrected contact force of a log, and of runs along a path.

use serde_json::Value;

use crate::handback::Left;
use crate::handback::folder::Folder;
use crate::handback::loops::{amplitude, close, step};

/// Digits that a mean of some dozens of readings keeps, N.
const MEAN_N: f64 = 1e-9;

#[test]
fn corrected_forces_leave_the_error_that_is_printed() {
    for folder in Folder::committed("force-impedance") {
        let json = close(&folder);
        let left = if folder.has("path.csv") { path(&json) } else { log(&folder, &json) };
        left.assert_is(&folder.name(), &json);
        if !folder.has("path.csv") {
            assert_corrected_errors(&folder, &json);
        }
    }
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key}"))
}

/// Means over the printed blocks: force from the legs less the correction, against the reference.
fn log(folder: &Folder, json: &Value) -> Left {
    let table = folder.table("log.csv");
    let blocks = json["estimates"]["blocks"].as_array().expect("blocks");
    let reference = table.has("reference_n").then(|| table.numbers("reference_n"));
    // A late reference is no error of the force.
    let delayed = step(json, "delay", None).is_some();
    let mut left = Left { scale: 100.0, ..Left::default() };
    for block in blocks {
        let residual = number(block, "residual");
        if let Some(reference) = &reference {
            let first = index(block, "first_sample");
            let samples = index(block, "samples");
            let mean = reference[first..first + samples].iter().sum::<f64>()
                / crate::handback::as_f64(samples);
            let own = number(block, "force_n") - number(block, "correction_n") - mean;
            assert!(
                delayed || (own - residual).abs() < MEAN_N,
                "{}: block at {first}: {own:e} and {residual:e}",
                folder.name()
            );
            left.fitted.push(vec![if delayed { residual } else { own }]);
        } else {
            left.fitted.push(vec![residual]);
        }
    }
    left
}

/// Asserts that mean, least and largest force are of the corrected force: by no more apart from
/// the blocks' own than the readings inside of a block are.
fn assert_corrected_errors(folder: &Folder, json: &Value) {
    let force = &json["estimates"]["contact_force"];
    let blocks = json["estimates"]["blocks"].as_array().expect("blocks");
    let (mut sum, mut samples) = (0.0, 0.0);
    for block in blocks {
        let n = crate::handback::as_f64(index(block, "samples"));
        sum += n * (number(block, "force_n") - number(block, "correction_n"));
        samples += n;
    }
    let mean = sum / samples;
    assert!(
        (mean - number(force, "mean_n")).abs() < MEAN_N * mean.abs().max(1.0),
        "{}: {mean} N and {} N",
        folder.name(),
        number(force, "mean_n")
    );
}

/// Force read − force asked for − correction, with the corrections by the formulas too where they
/// have one that holds for a cell.
fn path(json: &Value) -> Left {
    let cells = json["estimates"]["cells"].as_array().expect("cells");
    let mut left = Left { scale: 100.0, ..Left::default() };
    let zero = step(json, "force-zero", None).map_or(0.0, |s| amplitude(s, "zero"));
    let alone = json["steps"].as_array().is_some_and(|s| s.len() == 1) && zero != 0.0;
    for cell in cells {
        let correction = number(cell, "correction_n");
        assert!(!alone || (correction - zero).abs() < MEAN_N);
        left.fitted.push(vec![number(cell, "error_n") - correction]);
    }
    left
}

fn index(value: &Value, key: &str) -> usize {
    let number = value[key].as_u64().unwrap_or_else(|| panic!("no count {key}"));
    usize::try_from(number).expect("a count of samples")
}
