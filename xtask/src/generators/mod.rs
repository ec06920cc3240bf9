//! Committed cases: published tables, and simulations written from the physics.

mod axis_curves;
pub(crate) mod axis_run;
pub(crate) mod mirror;
pub(crate) mod noise;
pub(crate) mod oracle;
pub(crate) mod polish;
pub(crate) mod polish_head;
pub(crate) mod polish_tables;
pub(crate) mod positions;
pub(crate) mod press;
pub(crate) mod press_tables;
pub(crate) mod probe;
pub(crate) mod probe_tables;
pub(crate) mod strokes;
pub(crate) mod survey;
pub(crate) mod targets;
pub(crate) mod tracer;
mod tracer_physics;
pub(crate) mod tracer_run;
pub(crate) mod tracer_tables;
pub(crate) mod vector;

mod frame_cases;
mod mirror_cases;
mod polish_cases;
mod press_cases;
mod probe_cases;
mod published;
mod stroke_cases;
mod target_cases;
mod tracer_cases;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::expectation::{Expectation, HeldOut, Provenance};

pub(crate) use noise::Colour;

/// A case folder in memory.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// Folder under `fixtures/`: crate and case.
    pub folder: String,
    /// Name and text of each file.
    pub files: BTreeMap<String, String>,
}

/// What a generator says of a case; the rest of its provenance follows.
struct Story {
    title: &'static str,
    truth: String,
    expect: Expectation,
}

/// Every committed case that this program can write.
pub(crate) fn cases() -> Vec<Case> {
    let mut cases = published::cases();
    cases.extend(frame_cases::cases());
    cases.extend(press_cases::cases());
    cases.extend(mirror_cases::cases());
    cases.extend(polish_cases::cases());
    cases.extend(stroke_cases::cases());
    cases.extend(tracer_cases::cases());
    cases.extend(target_cases::cases());
    cases.extend(probe_cases::cases());
    cases
}

/// Completes a generated case with its provenance.
fn generated(folder: &str, seed: u64, tables: Vec<(&'static str, String)>, story: Story) -> Case {
    let units = match folder.split('/').next() {
        Some("ft-center") => "mm, N, N·mm, s",
        Some("force-impedance") => "mm, N, s",
        Some("tracker-lm") => "mm, degrees, s, °C",
        _ => "mm; other columns as their suffix says",
    };
    let provenance = Provenance {
        title: story.title.to_owned(),
        source: format!("simulated by xtask/src/generators, seed {seed}"),
        seed: Some(seed),
        units: units.to_owned(),
        licence: "MIT OR Apache-2.0".to_owned(),
        truth: story.truth,
        expect: story.expect,
        ..Provenance::default()
    };
    complete(folder, tables, provenance)
}

/// Adds the hashes, and the provenance itself.
fn complete(folder: &str, tables: Vec<(&'static str, String)>, mut provenance: Provenance) -> Case {
    let mut files: BTreeMap<String, String> =
        tables.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
    provenance.files =
        files.iter().map(|(name, text)| (name.clone(), sha256(text.as_bytes()))).collect();
    let text = toml::to_string(&provenance).expect("provenance is plain data");
    files.insert("provenance.toml".to_owned(), text);
    Case { folder: folder.to_owned(), files }
}

/// SHA-256 in the digits that `sha256sum` prints.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    let mut digits = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        let _ = write!(digits, "{byte:02x}");
    }
    digits
}

/// Strings for lists.
fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(|&word| word.to_owned()).collect()
}

/// One class of effects explains everything.
fn named(class: &[&str]) -> Expectation {
    Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(class)],
        nothing_else: true,
        ..Expectation::default()
    }
}

/// The same, and nearly nothing is left on data never fitted: `at_most` times their noise.
fn named_within(class: &[&str], at_most: f64) -> Expectation {
    Expectation { held_out: Some(HeldOut { noise: 0.0, at_most }), ..named(class) }
}

/// Nothing is to be added, and one of the `verdicts` is given.
fn nothing(verdicts: &[&str]) -> Expectation {
    Expectation { verdict: words(verdicts), nothing_else: true, ..Expectation::default() }
}

/// With the noise that the simulator made on data never fitted, where the error on them is judged.
fn over_noise(expect: Expectation, noise: f64) -> Expectation {
    Expectation { held_out: expect.held_out.map(|bound| HeldOut { noise, ..bound }), ..expect }
}
