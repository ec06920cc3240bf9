//! Small determinants: null directions and normal equations of the `4×3` leg Jacobian.

use nalgebra::{Matrix3, Matrix4x3, Vector3, Vector4};

use crate::scalar::sqrt;

/// Unit vector orthogonal to three columns in ℝ⁴, its first three components summing to a
/// positive number; NaN where the columns are dependent.
#[inline]
pub(crate) fn orthogonal(columns: &Matrix4x3<f64>) -> Vector4<f64> {
    let row = |i: usize| Vector3::new(columns[(i, 0)], columns[(i, 1)], columns[(i, 2)]);
    let (a, b, c, d) = (row(0), row(1), row(2), row(3));
    // Cofactors of the 4×4 matrix whose last column is sought.
    let minor = |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| p.dot(&q.cross(r));
    let normal =
        Vector4::new(-minor(&b, &c, &d), minor(&a, &c, &d), -minor(&a, &b, &d), minor(&a, &b, &c));
    let length = sqrt(normal.dot(&normal));
    let sign = if normal.x + normal.y + normal.z < 0.0 { -1.0 } else { 1.0 };
    normal * (sign / length)
}

/// Least-squares solution of `columns · x = rhs` by the normal equations and Cramer's rule.
///
/// Good to the square of the condition, which only slows the iteration that calls it.
#[inline]
pub(crate) fn least_squares(columns: &Matrix4x3<f64>, rhs: &Vector4<f64>) -> Vector3<f64> {
    let gram = columns.transpose() * columns;
    let right = columns.transpose() * rhs;
    let (x, y, z) = (column(&gram, 0), column(&gram, 1), column(&gram, 2));
    let (yz, zx, xy) = (y.cross(&z), z.cross(&x), x.cross(&y));
    Vector3::new(right.dot(&yz), right.dot(&zx), right.dot(&xy)) / x.dot(&yz)
}

/// Lower bound, up to a factor of three, of smallest over largest singular value.
pub(crate) fn gram_spread(columns: &Matrix4x3<f64>) -> f64 {
    let gram = columns.transpose() * columns;
    let (x, y, z) = (column(&gram, 0), column(&gram, 1), column(&gram, 2));
    let determinant = x.dot(&y.cross(&z));
    let trace = gram[(0, 0)] + gram[(1, 1)] + gram[(2, 2)];
    // det = λ1 λ2 λ3 and trace ≥ λ1, so λ3/λ1 ≥ det/trace³.
    sqrt((determinant / (trace * trace * trace)).max(0.0))
}

fn column(m: &Matrix3<f64>, j: usize) -> Vector3<f64> {
    Vector3::new(m[(0, j)], m[(1, j)], m[(2, j)])
}
