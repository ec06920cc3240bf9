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
    let [a, b, c, d] = rows;
    Gram::of(rows).solve(&(a * rhs[0] + b * rhs[1] + c * rhs[2] + d * rhs[3]))
}

/// Shortest solution of `rowsᵀ · x = rhs` in the same way; not finite where the rows span a plane.
pub(crate) fn shortest(rows: &[Vector3<f64>; 4], rhs: &Vector3<f64>) -> [f64; 4] {
    let weights = Gram::of(rows).solve(rhs);
    rows.map(|row| row.dot(&weights))
}

/// Lower bound, up to a factor of three, of smallest over largest singular value.
pub(crate) fn gram_spread(rows: &[Vector3<f64>; 4]) -> f64 {
    let gram = Gram::of(rows);
    let (x, _, _) = gram.cofactors();
    let determinant = gram.determinant(&x);
    let trace = gram.xx + gram.yy + gram.zz;
    // det = λ1 λ2 λ3 and trace ≥ λ1, so λ3/λ1 ≥ det/trace³.
    sqrt((determinant / (trace * trace * trace)).max(0.0))
}

/// `rowsᵀ · rows`, symmetric.
struct Gram {
    xx: f64,
    yy: f64,
    zz: f64,
    xy: f64,
    yz: f64,
    zx: f64,
}

impl Gram {
    /// Solution of `self · x = right`.
    #[inline]
    fn solve(&self, right: &Vector3<f64>) -> Vector3<f64> {
        let (x, y, z) = self.cofactors();
        Vector3::new(right.dot(&x), right.dot(&y), right.dot(&z)) * (1.0 / self.determinant(&x))
    }

    #[inline]
    fn of(rows: &[Vector3<f64>; 4]) -> Self {
        let [a, b, c, d] = rows;
        Self {
            xx: a.x * a.x + b.x * b.x + c.x * c.x + d.x * d.x,
            yy: a.y * a.y + b.y * b.y + c.y * c.y + d.y * d.y,
            zz: a.z * a.z + b.z * b.z + c.z * c.z + d.z * d.z,
            xy: a.x * a.y + b.x * b.y + c.x * c.y + d.x * d.y,
            yz: a.y * a.z + b.y * b.z + c.y * c.z + d.y * d.z,
            zx: a.z * a.x + b.z * b.x + c.z * c.x + d.z * d.x,
        }
    }

    /// Columns of the matrix of cofactors.
    #[inline]
    fn cofactors(&self) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        let &Self { xx, yy, zz, xy, yz, zx } = self;
        let (p, q, r) = (zx * yz - xy * zz, xy * yz - zx * yy, xy * zx - xx * yz);
        (
            Vector3::new(yy * zz - yz * yz, p, q),
            Vector3::new(p, xx * zz - zx * zx, r),
            Vector3::new(q, r, xx * yy - xy * xy),
        )
    }

    #[inline]
    fn determinant(&self, first: &Vector3<f64>) -> f64 {
        self.xx * first.x + self.xy * first.y + self.zx * first.z
    }
}
