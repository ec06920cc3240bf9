//! From records to offsets in the machine.

use ft_center::{
    FtCenterError, Handedness, HandednessSource, LocateOptions, Noise, OrbitOptions, Press,
    PressModel, PressRole, Table, locate, solve_presses,
};
use model_discrepancy::Model;
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulator::{CONTACT, Colour, Head, Placement, normal, press, record};

/// Round-off of orbit and frame: 1e3 mm · 2⁻⁵² · 100 operations, through a baseline of 40 mm.
const EXACT_TOL_MM: f64 = 1e-9;

const PLACEMENT: Placement =
    Placement { angle_rad: 0.9, mirrored: true, shift_mm: Vector2::new(-600.0, 250.0) };

const OFFSET_MM: Vector2<f64> = Vector2::new(0.4, -0.3);

/// Three frame presses, one check press, one press to locate.
fn session(colour: &Colour, repeat_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Press> {
    let plan = [
        (PressRole::Frame, [500.0, 300.0]),
        (PressRole::Frame, [560.0, 310.0]),
        (PressRole::Locate, [530.0, 330.0]),
        (PressRole::Frame, [520.0, 370.0]),
        (PressRole::Check, [550.0, 350.0]),
    ];
    (plan.iter().enumerate())
        .map(|(i, (role, at))| {
            let machine = Point2::from(*at);
            let offset = if *role == PressRole::Locate { OFFSET_MM } else { Vector2::zeros() };
            let slip = Vector2::new(normal(rng), normal(rng)) * repeat_mm;
            let center = PLACEMENT.to_sensor(machine + offset + slip);
            let head = Head { load_ripple: 0.0, ..Head::default() };
            press(&format!("p{i}"), *role, machine, record(center, &head, colour, 200, 20.0, rng))
        })
        .collect()
}

#[test]
fn without_noise_the_offset_is_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let presses = session(&Colour::NONE, 0.0, &mut rng);
    let solved = solve_presses(&presses, &CONTACT, &OrbitOptions::default()).unwrap();
    let located = locate(&solved, &CONTACT, &LocateOptions::default()).unwrap();
    assert_eq!(located.frame.handedness, Handedness::Opposed);
    assert_eq!(located.frame.handedness_source, HandednessSource::Measured);
    for center in &located.centers {
        let expected = if center.role == PressRole::Locate { OFFSET_MM } else { Vector2::zeros() };
        assert!((center.offset_mm - expected).norm() < EXACT_TOL_MM, "{}", center.press);
        let sensor = located.frame.sensor_from_machine().apply(&center.machine_mm);
        assert!((sensor - center.sensor_mm).norm() < EXACT_TOL_MM);
    }
}

#[test]
fn presses_that_do_not_repeat_show_in_every_uncertainty() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let steady = session(&Colour::WHITE, 0.0, &mut rng);
    let slipping = session(&Colour::WHITE, 0.5, &mut rng);
    let run = |presses: &[Press]| {
        let solved = solve_presses(presses, &CONTACT, &OrbitOptions::default()).unwrap();
        locate(&solved, &CONTACT, &LocateOptions::default()).unwrap()
    };
    let (steady, slipping) = (run(&steady), run(&slipping));
    // Of three degrees of freedom: the root of χ²/3 lies between 0.15 and 2.1 in 998 of 1000.
    assert!((0.07..1.1).contains(&slipping.seat_mm), "{}", slipping.seat_mm);
    // The records know 2 N·mm over 40 N and the root of 200 samples, 3.5 µm; three degrees of
    // freedom leave a few times that open.
    assert!(steady.seat_mm < 0.02, "{}", steady.seat_mm);
    assert!((slipping.degrees_of_freedom - 3.0).abs() < f64::EPSILON);
    let std = |l: &ft_center::Located| l.centers[2].covariance_mm2.trace().sqrt();
    assert!(std(&slipping) > 10.0 * std(&steady));
}

#[test]
fn declared_noise_takes_the_place_of_the_scatter() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let presses = session(&Colour::WHITE, 0.0, &mut rng);
    let solved = solve_presses(&presses, &CONTACT, &OrbitOptions::default()).unwrap();
    let std = |noise: Option<Noise>| {
        let options = LocateOptions { noise, ..LocateOptions::default() };
        let model = PressModel::new(&solved, &CONTACT, &options, &[]).unwrap();
        // Both axes: the sum does not know how the frame is turned.
        model.declared().layout.rows[0].sigma.hypot(model.declared().layout.rows[1].sigma)
    };
    let declared =
        Noise { force_n: Colour::WHITE.white_force_n, moment_nmm: Colour::WHITE.white_moment_nmm };
    let (found, given) = (std(None), std(Some(declared)));
    // The scatter's own covariance has some 100 degrees of freedom: 10 % of standard deviation
    // at 1.5 sigma, and the declared value is widened by as much at most.
    assert!((found / given - 1.0).abs() < 0.2, "{found} {given}");
    let doubled = Noise { force_n: 2.0 * declared.force_n, moment_nmm: 2.0 * declared.moment_nmm };
    assert!((std(Some(doubled)) / given - 2.0).abs() < 1e-9);
    let options =
        LocateOptions { noise: Some(Noise { force_n: 0.0, ..declared }), ..Default::default() };
    assert!(matches!(
        locate(&solved, &CONTACT, &options),
        Err(FtCenterError::NotPositive { setting: "force_n", .. })
    ));
}

#[test]
fn errors_name_the_press_and_what_is_missing() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut presses = session(&Colour::WHITE, 0.0, &mut rng);
    presses[3].record.truncate(3);
    let error = solve_presses(&presses, &CONTACT, &OrbitOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("press p3: 3 of 3 samples"), "{error}");
    let solved = solve_presses(&presses[..3], &CONTACT, &OrbitOptions::default()).unwrap();
    assert!(locate(&solved, &CONTACT, &LocateOptions::default()).is_ok());
    assert_eq!(
        locate(&solved[1..], &CONTACT, &LocateOptions::default()).unwrap_err(),
        FtCenterError::TooFewFramePoints { got: 1, needed: 2 }
    );
    assert_eq!(
        locate(&[], &CONTACT, &LocateOptions::default()).unwrap_err(),
        FtCenterError::Empty { of: Table::Presses }
    );
}
