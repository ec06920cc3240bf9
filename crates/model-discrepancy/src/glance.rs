//! Shapes along a covariate at a glance: the classical F test tells which are worth a hearing.

use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::linear::Linear;
use crate::shape::{MIN_SHAPE_KEPT, Shape, is_constant};
use crate::significance::{Significance, f_test};

/// Shapes whose columns are taken together: more would not stay in a processor's cache.
const TOGETHER: usize = 16;

/// What shapes are tested beside.
pub(crate) struct Onlooker<'a> {
    pub(crate) lin: &'a Linear<'a>,
    /// What the system leaves of the data.
    clean: &'a DVector<f64>,
    /// What it leaves of the constants that go along with a shape.
    constants: Basis,
    /// What both leave of the data.
    varying: DVector<f64>,
}

impl<'a> Onlooker<'a> {
    pub(crate) fn new(lin: &'a Linear<'a>, clean: &'a DVector<f64>) -> Self {
        let ones = vec![1.0; lin.layout.observations.len()];
        let tangent = DMatrix::from_columns(&lin.followed(&ones));
        let beside = lin.basis.reject_columns(&tangent);
        let mut constants = Basis::empty(tangent.nrows());
        for (left, whole) in beside.column_iter().zip(tangent.column_iter()) {
            constants.push(&left.into_owned(), whole.norm(), MIN_SHAPE_KEPT);
        }
        let varying = constants.reject(clean);
        Self { lin, clean, constants, varying }
    }

    /// The F test of each shape beside the constants that go along; `None` where nothing is left
    /// to test.
    pub(crate) fn glances(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        shapes.chunks(TOGETHER).flat_map(|some| self.together(some)).collect()
    }

    fn together(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        let columns = |shape: &Shape| -> Vec<DVector<f64>> {
            let varying = shape.functions.iter().filter(|(name, _)| !is_constant(name));
            varying.flat_map(|(_, values)| self.lin.followed(values)).collect()
        };
        let columns: Vec<_> = shapes.iter().map(columns).collect();
        let tangent = DMatrix::from_columns(&columns.concat());
        let beside = self.lin.basis.reject_columns(&tangent);
        let nothing = Basis::empty(tangent.nrows());
        let mut start = 0;
        let glance = |(shape, columns): (&Shape, &Vec<DVector<f64>>)| {
            let along = shape.functions.iter().any(|(name, _)| is_constant(name));
            let (constants, residual) =
                if along { (&self.constants, &self.varying) } else { (&nothing, self.clean) };
            let mut added = nothing.clone();
            for (i, whole) in columns.iter().enumerate() {
                let left = constants.reject(&beside.column(start + i).into_owned());
                added.push(&left, whole.norm(), MIN_SHAPE_KEPT);
            }
            start += columns.len();
            f_test(residual, self.lin.basis.dim() + constants.dim(), &added)
        };
        shapes.iter().zip(&columns).map(glance).collect()
    }
}
