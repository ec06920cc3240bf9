//! Held components, priors, and motions that the shape does not show.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use pose_icp::{
    CloudTarget, Freedom, Objective, PointCloud, RegisterError, RegisterOptions, register_to_cloud,
};
use rand::RngExt;

use super::scene;

/// A bowl of radius 200 mm, 80 mm across: a patch of a sphere.
fn bowl(seed: u64, n: usize, shift: &Vector3<f64>) -> PointCloud {
    let mut rng = scene::rng(seed);
    let center = Point3::new(0.0, 0.0, 200.0);
    let mut sampled = Vec::new();
    while sampled.len() < n {
        let (x, y): (f64, f64) = (rng.random_range(-40.0..40.0), rng.random_range(-40.0..40.0));
        if x.hypot(y) < 40.0 {
            let point = Point3::new(x, y, 200.0 - (4e4 - x * x - y * y).sqrt());
            sampled.push((point + shift, Unit::new_normalize(center - point)));
        }
    }
    let (points_mm, normals) = sampled.into_iter().unzip();
    PointCloud::with_normals(points_mm, normals)
}

fn source(seed: u64) -> PointCloud {
    let mut cloud = bowl(seed, 2000, &Vector3::new(0.0, 0.0, 0.3));
    cloud.points_mm.retain(|p| p.x.hypot(p.y) < 35.0);
    cloud.normals = None;
    cloud
}

#[test]
fn a_sphere_leaves_its_rotations_free_and_says_about_which_point() {
    let target = CloudTarget::new(&bowl(30, 20_000, &Vector3::zeros())).unwrap();
    for objective in [Objective::PointToPlane, Objective::PointToPoint] {
        let options = RegisterOptions { objective, max_iterations: 1000, ..Default::default() };
        match register_to_cloud(&source(31), &target, &options) {
            Err(RegisterError::Undetermined { directions }) => {
                assert_eq!(directions.len(), 3);
                for direction in &directions {
                    // A rotation about any axis through the centre of curvature.
                    let (point, axis, pitch_mm) = direction.screw().expect("a rotation");
                    let to_center = Point3::new(0.0, 0.0, 200.0) - point;
                    assert!(to_center.cross(&axis).norm() < 0.01, "{direction}");
                    assert!(pitch_mm.abs() < 0.01, "{direction}");
                    assert!(direction.to_string().starts_with("the rotation about"));
                }
            }
            // Between points every rotation seems to be known; the surface's rows tell.
            Ok(found) if objective == Objective::PointToPoint => {
                assert_eq!(found.observability.unwrap().weak.len(), 3);
            }
            Err(RegisterError::NotConverged { best }) if objective == Objective::PointToPoint => {
                assert_eq!(best.observability.unwrap().weak.len(), 3);
            }
            other => panic!("{objective:?}: {other:?}"),
        }
    }
}

#[test]
fn holding_the_lateral_position_and_spin_makes_the_sphere_solvable() {
    let target = CloudTarget::new(&bowl(32, 20_000, &Vector3::zeros())).unwrap();
    let mut options = RegisterOptions::default();
    for held in [0, 1, 5] {
        options.freedoms[held] = Freedom::Held;
    }
    let found = register_to_cloud(&source(33), &target, &options).unwrap();
    let motion = found.target_from_source.translation.vector;
    // z moves back by 0.3 mm; tangent planes between points 0.5 mm apart are good to
    // s²/8R = 0.2 µm each.
    assert!((motion.z + 0.3).abs() < 1e-3, "{motion}");
    let pivot = found.pivot_mm;
    let start_of_pivot = Isometry3::identity() * pivot;
    let shift = found.target_from_source * start_of_pivot - start_of_pivot;
    let turn = found.target_from_source.rotation.scaled_axis();
    assert!(turn.z.abs() < 1e-15, "{turn}");
    // What is held has no uncertainty of its own; a rotation about the shifted pivot lends it some.
    let sigma = |k: usize| found.covariance[(k, k)].sqrt();
    assert!(sigma(0) <= 0.31 * sigma(4) && sigma(1) <= 0.31 * sigma(3), "{}", found.covariance);
    // Held is held exactly, about the pivot; 1e-12 is the rounding of 100 mm.
    assert!(shift.x.abs() < 1e-12 && shift.y.abs() < 1e-12, "{shift}");
}

#[test]
fn a_prior_decides_what_the_shape_does_not() {
    let target = CloudTarget::new(&bowl(34, 20_000, &Vector3::zeros())).unwrap();
    let mut options = RegisterOptions { sigma_mm: Some(1e-3), ..Default::default() };
    options.freedoms[0] = Freedom::Prior { sigma: 0.02 };
    options.freedoms[1] = Freedom::Prior { sigma: 0.05 };
    options.freedoms[5] = Freedom::Prior { sigma: 1e-3 };
    let found = register_to_cloud(&source(35), &target, &options).unwrap();
    // On a sphere decentre and tilt are one: the prior's uncertainty is all that is known.
    for (component, sigma) in [(0, 0.02), (1, 0.05), (5, 1e-3)] {
        let claimed: f64 = found.covariance[(component, component)].sqrt();
        // The perturbation is that of the shifted pivot: 0.3 mm of 200 mm, 0.15 %.
        assert!((claimed / sigma - 1.0).abs() < 2e-3, "component {component}: {claimed}");
    }
    let motion = found.target_from_source * found.pivot_mm - found.pivot_mm;
    assert!(motion.x.abs() < 1e-3 && motion.y.abs() < 1e-3, "{motion}");
    let weak = found.observability.unwrap().weak;
    assert_eq!(weak.len(), 3, "priors are no information about the shape");
}

#[test]
fn a_plane_leaves_two_translations_and_its_spin_free() {
    let mut rng = scene::rng(36);
    let flat: Vec<_> = (0..4000)
        .map(|_| Point3::new(rng.random_range(-20.0..20.0), rng.random_range(-20.0..20.0), 0.0))
        .collect();
    let normals = vec![Vector3::z_axis(); flat.len()];
    let target = CloudTarget::new(&PointCloud::with_normals(flat.clone(), normals)).unwrap();
    let raised = flat[..500].iter().map(|p| p * 0.8 + Vector3::new(0.0, 0.0, 0.1)).collect();
    let error = register_to_cloud(&PointCloud::new(raised), &target, &RegisterOptions::default());
    let Err(RegisterError::Undetermined { directions }) = error else { panic!("{error:?}") };
    assert_eq!(directions.len(), 3);
    for direction in &directions {
        // Nothing along z, nothing about x or y.
        assert!(direction.twist.rows(2, 3).norm() < 1e-9, "{:?}", direction.twist);
    }
    let message = RegisterError::Undetermined { directions }.to_string();
    assert!(message.contains("hold it"), "{message}");
}

/// Normals that are a tenth of a milliradian off show the rotations of a sphere, as weakly.
#[test]
fn a_weak_direction_has_the_share_of_its_singular_value() {
    let mut rng = scene::rng(38);
    let mut sampled = bowl(36, 20_000, &Vector3::zeros());
    for normal in sampled.normals.iter_mut().flatten() {
        let off = Vector3::from_fn(|_, _| rng.random_range(-1e-4..1e-4));
        *normal = Unit::new_normalize(normal.into_inner() + off);
    }
    let target = CloudTarget::new(&sampled).unwrap();
    let options = RegisterOptions {
        objective: Objective::PointToPoint,
        max_iterations: 1000,
        ..Default::default()
    };
    let found = match register_to_cloud(&source(37), &target, &options) {
        Ok(found) => found,
        Err(RegisterError::NotConverged { best }) => *best,
        Err(other) => panic!("{other:?}"),
    };
    let seen = found.observability.unwrap();
    let (largest, first) = (seen.singular_values[0], 6 - seen.weak.len());
    assert_eq!(first, 3);
    for (weak, value) in seen.weak.iter().zip(&seen.singular_values[first..]) {
        assert!(*value > 0.0);
        assert_eq!(weak.relative_singular_value.to_bits(), (value / largest).to_bits());
    }
}
