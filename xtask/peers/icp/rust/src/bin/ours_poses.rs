//! `ours_poses DIR exact|gauss-newton`: nine touches of a paraboloid from further and further off, by
//! pose-icp or by plain Gauss-Newton. One JSON line a size of start.

use std::path::PathBuf;
use std::time::Instant;

use icp_peers::read_numbers;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, Vector3, Vector5};
use pose_icp::{Part, PoseOptions, PoseStart, Tip, Touch, fit_pose};

const RADIUS_MM: f64 = 480.0;
const DIAMETER_MM: f64 = 100.0;
const TIP_MM: f64 = 3.0;
const SIGMA_MM: f64 = 1e-3;
/// χ² of nine values at the true pose exceeds this once in 1e5.
const FOUND: f64 = 40.0;
const TOUCHES: usize = 9;
const ROW: usize = 1 + 3 * TOUCHES + 5;
const MAX_STEPS: usize = 100;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let directory = PathBuf::from(arguments.next().expect("DIR"));
    let exact = arguments.next().is_none_or(|way| way == "exact");
    let shape = geometry::AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], DIAMETER_MM);
    let part = Part::asphere(shape).expect("the paraboloid is sound");
    let rows = read_numbers(&directory.join("poses.bin"));
    let rows: Vec<&[f64]> = rows.chunks_exact(ROW).collect();
    for cell in rows.chunk_by(|a, b| a[0] == b[0]) {
        let (mut found, mut times) = (0, Vec::new());
        for row in cell {
            let centers: Vec<_> =
                row[1..=3 * TOUCHES].chunks_exact(3).map(Point3::from_slice).collect();
            let start = Vector5::from_column_slice(&row[ROW - 5..]);
            let begin = Instant::now();
            let squares = if exact {
                pose_icp_squares(&part, &centers, &start)
            } else {
                gauss_newton_squares(&part, &centers, start)
            };
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            found += usize::from(squares.is_some_and(|s| s < FOUND));
        }
        times.sort_by(f64::total_cmp);
        println!(
            "{{\"size\":{},\"found\":{found},\"starts\":{},\"median_us\":{:.2}}}",
            cell[0][0],
            cell.len(),
            times[times.len() / 2]
        );
    }
}

fn pose_icp_squares(part: &Part, centers: &[Point3<f64>], start: &Vector5<f64>) -> Option<f64> {
    let touches: Vec<_> = centers.iter().map(|c| Touch::new(*c, SIGMA_MM)).collect();
    let mut at = PoseStart::level(start.fixed_rows::<3>(0).into_owned(), 0.0);
    (at.angles.alpha_rad, at.angles.beta_rad) = (start[3], start[4]);
    let tip = Tip { radius_mm: TIP_MM, ..Tip::default() };
    let fit = fit_pose(part, &touches, &at, &PoseOptions { tip, ..PoseOptions::default() }).ok()?;
    Some(fit.residuals_mm.iter().map(|r| (r / SIGMA_MM).powi(2)).sum())
}

/// Undamped steps in x, y, z, α and β.
fn gauss_newton_squares(
    part: &Part,
    centers: &[Point3<f64>],
    mut at: Vector5<f64>,
) -> Option<f64> {
    for _ in 0..MAX_STEPS {
        let rotation = Rotation3::from_euler_angles(at[3], at[4], 0.0);
        let position = at.fixed_rows::<3>(0).into_owned();
        let axes = Matrix3::from_columns(&[
            Rotation3::from_euler_angles(0.0, at[4], 0.0) * Vector3::x(),
            Vector3::y(),
            Vector3::zeros(),
        ]);
        let mut jacobian = DMatrix::zeros(TOUCHES, 5);
        let mut residual = DVector::zeros(TOUCHES);
        for (i, center) in centers.iter().enumerate() {
            let arm = center.coords - position;
            let foot = part.surface().closest_point(&Point3::from(rotation.inverse() * arm)).ok()?;
            let normal = rotation * foot.normal.into_inner();
            let turned = axes.tr_mul(&normal.cross(&arm));
            let row = [-normal.x, -normal.y, -normal.z, turned.x, turned.y];
            for (k, value) in row.into_iter().enumerate() {
                jacobian[(i, k)] = value / SIGMA_MM;
            }
            residual[i] = (foot.signed_distance_mm - TIP_MM) / SIGMA_MM;
        }
        let step = jacobian.svd(true, true).solve(&-&residual, 0.0).ok()?;
        at += step.fixed_rows::<5>(0);
        // A step of a nanometre, or a nanoradian times the mirror's size.
        if step.iter().zip([1.0, 1.0, 1.0, 1e2, 1e2]).all(|(s, mm)| (s * mm).abs() < 1e-6) {
            return Some(residual.norm_squared());
        }
    }
    None
}
