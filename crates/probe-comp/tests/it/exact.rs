//! Contacts of exact data on every surface.

use std::sync::Arc;

use geometry::Plane;
use nalgebra::{Point3, Vector3};
use probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

use crate::scene::{
    TIP_MM, bowl, bowl_height, directions, let_down, normal_of, point_of, polynomials,
    reference_sphere,
};

/// What the crate promises, mm; coordinates of 100 mm round to 1e-14.
const EXACT_MM: f64 = 1e-10;

fn assert_exact(nominal: &Nominal, truth: &[(Point3<f64>, Vector3<f64>)]) {
    let touches: Vec<BallTouch> =
        truth.iter().map(|(at, n)| BallTouch::new(at + n * TIP_MM, 1e-3)).collect();
    let contacts = compensate(nominal, TIP_MM, &touches, NormalSource::Nominal).unwrap();
    for (contact, (at, normal)) in contacts.iter().zip(truth) {
        assert!((contact.point_mm - at).norm() < EXACT_MM, "{contact:?}");
        assert!((contact.normal.into_inner() - normal).norm() < EXACT_MM, "{contact:?}");
        assert!(contact.deviation_mm.abs() < EXACT_MM, "{contact:?}");
    }
}

#[test]
fn exact_contacts_on_every_surface() {
    let grid = |f: &dyn Fn(f64, f64) -> (Point3<f64>, Vector3<f64>)| -> Vec<_> {
        (-5..=5)
            .flat_map(|i| (-5..=5).map(move |j| (f64::from(i), f64::from(j))))
            .map(|(x, y)| f(4.0 * x, 4.0 * y))
            .collect()
    };
    let on_bowl = grid(&|x, y| (point_of(bowl_height, x, y), normal_of(bowl_height, x, y)));
    assert_exact(&bowl(), &on_bowl);
    let below: Vec<_> = on_bowl.iter().map(|(p, n)| (*p, -n)).collect();
    assert_exact(&bowl().from_side(Side::Against), &below);
    for (height, nominal) in polynomials() {
        assert_exact(&nominal, &grid(&|x, y| (point_of(height, x, y), normal_of(height, x, y))));
    }
    let up = Vector3::new(0.1, -0.2, 1.0).normalize();
    let plane = Plane::new(Point3::new(1.0, 2.0, 3.0), up).unwrap();
    let on_plane = |x: f64, y: f64| {
        let p = Point3::new(x, y, 3.0 - (up.x * (x - 1.0) + up.y * (y - 2.0)) / up.z);
        (p, up)
    };
    assert_exact(&Nominal::new(Arc::new(plane), Side::Along), &grid(&on_plane));
    for (side, sign) in [(Side::Along, 1.0), (Side::Against, -1.0)] {
        let center = Point3::new(40.0, -20.0, 15.0);
        let on: Vec<_> =
            directions(80).into_iter().map(|u| (center + u * 25.0, u * sign)).collect();
        assert_exact(&reference_sphere(side), &on);
    }
}

#[test]
fn deviations_count_towards_the_ball() {
    for (nominal, outward) in
        [(reference_sphere(Side::Along), 1.0), (reference_sphere(Side::Against), -1.0)]
    {
        let up = Vector3::new(0.6, 0.0, 0.8);
        let on = Point3::new(40.0, -20.0, 15.0) + up * 25.0;
        let high = on + up * (outward * (TIP_MM + 0.02));
        let touch = BallTouch::new(high, 1e-3);
        let contact = &compensate(&nominal, TIP_MM, &[touch], NormalSource::Nominal).unwrap()[0];
        assert!((contact.deviation_mm - 0.02).abs() < EXACT_MM, "{contact:?}");
    }
}

/// Compensated along z on a slope of 10°, a ball of 3 mm is off by r (1/cos 10° − 1) = 46 µm.
#[test]
fn an_approach_beside_the_normal_costs_what_it_must() {
    let (height, nominal) = (bowl_height, bowl());
    let x = super::scene::BOWL_MM * 10f64.to_radians().tan();
    let at = point_of(height, x, 0.0);
    let mut touch = BallTouch::new(at + normal_of(height, x, 0.0) * TIP_MM, 1e-3);
    touch.approach = Some(-Vector3::z_axis());
    let by = |source| compensate(&nominal, TIP_MM, std::slice::from_ref(&touch), source).unwrap();
    assert!(by(NormalSource::Nominal)[0].deviation_mm.abs() < EXACT_MM);
    let contact = &by(NormalSource::Approach)[0];
    // Above the nominal surface along z: the distance along the normal times 1/cos.
    let along_z = TIP_MM * (1.0 / 10f64.to_radians().cos() - 1.0);
    assert!((along_z - 0.0463).abs() < 1e-4);
    let vertical = contact.deviation_mm / contact.nominal_normal.z;
    // The surface bends by (r sin 10°)²/2R = 1.1 µm under the displaced contact.
    assert!((vertical - along_z).abs() < 1.5e-3, "{vertical} {along_z}");
}

#[test]
fn threads_change_nothing() {
    let touches: Vec<BallTouch> = (0..500)
        .map(|i| {
            let (x, y) = (f64::from(i % 25) - 12.0, f64::from(i / 25) - 10.0);
            BallTouch::new(let_down(bowl_height, x, y, TIP_MM), 1e-3)
        })
        .collect();
    let once = compensate(&bowl(), TIP_MM, &touches, NormalSource::Nominal).unwrap();
    let each: Vec<_> = (touches.iter())
        .flat_map(|t| {
            compensate(&bowl(), TIP_MM, std::slice::from_ref(t), NormalSource::Nominal).unwrap()
        })
        .collect();
    assert_eq!(once, each);
}

/// Principal curvatures of a part, and of the same from below, where a hump is a hollow.
#[test]
fn curvatures_count_from_the_side_that_is_touched() {
    // Of the freeform at its level place: second derivatives 0.008 and −0.012, mixed 0.003.
    let (mean, half) = (-0.002, 0.01_f64.hypot(0.003));
    let along = [[0.0, -0.02], [0.02, -0.02], [mean + half, mean - half]];
    for ((height, nominal), [major, minor]) in polynomials().into_iter().zip(along) {
        let at = point_of(height, 0.0, 0.0);
        let below = nominal.clone().from_side(Side::Against);
        for (nominal, expected) in [(nominal, [major, minor]), (below, [-minor, -major])] {
            let found = nominal.curvatures_per_mm(&at).unwrap();
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-14), "{found:?}");
        }
    }
}
