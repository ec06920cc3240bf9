use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::{Deserializer, Error};
use toml::Spanned;

use super::number::{Finite, Positive};

/// The section `[conformity]`, the same for every kind: what results are held against.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConformitySettings {
    /// Largest magnitude allowed of results, by their names and in their units.
    pub(crate) limits: Option<Spanned<BTreeMap<String, Positive>>>,
    conformance: Option<Conformance>,
}

impl ConformitySettings {
    /// Probability from which on a result passes.
    pub(crate) fn required(&self) -> f64 {
        self.conformance.unwrap_or_default().0
    }
}

/// Probability from which on a thing conforms, above one half and below one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conformance(pub(crate) f64);

/// What ISO 14253-1 takes where nothing else is agreed.
impl Default for Conformance {
    fn default() -> Self {
        Self(0.95)
    }
}

impl<'de> Deserialize<'de> for Conformance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Finite(value) = Finite::deserialize(deserializer)?;
        if value > 0.5 && value < 1.0 {
            return Ok(Self(value));
        }
        Err(D::Error::custom(format_args!(
            "expected a probability above 0.5 and below 1, found {value}"
        )))
    }
}
