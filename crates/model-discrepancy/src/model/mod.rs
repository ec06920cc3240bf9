//! What the loop needs to know of a domain: one trait, and the plain data it speaks of.

mod check;
pub(crate) mod covariate;
mod declared;
mod differences;
mod effect;
mod extended;
mod inside;
mod joint;
mod linear;
pub(crate) mod moved;
mod resolution;
pub(crate) mod validate;

use nalgebra::{DMatrix, DVector};

pub use check::check_tangents;
pub use covariate::{Covariate, Origin, Quantity};
pub use declared::{Cells, Declared, Group, Layout, Projected, Remaining, Role, Row};
pub use differences::Differenced;
pub use effect::{Effect, Parameter, Scope};
pub use extended::Extended;
pub use inside::Inside;
pub use joint::{CommonEffect, Joint, JointPart, ShownAmplitude};
pub use linear::LinearModel;
pub use resolution::resolution_of;

/// A declared model with its data, and the effects that it leaves out.
///
/// What is known beforehand is data, [`Declared`]; the methods are what must be computed. None has a
/// default, so that a model around another one cannot leave anything out. [`Differenced`] is a model
/// of which only the residual is written down, [`LinearModel`] one that is linear throughout.
///
/// Residual rows are in the unit they are reported in; [`Row::sigma`] whitens them. Parameters
/// are plain vectors: a pose enters as a chart around a nearby pose.
///
/// An effect that is not part of the model has amplitude zero. The residual is one function of
/// base parameters and *all* amplitudes, so that any set of effects can be switched on.
pub trait Model: Sync {
    /// What is known of the model without computing; fixed for its life.
    fn declared(&self) -> &Declared;

    /// Residuals (observed − predicted, or as the domain documents), one per row.
    fn residuals(&self, at: &State) -> DVector<f64>;

    /// `∂ residual / ∂ base`, `rows × base`.
    fn base_jacobian(&self, at: &State) -> DMatrix<f64>;

    /// `∂ residual / ∂ amplitude` of one effect, `rows × parameters of the effect`: all rows, or
    /// those of the one observation that the effect moves ([`Scope::Observation`]).
    ///
    /// A column of zeros is an error unless the effect says that there are such designs
    /// ([`Scope::SomeDesigns`]).
    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64>;

    /// Scatter inside the observations, where these are means of several readings; `None` where an
    /// observation is a reading, or no noise of readings was declared.
    ///
    /// With it the global test is one of the readings: declared noise is theirs, and with memory
    /// it is another in their means.
    fn inside(&self, at: &State) -> Option<Inside>;

    /// Further measurements that the user could make, the cheapest first; none is an answer.
    ///
    /// The loop uses them to say which measurement would tell two effects apart.
    fn proposals(&self) -> Vec<Proposal<'_>>;
}

/// [`Model::tangent`] on all rows of the layout, whatever the scope of the effect.
#[must_use]
pub fn whole_tangent(model: &dyn Model, at: &State, effect: usize) -> DMatrix<f64> {
    let tangent = model.tangent(at, effect);
    let declared = model.declared();
    let Scope::Observation(observation) = declared.effects[effect].scope else { return tangent };
    let rows = &declared.layout.rows;
    let mut whole = DMatrix::zeros(rows.len(), tangent.ncols());
    if let Some(first) = rows.iter().position(|row| row.observation == observation) {
        whole.rows_mut(first, tangent.nrows()).copy_from(&tangent);
    }
    whole
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

    /// Where the fit of a model starts: [`Declared::start`], and every amplitude zero.
    #[must_use]
    pub fn start(model: &dyn Model) -> Self {
        let Declared { start, effects, .. } = model.declared();
        Self::declared(start.clone(), effects)
    }

    /// Whether an effect is in the model: whether one of its amplitudes is not zero.
    #[must_use]
    pub fn has(&self, effect: usize) -> bool {
        self.amplitudes[effect].iter().any(|a| *a != 0.0)
    }
}

/// A further measurement that the user could make.
///
/// Its model is as large as that of the data, and is built when it is asked for.
pub struct Proposal<'a> {
    /// What to do, in the imperative: «press at a second load».
    pub text: String,
    build: Box<dyn Fn() -> Option<Box<dyn Model>> + 'a>,
}

impl<'a> Proposal<'a> {
    /// What to do, and the model with that measurement added (its value does not matter, only its
    /// design), `None` where it cannot be made; effects are matched by id and subject.
    pub fn new<M: Model + 'static>(
        text: impl Into<String>,
        build: impl Fn() -> Option<M> + 'a,
    ) -> Self {
        let boxed = move || Some(Box::new(build()?) as Box<dyn Model>);
        Self { text: text.into(), build: Box::new(boxed) }
    }

    /// The model with that measurement added; `None` where it cannot be made.
    #[must_use]
    pub fn model(&self) -> Option<Box<dyn Model>> {
        (self.build)()
    }
}

impl std::fmt::Debug for Proposal<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Proposal").field("text", &self.text).finish_non_exhaustive()
    }
}
