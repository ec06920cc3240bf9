//! An effect that a declared model may lack, as data.

use nalgebra::DMatrix;

/// A physical effect that the declared model lacks.
///
/// [`Effect::new`] and the methods after it say only what is out of the ordinary.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Catalogue id, e.g. `datum-offset`.
    pub id: String,
    /// The one thing it is about where there is a candidate per thing, e.g. the point's name
    /// for `bad-point`; candidates of one id with subjects are tested as one family.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// The covariate that drives it, e.g. `air_c`, or `None`.
    ///
    /// A driven effect is large where the covariate's mean is large, and that part may be
    /// absorbed by the base model; what is tested is its variation.
    pub driver: Option<String>,
    /// How many like it were looked at in the same data to find it: its p-value is multiplied by
    /// that. One where it was not found by looking.
    pub searched: usize,
    /// Where it was found by looking for its place or time constant, `∂² residual / ∂ amplitude ∂
    /// coordinate` by each coordinate of that place: a matrix per amplitude, with all rows of the
    /// layout and one column per coordinate. Uncertainties count the place as fitted. Empty of others.
    pub by_place: Vec<DMatrix<f64>>,
    /// Whether it is looked for only in place of two effects or more that were named: one that the design hardly tells from
    /// others, for which it would stand in wherever one reading is far off.
    pub only_instead: bool,
    /// What it moves.
    pub scope: Scope,
    /// Size that no amplitude of it has in the world, in internal units; `None` where none is too
    /// large. A fit that needs more describes something else, and the effect is not accepted.
    pub maximum: Option<f64>,
    /// Its amplitudes.
    pub parameters: Vec<Parameter>,
}

/// What an effect moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// Every design shows each of its amplitudes: a tangent column of zeros is a mistake in the model.
    #[default]
    Everywhere,
    /// Designs that show nothing of an amplitude exist: a part that is touched from above does not
    /// show sideways motion.
    SomeDesigns,
    /// One observation alone, by its index in [`Layout::observations`](crate::Layout::observations).
    ///
    /// Its tangent has the rows of that observation only, which must follow each other. A catalogue
    /// with one such effect per observation is searched in a time that grows with their number, and
    /// not with its square.
    Observation(usize),
}

impl Effect {
    /// An effect that every design shows, without subject or driver.
    #[must_use]
    pub fn new(id: &str, description: &str, parameters: Vec<Parameter>) -> Self {
        Self {
            id: id.to_owned(),
            subject: None,
            description: description.to_owned(),
            driver: None,
            searched: 1,
            by_place: Vec::new(),
            only_instead: false,
            scope: Scope::Everywhere,
            maximum: None,
            parameters,
        }
    }

    /// Coordinates of the place, or time constants, that were fitted in looking for it.
    pub(crate) fn coordinates(&self) -> usize {
        self.by_place.first().map_or(0, DMatrix::ncols)
    }

    /// The same about one thing of several.
    #[must_use]
    pub fn about(mut self, subject: &str) -> Self {
        self.subject = Some(subject.to_owned());
        self
    }

    /// The same driven by a covariate.
    #[must_use]
    pub fn driven_by(mut self, covariate: &str) -> Self {
        self.driver = Some(covariate.to_owned());
        self
    }

    /// The same with a size that no amplitude has, in internal units.
    #[must_use]
    pub fn at_most(mut self, maximum: f64) -> Self {
        self.maximum = Some(maximum);
        self
    }

    /// The same with another scope.
    #[must_use]
    pub fn within(mut self, scope: Scope) -> Self {
        self.scope = scope;
        self
    }
}

/// One scalar parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name as reported.
    pub name: String,
    /// Unit as reported.
    pub unit: String,
    /// Reported value = internal value × `report_factor`.
    pub report_factor: f64,
}

impl Parameter {
    /// A parameter, and by what its value is multiplied to be reported in `unit`.
    #[must_use]
    pub fn new(name: &str, unit: &str, report_factor: f64) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), report_factor }
    }
}
