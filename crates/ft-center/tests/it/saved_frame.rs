//! The frame calibrated once, and heads located in it later.

use ft_center::{
    CommandedFrame, FtCenterError, LocateOptions, Located, OrbitOptions, Press, PressRole,
    SavedFrame, SolvedPress, locate, locate_in, solve_presses,
};
use nalgebra::{Matrix2, Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::simulator::{CONTACT, Colour, Head, Placement, normal, press, record};

/// Round-off of two frames: 1e3 mm · 2⁻⁵² · 100 operations, through a baseline of 40 mm.
const EXACT_TOL_MM: f64 = 1e-9;
/// How well the head seats.
const SEAT_MM: f64 = 0.05;
/// Sessions simulated. Of 2 axes × 600, 95 % ± 4 standard deviations (of 0.63 %) are 92.5–97.5 %.
const SESSIONS: usize = 600;
const COVERED: std::ops::RangeInclusive<f64> = 0.925..=0.975;

const PLACEMENT: Placement =
    Placement { angle_rad: 0.9, mirrored: true, shift_mm: Vector2::new(-600.0, 250.0) };

fn pressed(
    (name, role, at): (&str, PressRole, Point2<f64>),
    offset: Vector2<f64>,
    (colour, seat_mm): (&Colour, f64),
    rng: &mut ChaCha8Rng,
) -> Press {
    let slip = Vector2::new(normal(rng), normal(rng)) * seat_mm;
    let center = PLACEMENT.to_sensor(at + offset + slip);
    let head = Head { load_ripple: 0.0, ..Head::default() };
    press(name, role, at, record(center, &head, colour, 100, 20.0, rng))
}

/// Ten presses on two circles.
fn calibration(colour: &Colour, seat_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Press> {
    (0..10)
        .map(|i| {
            let (sin, cos) = (0.7 * f64::from(i)).sin_cos();
            let radius = if i % 2 == 0 { 30.0 } else { 15.0 };
            let at = Point2::new(530.0 + radius * cos, 330.0 + radius * sin);
            let name = format!("f{i}");
            pressed((&name, PressRole::Frame, at), Vector2::zeros(), (colour, seat_mm), rng)
        })
        .collect()
}

fn solved(presses: &[Press]) -> Vec<SolvedPress> {
    solve_presses(presses, &CONTACT, &OrbitOptions::default()).unwrap()
}

fn located(presses: &[Press]) -> Located {
    locate(&solved(presses), &CONTACT, &LocateOptions::default()).unwrap()
}

#[test]
fn a_head_is_where_one_solve_of_all_presses_puts_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut presses = calibration(&Colour::WHITE, SEAT_MM, &mut rng);
    let saved = SavedFrame::of(&located(&presses));
    let offset = Vector2::new(0.4, -0.3);
    let at = Point2::new(541.0, 322.0);
    let head = pressed(("h", PressRole::Locate, at), offset, (&Colour::WHITE, SEAT_MM), &mut rng);
    let later =
        locate_in(&saved, &solved(std::slice::from_ref(&head)), &CONTACT, None).unwrap().centers;
    presses.push(head);
    let together = located(&presses);
    let joint = &together.centers[10];
    // The records weigh a little differently where their noise is pooled over one more.
    assert!((later[0].machine_mm - joint.machine_mm).norm() < 1e-4, "{}", later[0].machine_mm);
    let ratio = later[0].covariance_mm2.trace() / joint.covariance_mm2.trace();
    // Its own scatter, up to a tenth of the seat's variance, is drawn towards that of ten more there.
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    let commanded = CommandedFrame::saved(&saved);
    let difference = commanded.std_translation_mm - together.commanded.std_translation_mm;
    assert!(difference.norm() < 0.05 * commanded.std_translation_mm.norm());
}

#[test]
fn without_noise_the_position_is_exact_and_a_scale_is_in_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut saved = SavedFrame::of(&located(&calibration(&Colour::NONE, 0.0, &mut rng)));
    let offset = Vector2::new(-0.7, 0.2);
    let at = Point2::new(520.0, 345.0);
    let head = pressed(("h", PressRole::Locate, at), offset, (&Colour::NONE, 0.0), &mut rng);
    let of = |saved: &SavedFrame| {
        locate_in(saved, &solved(std::slice::from_ref(&head)), &CONTACT, None)
            .unwrap()
            .centers
            .remove(0)
    };
    let center = of(&saved);
    assert!((center.offset_mm - offset).norm() < EXACT_TOL_MM, "{}", center.offset_mm);
    assert!((center.sensor_mm - PLACEMENT.to_sensor(at + offset)).norm() < EXACT_TOL_MM);
    // The machine moves 2 % farther than it says, about the reference.
    saved.scale = 1.02;
    let says = saved.reference_mm + (at + offset - saved.reference_mm) / 1.02;
    assert!((of(&saved).machine_mm - says).norm() < EXACT_TOL_MM);
    // A scale known to 1 % is 1 % of the distance from the reference, along it.
    let sharp = of(&saved).covariance_mm2;
    saved.covariance[(3, 3)] = 1e-4;
    let arm = says - saved.reference_mm;
    // d(machine)/d(scale) = −arm/scale.
    let expected: Matrix2<f64> = sharp + arm * arm.transpose() * (1e-4 / 1.02_f64.powi(2));
    assert!(
        (of(&saved).covariance_mm2 - expected).norm() < EXACT_TOL_MM * expected.norm().max(1.0)
    );
}

#[test]
fn intervals_of_later_heads_cover_with_the_scatter_of_the_calibration() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let mut hits = 0;
    for _ in 0..SESSIONS {
        let saved = SavedFrame::of(&located(&calibration(&Colour::COLOURED, SEAT_MM, &mut rng)));
        let offset = Vector2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        // Half outside of the calibrated circle, where the angle counts.
        let far = rng.random_range(0.0..60.0);
        let at = Point2::new(530.0 + far, 330.0);
        let conditions = (&Colour::COLOURED, SEAT_MM);
        let heads: Vec<Press> = (0..3)
            .map(|i| {
                let name = format!("h{i}");
                pressed((&name, PressRole::Locate, at), offset, conditions, &mut rng)
            })
            .collect();
        let center = &locate_in(&saved, &solved(&heads), &CONTACT, None).unwrap().centers[0];
        let dof = f64::from(u8::try_from(saved.degrees_of_freedom).unwrap());
        let factor = StudentsT::new(0.0, 1.0, dof).unwrap().inverse_cdf(0.975);
        for axis in 0..2 {
            let std = center.covariance_mm2[(axis, axis)].sqrt();
            hits += usize::from((center.offset_mm[axis] - offset[axis]).abs() <= factor * std);
        }
    }
    let share = hits as f64 / (2 * SESSIONS) as f64;
    assert!(COVERED.contains(&share), "95 % intervals cover {:.2} %", 100.0 * share);
}

#[test]
fn what_is_no_frame_is_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let presses = calibration(&Colour::WHITE, SEAT_MM, &mut rng);
    let saved = SavedFrame::of(&located(&presses));
    let of = |saved: SavedFrame| locate_in(&saved, &solved(&presses), &CONTACT, None);
    assert_eq!(of(saved).unwrap_err(), FtCenterError::FrameGiven { name: "f0".to_owned() });
    let with = |change: fn(&mut SavedFrame)| {
        let mut other = saved;
        change(&mut other);
        of(other).unwrap_err()
    };
    assert!(matches!(
        with(|s| s.covariance[(1, 1)] = -1.0),
        FtCenterError::InvalidFrameCovariance { .. }
    ));
    // Correlated by more than one.
    assert!(matches!(
        with(|s| {
            let product = 2.0 * (s.covariance[(1, 1)] * s.covariance[(2, 2)]).sqrt();
            s.covariance[(1, 2)] = product;
            s.covariance[(2, 1)] = product;
        }),
        FtCenterError::InvalidFrameCovariance { .. }
    ));
    assert!(matches!(
        with(|s| s.covariance[(0, 0)] = 1.0),
        FtCenterError::InvalidFrameCovariance { .. }
    ));
    assert_eq!(with(|s| s.angle_rad = f64::NAN), FtCenterError::NotFinite { index: 4 });
    assert_eq!(
        with(|s| s.scale = 0.0),
        FtCenterError::NotPositive { setting: "scale", value: 0.0 }
    );
}
