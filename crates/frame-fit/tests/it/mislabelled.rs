//! Poses under the name of another place.

use frame_fit::{TipPose, mislabelled};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

const TIP_MM: [f64; 3] = [1.0, -2.0, 133.0];
const NOISE_MM: f64 = 0.02;
/// Ten standard deviations of a pose, and of what the others make of tip and places.
const NEAR_MM: f64 = 10.0 * NOISE_MM;
/// Distance of two neighbouring places.
const APART_MM: f64 = 150.0;
/// Poses of each place.
const EACH: usize = 8;

fn place_mm(k: usize) -> Vector3<f64> {
    Vector3::new(600.0 - APART_MM * k as f64, 40.0, 20.0)
}

fn poses(seed: u64) -> Vec<TipPose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..3 * EACH)
        .map(|i| {
            let turn = Vector3::from_fn(|_, _| rng.random_range(-0.5..0.5));
            let rotation = UnitQuaternion::from_scaled_axis(turn);
            let noise = scene::gauss::<3>(&mut rng) * NOISE_MM;
            let position_mm = place_mm(i / EACH) - rotation * Vector3::from(TIP_MM) + noise;
            TipPose { place: format!("P{}", i / EACH), position_mm, rotation }
        })
        .collect()
}

#[test]
fn exchanged_names_are_found_with_where_they_belong() {
    let mut named = poses(1);
    assert!(mislabelled(&named).unwrap().is_empty());
    // The first pose of P1 as P0, the last of P2 as P1: places beside each other.
    named[EACH].place = "P0".to_owned();
    named[3 * EACH - 1].place = "P1".to_owned();
    let found = mislabelled(&named).unwrap();
    let told: Vec<_> = found.iter().map(|m| (m.pose, m.like)).collect();
    // Beside another pose of its place, the first that has kept its name.
    assert_eq!(told, [(EACH, EACH + 1), (3 * EACH - 1, 2 * EACH)]);
    for pose in &found {
        assert!((pose.from_named_mm - APART_MM).abs() < NEAR_MM, "{pose:?}");
        assert!(pose.from_own_mm < NEAR_MM, "{pose:?}");
    }
}

/// Four times nearer to another place is another's; three times nearer is a bad pose of its own.
#[test]
fn a_pose_between_two_places_keeps_its_name() {
    for (share, moved) in [(0.75, false), (0.85, true)] {
        let mut poses = poses(2);
        poses[3].position_mm -= Vector3::x() * (share * APART_MM);
        let found: Vec<_> = mislabelled(&poses).unwrap().iter().map(|m| m.pose).collect();
        assert_eq!(found, if moved { vec![3] } else { vec![] }, "{share}");
    }
}
