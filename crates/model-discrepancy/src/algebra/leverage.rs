//! What a system takes of the rows of one group, and what is made of columns beside it.

use faer::Side;
use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::inverse_root::{SMALLEST, terms};
use crate::algebra::product::{gram, times, tr_times, view};

/// The rows of a group, as an orthonormal basis of a system sees them: `I − QQᵀ` of these rows is
/// `U·diag(left)·Uᵀ`, and one beside `U`.
pub(crate) struct Leverage {
    rows: Vec<usize>,
    /// `U`, rows × directions of which the system takes anything.
    directions: DMatrix<f64>,
    /// What it leaves along each.
    left: DVector<f64>,
    /// `Qᵀ·U`.
    across: DMatrix<f64>,
}

/// Columns of a group times the inverse root `A = (I − HHᵀ)^(−½)` of what a model leaves there, whose
/// orthonormal columns are those of the system and further ones, the tested columns G last.
pub(crate) struct Adjusted {
    /// `GᵀA·AG`.
    pub(crate) square: DMatrix<f64>,
    /// `HᵀAG`.
    pub(crate) across: DMatrix<f64>,
    /// `GᵀA·e` of a residual.
    pub(crate) score: DVector<f64>,
}

impl Leverage {
    pub(crate) fn of(basis: &Basis, rows: &[usize]) -> Option<Self> {
        let q = basis.rows(rows);
        let (leverages, vectors) = eigen(&smaller_gram(&q))?;
        let seen: Vec<usize> =
            (0..leverages.len()).filter(|&i| leverages[i] > NEW_DIRECTION).collect();
        let vectors = vectors.select_columns(&seen);
        let left = DVector::from_fn(seen.len(), |i, _| 1.0 - leverages[seen[i]]);
        let (directions, across) = if q.nrows() < q.ncols() {
            let across = tr_times(&q, &vectors);
            (vectors, across)
        } else {
            let mut directions = times(view(&q), view(&vectors));
            let mut across = vectors;
            for (i, &seen) in seen.iter().enumerate() {
                let root = leverages[seen].sqrt();
                directions.column_mut(i).unscale_mut(root);
                across.column_mut(i).scale_mut(root);
            }
            (directions, across)
        };
        Some(Self { rows: rows.to_vec(), directions, left, across })
    }

    /// With all columns `beside` the system, of which the last `tested` are tested; `None` where the
    /// model leaves hardly anything of a direction, or where a decomposition of the whole is cheaper.
    ///
    /// By Woodbury's formula under each term of the root: the system's own decomposition serves all
    /// candidates.
    pub(crate) fn adjusted(
        &self,
        beside: &DMatrix<f64>,
        tested: usize,
        residual: &DVector<f64>,
    ) -> Option<Adjusted> {
        let k = beside.ncols();
        if CHEAP * k > self.left.len() || self.left.min() <= SMALLEST {
            return None;
        }
        let columns = beside.select_rows(&self.rows);
        let residual = residual.select_rows(&self.rows);
        let along = tr_times(&self.directions, &columns);
        // Of what the system takes nothing from, products are enough.
        let rest = gram(&columns) - gram(&along);
        let residual_along = self.directions.tr_mul(&residual);
        let residual_rest = columns.tr_mul(&residual) - along.tr_mul(&residual_along);
        // Both parts over what the system leaves, and a shift of it.
        let over = |shift: f64| {
            let mut over = along.clone();
            for (mut row, left) in over.row_iter_mut().zip(self.left.iter()) {
                row.unscale_mut(left + shift);
            }
            over
        };
        let taken = |over: &DMatrix<f64>, shift: f64| along.tr_mul(over) + &rest / (1.0 + shift);
        let whole = |taken: DMatrix<f64>| (DMatrix::identity(k, k) - taken).cholesky();
        whole(taken(&over(-SMALLEST), -SMALLEST))?;
        let first = k - tested;
        let (mut root, mut root_rest) =
            (DMatrix::zeros(along.nrows(), tested), DMatrix::zeros(k, tested));
        for &(weight, shift) in terms() {
            let over = over(shift);
            let inverse = whole(taken(&over, shift))?.inverse();
            let inverse = inverse.columns(first, tested);
            root.gemm(weight, &over, &inverse, 1.0);
            root_rest += inverse * (weight / (1.0 + shift));
        }
        let taken = taken(&over(0.0), 0.0);
        let square = &taken * whole(taken.clone())?.inverse();
        let of_system = &self.across * &root;
        let of_beside = along.tr_mul(&root) + &rest * &root_rest;
        let across = DMatrix::from_fn(of_system.nrows() + k, tested, |i, j| {
            match i.checked_sub(of_system.nrows()) {
                Some(own) => of_beside[(own, j)],
                None => of_system[(i, j)],
            }
        });
        Some(Adjusted {
            square: square.view((first, first), (tested, tested)).into_owned(),
            across,
            score: root.tr_mul(&residual_along) + root_rest.tr_mul(&residual_rest),
        })
    }
}

/// Directions per column from which on the terms of the root cost less than a decomposition.
const CHEAP: usize = 3;

/// [`Leverage::adjusted`] from the rows of the whole model's orthonormal columns, the tested ones
/// last; `None` where eigenvectors are not found.
///
/// A direction of leverage one has no residual and is left as it is.
pub(crate) fn adjusted_by_rows(
    q: &DMatrix<f64>,
    tested: usize,
    residual: &DVector<f64>,
) -> Option<Adjusted> {
    let columns = q.columns(q.ncols() - tested, tested).into_owned();
    let root = inverse_root_times(q, &columns)?;
    Some(Adjusted {
        square: root.tr_mul(&root),
        across: q.tr_mul(&root),
        score: root.tr_mul(residual),
    })
}

/// `(I − Q·Qᵀ)^(−½)·X`.
fn inverse_root_times(q: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (leverages, v) = eigen(&smaller_gram(q))?;
    let stretch = leverages.map(|leverage| {
        let left = 1.0 - leverage;
        let kept = leverage < NEW_DIRECTION || left < NEW_DIRECTION.sqrt();
        if kept { 0.0 } else { left.powf(-0.5) - 1.0 }
    });
    let scaled = |factors: DVector<f64>, mut along: DMatrix<f64>| {
        for (mut row, factor) in along.row_iter_mut().zip(factors.iter()) {
            row *= *factor;
        }
        &v * along
    };
    if q.nrows() < q.ncols() {
        return Some(x + scaled(stretch, v.tr_mul(x)));
    }
    let factors = stretch.zip_map(&leverages, |s, l| if s == 0.0 { 0.0 } else { s / l });
    Some(x + q * scaled(factors, v.tr_mul(&q.tr_mul(x))))
}

/// The smaller of `Q·Qᵀ` and `Qᵀ·Q`.
fn smaller_gram(q: &DMatrix<f64>) -> DMatrix<f64> {
    if q.nrows() < q.ncols() { times(view(q), view(q).transpose()) } else { gram(q) }
}

fn eigen(gram: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let n = gram.nrows();
    if n == 0 {
        return Some((DVector::zeros(0), DMatrix::zeros(0, 0)));
    }
    let eigen = view(gram).self_adjoint_eigen(Side::Lower).ok()?;
    let vectors = DMatrix::from_fn(n, n, |i, j| eigen.U()[(i, j)]);
    Some((DVector::from_fn(n, |i, _| eigen.S().column_vector()[i]), vectors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::count;

    /// Of the terms of the root and of products of numbers near one, over the smallest eigenvalue.
    const ROUND_OFF: f64 = 1e-10;

    fn wave(i: usize, j: usize) -> f64 {
        (1.3 * count(i) + 0.7 * count(j * j) + 0.9 * count(i * j)).sin()
    }

    /// A model without parameters takes nothing of any group.
    #[test]
    fn of_a_system_without_columns_all_is_left() {
        let known = Leverage::of(&Basis::empty(8), &[2, 3, 5]).unwrap();
        assert!(known.left.is_empty());
        let columns = DMatrix::from_fn(8, 1, wave);
        let whole = Basis::of(&columns, NEW_DIRECTION);
        let residual = DVector::from_fn(3, wave);
        let adjusted = adjusted_by_rows(&whole.rows(&[2, 3, 5]), 1, &residual).unwrap();
        let taken = whole.rows(&[2, 3, 5]).norm_squared();
        assert!((adjusted.square[(0, 0)] - taken / (1.0 - taken)).abs() < ROUND_OFF);
    }

    /// A group with more rows than columns, and one with fewer.
    #[test]
    fn terms_give_what_the_decomposition_of_the_whole_gives() {
        const ROWS: usize = 60;
        let columns = DMatrix::from_fn(ROWS, 14, wave);
        let whole = Basis::of(&columns, NEW_DIRECTION);
        let system = Basis::of(&columns.columns(0, 11).into_owned(), NEW_DIRECTION);
        let beside = whole.columns_from(11);
        let residual = DVector::from_fn(ROWS, |i, _| wave(i, 31));
        for rows in [(0..25).collect::<Vec<_>>(), (30..39).collect()] {
            let known = Leverage::of(&system, &rows).unwrap();
            let by_terms = known.adjusted(&beside, 2, &residual).unwrap();
            let residual = residual.select_rows(&rows);
            let by_rows = adjusted_by_rows(&whole.rows(&rows), 2, &residual).unwrap();
            assert!((by_terms.square - by_rows.square).amax() < ROUND_OFF);
            assert!((by_terms.across - by_rows.across).amax() < ROUND_OFF);
            assert!((by_terms.score - by_rows.score).amax() < ROUND_OFF);
        }
    }
}
