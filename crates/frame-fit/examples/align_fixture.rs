//! A fixture with six balls, known from a coordinate measuring machine, is measured on the
//! machine tool. One ball has been knocked since; and one machine axis is long by 40 ppm.
//!
//! `cargo run -p frame-fit --example align_fixture`

use frame_fit::{
    Options, PointPair, SnoopingOptions, Transform, compare_transforms, fit_frame, shape_of, snoop,
};
use nalgebra::{Isometry3, Point3, Vector3};

/// Balls of the fixture, in its own frame, mm.
const BALLS_MM: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [400.0, 0.0, 15.0],
    [400.0, 300.0, 0.0],
    [0.0, 300.0, 40.0],
    [200.0, 150.0, 120.0],
    [90.0, 220.0, 80.0],
    [310.0, 60.0, 95.0],
    [180.0, 20.0, 60.0],
];
/// Deviations of the readings, as a random generator of 2 µm gave them, in units of 1 µm.
const NOISE_UM: [[f64; 3]; 8] = [
    [0.6, -1.9, 2.2],
    [-2.4, 0.3, -0.8],
    [1.1, 1.6, 0.4],
    [-0.2, -2.6, -1.3],
    [3.1, 0.9, 0.7],
    [-1.5, 2.0, -2.1],
    [0.8, -0.7, 1.9],
    [-1.0, 0.2, -0.9],
];

fn main() -> Result<(), frame_fit::FrameFitError> {
    let machine_from_fixture =
        Isometry3::new(Vector3::new(250.0, -80.0, 33.0), Vector3::z() * 0.02);
    let mut pairs: Vec<_> = BALLS_MM
        .iter()
        .zip(NOISE_UM)
        .map(|(ball, noise)| {
            let ball = Point3::from(*ball);
            let mut read = machine_from_fixture * ball + Vector3::from(noise) * 1e-3;
            // The x axis of the machine is long by 40 ppm.
            read.x *= 1.0 + 40e-6;
            PointPair::isotropic(ball, read, 0.002)
        })
        .collect();
    // The ball that was knocked.
    pairs[5].target_mm.z += 0.2;

    let found = snoop(&pairs, &Options::of(Transform::Affine), &SnoopingOptions::default())?;
    assert_eq!(found.suspects.len(), 1);
    let suspect = &found.suspects[0];
    assert_eq!(suspect.index, 5);
    assert!((suspect.bias_mm.z - 0.2).abs() < 0.02);
    pairs.remove(suspect.index);

    let tests = compare_transforms(&pairs, &Options::default())?;
    let needed = tests.iter().rev().find(|t| t.p_value < 0.01).map(|t| t.larger);
    assert_eq!(needed, Some(Transform::Affine));

    let affine = fit_frame(&pairs, &Options::of(Transform::Affine))?;
    let shape = shape_of(&affine.target_from_source);
    let long_by_ppm = (shape.principal_scales[0] - 1.0) * 1e6;
    assert!((long_by_ppm - 40.0).abs() < 20.0, "{long_by_ppm} ppm");

    let rigid = fit_frame(&pairs, &Options::default())?;
    let place = Point3::new(200.0, 150.0, 0.0);
    let covariance = rigid.point_covariance_mm2(&place).expect("the noise is declared");
    let sigma_um = covariance.diagonal().map(|v| v.sqrt() * 1e3);
    assert!(sigma_um.max() < 2.0, "the fixture's middle is known to {sigma_um} µm");
    Ok(())
}
