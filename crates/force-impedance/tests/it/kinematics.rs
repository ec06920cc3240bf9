//! Inverse and forward kinematics, the leg Jacobian, and the machine's axes.

use force_impedance::{ForceImpedanceError, Head, HeadLimits, MachineChain};
use nalgebra::{Matrix4x3, Point3, SVD, Vector3, Vector4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::equilibrium::{equilibrium, random_tip};
use crate::usual_head::{GEOMETRY, head};

/// 300 mm · 2⁻⁵² · 15 operations.
const EXACT_TOL_MM: f64 = 1e-12;
/// The step tolerance of the forward kinematics, 1e-11 mm, and as much round-off.
const FORWARD_TOL_MM: f64 = 2e-11;
/// Central differences of 1e-3 mm over a head of 40 mm: h²/6·|f'''| ≈ 1e-10, and 1e-13/1e-3.
const DIFFERENCE_TOL: f64 = 1e-9;

#[test]
fn the_tip_lands_where_it_was_asked_to() {
    let head = head();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..1000 {
        let tip_mm = random_tip(&mut rng);
        let pose = head.pose_at(&tip_mm).unwrap();
        let reached_mm =
            pose.axis * (pose.lengths_mm[3] + GEOMETRY.tip_to_plane_mm) - tip_mm.coords;
        assert!(reached_mm.norm() < EXACT_TOL_MM, "{reached_mm}");
        // The joints keep their distances from the tip, as those of a rigid head do.
        let straight_mm = GEOMETRY.head_radius_mm.hypot(GEOMETRY.tip_to_plane_mm);
        for joint_mm in pose.joints_mm {
            assert!(((joint_mm - tip_mm).norm() - straight_mm).abs() < EXACT_TOL_MM);
        }
        let oracle = equilibrium(tip_mm, Vector3::y(), Vector3::zeros(), 0.0, &GEOMETRY);
        for (ours, theirs) in pose.lengths_mm.iter().zip(oracle.lengths_mm) {
            assert!((ours - theirs).abs() < EXACT_TOL_MM, "{ours} {theirs}");
        }
    }
}

#[test]
fn forward_undoes_inverse_over_the_workspace() {
    let head = head();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..1000 {
        let tip_mm = random_tip(&mut rng);
        let lengths_mm = head.pose_at(&tip_mm).unwrap().lengths_mm;
        let found = head.pose_of_lengths(&lengths_mm).unwrap();
        assert!((found.pose.tip_mm - tip_mm).norm() < FORWARD_TOL_MM);
        assert!(found.consistency_mm.abs() < FORWARD_TOL_MM);
    }
}

/// 10 µm on one of three legs: the motion takes two thirds of its square, 1/√3 of it is left.
#[test]
fn a_zero_error_of_a_leg_shows_in_the_consistency() {
    let head = head();
    let mut lengths_mm = head.pose_at(&head.start_tip_mm()).unwrap().lengths_mm;
    lengths_mm[0] += 0.010;
    let found = head.pose_of_lengths(&lengths_mm).unwrap();
    assert!((found.consistency_mm - 0.010 / 3f64.sqrt()).abs() < 2e-6, "{}", found.consistency_mm);
    let expected = Vector4::new(1.0, 1.0, 1.0, 0.0) / 3f64.sqrt();
    assert!((found.consistency_direction - expected).norm() < 1e-3);
    // The axial unit moves the head alone: its zero shows to second order only, by
    // 0.01²/(2·70) = 0.7 nm a leg.
    let mut lengths_mm = head.pose_at(&head.start_tip_mm()).unwrap().lengths_mm;
    lengths_mm[3] += 0.010;
    let found = head.pose_of_lengths(&lengths_mm).unwrap();
    assert!(found.consistency_mm.abs() < 1.5e-6, "{}", found.consistency_mm);
}

#[test]
fn the_leg_jacobian_agrees_with_differences() {
    const STEP_MM: f64 = 1e-3;
    let head = head();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..200 {
        let tip_mm = random_tip(&mut rng);
        let exact = head.leg_jacobian(&head.pose_at(&tip_mm).unwrap());
        let mut differences = Matrix4x3::zeros();
        for axis in 0..3 {
            let step_mm = Vector3::ith(axis, STEP_MM);
            let lengths = |tip| Vector4::from(head.pose_at(&tip).unwrap().lengths_mm);
            let column = (lengths(tip_mm + step_mm) - lengths(tip_mm - step_mm)) / (2.0 * STEP_MM);
            differences.set_column(axis, &column);
        }
        assert!((exact - differences).amax() < DIFFERENCE_TOL, "{}", exact - differences);
        // The consistency direction is the left null vector, by a decomposition of its own.
        let found = head.pose_of_lengths(&head.pose_at(&tip_mm).unwrap().lengths_mm).unwrap();
        let svd = SVD::new(exact, true, false);
        let along = svd.u.unwrap().transpose() * found.consistency_direction;
        assert!(along.amax() < 1e-12);
    }
}

#[test]
fn lengths_beyond_the_limits_are_refused_by_name() {
    let narrow = HeadLimits { leg_mm: [60.0, 80.0], axial_mm: [170.0, 190.0], tilt_rad: 0.1 };
    let head = Head::new(GEOMETRY, narrow).unwrap();
    let message = |x: f64, y: f64| head.pose_at(&Point3::new(x, y, 0.0)).unwrap_err().to_string();
    assert!(
        message(0.0, -320.0).starts_with("axial length would be 200"),
        "{}",
        message(0.0, -320.0)
    );
    assert!(
        message(40.0, -300.0).starts_with("head would lean by 0.13"),
        "{}",
        message(40.0, -300.0)
    );
    assert!(message(25.0, -300.0).starts_with("leg "), "{}", message(25.0, -300.0));
}

#[test]
fn the_axes_bring_a_point_of_the_workpiece_to_the_tip() {
    let chain = MachineChain { offset_z_mm: 410.0, offset_y_mm: -37.5 };
    let head = head();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..100 {
        let point_mm = Point3::new(
            rng.random_range(-200.0..200.0),
            rng.random_range(-200.0..200.0),
            rng.random_range(-50.0..50.0),
        );
        let axes_mm = chain.axes_for(&point_mm, &head.start_tip_mm());
        // The document's start pose, with Z1 = d1 − z1.
        let reach_mm = GEOMETRY.tip_to_plane_mm + GEOMETRY.plane_to_joint_mm;
        let expected = [
            -point_mm.x,
            reach_mm + point_mm.y - chain.offset_y_mm,
            chain.offset_z_mm - point_mm.z,
        ];
        assert!((axes_mm - Vector3::from(expected)).norm() < EXACT_TOL_MM);
        let there_mm = chain.head_from_workpiece(&point_mm, &axes_mm);
        assert!((there_mm - head.start_tip_mm()).norm() < EXACT_TOL_MM);
    }
}

/// The first leg that is too short or too long, by its number and its length.
#[test]
fn a_leg_out_of_range_is_the_one_that_is_named() {
    let wide = head();
    let leg_mm = [68.0, 75.0];
    let narrow = Head::new(GEOMETRY, HeadLimits { leg_mm, ..HeadLimits::wide(&GEOMETRY) }).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut named = [0; 3];
    for _ in 0..300 {
        let tip_mm = random_tip(&mut rng);
        let lengths_mm = wide.pose_at(&tip_mm).unwrap().lengths_mm;
        let first = lengths_mm[..3].iter().position(|l| *l < leg_mm[0] || *l > leg_mm[1]);
        let error = narrow.pose_at(&tip_mm).err();
        let Some(leg) = first else {
            assert_eq!(error, None);
            continue;
        };
        named[leg] += 1;
        let Some(ForceImpedanceError::LegOutOfRange { leg: found, length_mm, .. }) = error else {
            panic!("{error:?}");
        };
        assert_eq!(found, leg + 1);
        assert!((length_mm - lengths_mm[leg]).abs() < EXACT_TOL_MM, "{length_mm}");
    }
    assert!(named.iter().all(|n| *n > 3), "{named:?}");
}
