use std::sync::Arc;

use model_discrepancy::{
    Closure, Covariate, Effect, Layout, Model, Parameter, Proposal, Remaining, State,
};
use nalgebra::{DMatrix, DVector};

use crate::kinds::Prepared;

/// The case's model with effects of fixed size in what counts as declared.
///
/// An amplitude of this model is what an effect has on top of what was carried.
struct Carrying<'c> {
    inner: Arc<dyn Model + Send + 'c>,
    carried: Vec<DVector<f64>>,
}

/// What the loop needs, with `carried` amplitudes in the declared model.
pub(crate) fn carrying(prepared: Prepared<'_>, carried: Vec<DVector<f64>>) -> Prepared<'_> {
    let Prepared { model, covariates, estimates } = prepared;
    let on_top = carried.clone();
    let estimates = Box::new(move |closure: &Closure| {
        let mut closure = closure.clone();
        closure.state = with(&closure.state, &on_top);
        estimates(&closure)
    });
    let covariates: Vec<Covariate> = covariates;
    Prepared { model: Arc::new(Carrying { inner: model, carried }), covariates, estimates }
}

fn with(at: &State, carried: &[DVector<f64>]) -> State {
    let amplitudes = at.amplitudes.iter().zip(carried).map(|(a, c)| a + c).collect();
    State { base: at.base.clone(), amplitudes }
}

impl Carrying<'_> {
    fn at(&self, at: &State) -> State {
        with(at, &self.carried)
    }
}

impl Model for Carrying<'_> {
    fn layout(&self) -> &Layout {
        self.inner.layout()
    }

    fn base(&self) -> &[Parameter] {
        self.inner.base()
    }

    fn effects(&self) -> &[Effect] {
        self.inner.effects()
    }

    fn start(&self) -> DVector<f64> {
        self.inner.start()
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        self.inner.residuals(&self.at(at))
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.inner.base_jacobian(&self.at(at))
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.inner.tangent(&self.at(at), effect)
    }

    fn local_tangent(&self, at: &State, effect: usize) -> Option<(usize, DMatrix<f64>)> {
        self.inner.local_tangent(&self.at(at), effect)
    }

    fn doubts(&self) -> Vec<Remaining> {
        self.inner.doubts()
    }

    fn common_scatter(&self) -> bool {
        self.inner.common_scatter()
    }

    fn proposals(&self) -> Vec<Proposal> {
        self.inner.proposals()
    }
}
