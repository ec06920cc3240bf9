//! Committed cases: published tables, and simulations written from the physics.

pub(crate) mod noise;
pub(crate) mod oracle;
pub(crate) mod vector;

pub(crate) mod published;

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
pub(crate) struct Story {
    pub(crate) title: &'static str,
    pub(crate) truth: String,
    pub(crate) expect: Expectation,
}

/// Completes a generated case with its provenance.
pub(crate) fn generated(
    folder: &str,
    seed: u64,
    tables: Vec<(&'static str, String)>,
    story: Story,
) -> Case {
    let units = match folder.split('/').next() {
        Some("ft-center") => "mm, N, N·mm, s",
        Some("force-impedance") => "mm, N, s",
        Some("tracker-lm") => "mm, degrees, s, °C",
        _ => "mm; other columns as their suffix says",
    };
    let provenance = Provenance {
        title: story.title.to_owned(),
        source: format!("simulated by cargo xtask fixtures, seed {seed}"),
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
pub(crate) fn complete(
    folder: &str,
    tables: Vec<(&'static str, String)>,
    mut provenance: Provenance,
) -> Case {
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
pub(crate) fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(|&word| word.to_owned()).collect()
}

/// One class of effects explains everything.
pub(crate) fn named(class: &[&str]) -> Expectation {
    Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(class)],
        nothing_else: true,
        ..Expectation::default()
    }
}

/// The same, and nearly nothing is left on data never fitted: `at_most` times their noise.
pub(crate) fn named_within(class: &[&str], at_most: f64) -> Expectation {
    Expectation { held_out: Some(HeldOut { noise: 0.0, at_most }), ..named(class) }
}

/// Nothing is to be added, and one of the `verdicts` is given.
pub(crate) fn nothing(verdicts: &[&str]) -> Expectation {
    Expectation { verdict: words(verdicts), nothing_else: true, ..Expectation::default() }
}

/// With the noise that the simulator made on data never fitted, where the error on them is judged.
pub(crate) fn over_noise(expect: Expectation, noise: f64) -> Expectation {
    Expectation { held_out: expect.held_out.map(|bound| HeldOut { noise, ..bound }), ..expect }
}
