use std::collections::HashMap;
use std::sync::Arc;

use model_discrepancy::{
    Condensed, Effect, Group, Layout, Model, Parameter, Proposal, Remaining, Role, State,
};
use nalgebra::{DMatrix, DVector, Vector3};

/// A model whose observations are grouped by a column of the user's.
pub(crate) struct Regrouped<'m> {
    inner: Arc<dyn Model + Send + 'm>,
    layout: Layout,
}

impl<'m> Regrouped<'m> {
    /// `names` holds the group of each observation.
    ///
    /// Observations that are only judged never share a group with fitted ones; prior knowledge
    /// keeps its own groups.
    pub(crate) fn new(inner: Arc<dyn Model + Send + 'm>, names: &[String]) -> Self {
        let mut layout = inner.layout().clone();
        let before = std::mem::take(&mut layout.groups);
        let mut known: HashMap<(String, u8), usize> = HashMap::new();
        for (observation, group) in layout.observations.iter_mut().enumerate() {
            let Group { name, role } = &before[*group];
            let name = match (role, names.get(observation)) {
                (Role::Prior, _) | (_, None) => name.clone(),
                (_, Some(name)) => name.clone(),
            };
            let key = match role {
                Role::Fit => 0,
                Role::Check => 1,
                Role::Prior => 2,
            };
            *group = *known.entry((name.clone(), key)).or_insert_with(|| {
                layout.groups.push(Group { name, role: *role });
                layout.groups.len() - 1
            });
        }
        Self { inner, layout }
    }
}

impl Model for Regrouped<'_> {
    fn layout(&self) -> &Layout {
        &self.layout
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
        self.inner.residuals(at)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.inner.base_jacobian(at)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.inner.tangent(at, effect)
    }

    fn local_tangent(&self, at: &State, effect: usize) -> Option<(usize, DMatrix<f64>)> {
        self.inner.local_tangent(at, effect)
    }

    fn records(&self) -> Option<&[usize]> {
        self.inner.records()
    }

    fn condensed(&self) -> &[Condensed] {
        self.inner.condensed()
    }

    fn directions(&self) -> Option<&[Vector3<f64>]> {
        self.inner.directions()
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
