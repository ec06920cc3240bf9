//! Six errors from displaced points.

use geometry::so3;
use nalgebra::{DMatrix, Vector3, Vector6};

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
    /// Steps: the first leaves the square of the angle, the third its eighth power.
    const STEPS: usize = 4;
    let n = arms_mm.len();
    if n < 3 || displacements_mm.len() != n {
        return None;
    }
    let mut error = Vector6::zeros();
    let mut inverse = DMatrix::zeros(6, 3 * n);
    for _ in 0..STEPS {
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
        inverse = pseudo_inverse(&design, reach(arms_mm))?;
        error += Vector6::from_iterator((&inverse * left).iter().copied());
    }
    error.iter().all(|v| v.is_finite()).then_some((error, inverse))
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
