//! What candidates are tested beside, on all rows or on some of them, by sums over the rows.

use nalgebra::{DMatrix, DVector};

use crate::algebra::independent::Independent;
use crate::algebra::product::{gram, tr_times};
use crate::levels::MIN_SHAPE_KEPT;

/// Share of its length that each direction of a system must keep on some of the rows for sums over
/// the others to hold enough digits.
const WELL_DETERMINED: f64 = 1e-3;

/// Sums over rows of the products of a system's directions, of the constants that may go along with
/// a shape, one a component, and of what the system leaves of the data.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    pub(crate) rows: usize,
    constants: usize,
    /// Directions, constants, data.
    products: DMatrix<f64>,
}

impl Sums {
    /// Over rows of these columns.
    pub(crate) fn of(
        directions: &DMatrix<f64>,
        constants: &DMatrix<f64>,
        left: &DVector<f64>,
    ) -> Self {
        let columns = directions.column_iter().chain(constants.column_iter());
        let columns: Vec<_> = columns.chain(left.column_iter()).collect();
        let all = DMatrix::from_columns(&columns);
        let products = gram(&all);
        Self { rows: left.len(), constants: constants.ncols(), products }
    }

    /// Over all rows, on which the directions are orthonormal and nothing of them is left in the data.
    pub(crate) fn of_all(
        directions: &DMatrix<f64>,
        constants: &DMatrix<f64>,
        left: &DVector<f64>,
    ) -> Self {
        let (k, c) = (directions.ncols(), constants.ncols());
        let mut products = DMatrix::identity(k + c + 1, k + c + 1);
        let across = tr_times(directions, constants);
        products.view_mut((0, k), (k, c)).copy_from(&across);
        products.view_mut((k, 0), (c, k)).copy_from(&across.transpose());
        products.view_mut((k, k), (c, c)).copy_from(&constants.tr_mul(constants));
        let onto = constants.tr_mul(left);
        products.view_mut((k, k + c), (c, 1)).copy_from(&onto);
        products.view_mut((k + c, k), (1, c)).copy_from(&onto.transpose());
        products[(k + c, k + c)] = left.norm_squared();
        Self { rows: left.len(), constants: c, products }
    }

    /// Over these rows without those of `some`.
    pub(crate) fn less(&self, some: &Self) -> Self {
        Self {
            rows: self.rows - some.rows,
            constants: self.constants,
            products: &self.products - &some.products,
        }
    }
}

/// A system, and the constants that it does not hold, on some rows.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    pub(crate) rows: usize,
    /// Orthonormal columns of the directions, then of the constants.
    columns: Independent,
    /// The data along them.
    along: DVector<f64>,
    /// Directions of the system, and with the constants.
    pub(crate) directions: [usize; 2],
    /// Square of what the system leaves of the data, and with the constants.
    pub(crate) squares: [f64; 2],
}

impl Beside {
    /// `None` where these rows hardly determine the system.
    pub(crate) fn of(sums: &Sums) -> Option<Self> {
        let last = sums.products.ncols() - 1;
        let k = last - sums.constants;
        let system = sums.products.view((0, 0), (k, k)).into_owned();
        let well = Independent::of(&system, |_| WELL_DETERMINED * WELL_DETERMINED);
        if well.kept.len() < k {
            return None;
        }
        let all = sums.products.view((0, 0), (last, last)).into_owned();
        // What is asked of a constant the directions have many times over.
        let columns = Independent::of(&all, |c| MIN_SHAPE_KEPT * MIN_SHAPE_KEPT * all[(c, c)]);
        if columns.kept.iter().take_while(|c| **c < k).count() < k {
            return None;
        }
        let onto = sums.products.view((0, last), (last, 1)).column(0).into_owned();
        let along = columns.along_one(&onto);
        let whole = sums.products[(last, last)];
        let of_system = along.rows(0, k).norm_squared();
        Some(Self {
            rows: sums.rows,
            directions: [k, columns.kept.len()],
            squares: [whole - of_system, whole - along.norm_squared()],
            columns,
            along,
        })
    }

    /// Products of columns with the directions and constants as products with orthonormal ones, of
    /// the system alone or with the constants.
    pub(crate) fn held(&self, products: &DMatrix<f64>, with_constants: bool) -> DMatrix<f64> {
        if with_constants {
            return self.columns.along(products);
        }
        let k = self.directions[0];
        let mut along = products.rows(0, k).into_owned();
        let factor = self.columns.factor.view((0, 0), (k, k));
        factor.solve_lower_triangular_mut(&mut along);
        along
    }

    /// The data along the orthonormal columns.
    pub(crate) fn data(&self, with_constants: bool) -> DVector<f64> {
        self.along.rows(0, self.directions[usize::from(with_constants)]).into_owned()
    }
}
