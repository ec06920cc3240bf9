use crate::Progress;

/// Settings of the loop; the defaults are the same for every kind of data.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Probability of adding anything at all where nothing is missing; 0.05.
    ///
    /// Shared out over the catalogue, pairs of effects and covariates. Once something was added the
    /// next pass looks again, at two fifths of it: an answer must be right as a whole.
    pub alpha: f64,
    /// Effects and empirical corrections added at most; 6. More than that is curve fitting.
    pub max_steps: usize,
    /// Whether to repeat the choice of effects without each fold (nested hold-out); true.
    ///
    /// Switched off, the held-out error is that of the effects chosen on all groups.
    pub nested: bool,
    /// Counts the repetitions of the choice while the loop runs; nobody asks by default.
    pub progress: Progress,
}

impl Default for Options {
    fn default() -> Self {
        Self { alpha: 0.05, max_steps: 6, nested: true, progress: Progress::default() }
    }
}
