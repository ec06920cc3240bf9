//! The declared model as data: rows, groups, parameters, effects, and what is known of the noise.

use nalgebra::{DMatrix, DVector, Vector3};

use super::{Effect, Parameter};

/// What is known of a model without computing.
///
/// [`Declared::new`] fills what few models need with nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declared {
    /// Observations, groups and rows.
    pub layout: Layout,
    /// Parameters of the declared model, one per entry of [`State::base`](crate::State::base).
    pub base: Vec<Parameter>,
    /// Base parameters to start the fit from; amplitudes start at zero.
    pub start: DVector<f64>,
    /// Candidate effects, in the order of [`State::amplitudes`](crate::State::amplitudes).
    pub effects: Vec<Effect>,
    /// Structure that the domain sees inside its observations, where the loop does not look.
    ///
    /// It is reported as left over, and nothing is «explained» while it is there.
    pub findings: Vec<Remaining>,
    /// Whether observations may scatter by more than [`Row::sigma`], all alike.
    ///
    /// True where sigma is known from inside each observation (the noise of its record) and says
    /// nothing of how well an observation repeats. The loop then adds to the reported rows the
    /// one variance that makes the residual most likely, anew for every set of effects.
    pub between_variance: bool,
    /// The record that each observation belongs to: a channel, the lock of one beam.
    ///
    /// Successive observations of a record may depend on each other, also where they belong to
    /// different groups. `None`: all are one series, and whether groups depend on each other is
    /// not said: the scatter between them is taken for what they disagree by.
    pub records: Option<Vec<usize>>,
    /// Rows that are what is left of several observations once unknowns of their own are taken out
    /// of these.
    ///
    /// Noise with memory is then in the observations, record by record, and not in the rows. A row
    /// that is in none of them is one observation.
    pub projected: Vec<Projected>,
    /// Unit vector along which each observation, a scalar, reads a displacement of the machine: the
    /// normal of a touch.
    ///
    /// Where it is given, the noise may also be one of the machine's position that changes slowly:
    /// two successive readings then agree as far as they look the same way.
    pub directions: Option<Vec<Vector3<f64>>>,
    /// The place of each observation, where coordinates alone do not say which repeat each other:
    /// equal numbers were made at one place, under one load, along one beam.
    pub places: Option<Vec<usize>>,
    /// What observations may have an error in common by, where no effect says so: the station and the step that they were
    /// read from and at. Noise does not do so.
    pub cells: Vec<Cells>,
    /// How finely the readings are recorded, in the unit of the reported rows; 0 where they are
    /// means of many. What is accepted must be found again where they are moved within it.
    pub resolution: f64,
}

impl Declared {
    /// A model whose parameters start at zero, and of which nothing else is known.
    #[must_use]
    pub fn new(layout: Layout, base: Vec<Parameter>, effects: Vec<Effect>) -> Self {
        let start = DVector::zeros(base.len());
        Self { layout, base, start, effects, ..Self::default() }
    }
}

/// How rows belong to observations, and observations to groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// One per residual.
    pub rows: Vec<Row>,
    /// One per observation (a point, a press, a sample): the group it belongs to.
    ///
    /// In the order measured.
    pub observations: Vec<usize>,
    /// Units that are left out together, in the order measured.
    pub groups: Vec<Group>,
    /// Unit of the reported residual, e.g. `mm`.
    pub unit: String,
    /// Whether `Row::sigma` was declared by the user; otherwise it only weighs rows against
    /// each other, and the noise is estimated from the residual.
    pub sigma_declared: bool,
}

impl Layout {
    /// One row and one group per name, in the order measured; all are fitted.
    ///
    /// `sigma` is the standard uncertainty of a reading, `None` where the residual is to tell.
    pub fn scalars<N: Into<String>>(
        names: impl IntoIterator<Item = N>,
        unit: &str,
        sigma: Option<f64>,
    ) -> Self {
        let group = |name: N| Group { name: name.into(), role: Role::Fit };
        let groups: Vec<Group> = names.into_iter().map(group).collect();
        let sigma_declared = sigma.is_some();
        let sigma = sigma.unwrap_or(1.0);
        let row = |observation| Row { observation, component: 0, sigma, reported: true };
        let (rows, observations) = (0..groups.len()).map(|i| (row(i), i)).unzip();
        Self { rows, observations, groups, unit: unit.to_owned(), sigma_declared }
    }
}

/// One residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Index into [`Layout::observations`].
    pub observation: usize,
    /// Which component of the observation: 0, 1, 2 for x, y, z.
    pub component: usize,
    /// Standard uncertainty of the residual, in its own unit.
    pub sigma: f64,
    /// Whether the row counts in the reported residual; false for rows in another unit.
    pub reported: bool,
}

/// A way in which observations belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// What those of one cell share.
    pub what: String,
    /// Cell of each observation.
    pub of_observation: Vec<usize>,
}

/// Successive rows that are combinations of a few readings.
///
/// The readings are alike (one sigma), and the combinations orthonormal: white noise of the readings
/// is white noise of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Projected {
    /// The first of the rows.
    pub first_row: usize,
    /// Of each reading the index into [`Layout::observations`], and which component of it.
    pub readings: Vec<(usize, usize)>,
    /// `rows × readings`.
    pub combination: DMatrix<f64>,
}

/// A unit that is fitted, or left out, as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name as the user knows it.
    pub name: String,
    /// What the group is for.
    pub role: Role,
}

/// What a group is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Fitted; left out in turn when the error on unseen data is judged.
    Fit,
    /// Never fitted, only judged.
    Check,
    /// Prior knowledge: always fitted, never left out, never judged.
    Prior,
}

/// Structure left in the residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Remaining {
    /// Column along which it shows.
    pub covariate: String,
    /// Its shape: `linear`, `smooth`, `periodic`, `two-valued`, `lagged`, `autocorrelated`, …
    pub shape: String,
    /// Significance, before correction.
    pub p_value: f64,
}
