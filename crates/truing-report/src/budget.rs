//! Where the uncertainty of every result comes from.

/// Uncertainties by linear propagation beside those over draws of the data (JCGM 100, JCGM 101).
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Draws of which the model was solved.
    pub draws: usize,
    /// Draws of which it could not be.
    pub failed: usize,
    /// What is uncertain, in words: file and key.
    pub sources: Vec<String>,
    /// One per result.
    pub results: Vec<BudgetResult>,
}

/// The uncertainty of one result.
#[derive(Clone, Debug, PartialEq)]
pub struct BudgetResult {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Estimate from the data as they are.
    pub value: f64,
    /// Standard uncertainty by linear propagation.
    pub linear_std: f64,
    /// Standard deviation over the draws.
    pub std: f64,
    /// Probabilistically symmetric 95 % coverage interval.
    pub interval_95: [f64; 2],
    /// Standard deviation where one source alone is drawn, one per source.
    pub by_source: Vec<f64>,
}
