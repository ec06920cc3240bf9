use model_discrepancy::{Options, Progress};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use toml::Spanned;

use super::column_kinds::ColumnKinds;

/// The section `[loop]`, the same for every kind.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopSettings {
    /// Column whose equal values make one group.
    pub(crate) group: Option<Spanned<String>>,
    /// What recorded columns hold, where their names do not say it.
    #[serde(default)]
    pub(crate) columns: ColumnKinds,
    /// Probability of adding anything where nothing is missing.
    alpha: Option<Probability>,
    /// Effects and corrections added at most.
    max_steps: Option<u8>,
    /// Who waits for the loop.
    #[serde(skip)]
    pub(crate) progress: Progress,
}

impl LoopSettings {
    /// With at most so many additions, unless the user says how many.
    pub(crate) fn or_at_most(mut self, max_steps: u8) -> Self {
        self.max_steps.get_or_insert(max_steps);
        self
    }

    /// The engine's options with what the user set.
    pub(crate) fn options(&self) -> Options {
        let mut options = Options { progress: self.progress.clone(), ..Options::default() };
        if let Some(Probability(alpha)) = self.alpha {
            options.alpha = alpha;
        }
        if let Some(max_steps) = self.max_steps {
            options.max_steps = usize::from(max_steps);
        }
        options
    }
}

/// Strictly between 0 and ½.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Probability(f64);

impl<'de> Deserialize<'de> for Probability {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = f64::deserialize(deserializer)?;
        if value > 0.0 && value < 0.5 {
            Ok(Self(value))
        } else {
            Err(D::Error::custom(format_args!(
                "expected a number between 0 and 0.5, found {value}"
            )))
        }
    }
}
