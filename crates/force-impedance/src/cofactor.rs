//! Small determinants: null directions and normal equations of the `4×3` leg Jacobian.

use nalgebra::{Vector3, Vector4};

use crate::scalar::sqrt;

/// Unit vector orthogonal to the three columns of four rows, its first three components summing to a
/// positive number; NaN where the columns are dependent.
#[inline]
pub(crate) fn orthogonal(rows: &[Vector3<f64>; 4]) -> Vector4<f64> {
    let [a, b, c, d] = rows;
    // Cofactors of the 4×4 matrix whose last column is sought.
    let minor = |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| p.dot(&q.cross(r));
    let normal = Vector4::new(-minor(b, c, d), minor(a, c, d), -minor(a, b, d), minor(a, b, c));
    let length = sqrt(normal.dot(&normal));
    let sign = if normal.x + normal.y + normal.z < 0.0 { -1.0 } else { 1.0 };
    normal * (sign / length)
}

/// Least-squares solution of `rows · x = rhs` by the normal equations and Cramer's rule.
///
/// Good to the square of the condition, which only slows the iteration that calls it.
#[inline]
pub(crate) fn least_squares(rows: &[Vector3<f64>; 4], rhs: &[f64; 4]) -> Vector3<f64> {
    let (x, y, z) = gram(rows);
    let [a, b, c, d] = rows;
    let right = a * rhs[0] + b * rhs[1] + c * rhs[2] + d * rhs[3];
    let (yz, zx, xy) = (y.cross(&z), z.cross(&x), x.cross(&y));
    Vector3::new(right.dot(&yz), right.dot(&zx), right.dot(&xy)) * (1.0 / x.dot(&yz))
}

/// Lower bound, up to a factor of three, of smallest over largest singular value.
pub(crate) fn gram_spread(rows: &[Vector3<f64>; 4]) -> f64 {
    let (x, y, z) = gram(rows);
    let determinant = x.dot(&y.cross(&z));
    let trace = x.x + y.y + z.z;
    // det = λ1 λ2 λ3 and trace ≥ λ1, so λ3/λ1 ≥ det/trace³.
    sqrt((determinant / (trace * trace * trace)).max(0.0))
}

/// Columns of `rowsᵀ · rows`.
#[inline]
fn gram(rows: &[Vector3<f64>; 4]) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let [a, b, c, d] = rows;
    (
        a * a.x + b * b.x + c * c.x + d * d.x,
        a * a.y + b * b.y + c * c.y + d * d.y,
        a * a.z + b * b.z + c * c.z + d * d.z,
    )
}
