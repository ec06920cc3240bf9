use std::ops::Range;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

use super::conformity::ConformitySettings;
use super::edit::Edit;
use super::folder::Folder;
use super::nearest::nearest;
use super::unit::{differs_in_unit, unit_of};
use super::{Location, Problem};
use crate::Error;

/// Name of the file that makes a folder a case.
pub(crate) const CASE_FILE: &str = "case.toml";

/// The text of `case.toml`, for settings and for saying where one of them is wrong.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    file: Location,
    text: String,
}

/// The one key that every kind has; the others are read by the kind itself.
#[derive(Deserialize)]
struct Head {
    kind: Spanned<String>,
}

/// What every kind takes and none reads.
#[derive(Deserialize)]
struct Common {
    #[serde(default)]
    conformity: ConformitySettings,
}

impl Document {
    pub(crate) fn read(folder: &Folder, file: &str) -> Result<Self, Error> {
        let text = folder.text(file)?;
        Ok(Self { file: folder.location(file), text })
    }

    /// The document as it would be with the settings among `edits`.
    pub(crate) fn with(&self, edits: &[Edit]) -> Self {
        let mut document = self.clone();
        for edit in edits.iter().filter(|edit| edit.file == CASE_FILE) {
            if let Some(text) = edit.change.of_settings(&document.text) {
                document.text = text;
            }
        }
        document
    }

    /// The value of a setting, by the path of its keys.
    pub(crate) fn value(&self, path: &[&str]) -> Option<toml::Value> {
        let document: toml::Table = self.text.parse().ok()?;
        let (last, sections) = path.split_last()?;
        let mut section = &document;
        for key in sections {
            section = section.get(*key)?.as_table()?;
        }
        section.get(*last).cloned()
    }

    /// The section `[conformity]`, which every kind takes.
    pub(crate) fn conformity(&self) -> Result<ConformitySettings, Error> {
        let common: Common = self.settings()?;
        Ok(common.conformity)
    }

    pub(crate) fn kind(&self) -> Result<Spanned<String>, Error> {
        let head: Head = self.settings()?;
        Ok(head.kind)
    }

    /// Settings of a kind; unknown keys are errors that say which key was probably meant.
    pub(crate) fn settings<T: DeserializeOwned>(&self) -> Result<T, Error> {
        toml::from_str(&self.text).map_err(|e| {
            let span = e.span().unwrap_or(0..0);
            Error::case(self.at(&span), self.problem(e.message(), &span))
        })
    }

    pub(crate) fn at(&self, span: &Range<usize>) -> Location {
        let before = &self.text[..self.text.floor_char_boundary(span.start)];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = 1 + before.matches('\n').count();
        self.file.clone().line(line).column(1 + before[line_start..].chars().count())
    }

    pub(crate) fn at_file(&self) -> Location {
        self.file.clone()
    }

    fn problem(&self, message: &str, span: &Range<usize>) -> Problem {
        // serde puts every name it speaks of between backticks, the one found first.
        let mut names = message.split('`').skip(1).step_by(2).map(str::to_owned);
        let (first, rest) = (names.next().unwrap_or_default(), names);
        if message.starts_with("unknown field") {
            unknown_key(first, rest.collect())
        } else if message.starts_with("unknown variant") {
            let expected: Vec<String> = rest.collect();
            let nearest = nearest(&first, expected.iter().map(String::as_str)).map(str::to_owned);
            Problem::UnknownWord { found: first, nearest, expected }
        } else if message.starts_with("missing field") {
            Problem::MissingKey { purpose: purpose(&first), key: first }
        } else if message.starts_with("invalid") || message.starts_with("expected a number") {
            Problem::WrongValue { message: format!("{}{}", self.key_at(span), plain(message)) }
        } else {
            Problem::Syntax { message: message.to_owned() }
        }
    }

    /// The key whose value stands at `span`, with its unit, for the head of a message.
    fn key_at(&self, span: &Range<usize>) -> String {
        let before = &self.text[..self.text.floor_char_boundary(span.start)];
        let line = &before[before.rfind('\n').map_or(0, |at| at + 1)..];
        let Some((key, _)) = line.rsplit_once('=') else { return String::new() };
        let key = key.rsplit(['{', ',']).next().unwrap_or(key).trim();
        match unit_of(key) {
            Some(unit) => format!("{} (in {unit}): ", super::quote(key)),
            None => format!("{}: ", super::quote(key)),
        }
    }
}

fn unknown_key(found: String, expected: Vec<String>) -> Problem {
    let in_another_unit = expected.iter().find(|known| differs_in_unit(&found, known));
    let similar = || nearest(&found, expected.iter().map(String::as_str));
    let nearest = in_another_unit.map(String::as_str).or_else(similar).map(str::to_owned);
    Problem::UnknownKey { found, nearest, expected }
}

fn purpose(key: &str) -> &'static str {
    match key {
        "kind" => "the kind of the case, e.g. `kind = \"frame-fit\"`",
        "axis" => "the nominal rotary axis: `letter`, `origin_mm` and `direction`",
        "letter" => "the letter of the rotary axis, `A`, `B` or `C`",
        "origin_mm" => "a point on the rotary axis, machine frame",
        "surface" => "the nominal surface: `shape` and what it needs",
        "probe" => "the probe: `tip_radius_mm`",
        "tip_radius_mm" => "the radius of the probe's ball",
        "shape" => "the shape of the nominal surface, e.g. `shape = \"asphere\"`",
        "z0_mm" => "the height of the contact plane above the sensor's reference point",
        _ => "add it",
    }
}

/// A message about a wrong value without the names that Rust gives to types.
fn plain(message: &str) -> String {
    message
        .replace("invalid type: ", "found ")
        .replace("invalid value: ", "found ")
        .replace(", expected struct ", ", expected the section ")
        .replace("floating point", "the number")
        .replace("usize", "a whole number that is not negative")
        .replace("u64", "a whole number that is not negative")
        .replace("a map", "a section")
}
