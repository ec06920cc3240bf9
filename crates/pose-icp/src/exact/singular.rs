//! Singular values of the few columns of a pose, without allocation.

use nalgebra::DMatrix;

use super::triangle::MAX;

/// A square matrix by rows; its leading block counts.
pub(crate) type Rows = [[f64; MAX]; MAX];

/// Cosine of an angle at which two rows count as orthogonal: round-off of their product.
const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;
/// Sweeps over all pairs; three to six are needed.
const MAX_SWEEPS: usize = 30;
/// Below this share of the largest a row is round-off, and has no direction of its own.
const NO_DIRECTION: f64 = 1e-13;

/// Singular values, the largest first, with their right singular vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Singular {
    pub(crate) values: [f64; MAX],
    pub(crate) directions: Rows,
}

/// Those of the leading `n × n` block of `matrix`.
pub(crate) fn singular(matrix: &Rows, n: usize) -> Singular {
    by_rotations(matrix, n).unwrap_or_else(|| by_decomposition(matrix, n))
}

/// One-sided Jacobi: rotates pairs of rows until all are orthogonal; they then are the right
/// singular vectors times their singular values.
///
/// `None` where a row vanishes, or the sweeps do not end.
fn by_rotations(matrix: &Rows, n: usize) -> Option<Singular> {
    let mut rows = *matrix;
    for _ in 0..MAX_SWEEPS {
        let mut orthogonal = true;
        for p in 0..n {
            for q in p + 1..n {
                orthogonal &= !rotate(&mut rows, p, q);
            }
        }
        if orthogonal {
            return sorted(&rows, n);
        }
    }
    None
}

/// Makes two rows orthogonal; false where they were.
fn rotate(rows: &mut Rows, p: usize, q: usize) -> bool {
    let (first, second) = (rows[p], rows[q]);
    let (a, b, across) = (dot(&first, &first), dot(&second, &second), dot(&first, &second));
    // NaN rotates, until the sweeps run out.
    if across.abs() <= ORTHOGONAL * (a * b).sqrt() {
        return false;
    }
    let zeta = (b - a) / (2.0 * across);
    let tangent = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cos = (1.0 + tangent * tangent).sqrt().recip();
    let sin = cos * tangent;
    for k in 0..MAX {
        rows[p][k] = cos * first[k] - sin * second[k];
        rows[q][k] = sin * first[k] + cos * second[k];
    }
    true
}

fn dot(a: &[f64; MAX], b: &[f64; MAX]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn sorted(rows: &Rows, n: usize) -> Option<Singular> {
    let lengths: [f64; MAX] = std::array::from_fn(|i| dot(&rows[i], &rows[i]).sqrt());
    let mut order: [usize; MAX] = std::array::from_fn(|i| i);
    order[..n].sort_unstable_by(|&i, &j| lengths[j].total_cmp(&lengths[i]));
    let smallest = lengths[order[n.checked_sub(1)?]];
    if smallest.is_nan() || smallest <= NO_DIRECTION * lengths[order[0]] {
        return None;
    }
    let mut found = Singular { values: [0.0; MAX], directions: [[0.0; MAX]; MAX] };
    for (k, &i) in order[..n].iter().enumerate() {
        found.values[k] = lengths[i];
        found.directions[k] = rows[i].map(|v| v / lengths[i]);
    }
    Some(found)
}

/// The general way, which gives a direction to every singular value of zero.
fn by_decomposition(matrix: &Rows, n: usize) -> Singular {
    let svd = DMatrix::from_fn(n, n, |i, j| matrix[i][j]).svd(false, true);
    let v_t = svd.v_t.unwrap_or_else(|| DMatrix::identity(n, n));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let mut found = Singular { values: [0.0; MAX], directions: [[0.0; MAX]; MAX] };
    for (k, &i) in order.iter().enumerate() {
        found.values[k] = svd.singular_values[i];
        for j in 0..n {
            found.directions[k][j] = v_t[(i, j)];
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of about one, up to six rows: some two hundred roundings.
    const EXACT: f64 = 5e-14;

    /// A fixed pattern without order.
    fn entry(i: usize, j: usize) -> f64 {
        f64::from(u32::try_from(3 * i + 5 * j + i * j + 1).unwrap()).sin()
    }

    #[test]
    fn rotations_agree_with_the_decomposition() {
        for (n, squeeze) in [(1, 1.0), (2, 1e-3), (5, 1.0), (5, 1e-5), (6, 1e-8)] {
            let matrix: Rows = std::array::from_fn(|i| {
                let weight = if i + 1 == n { squeeze } else { 1.0 };
                std::array::from_fn(|j| if j >= i && j < n { weight * entry(i, j) } else { 0.0 })
            });
            let (rotated, known) =
                (by_rotations(&matrix, n).unwrap(), by_decomposition(&matrix, n));
            for k in 0..n {
                let off = (rotated.values[k] - known.values[k]).abs();
                assert!(off <= EXACT * known.values[0], "{n} {squeeze} {k}: {off:e}");
                // M v is as long as the singular value, whatever the order of equal ones.
                let v = rotated.directions[k];
                let image: f64 = matrix[..n].iter().map(|row| dot(row, &v).powi(2)).sum();
                let off = (image.sqrt() - rotated.values[k]).abs();
                assert!(off <= EXACT * known.values[0], "{n} {squeeze} {k}: {off:e}");
                assert!((dot(&v, &v) - 1.0).abs() <= EXACT);
            }
        }
    }

    #[test]
    fn a_matrix_of_less_than_full_rank_goes_the_general_way() {
        let mut matrix: Rows = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        matrix[3] = matrix[1];
        assert!(by_rotations(&matrix, 5).is_none());
        let found = singular(&matrix, 5);
        assert!(found.values[4] <= EXACT * found.values[0]);
        let unseen = found.directions[4];
        assert!((dot(&unseen, &unseen) - 1.0).abs() <= EXACT);
        assert!(matrix[..5].iter().all(|row| {
            let seen: f64 = (0..5).map(|k| row[k] * unseen[k]).sum();
            seen.abs() <= EXACT * found.values[0]
        }));
    }

    #[test]
    fn what_is_not_a_number_ends() {
        let mut matrix: Rows = [[1.0; MAX]; MAX];
        matrix[0][0] = f64::NAN;
        assert!(by_rotations(&matrix, 3).is_none());
    }
}
