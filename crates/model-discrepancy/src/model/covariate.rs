//! Quantities recorded beside the observations.

/// A quantity recorded beside the observations that the declared model does not use.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariate {
    /// Column name, unit suffix included.
    pub name: String,
    /// One value per observation; finite.
    pub values: Vec<f64>,
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a covariate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A column recorded by the user.
    Recorded,
    /// A position or setting at which the observation was made, from the model's own input.
    Coordinate,
}
