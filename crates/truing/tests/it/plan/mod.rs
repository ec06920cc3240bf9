//! `truing plan`: what to measure next, and the loop with it.

mod axes;
mod committed;
mod heads;
mod points;
mod sensors;
mod touches;
mod trackers;

use serde_json::Value;

use crate::command::{Case, Ended, truing};

fn plan(case: &Case, further: &[&str]) -> Ended {
    truing(&[&["plan", case.path().to_str().unwrap()], further].concat())
}

fn json(case: &Case, further: &[&str]) -> Value {
    let ended = plan(case, &[further, &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn message(case: &Case, further: &[&str]) -> String {
    let ended = plan(case, further);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
    ended.one_message().replace(&format!("{}/", case.path().display()), "")
}

/// A pattern in place of noise: 1 µm, without memory.
fn noise_mm(i: usize) -> f64 {
    [3.0, -5.0, 1.0, 4.0, -2.0, 0.0, -4.0, 5.0, 2.0, -1.0, -3.0][i * 7 % 11] * 3e-4
}
