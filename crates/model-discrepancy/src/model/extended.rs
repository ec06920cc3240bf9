//! A model with effects of one's own beside those that it has.

use nalgebra::{DMatrix, DVector};

use super::{Declared, Effect, Inside, Model, Proposal, Scope, State};
use crate::LoopError;

/// Another model with further effects, each linear in its amplitudes.
///
/// For what is known of one machine and of no other: nobody has to change the crate that the model
/// comes from. Its proposals are those of the model, which know nothing of the further effects: they
/// tell the model's own apart.
#[derive(Clone, Debug)]
pub struct Extended<M> {
    model: M,
    declared: Declared,
    /// One per further effect.
    tangents: Vec<DMatrix<f64>>,
}

impl<M: Model> Extended<M> {
    /// The model as it is.
    #[must_use]
    pub fn new(model: M) -> Self {
        let declared = model.declared().clone();
        Self { model, declared, tangents: Vec::new() }
    }

    /// The same with one more effect; `tangent` is `∂ residual / ∂ amplitude` as in
    /// [`Model::tangent`], one column per parameter. What adds to a prediction lowers a residual
    /// that is observed − predicted.
    ///
    /// # Errors
    ///
    /// [`LoopError::InconsistentModel`] where the tangent has not one row per row of the layout (or
    /// of the one observation that it moves) and one column per parameter, and where rows are
    /// combinations of readings ([`Declared::projected`]), of which nobody can say this.
    pub fn with(mut self, effect: Effect, tangent: DMatrix<f64>) -> Result<Self, LoopError> {
        let fits = |needed, fits: bool| {
            if fits {
                Ok(())
            } else {
                Err(LoopError::InconsistentModel { field: "tangent", needed })
            }
        };
        fits("rows that are readings", self.declared.projected.is_empty())?;
        let rows = &self.declared.layout.rows;
        let moved = match effect.scope {
            Scope::Observation(o) => rows.iter().filter(|row| row.observation == o).count(),
            Scope::Everywhere | Scope::SomeDesigns => rows.len(),
        };
        fits("one row per row that the effect moves", tangent.nrows() == moved)?;
        fits("one column per parameter", tangent.ncols() == effect.parameters.len())?;
        self.declared.effects.push(effect);
        self.tangents.push(tangent);
        Ok(self)
    }

    /// The model without the further effects.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// A state as the model knows it.
    fn inner(&self, at: &State) -> State {
        let own = self.model.declared().effects.len();
        State { base: at.base.clone(), amplitudes: at.amplitudes[..own].to_vec() }
    }
}

impl<M: Model> Model for Extended<M> {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut residual = self.model.residuals(&self.inner(at));
        let own = self.model.declared().effects.len();
        for (effect, amplitudes) in at.amplitudes.iter().enumerate().skip(own) {
            if amplitudes.iter().any(|a| *a != 0.0) {
                residual.gemv(1.0, &super::whole_tangent(self, at, effect), amplitudes, 1.0);
            }
        }
        residual
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.model.base_jacobian(&self.inner(at))
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        match effect.checked_sub(self.model.declared().effects.len()) {
            Some(further) => self.tangents[further].clone(),
            None => self.model.tangent(&self.inner(at), effect),
        }
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        self.model.inside(&self.inner(at))
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        self.model.proposals()
    }
}
