//! Distance of a tool from the part, and its uncertainty.

use nalgebra::{Point3, Vector3};
use pose_icp::{PoseOptions, TipSide, fit_pose, gap_at, program_points};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::pose_scene::{edge, nine_points, paraboloid, random_pose, tip, to_machine, touches};

const SIGMA_MM: f64 = 1e-3;
/// Sessions whose intervals are counted.
const SESSIONS: u64 = 300;
/// Of 300 intervals of 95 %, fewer or more than these hold the truth once in a thousand.
const COVERED: std::ops::RangeInclusive<usize> = 272..=297;

/// A point 1.2 mm over the paraboloid at (x, y), workpiece frame.
fn over(x: f64, y: f64) -> Vector3<f64> {
    let normal = Vector3::new(-x / 480.0, -y / 480.0, 1.0).normalize();
    Vector3::new(x, y, (x * x + y * y) / 960.0) + normal * 1.2
}

#[test]
fn intervals_hold_the_true_gap() {
    let part = paraboloid();
    for at in [[0.0, 0.0], [25.0, -10.0], [-30.0, 35.0]] {
        let mut covered = 0;
        for seed in 0..SESSIONS {
            let mut rng = ChaCha8Rng::seed_from_u64(41_000 + seed);
            let truth = random_pose(&mut rng);
            let touched = touches(&truth, &nine_points(), SIGMA_MM, &mut rng);
            let side = edge(&truth, 5e-3, &mut rng).locate(tip(), truth.angles.gamma_rad).unwrap();
            let lateral = Some(side.prior);
            let options = PoseOptions { tip: tip(), lateral, ..PoseOptions::default() };
            let fit = fit_pose(&part, &touched, &side.start, &options).unwrap();
            let tool = to_machine(&truth, over(at[0], at[1]));
            let gap = gap_at(&part, &fit, TipSide::Above, &tool).unwrap();
            let off = (gap.gap_mm - 1.2).abs();
            covered += usize::from(off <= 1.96 * gap.sigma_mm.unwrap());
        }
        assert!(COVERED.contains(&covered), "{at:?}: {covered}");
    }
}

#[test]
fn beside_the_part_the_gap_says_so() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let truth = random_pose(&mut rng);
    let touched = touches(&truth, &nine_points(), 0.0, &mut rng);
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let fit = fit_pose(&paraboloid(), &touched, &truth, &options).unwrap();
    let at = |point| gap_at(&paraboloid(), &fit, TipSide::Above, &point).unwrap();
    assert!(at(to_machine(&truth, over(49.0, 0.0))).inside_aperture);
    assert!(!at(to_machine(&truth, over(60.0, 0.0))).inside_aperture);
    let below = gap_at(&paraboloid(), &fit, TipSide::Below, &to_machine(&truth, over(5.0, 0.0)));
    assert!((below.unwrap().gap_mm + 1.2).abs() < 1e-6);
}

#[test]
fn points_of_a_program_are_those_that_it_moves_to() {
    let text = "G20 G90\nG0 X0 Y0 Z1\n(a word) G1 X1 F10\nG91 G1 Y1\nG38.2 Z-1\n";
    let points = program_points(text, &pose_icp::ProgramOptions::default()).unwrap();
    let mm = |x: f64, y: f64, z: f64| Point3::new(25.4 * x, 25.4 * y, 25.4 * z);
    let expected = [
        (2, mm(0.0, 0.0, 1.0), false),
        (3, mm(1.0, 0.0, 1.0), true),
        (4, mm(1.0, 1.0, 1.0), true),
        (5, mm(1.0, 1.0, 0.0), false),
    ];
    let found: Vec<_> = points.iter().map(|p| (p.line, p.point_mm, p.in_feed)).collect();
    assert_eq!(found, expected);
}
