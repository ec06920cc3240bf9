//! Whatever the numbers, an answer or an error, never a panic and never NaN.

use ft_center::{
    Contact, FramePoint, GravityOptions, LocateOptions, OrbitOptions, Press, PressModel, PressRole,
    Sample, StaticPose, calibrate_gravity, fit_affine_frame, fit_sensor_frame, locate, solve_orbit,
    solve_presses,
};
use geometry::Wrench;
use nalgebra::{Matrix2, Point2, Quaternion, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -100.0..100.0f64,
        1 => prop::sample::select(vec![
            0.0, -0.0, 1e300, -1e300, 1e-300, f64::MAX, f64::MIN_POSITIVE, 5e-324, 1e160, 1e-160,
        ]),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
}

fn finite_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -100.0..100.0f64,
        1 => prop::sample::select(vec![0.0, 1e300, -1e300, 1e-300, f64::MAX, 5e-324, 1e160]),
    ]
}

fn wrench(of: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Wrench> {
    prop::collection::vec(of, 6).prop_map(|v| Wrench::from_vector(&Vector6::from_vec(v)))
}

fn record() -> impl Strategy<Value = Vec<Sample>> {
    let clean = -100.0..100.0f64;
    let clean = prop::collection::vec(wrench(clean), 0..60);
    let dirty = prop::collection::vec(wrench(finite_number().boxed()), 0..60);
    prop_oneof![3 => clean, 1 => dirty].prop_flat_map(|wrenches| {
        let n = wrenches.len();
        (Just(wrenches), prop::collection::vec(1e-3..10.0f64, n), any::<bool>()).prop_map(
            |(wrenches, steps, down)| {
                let mut time_s = 0.0;
                let samples = wrenches.into_iter().zip(steps);
                samples
                    .map(|(mut wrench, step)| {
                        time_s += step;
                        let load = wrench.force_n.z.abs();
                        wrench.force_n.z = if down { -load } else { load };
                        Sample { time_s, wrench }
                    })
                    .collect()
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn records(record in record(), z0_mm in number(), gate in prop::option::of(number())) {
        let contact = Contact { z0_mm, min_fz_n: gate };
        if let Ok(orbit) = solve_orbit(&record, &contact, &OrbitOptions::default()) {
            prop_assert!(orbit.center_mm.iter().all(|v| v.is_finite()));
            prop_assert!(orbit.covariance_mm2.iter().all(|v| v.is_finite()));
            prop_assert!(orbit.mean_wrench.to_vector().iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn frames(
        numbers in prop::collection::vec([number(), number(), number(), number()], 0..6),
        variance in number(),
    ) {
        let points: Vec<_> = numbers
            .iter()
            .map(|n| FramePoint {
                machine_mm: Point2::new(n[0], n[1]),
                sensor_mm: Point2::new(n[2], n[3]),
                covariance_mm2: Matrix2::identity() * variance.abs(),
            })
            .collect();
        if let Ok(frame) = fit_sensor_frame(&points, None) {
            prop_assert!(frame.angle_rad.is_finite());
            prop_assert!(frame.translation_mm.iter().all(|v| v.is_finite()));
        }
        if let Ok(affine) = fit_affine_frame(&points) {
            prop_assert!(affine.sensor_from_machine.linear.iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn sessions(
        records in prop::collection::vec((record(), number(), number()), 0..5),
        roles in prop::collection::vec(0..3usize, 5),
    ) {
        let presses: Vec<_> = (records.into_iter().zip(roles).enumerate())
            .map(|(i, ((record, x, y), role))| Press {
                name: i.to_string(),
                role: [PressRole::Frame, PressRole::Check, PressRole::Locate][role],
                machine_mm: Point2::new(x, y),
                record,
            })
            .collect();
        let contact = Contact { z0_mm: 30.0, min_fz_n: None };
        if let Ok(solved) = solve_presses(&presses, &contact, &OrbitOptions::default()) {
            let options = LocateOptions::default();
            if let Ok(located) = locate(&solved, &contact, &options) {
                prop_assert_eq!(located.centers.len(), presses.len());
                let finite = |c: &ft_center::Center| c.offset_mm.iter().all(|v| v.is_finite());
                prop_assert!(located.centers.iter().all(finite));
                prop_assert!(PressModel::new(&solved, &contact, &options, &[]).is_ok());
            }
        }
    }

    #[test]
    fn tools(readings in prop::collection::vec((wrench(number().boxed()), [number(), number(), number(), number()]), 0..12)) {
        let poses: Vec<_> = readings
            .into_iter()
            .map(|(wrench, q)| StaticPose {
                name: String::new(),
                base_from_sensor: UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3])),
                wrench,
            })
            .collect();
        if let Ok(found) = calibrate_gravity(&poses, &GravityOptions::default()) {
            prop_assert!(found.weight_n.is_finite());
            prop_assert!(found.center_of_gravity_mm.iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn a_clock_that_barely_moves_is_still_a_clock() {
    let wrench = Wrench { force_n: Vector3::new(0.0, 0.0, 40.0), torque_nmm: Vector3::zeros() };
    let record: Vec<_> =
        (0..100u32).map(|i| Sample { time_s: 1e9 + f64::from(i) * 1e-6, wrench }).collect();
    let contact = Contact { z0_mm: 30.0, min_fz_n: None };
    assert!(solve_orbit(&record, &contact, &OrbitOptions::default()).is_ok());
}
