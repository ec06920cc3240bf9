//! A paraboloid mirror, R = 480 mm, Φ100, is touched nine times; where does it lie?
//!
//! First by its surface alone, then with four touches of its side as well.
//!
//! `cargo run -p pose-icp --example nine_touches`

#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use geometry::{AsphereShape, EulerAngles};
use nalgebra::{Point3, Vector3};
use pose_icp::{
    EdgeTouches, Part, PoseError, PoseOptions, PoseStart, Tip, Touch, fit_pose, height_at,
    start_from_touches,
};

/// Deviations of the readings, as a random generator of 1 µm gave them.
const NOISE_UM: [f64; 9] = [0.4, -1.3, 0.9, 0.2, -0.7, 1.6, -0.3, -1.1, 0.8];
const TIP: Tip = Tip { radius_mm: 3.0, side: pose_icp::TipSide::Above };
const SIGMA_MM: f64 = 1e-3;

fn main() -> Result<(), PoseError> {
    let part = Part::asphere(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0))?;
    let angles = EulerAngles { alpha_rad: 4e-3, beta_rad: -2e-3, gamma_rad: 0.0 };
    let truth = PoseStart { position_mm: Vector3::new(-499.3, -474.6, -284.9), angles };
    let machine_from_workpiece = truth.machine_from_workpiece();

    // The ball's centre is 3 mm off the surface, along the normal.
    let center = |x: f64, y: f64| {
        let normal = Vector3::new(-x / 480.0, -y / 480.0, 1.0).normalize();
        machine_from_workpiece
            * (Point3::new(x, y, (x * x + y * y) / 960.0) + normal * TIP.radius_mm)
    };
    let mut at = vec![[0.0, 0.0]];
    for radius in [20.0, 40.0] {
        at.extend([[radius, 0.0], [0.0, radius], [-radius, 0.0], [0.0, -radius]]);
    }
    let touches: Vec<Touch> = at
        .iter()
        .zip(NOISE_UM)
        .map(|(&[x, y], noise)| Touch::new(center(x, y) + Vector3::z() * noise * 1e-3, SIGMA_MM))
        .collect();

    // The surface alone: heights are good to a micrometre, tilt and decentre are not.
    let options = PoseOptions { tip: TIP, ..PoseOptions::default() };
    let start = start_from_touches(&part, &touches, TIP, 0.0)?;
    let alone = fit_pose(&part, &touches, &start, &options)?;
    for weak in &alone.weak_directions {
        println!("hardly visible: {weak}");
    }
    assert_eq!(alone.weak_directions.len(), 2);

    // With the side, 8 mm below the vertex.
    let side = |x: f64, y: f64| machine_from_workpiece * Point3::new(x, y, -8.0);
    let edge = EdgeTouches {
        sides_mm: [side(0.0, -53.0), side(53.0, 0.0), side(0.0, 53.0), side(-53.0, 0.0)],
        center_mm: center(0.0, 0.0),
        sigma_mm: SIGMA_MM,
    };
    let edge = edge.locate(TIP, 0.0)?;
    let options = PoseOptions { lateral: Some(edge.prior), ..options };
    let fit = fit_pose(&part, &touches, &edge.start, &options)?;
    assert!(fit.weak_directions.is_empty());
    let sigmas = fit.standard_uncertainties().expect("the noise is declared");
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        println!("{name} = {:.4} mm, std {:.4}", fit.pose.position_mm[k], sigmas[k]);
        assert!((fit.pose.position_mm - truth.position_mm)[k].abs() < 4.0 * sigmas[k]);
    }

    // Where will the probe meet the mirror between the rings?
    let expected = center(15.0, 25.0);
    let height = height_at(&part, &fit, TIP, expected.x, expected.y, start.position_mm.z)?;
    assert!((height.z_mm - expected.z).abs() < 2e-3);
    Ok(())
}
