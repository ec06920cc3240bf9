//! Intervals cover the truth as often as they say, under white and under coloured noise.

use ft_center::{
    LocateOptions, Located, OrbitOptions, Press, PressRole, locate, solve_orbit, solve_presses,
};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::simulator::{CONTACT, Colour, Head, Placement, normal, press, record};

/// Sets simulated. Of 2 axes × 1000, 95 % ± 4 standard deviations (of 0.49 %) are 93–97 %.
const SETS: usize = 1000;

const RANGE: std::ops::RangeInclusive<f64> = 0.93..=0.97;

/// Share of hits among tries.
#[derive(Default)]
struct Share {
    hits: usize,
    tries: usize,
}

impl Share {
    fn add(&mut self, error: f64, std: f64, dof: f64) {
        let factor = StudentsT::new(0.0, 1.0, dof).unwrap().inverse_cdf(0.975);
        self.hits += usize::from(error.abs() <= factor * std);
        self.tries += 1;
    }

    fn assert_95(&self, of: &str) {
        assert!(self.tries >= 1000);
        let share = self.hits as f64 / self.tries as f64;
        assert!(RANGE.contains(&share), "95 % intervals of {of} cover {:.2} %", 100.0 * share);
    }
}

fn assert_centres_covered(colour: &Colour, samples: usize, rate_hz: f64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth = Point2::new(12.0, -7.0);
    let mut share = Share::default();
    for _ in 0..SETS {
        let spin_hz = rng.random_range(1.0..2.5);
        let head = Head { spin_hz, ..Head::default() };
        let record = record(truth, &head, colour, samples, rate_hz, &mut rng);
        let orbit = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap();
        for axis in 0..2 {
            let std = orbit.covariance_mm2[(axis, axis)].sqrt();
            share.add(orbit.center_mm[axis] - truth[axis], std, orbit.degrees_of_freedom);
        }
    }
    share.assert_95(&format!("centres, {samples} samples, memory {} s", colour.memory_s));
}

#[test]
fn centres_under_white_noise() {
    assert_centres_covered(&Colour::WHITE, 300, 20.0, 1);
}

#[test]
fn centres_under_coloured_noise() {
    assert_centres_covered(&Colour::COLOURED, 600, 20.0, 2);
}

#[test]
fn centres_under_slow_noise() {
    // Remembers a thirtieth of the record: a dozen independent samples.
    assert_centres_covered(&Colour { memory_s: 1.0, ..Colour::COLOURED }, 600, 20.0, 3);
}

#[test]
fn white_intervals_would_fail_under_coloured_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let truth = Point2::new(12.0, -7.0);
    let mut share = Share::default();
    for _ in 0..300 {
        let record = record(truth, &Head::default(), &Colour::COLOURED, 600, 20.0, &mut rng);
        let orbit = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap();
        let white = orbit.scatter_mm2 / orbit.contact_samples as f64;
        share.add(orbit.center_mm.x - truth.x, white[(0, 0)].sqrt(), 600.0);
    }
    let covered = share.hits as f64 / share.tries as f64;
    assert!(covered < 0.7, "independent samples would do: {covered}");
}

const PLACEMENT: Placement =
    Placement { angle_rad: -2.1, mirrored: true, shift_mm: Vector2::new(264.3, 210.3) };

/// How a session is pressed.
struct Session<'a> {
    /// Four frame presses under each; the press to locate has the first.
    loads_n: &'a [f64],
    samples: usize,
    colour: Colour,
    /// The head seats anew on each press.
    seat_mm: f64,
}

fn session(session: &Session<'_>, offset_mm: Vector2<f64>, rng: &mut ChaCha8Rng) -> Vec<Press> {
    let at = [[300.0, 100.0], [340.0, 100.0], [320.0, 150.0], [290.0, 140.0]];
    let frame = session.loads_n.iter().flat_map(|load_n| at.map(|at| (at, *load_n)));
    let located = ([322.0, 118.0], session.loads_n[0]);
    let n_frame = at.len() * session.loads_n.len();
    (frame.chain([located]).enumerate())
        .map(|(i, (at, load_n))| {
            let machine = Point2::from(at);
            let (role, truth) = if i == n_frame {
                (PressRole::Locate, machine + offset_mm)
            } else {
                (PressRole::Frame, machine)
            };
            let seat = Vector2::new(normal(rng), normal(rng)) * session.seat_mm;
            let center = PLACEMENT.to_sensor(truth + seat);
            let head = Head { load_n, ..Head::default() };
            let record = record(center, &head, &session.colour, session.samples, 20.0, rng);
            press(&format!("p{i}"), role, machine, record)
        })
        .collect()
}

fn assert_located_covered(of: &Session<'_>, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let offset_mm = Vector2::new(0.31, -0.22);
    let [mut angles, mut pivots, mut offsets] = [const { Share { hits: 0, tries: 0 } }; 3];
    for _ in 0..SETS {
        let presses = session(of, offset_mm, &mut rng);
        let solved = solve_presses(&presses, &CONTACT, &OrbitOptions::default()).unwrap();
        let Located { frame, centers, degrees_of_freedom: dof, .. } =
            locate(&solved, &CONTACT, &LocateOptions::default()).unwrap();
        let covariance = &frame.covariance;
        angles.add(frame.angle_rad - PLACEMENT.angle_rad, covariance[(0, 0)].sqrt(), dof);
        let pivot = PLACEMENT.to_sensor(frame.pivot_mm);
        let found = frame.sensor_from_machine().apply(&frame.pivot_mm);
        for axis in 0..2 {
            let std = covariance[(1 + axis, 1 + axis)].sqrt();
            pivots.add(found[axis] - pivot[axis], std, dof);
            let located = centers.last().unwrap();
            let std = located.covariance_mm2[(axis, axis)].sqrt();
            offsets.add(located.offset_mm[axis] - offset_mm[axis], std, dof);
        }
    }
    angles.assert_95("frame angles");
    pivots.assert_95("frame translations");
    offsets.assert_95("offsets");
}

/// One load: the records' noise is the same for all.
fn steady(colour: Colour) -> Session<'static> {
    Session { loads_n: &[40.0], samples: 300, colour, seat_mm: 0.0 }
}

/// 2 N·mm over 60 N, or 20 N, and the root of 120 samples: the records know 3 and 9 µm.
fn seating(seat_mm: f64) -> Session<'static> {
    Session { loads_n: &[20.0, 60.0], samples: 120, colour: Colour::WHITE, seat_mm }
}

#[test]
fn frame_and_offsets_under_white_noise() {
    assert_located_covered(&steady(Colour::WHITE), 5);
}

#[test]
fn frame_and_offsets_under_coloured_noise() {
    assert_located_covered(&steady(Colour { memory_s: 0.2, ..Colour::COLOURED }), 6);
}

#[test]
fn frame_and_offsets_of_a_head_that_seats_perfectly() {
    assert_located_covered(&seating(0.0), 7);
}

#[test]
fn frame_and_offsets_with_a_seat_like_the_noise_of_the_records() {
    assert_located_covered(&seating(0.005), 8);
}

#[test]
fn frame_and_offsets_with_a_seat_beyond_the_noise_of_the_records() {
    assert_located_covered(&seating(0.030), 9);
}
