//! Quantities recorded beside the observations.

use super::Layout;

/// Name of the covariate that every data set has: the order in which it was measured.
pub(crate) const ORDER: &str = "order";

/// A quantity recorded beside the observations that the declared model does not use.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariate {
    /// Column name, unit suffix included.
    pub name: String,
    /// One value per observation; finite.
    pub values: Vec<f64>,
    /// Where it comes from.
    pub origin: Origin,
    /// What it is; nothing is read from its name.
    pub quantity: Quantity,
}

impl Covariate {
    /// A column recorded beside the observations.
    pub fn recorded(name: impl Into<String>, quantity: Quantity, values: Vec<f64>) -> Self {
        Self { name: name.into(), values, origin: Origin::Recorded, quantity }
    }

    /// A position or setting from the model's own input.
    pub fn coordinate(name: impl Into<String>, quantity: Quantity, values: Vec<f64>) -> Self {
        Self { name: name.into(), values, origin: Origin::Coordinate, quantity }
    }

    /// Whether it runs on with the measurement, as the measured order does.
    pub(crate) fn is_course(&self) -> bool {
        matches!(self.quantity, Quantity::Order | Quantity::Time)
    }
}

/// What a covariate is a value of; it decides which shapes are looked for along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The order of measurement. Every data set has it; no need to give it.
    Order,
    /// A time in s: a course along it may break off.
    Time,
    /// A temperature in °C, whose effects are proportional to what it differs from 20 °C (ISO 1).
    Temperature,
    /// An angle in degrees, periodic where it covers enough of a turn.
    Angle,
    /// A position in mm.
    Position,
    /// Anything else.
    Other,
}

/// Where a covariate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A column recorded by the user.
    Recorded,
    /// A position or setting at which the observation was made, from the model's own input.
    Coordinate,
}

/// The given covariates that vary, and the measured order.
pub(crate) fn with_order(layout: &Layout, covariates: &[Covariate]) -> Vec<Covariate> {
    let varies = |c: &&Covariate| c.values.iter().any(|v| v.total_cmp(&c.values[0]).is_ne());
    let mut all: Vec<_> = covariates.iter().filter(varies).cloned().collect();
    let n = layout.observations.len();
    let order = (0..n).map(crate::count::count).collect();
    all.push(Covariate::coordinate(ORDER, Quantity::Order, order));
    all
}
