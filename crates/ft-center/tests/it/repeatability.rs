//! How well a head comes back.

use ft_center::{
    LocateOptions, OrbitOptions, Press, PressRole, locate, repeatability, solve_presses,
};
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulator::{CONTACT, Colour, Head, Placement, normal, press, record};

const PLACEMENT: Placement =
    Placement { angle_rad: 0.4, mirrored: false, shift_mm: Vector2::new(5.0, -8.0) };
/// Scatter along the machine's x and y.
const SEAT_MM: [f64; 2] = [0.08, 0.02];
const PLACES: [[f64; 2]; 4] = [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]];

fn presses(times: usize, seed: u64) -> Vec<Press> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let head = Head { load_ripple: 0.0, ..Head::default() };
    let mut all = Vec::new();
    for visit in 0..times {
        for [x, y] in PLACES {
            let at = Point2::new(x, y);
            let slip = Vector2::from(SEAT_MM).map(|s| s * normal(&mut rng));
            let record =
                record(PLACEMENT.to_sensor(at + slip), &head, &Colour::NONE, 60, 20.0, &mut rng);
            all.push(press(&format!("{visit}/{x}/{y}"), PressRole::Frame, at, record));
        }
    }
    all
}

fn of(presses: &[Press]) -> Option<ft_center::Repeatability> {
    let solved = solve_presses(presses, &CONTACT, &OrbitOptions::default()).unwrap();
    let located = locate(&solved, &CONTACT, &LocateOptions::default()).unwrap();
    repeatability(&solved, &located.centers)
}

#[test]
fn the_scatter_within_places_is_found_axis_by_axis() {
    let found = of(&presses(40, 3)).unwrap();
    assert_eq!((found.places, found.presses, found.degrees_of_freedom), (4, 160, 156));
    // A standard deviation of 156 degrees of freedom is known to 1/√312 = 5.7 %: four of those.
    for (axis, seat_mm) in SEAT_MM.iter().enumerate() {
        let ratio = found.std_mm[axis] / seat_mm;
        assert!((ratio - 1.0).abs() < 0.23, "axis {axis}: {ratio}");
    }
}

#[test]
fn places_pressed_once_say_nothing() {
    assert_eq!(of(&presses(1, 4)), None);
}
