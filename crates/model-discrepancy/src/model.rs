//! What the loop needs to know of a domain: one trait, and the plain data it speaks of.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::Remaining;

/// A declared model with its data, and the effects that it leaves out.
///
/// Residual rows are in the unit they are reported in; [`Row::sigma`] whitens them. Parameters
/// are plain vectors: a pose enters as a chart around a nearby pose.
///
/// An effect that is not part of the model has amplitude zero. The residual is one function of
/// base parameters and *all* amplitudes, so that any set of effects can be switched on.
pub trait Model: Sync {
    /// Observations, groups and rows; fixed for the life of the model.
    fn layout(&self) -> &Layout;

    /// Parameters of the declared model, one per entry of [`State::base`].
    fn base(&self) -> &[Parameter];

    /// Candidate effects, in the order of [`State::amplitudes`].
    fn effects(&self) -> &[Effect];

    /// Base parameters to start the fit from; amplitudes start at zero.
    fn start(&self) -> DVector<f64>;

    /// Residuals (observed − predicted, or as the domain documents), one per row.
    fn residuals(&self, at: &State) -> DVector<f64>;

    /// `∂ residual / ∂ base`, `rows × base`.
    fn base_jacobian(&self, at: &State) -> DMatrix<f64>;

    /// `∂ residual / ∂ amplitude` of one effect, `rows × parameters of the effect`.
    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64>;

    /// The tangent of an effect that moves one observation only: which, and its rows there.
    ///
    /// Must agree with [`Model::tangent`], which is zero in all other rows. The rows of that
    /// observation must follow each other. A catalogue with one candidate per observation is
    /// searched in a time that grows with their number, and not with its square, where this is
    /// given.
    fn local_tangent(&self, _at: &State, _effect: usize) -> Option<(usize, DMatrix<f64>)> {
        None
    }

    /// Structure that the domain sees inside its observations, where the loop does not look.
    ///
    /// It is reported as left over, and nothing is «explained» while it is there.
    fn doubts(&self) -> Vec<Remaining> {
        Vec::new()
    }

    /// Whether observations may scatter by more than [`Row::sigma`], all alike.
    ///
    /// True where sigma is known from inside each observation (the noise of its record) and says
    /// nothing of how well an observation repeats. The loop then adds to the reported rows the
    /// one variance that makes the residual most likely, anew for every set of effects.
    fn common_scatter(&self) -> bool {
        false
    }

    /// The record that each observation belongs to: a channel, the lock of one beam.
    ///
    /// Successive observations of a record may depend on each other, also where they belong to
    /// different groups. `None`: all are one series, and whether groups depend on each other is
    /// not said: the scatter between them is taken for what they disagree by.
    fn records(&self) -> Option<&[usize]> {
        None
    }

    /// Rows that are what is left of several observations once unknowns of their own are taken out of
    /// these.
    ///
    /// Noise with memory is then in the observations, record by record, and not in the rows. A row
    /// that is in none of them is one observation.
    fn condensed(&self) -> &[Condensed] {
        &[]
    }

    /// Unit vector along which each observation, a scalar, reads a displacement of the machine: the
    /// normal of a touch.
    ///
    /// Where it is given, the noise may also be one of the machine's position that changes slowly:
    /// two successive readings then agree as far as they look the same way.
    fn directions(&self) -> Option<&[Vector3<f64>]> {
        None
    }

    /// Further measurements that the user could make, the cheapest first.
    ///
    /// The loop uses them to say which measurement would tell two effects apart.
    fn proposals(&self) -> Vec<Proposal> {
        Vec::new()
    }
}

/// Base parameters and the amplitudes of every catalogue effect.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Parameters of the declared model.
    pub base: DVector<f64>,
    /// One vector per effect; all zeros where the effect is absent.
    pub amplitudes: Vec<DVector<f64>>,
}

impl State {
    /// The declared model alone: `base`, and every amplitude zero.
    #[must_use]
    pub fn declared(base: DVector<f64>, effects: &[Effect]) -> Self {
        let amplitudes = effects.iter().map(|e| DVector::zeros(e.parameters.len())).collect();
        Self { base, amplitudes }
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

/// Successive rows that are combinations of a few observations.
///
/// The observations are alike (one sigma), and the combinations orthonormal: white noise of the
/// observations is white noise of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Condensed {
    /// The first of the rows.
    pub first_row: usize,
    /// Indices into [`Layout::observations`].
    pub observations: Vec<usize>,
    /// `rows × observations`.
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

/// A physical effect that the declared model lacks.
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
    /// Its amplitudes.
    pub parameters: Vec<Parameter>,
}

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

/// A further measurement that the user could make.
pub struct Proposal {
    /// What to do, in the imperative: «press at a second load».
    pub text: String,
    /// The model with that measurement added (its value does not matter, only its design);
    /// effects are matched by id and subject.
    pub model: Box<dyn Model>,
}

impl std::fmt::Debug for Proposal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Proposal").field("text", &self.text).finish_non_exhaustive()
    }
}
