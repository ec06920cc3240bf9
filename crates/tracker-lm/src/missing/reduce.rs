//! Takes the unknowns of a unit out of its rows: the six errors of an angle, the place of a
//! reflector.
//!
//! The rows at one angle share six unknowns of their own. An orthogonal transformation makes of
//! `n` rows `n − 6` that do not depend on these, with noise as white as before, each of them
//! tied to one range: the part of that range's residual that nothing else at its angle explains.
//!
//! The first visit of an angle gives the residuals closest to the ranges' own under that
//! condition (Theil 1965, BLUS); a later one gives its deviation from what the visits before
//! predict, whitened (the innovations of a Kalman filter). So a visit that is left out takes its
//! rows with it.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Rows of one angle that do not depend on its six errors.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    /// Transformation, `reduced rows × rows`.
    pub(crate) transformation: DMatrix<f64>,
    /// Row of the angle that each reduced row is tied to.
    pub(crate) tied_to: Vec<usize>,
}

/// Reciprocal condition of the scaled design below which six errors do not show yet.
const SHOWN: f64 = 1e-6;

/// Share of the best six rows' smallest singular value that the six of the angle before must have.
const GOOD_STILL: f64 = 0.3;

/// Reduces the rows of one angle, `by_block` their derivative by its errors; `visits` are the
/// numbers of rows of each step, in order. `None` where the errors do not show.
///
/// No row is tied to six of the first visit. They are those of `given_up`, where they determine the
/// errors well: what is tied to the same source at every angle is one record.
pub(crate) fn reduce(
    by_block: &DMatrix<f64>,
    visits: &[usize],
    given_up: &[usize],
) -> Option<Reduced> {
    let n = by_block.nrows();
    let mut scaled = by_block.clone();
    for mut column in scaled.column_iter_mut() {
        let length = column.norm();
        if length.is_nan() || length == 0.0 {
            return None;
        }
        column.unscale_mut(length);
    }
    let mut ends = visits.iter().scan(0, |sum, v| {
        *sum += v;
        Some(*sum)
    });
    let first = ends.by_ref().find(|&end| shows(&scaled.rows(0, end).into_owned()))?;
    let (mut rows, mut tied_to) = first_visit(&scaled.rows(0, first).into_owned(), n, given_up)?;
    let mut start = first;
    for end in ends {
        rows.extend(later_visit(&scaled, start, end)?);
        tied_to.extend(start..end);
        start = end;
    }
    let transformation = DMatrix::from_fn(rows.len(), n, |i, j| rows[i][j]);
    Some(Reduced { transformation, tied_to })
}

fn shows(design: &DMatrix<f64>) -> bool {
    design.nrows() >= design.ncols() && {
        let values = design.clone().singular_values();
        values.min() > SHOWN * values.max()
    }
}

/// Orthonormal rows orthogonal to the design, as near to unit rows as can be.
fn first_visit(
    design: &DMatrix<f64>,
    n: usize,
    given_up: &[usize],
) -> Option<(Vec<DVector<f64>>, Vec<usize>)> {
    let rows = design.nrows();
    let q = design.clone().qr().q();
    let mut pivots = pivots(&q);
    let determine = |some: &[usize]| q.select_rows(some).singular_values().min();
    let are_as_many = given_up.len() == pivots.len() && given_up.iter().all(|&i| i < rows);
    if are_as_many && determine(given_up) > GOOD_STILL * determine(&pivots) {
        pivots = given_up.to_vec();
    }
    let kept: Vec<usize> = (0..rows).filter(|row| !pivots.contains(row)).collect();
    if kept.is_empty() {
        return Some((Vec::new(), kept));
    }
    // The complement: what the projector leaves of the kept rows' unit vectors. Its symmetric
    // square root on those rows gives the orthonormal rows nearest to the units.
    let q_kept = q.select_rows(&kept);
    let gram = DMatrix::identity(kept.len(), kept.len()) - &q_kept * q_kept.transpose();
    let root = inverse_root(gram)?;
    let mut left = DMatrix::zeros(rows, kept.len());
    for (column, &row) in kept.iter().enumerate() {
        left[(row, column)] = 1.0;
    }
    left -= &q * q_kept.transpose();
    let transformation = left * root;
    let wide = |column: usize| {
        let mut row = DVector::zeros(n);
        row.rows_mut(0, rows).copy_from(&transformation.column(column));
        row
    };
    Some(((0..kept.len()).map(wide).collect(), kept))
}

/// Six rows that determine the errors well: pivots of the orthonormal basis.
fn pivots(q: &DMatrix<f64>) -> Vec<usize> {
    let mut left = q.clone();
    let mut pivots = Vec::with_capacity(q.ncols());
    for _ in 0..q.ncols() {
        let lengths = (0..left.nrows()).map(|i| left.row(i).norm_squared());
        let pivot =
            lengths.enumerate().reduce(|a, b| if b.1 > a.1 { b } else { a }).map_or(0, |(i, _)| i);
        let direction = left.row(pivot).normalize();
        let along = &left * direction.transpose();
        left -= along * direction;
        pivots.push(pivot);
    }
    pivots
}

/// Whitened deviations of the rows `start..end` from what those before `start` predict.
fn later_visit(design: &DMatrix<f64>, start: usize, end: usize) -> Option<Vec<DVector<f64>>> {
    let before = design.rows(0, start).into_owned().qr();
    let own = design.rows(start, end - start);
    let through = own * before.r().try_inverse()?;
    let spread = DMatrix::identity(end - start, end - start) + &through * through.transpose();
    let root = inverse_root(spread)?;
    let predicted = &root * &through * before.q().transpose();
    let wide = |i: usize| {
        let mut row = DVector::zeros(design.nrows());
        row.rows_mut(0, start).copy_from(&-predicted.row(i).transpose());
        row.rows_mut(start, end - start).copy_from(&root.row(i).transpose());
        row
    };
    Some((0..end - start).map(wide).collect())
}

/// `M^(−½)` of a symmetric positive definite matrix.
fn inverse_root(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let eigen = SymmetricEigen::new(matrix);
    if eigen.eigenvalues.iter().any(|v| v.is_nan() || *v <= f64::EPSILON) {
        return None;
    }
    let roots = DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| v.powf(-0.5)));
    Some(&eigen.eigenvectors * roots * eigen.eigenvectors.transpose())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::cast_precision_loss, reason = "small indices")]

    use nalgebra::DMatrix;

    use super::reduce;

    /// Some hundred products of numbers of size 1.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn rows_are_orthonormal_and_free_of_the_errors() {
        let design = DMatrix::from_fn(24, 6, |i, j| {
            let x = 0.7 * i as f64 + 1.3 * j as f64;
            x.sin() + 0.3 * (x * x).cos()
        });
        for visits in [vec![24], vec![12, 12], vec![4, 8, 12], vec![1; 24]] {
            let reduced = reduce(&design, &visits, &[]).unwrap();
            let t = &reduced.transformation;
            assert_eq!(t.nrows(), 18);
            assert!((t * &design).amax() < ROUND_OFF, "{visits:?}");
            let gram = t * t.transpose() - DMatrix::identity(18, 18);
            assert!(gram.amax() < ROUND_OFF, "{visits:?}");
            for (row, &tied) in reduced.tied_to.iter().enumerate() {
                // The part of each row on its own range is the largest of its visit.
                assert!(t[(row, tied)] > 0.0);
            }
        }
    }

    #[test]
    fn collinear_designs_are_refused() {
        let design = DMatrix::from_fn(12, 6, |i, j| (i as f64 + 1.0) * (j as f64 + 1.0));
        assert!(reduce(&design, &[12], &[]).is_none());
    }
}
