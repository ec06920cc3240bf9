//! Effects that were chosen.

use crate::Pass;
use crate::algebra::system::{Estimate, System};

/// A system as chosen on some groups.
#[derive(Clone)]
pub(crate) struct Selected<'a> {
    pub(crate) system: System<'a>,
    pub(crate) estimate: Estimate,
    pub(crate) added: Vec<Added>,
    /// For the report, where it is asked for.
    pub(crate) passes: Vec<Pass>,
    /// Effects that the declared model's design cannot see, with the share absorbed.
    pub(crate) not_estimable: Vec<(usize, f64)>,
}

/// Something that was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Added {
    pub(crate) what: What,
    pub(crate) p_value: f64,
}

/// What was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    /// Index into the catalogue.
    Effect(usize),
    /// Covariate and shape.
    Empirical(String, String),
}
