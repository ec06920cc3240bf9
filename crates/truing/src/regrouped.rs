use std::collections::HashMap;
use std::sync::Arc;

use model_discrepancy::{Declared, Group, Inside, Layout, Model, Proposal, Role, State};
use nalgebra::{DMatrix, DVector};

/// A model whose observations are grouped by a column of the user's.
pub(crate) struct Regrouped<'m> {
    inner: Arc<dyn Model + Send + 'm>,
    declared: Declared,
}

impl<'m> Regrouped<'m> {
    /// `names` holds the group of each observation.
    pub(crate) fn new(inner: Arc<dyn Model + Send + 'm>, names: &[String]) -> Self {
        let mut declared = inner.declared().clone();
        regroup(&mut declared.layout, names);
        Self { inner, declared }
    }
}

/// Observations that are only judged never share a group with fitted ones; prior knowledge
/// keeps its own groups.
fn regroup(layout: &mut Layout, names: &[String]) {
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
}

impl Model for Regrouped<'_> {
    fn declared(&self) -> &Declared {
        &self.declared
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

    fn inside(&self, at: &State) -> Option<Inside> {
        self.inner.inside(at)
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        self.inner.proposals()
    }
}
