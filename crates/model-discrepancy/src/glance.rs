//! Shapes along a covariate at a glance: the classical F test tells which are worth a hearing.

use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::linear::Linear;
use crate::shape::{MIN_SHAPE_KEPT, Shape, constant_of, is_constant};
use crate::significance::{count, f_tail};

/// Shapes whose columns are taken together: more would not stay in a processor's cache.
const TOGETHER: usize = 16;

/// What shapes are tested beside.
pub(crate) struct Onlooker<'a> {
    lin: &'a Linear<'a>,
    /// What the system leaves of the data.
    clean: &'a DVector<f64>,
    /// What it leaves of the constants that go along with a shape.
    constants: Basis,
}

/// A shape by the classical F test alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glance {
    /// What it takes away beside the constants that go along.
    pub(crate) explained: f64,
    pub(crate) p_value: f64,
}

impl<'a> Onlooker<'a> {
    pub(crate) fn new(lin: &'a Linear<'a>, clean: &'a DVector<f64>) -> Self {
        let ones = constant_of(lin.layout.observations.len());
        let tangent = DMatrix::from_columns(&lin.followed(&ones));
        let beside = lin.basis.reject_columns(&tangent);
        let mut constants = Basis::empty(tangent.nrows());
        for (left, whole) in beside.column_iter().zip(tangent.column_iter()) {
            constants.push(&left.into_owned(), whole.norm(), MIN_SHAPE_KEPT);
        }
        Self { lin, clean, constants }
    }

    /// One a shape.
    pub(crate) fn glances(&self, shapes: &[Shape]) -> Vec<Glance> {
        shapes.chunks(TOGETHER).flat_map(|some| self.together(some)).collect()
    }

    fn together(&self, shapes: &[Shape]) -> Vec<Glance> {
        let columns = |shape: &Shape| -> Vec<DVector<f64>> {
            let varying = shape.functions.iter().filter(|(name, _)| !is_constant(name));
            varying.flat_map(|(_, values)| self.lin.followed(values)).collect()
        };
        let columns: Vec<_> = shapes.iter().map(columns).collect();
        let tangent = DMatrix::from_columns(&columns.concat());
        let beside = self.lin.basis.reject_columns(&tangent);
        let mut next = 0..;
        let mut glance = |(shape, columns): (&Shape, &Vec<DVector<f64>>)| {
            let along = shape.functions.iter().any(|(name, _)| is_constant(name));
            let nothing = || Basis::empty(tangent.nrows());
            let mut own = if along { self.constants.clone() } else { nothing() };
            let n_constants = own.dim();
            for (whole, at) in columns.iter().zip(next.by_ref()) {
                own.push(&beside.column(at).into_owned(), whole.norm(), MIN_SHAPE_KEPT);
            }
            self.glance(&own, n_constants)
        };
        shapes.iter().zip(&columns).map(&mut glance).collect()
    }

    /// The columns of `own` after the constants, tested beside these.
    fn glance(&self, own: &Basis, n_constants: usize) -> Glance {
        let explained = own.explained_from(n_constants, self.clean);
        let left = self.clean.norm_squared() - own.explained(self.clean);
        let directions = own.dim() - n_constants;
        let dof = self.clean.len().saturating_sub(self.lin.basis.dim() + own.dim());
        if directions == 0 || dof == 0 {
            return Glance { explained, p_value: 1.0 };
        }
        let ratio = (explained / count(directions)) / (left.max(0.0) / count(dof));
        Glance { explained, p_value: f_tail(ratio, count(directions), count(dof)) }
    }
}
