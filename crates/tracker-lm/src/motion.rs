//! Six errors from displaced points.

use geometry::so3;
use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};

use crate::count::count;

/// Six errors at one angle, from where points are and where they should be.
///
/// `arms_mm` are `q = Rot(b)·t`, from the nominal axis' origin to where each reflector should be;
/// `displacements_mm` how far it is from there. Least squares on
/// `Δ = e + exp(ω)·q − q`, whose linear part is \[B\]'s `ΔP = B·E` with
/// `B = [0 qz −qy 1 0 0; −qz 0 qx 0 1 0; qy −qx 0 0 0 1]` for E = (EA, EB, EC, EX, EY, EZ).
/// Returns `[ex ey ez ea eb ec]`, mm and rad, and the matrix that takes small further
/// displacements (x y z of each point) to errors, `6 × 3n`; `None` where the points are
/// collinear or fewer than three.
#[must_use]
pub fn error_at_angle(
    arms_mm: &[Vector3<f64>],
    displacements_mm: &[Vector3<f64>],
) -> Option<(Vector6<f64>, DMatrix<f64>)> {
    let n = arms_mm.len();
    if displacements_mm.len() != n {
        return None;
    }
    let mut inverse = vec![0.0; 18 * n];
    let error = error_by(arms_mm, displacements_mm, &mut inverse)?;
    Some((error, DMatrix::from_row_slice(6, 3 * n, &inverse)))
}

/// The same, with the matrix written by rows into `inverse`.
pub(crate) fn error_by(
    arms_mm: &[Vector3<f64>],
    displacements_mm: &[Vector3<f64>],
    inverse: &mut [f64],
) -> Option<Vector6<f64>> {
    /// Steps: the first leaves the square of the angle, the third its eighth power.
    const STEPS: usize = 4;
    if arms_mm.len() < 3 {
        return None;
    }
    let mut error = Vector6::zeros();
    for step in 0..STEPS {
        let rotation = error.fixed_rows::<3>(3).into_owned();
        let displacement = error.fixed_rows::<3>(0).into_owned();
        let turned = so3::exp(&rotation);
        let jacobian = so3::left_jacobian(&rotation);
        let moved = |arm: &Vector3<f64>| turned * arm;
        let missed =
            |(arm, seen): (&Vector3<f64>, &Vector3<f64>)| seen - (displacement + moved(arm) - arm);
        let Some(about) = About::new(arms_mm.iter().map(moved), &jacobian) else {
            error += by_singular_values(arms_mm, displacements_mm, &error, inverse)?;
            continue;
        };
        let missed = arms_mm.iter().zip(displacements_mm).map(missed);
        error += about.solve(arms_mm.iter().map(moved), missed);
        if step + 1 == STEPS {
            about.write_inverse(arms_mm.iter().map(moved), inverse);
        }
    }
    error.iter().all(|v| v.is_finite()).then_some(error)
}

/// Normal equations of the six errors about the centroid of the points, where displacement and
/// rotation are apart.
struct About {
    n: f64,
    centroid: Vector3<f64>,
    /// From the moment of the displacements about the centroid to the rotation vector's change, and
    /// to the rotation alone.
    turn: Matrix3<f64>,
    by_moment: Matrix3<f64>,
}

impl About {
    /// `None` where the points are so nearly on a line that squares would show it badly.
    fn new(
        moved: impl Iterator<Item = Vector3<f64>> + Clone,
        jacobian: &Matrix3<f64>,
    ) -> Option<Self> {
        /// Share of the whole moment below which points count as such: 1 mm off a line of 10 m.
        const FLAT: f64 = 1e-8;
        let n = count(moved.clone().count());
        let centroid = moved.clone().sum::<Vector3<f64>>() / n;
        let mut moment = Matrix3::zeros();
        for point in moved {
            let arm = point - centroid;
            moment += Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        }
        let factor = moment.cholesky()?;
        let pivots = factor.l_dirty().diagonal();
        if pivots.min().powi(2) <= FLAT * moment.trace() {
            return None;
        }
        let by_moment = factor.inverse();
        Some(Self { n, centroid, turn: jacobian.try_inverse()? * by_moment, by_moment })
    }

    fn solve(
        &self,
        moved: impl Iterator<Item = Vector3<f64>>,
        missed: impl Iterator<Item = Vector3<f64>>,
    ) -> Vector6<f64> {
        let (mut sum, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (point, missed) in moved.zip(missed) {
            sum += missed;
            moment += (point - self.centroid).cross(&missed);
        }
        let shift = sum / self.n + self.centroid.cross(&(self.by_moment * moment));
        let turn = self.turn * moment;
        Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    }

    /// The linear map of `solve`, by rows.
    fn write_inverse(
        &self,
        moved: impl Iterator<Item = Vector3<f64>> + Clone,
        inverse: &mut [f64],
    ) {
        let width = 3 * moved.clone().count();
        let lever = self.centroid.cross_matrix() * self.by_moment;
        for (i, point) in moved.enumerate() {
            let cross = (point - self.centroid).cross_matrix();
            let shift = Matrix3::from_diagonal_element(1.0 / self.n) + lever * cross;
            let turn = self.turn * cross;
            for r in 0..3 {
                for c in 0..3 {
                    inverse[r * width + 3 * i + c] = shift[(r, c)];
                    inverse[(3 + r) * width + 3 * i + c] = turn[(r, c)];
                }
            }
        }
    }
}

/// One step by singular values; the matrix by rows goes to `inverse`.
fn by_singular_values(
    arms_mm: &[Vector3<f64>],
    displacements_mm: &[Vector3<f64>],
    error: &Vector6<f64>,
    inverse: &mut [f64],
) -> Option<Vector6<f64>> {
    let n = arms_mm.len();
    let rotation = error.fixed_rows::<3>(3).into_owned();
    let turned = so3::exp(&rotation);
    let jacobian = so3::left_jacobian(&rotation);
    let mut design = DMatrix::zeros(3 * n, 6);
    let mut left = DMatrix::zeros(3 * n, 1);
    for (j, (arm, displacement)) in arms_mm.iter().zip(displacements_mm).enumerate() {
        let moved = turned * arm;
        design.fixed_view_mut::<3, 3>(3 * j, 0).fill_with_identity();
        let by_rotation = -moved.cross_matrix() * jacobian;
        design.fixed_view_mut::<3, 3>(3 * j, 3).copy_from(&by_rotation);
        let predicted = error.fixed_rows::<3>(0) + moved - arm;
        left.fixed_view_mut::<3, 1>(3 * j, 0).copy_from(&(displacement - predicted));
    }
    let found = pseudo_inverse(&design, reach(arms_mm))?;
    inverse.copy_from_slice(found.transpose().as_slice());
    Some(Vector6::from_iterator((found * left).iter().copied()))
}

/// Largest distance from the origin, which makes angles and displacements comparable.
fn reach(arms_mm: &[Vector3<f64>]) -> f64 {
    arms_mm.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max)
}

/// `(BᵀB)⁻¹Bᵀ` by singular values, with rotations counted at `reach_mm`.
fn pseudo_inverse(design: &DMatrix<f64>, reach_mm: f64) -> Option<DMatrix<f64>> {
    /// Reciprocal condition below which a rotation is free.
    const FREE: f64 = 1e-8;
    let scale = Vector6::new(1.0, 1.0, 1.0, reach_mm, reach_mm, reach_mm);
    let mut scaled = design.clone();
    for (mut column, s) in scaled.column_iter_mut().zip(scale.iter()) {
        column.unscale_mut(*s);
    }
    let svd = scaled.svd(true, true);
    let ratio = svd.singular_values.min() / svd.singular_values.max();
    if ratio.is_nan() || ratio <= FREE {
        return None;
    }
    let mut inverse = svd.pseudo_inverse(0.0).ok()?;
    for (mut row, s) in inverse.row_iter_mut().zip(scale.iter()) {
        row.unscale_mut(*s);
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector3, Vector6};

    use super::{by_singular_values, error_at_angle, reach};

    /// Rounding of a metre's arms over their distance from a line.
    const TOLERANCE: f64 = 1e-12;

    /// The step about the centroid is that by singular values, near the axis and far from it.
    #[test]
    fn normal_equations_are_the_pseudo_inverse() {
        for offset_mm in [0.0, 900.0] {
            let arms =
                [[150.0, 0.0, 20.0], [0.0, 120.0, -30.0], [-80.0, -90.0, 0.0], [10.0, 7.0, 99.0]]
                    .map(|arm| Vector3::from(arm) + Vector3::repeat(offset_mm));
            let seen = arms.map(|arm| {
                Vector3::new(0.01, -0.02, 0.005)
                    + Vector3::new(2e-4, 1e-4, -3e-4).cross(&arm)
                    + Vector3::new(1e-3 * f64::sin(arm.x / 50.0), 1e-3, 0.0)
            });
            let (error, inverse) = error_at_angle(&arms, &seen).unwrap();
            let mut other = vec![0.0; 6 * 3 * arms.len()];
            let step = by_singular_values(&arms, &seen, &error, &mut other).unwrap();
            let scale = Vector6::new(1.0, 1.0, 1.0, reach(&arms), reach(&arms), reach(&arms));
            assert!(step.component_mul(&scale).amax() < TOLERANCE * reach(&arms));
            for (i, row) in other.chunks_exact(3 * arms.len()).enumerate() {
                for (j, value) in row.iter().enumerate() {
                    let difference = (inverse[(i, j)] - value) * scale[i];
                    // An inverse at the step before the last differs by that step.
                    assert!(difference.abs() < 1e-9 * (1.0 + reach(&arms) / 100.0), "{difference}");
                }
            }
        }
    }

    /// Points 0.1 µm off a line of a metre still show the turn about it.
    #[test]
    fn points_near_a_line_go_by_singular_values() {
        let arms =
            [0.0, 400.0, 1000.0].map(|x: f64| Vector3::new(x, 1e-4 * (x / 300.0).sin(), 0.0));
        let seen = arms.map(|arm| Vector3::new(0.0, 0.0, 1e-3) + Vector3::y().cross(&arm) * 1e-5);
        let (error, _) = error_at_angle(&arms, &seen).unwrap();
        assert!((error[4] - 1e-5).abs() < 1e-9 && (error[2] - 1e-3).abs() < 1e-6, "{error}");
        let line = arms.map(|arm| Vector3::new(arm.x, 0.0, 0.0));
        assert!(error_at_angle(&line, &seen).is_none());
    }
}
