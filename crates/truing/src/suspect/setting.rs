use super::hypothesis::Hypothesis;
use crate::case::{CASE_FILE, Change, Document, Edit};

/// A setting that was typed: one number, or a list of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Typed {
    pub(crate) path: &'static [&'static str],
    /// What it is where it is not written.
    pub(crate) unwritten: Option<f64>,
}

impl Typed {
    pub(crate) const fn of(path: &'static [&'static str]) -> Self {
        Self { path, unwritten: None }
    }
}

/// A number of `case.toml`.
pub(crate) fn number(document: &Document, path: &[&'static str]) -> Option<f64> {
    number_of(&document.value(path)?)
}

/// A list of numbers of `case.toml`; `None` where it is none.
pub(crate) fn numbers(document: &Document, path: &[&'static str]) -> Option<Vec<f64>> {
    document.value(path)?.as_array()?.iter().map(number_of).collect()
}

/// The number that a value is.
pub(super) fn number_of(value: &toml::Value) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "settings are small numbers")]
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// A setting as it is called in a message.
pub(super) fn name_of(path: &[&str]) -> String {
    let (key, sections) = path.split_last().unwrap_or((&"", &[]));
    match sections {
        [section, ..] => format!("[{section}] {key}"),
        [] => (*key).to_owned(),
    }
}

/// A number of `case.toml` times a factor; `what` says what is wrong with it as it stands.
pub(crate) fn scaled_setting(
    document: &Document,
    path: &[&'static str],
    effect: &'static str,
    what: &str,
    factor: f64,
) -> Option<Hypothesis> {
    let number = number(document, path)?;
    let value = toml::Value::Float(number * factor);
    let to = number * factor;
    Some(other_setting(path, effect, &format!("{what}: {to} instead of {number}"), value))
}

/// Another value of a setting.
pub(crate) fn other_setting(
    path: &[&'static str],
    effect: &'static str,
    what: &str,
    value: toml::Value,
) -> Hypothesis {
    let name = name_of(path);
    let description = format!("`{name}` of {CASE_FILE} is {what}");
    let change = Change::Setting { path: path.to_vec(), value };
    let edits = vec![Edit { file: CASE_FILE, change }];
    Hypothesis::of(effect, (CASE_FILE, &[name.as_str()]), description, edits)
}

/// Lengths of `case.toml` in other units, or a diameter for a radius.
pub(crate) fn lengths(document: &Document, path: &[&'static str]) -> Vec<Hypothesis> {
    let units = [
        ("in another unit, inches", 25.4),
        ("in another unit, metres", 1e3),
        ("in another unit, µm", 1e-3),
        ("in another unit, cm", 10.0),
    ];
    let units = units
        .iter()
        .filter_map(|(what, factor)| scaled_setting(document, path, "input:unit", what, *factor));
    let is_radius = path.last().is_some_and(|key| key.contains("radius"));
    let radii = [("the diameter, not the radius", 0.5), ("half of the radius", 2.0)];
    let radii = radii.iter().filter(|_| is_radius).filter_map(|(what, factor)| {
        scaled_setting(document, path, "input:diameter", what, *factor)
    });
    radii.chain(units).collect()
}
