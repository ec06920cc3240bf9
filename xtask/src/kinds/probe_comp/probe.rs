//! A part on a machine, touched by a ball probe.
//!
//! Written from what happens: the ball moves along its approach until its least distance from the
//! real surface, found by searching the surface, is its radius; then the probe triggers late, the
//! stylus gives way, and the machine reads with its own errors.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise, gaussian};
use crate::generators::vector::{add, cross, dot, norm, rotate, scale};

/// What is wrong with probe, machine or part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flaw {
    None,
    /// The ball is larger, mm.
    Ball(f64),
    /// The probe triggers late by this travel, mm.
    Pretravel(f64),
    /// The travel has three lobes, cos and sin, times the sideways part of the approach, mm.
    Lobing([f64; 2]),
    /// The stylus gives way sideways, mm.
    Bending(f64),
    /// The machine is read late, s.
    Latency(f64),
    /// The axes are not square: xy, xz, yz, rad.
    Squareness([f64; 3]),
    /// The axes read long, ratio.
    AxisScale([f64; 3]),
    /// The machine drifts by this over the session, warming up, mm.
    Drift([f64; 3]),
    /// The part settles in its fixture: in the end by this, mm, with this share of the session as
    /// its time constant.
    Settling([f64; 3], f64),
    /// One touch stops short by this, mm.
    BadPoint(usize, f64),
    /// Readings of z follow the air, mm per kelvin.
    Growth(f64),
    /// The part has three lobes about z, mm.
    PartLobes(f64),
    /// A planed part: waves along x, mm, of this length, mm.
    Waves(f64, f64),
    /// A patch of the part is low: mm, and its width, mm.
    Patch(f64, f64),
    /// The x axis stops on either side of where it is read, by the way it came, this far apart, mm.
    Reversal(f64),
    /// The ball swells with the humidity, mm per percent.
    Humidity(f64),
}

/// The part as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// A whole sphere about the origin, of which the upper half is touched.
    Sphere { radius_mm: f64 },
    /// A paraboloid bowl, Φ100.
    Bowl { radius_mm: f64 },
}

/// A session.
#[derive(Clone, Debug)]
pub(crate) struct Session {
    pub shape: Shape,
    pub tip_mm: f64,
    /// Touches, every fourth of which is only judged.
    pub n_touches: usize,
    /// Angle between approach and nominal normal, any way round; recorded unless it is zero.
    pub oblique_rad: f64,
    /// Feeds, one of which is taken at random.
    pub feeds_mm_per_min: &'static [f64],
    pub record_feed: bool,
    pub record_air: bool,
    /// Standard uncertainty of each coordinate of a touch, mm.
    pub noise_mm: f64,
    pub colour: Colour,
    pub declare_noise: bool,
    pub flaw: Flaw,
    /// Another flaw beside it.
    pub also: Flaw,
    pub seed: u64,
}

impl Session {
    /// Forty-eight touches of 1 µm on a sphere of 25 mm, nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            shape: Shape::Sphere { radius_mm: 25.0 },
            tip_mm: 3.0,
            n_touches: 64,
            oblique_rad: 0.0,
            feeds_mm_per_min: &FEEDS_MM_PER_MIN,
            record_feed: false,
            record_air: false,
            noise_mm: 1e-3,
            colour: Colour::White,
            declare_noise: true,
            flaw: Flaw::None,
            also: Flaw::None,
            seed,
        }
    }

    fn flaws(&self) -> [Flaw; 2] {
        [self.flaw, self.also]
    }
}

/// One touch.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    pub read_mm: [f64; 3],
    pub approach: [f64; 3],
    pub feed_mm_per_min: f64,
    pub air_c: f64,
    pub humidity_pct: f64,
    pub is_check: bool,
    /// Reading without noise less that of the nominal part by a sound machine, along the normal.
    pub signal_mm: f64,
    /// The noise along the normal.
    pub noise_mm: f64,
    /// Nominal normal.
    pub normal: [f64; 3],
    /// Nominal contact.
    pub contact_mm: [f64; 3],
}

/// Seconds between touches.
pub(crate) const TOUCH_INTERVAL_S: f64 = 12.0;
/// Feeds that an operator would use, mm/min.
const FEEDS_MM_PER_MIN: [f64; 3] = [60.0, 120.0, 300.0];
/// Distance from which the ball starts, mm.
const STANDOFF_MM: f64 = 0.5;
/// Step of the search over the surface, mm; steps halve it to a picometre.
const SEARCH_STEP_MM: f64 = 0.1;
/// Warming time constant over the length of the session.
const WARMING_TIME: f64 = 2.0;
/// Radius of the bowl that is touched, mm.
const BOWL_REACH_MM: f64 = 46.0;

/// Simulates a session.
pub(crate) fn simulate(session: &Session) -> Vec<Touch> {
    let mut rng = ChaCha8Rng::seed_from_u64(session.seed);
    let n = session.n_touches;
    let mut order: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        order.swap(i, rng.random_range(0..=i));
    }
    let phase = rng.random_range(0.0..TAU);
    let wander = |i: usize, size: f64, periods: f64, rng: &mut ChaCha8Rng| {
        size * (phase + TAU * periods * as_f64(i) / as_f64(n)).sin() + 0.1 * size * gaussian(rng)
    };
    let mut noises: Vec<Noise> = (0..3).map(|_| Noise::new(session.colour, &mut rng)).collect();
    let mut last_x_mm = None;
    order
        .iter()
        .enumerate()
        .map(|(index, &place)| {
            let (contact_mm, normal) = nominal(session, place);
            let approach = approach(session, normal, &mut rng);
            let mut touch = Touch {
                read_mm: [0.0; 3],
                approach,
                feed_mm_per_min: session.feeds_mm_per_min
                    [rng.random_range(0..session.feeds_mm_per_min.len())],
                air_c: 20.4 + wander(index, 0.6, 1.3, &mut rng),
                humidity_pct: 45.0 + wander(index, 4.0, 2.1, &mut rng),
                is_check: index % 4 == 3,
                signal_mm: 0.0,
                noise_mm: 0.0,
                normal,
                contact_mm,
            };
            let mut clean = read(session, index, &touch);
            let x_mm = clean[0];
            clean[0] += reversed_mm(session, x_mm - last_x_mm.replace(x_mm).unwrap_or(x_mm));
            let nominal_center = add(contact_mm, scale(session.tip_mm, normal));
            touch.signal_mm = dot(add(clean, scale(-1.0, nominal_center)), normal);
            let noise: [f64; 3] =
                std::array::from_fn(|axis| session.noise_mm * noises[axis].next(&mut rng));
            touch.noise_mm = dot(noise, normal);
            touch.read_mm = add(clean, noise);
            touch
        })
        .collect()
}

/// Where a further touch of the same part is meant to be: nominal contact and normal, approach, feed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meant {
    pub contact_mm: [f64; 3],
    pub normal: [f64; 3],
    pub approach: [f64; 3],
    pub feed_mm_per_min: f64,
}

/// What the machine reads at further touches after a session, with noise of its own.
pub(crate) fn touch_again(session: &Session, meant: &[Meant], seed: u64) -> Vec<[f64; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (meant.iter().enumerate())
        .map(|(index, place)| {
            let touch = Touch {
                read_mm: [0.0; 3],
                approach: place.approach,
                feed_mm_per_min: place.feed_mm_per_min,
                air_c: 20.4,
                humidity_pct: 45.0,
                is_check: false,
                signal_mm: 0.0,
                noise_mm: 0.0,
                normal: place.normal,
                contact_mm: place.contact_mm,
            };
            let noise = std::array::from_fn(|_| session.noise_mm * gaussian(&mut rng));
            add(read(session, session.n_touches + index, &touch), noise)
        })
        .collect()
}

/// Places spread evenly over what a session touches, approached along their normals.
pub(crate) fn even_places(session: &Session, count: usize) -> Vec<Meant> {
    let grid = Session { n_touches: count, ..session.clone() };
    (0..count)
        .map(|place| {
            let (contact_mm, normal) = nominal(&grid, place);
            Meant { contact_mm, normal, approach: scale(-1.0, normal), feed_mm_per_min: 100.0 }
        })
        .collect()
}

/// Nominal contact and normal of a place.
fn nominal(session: &Session, place: usize) -> ([f64; 3], [f64; 3]) {
    let share = (as_f64(place) + 0.5) / as_f64(session.n_touches);
    let (sin, cos) = (2.399_963 * as_f64(place)).sin_cos();
    match session.shape {
        Shape::Sphere { radius_mm } => {
            let side = (1.0 - share * share).sqrt();
            let up = [side * cos, side * sin, share];
            (scale(radius_mm, up), up)
        }
        Shape::Bowl { radius_mm } => {
            let reach = BOWL_REACH_MM * share.sqrt();
            let (x, y) = (reach * cos, reach * sin);
            let n = [-x / radius_mm, -y / radius_mm, 1.0];
            ([x, y, (x * x + y * y) / (2.0 * radius_mm)], scale(1.0 / norm(&n), n))
        }
    }
}

/// From the ball towards the part.
fn approach(session: &Session, normal: [f64; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    let towards = scale(-1.0, normal);
    let turn = rng.random_range(0.0..TAU);
    if session.oblique_rad == 0.0 {
        return towards;
    }
    let [first, _] = tangents(normal);
    rotate(rotate(normal, turn, first), session.oblique_rad, towards)
}

/// What the machine reads.
fn read(session: &Session, index: usize, touch: &Touch) -> [f64; 3] {
    let swollen = session.flaws().map(|flaw| match flaw {
        Flaw::Ball(larger) => larger,
        Flaw::Humidity(per_pct) => per_pct * (touch.humidity_pct - 45.0),
        _ => 0.0,
    });
    let mut center = touched_by(session, touch, session.tip_mm + (swollen[0] + swollen[1]));
    for flaw in session.flaws() {
        center = add(center, late(flaw, index, touch));
    }
    let of_machine = session.flaws().map(|flaw| machine_error(flaw, session, index, center, touch));
    add(center, add(of_machine[0], of_machine[1]))
}

/// Where x stops beside where it is read, after a move by this much.
fn reversed_mm(session: &Session, moved_mm: f64) -> f64 {
    let of = |flaw: Flaw| match flaw {
        Flaw::Reversal(apart_mm) if moved_mm != 0.0 => 0.5 * apart_mm * moved_mm.signum(),
        _ => 0.0,
    };
    session.flaws().map(of).iter().sum()
}

/// How far from the contact the probe triggers.
fn late(flaw: Flaw, index: usize, touch: &Touch) -> [f64; 3] {
    let a = touch.approach;
    let sideways = [a[0], a[1], 0.0];
    match flaw {
        Flaw::Pretravel(travel) => scale(travel, a),
        Flaw::Lobing([cos, sin]) => {
            let angle = 3.0 * a[1].atan2(a[0]);
            scale(norm(&sideways) * (cos * angle.cos() + sin * angle.sin()), a)
        }
        Flaw::Bending(by) => scale(by, sideways),
        Flaw::Latency(time_s) => scale(time_s * touch.feed_mm_per_min / 60.0, a),
        Flaw::BadPoint(bad, short) if bad == index => scale(-short, a),
        _ => [0.0; 3],
    }
}

fn machine_error(
    flaw: Flaw,
    session: &Session,
    index: usize,
    at: [f64; 3],
    touch: &Touch,
) -> [f64; 3] {
    match flaw {
        Flaw::Squareness(g) => [g[0] * at[1] + g[1] * at[2], g[2] * at[2], 0.0],
        Flaw::AxisScale(s) => std::array::from_fn(|i| s[i] * at[i]),
        Flaw::Drift(total) => {
            let time = as_f64(index) / as_f64(session.n_touches - 1) / WARMING_TIME;
            let grown = (1.0 - (-time).exp()) / (1.0 - (-1.0 / WARMING_TIME).exp());
            scale(grown, total)
        }
        Flaw::Settling(total, share) => {
            let time = as_f64(index) / as_f64(session.n_touches - 1);
            scale(1.0 - (-time / share).exp(), total)
        }
        Flaw::Growth(per_k) => [0.0, 0.0, per_k * (touch.air_c - 20.0)],
        _ => [0.0; 3],
    }
}

/// Ball's centre where, moved along its approach, it meets the real surface.
fn touched_by(session: &Session, touch: &Touch, tip_mm: f64) -> [f64; 3] {
    let aim = add(touch.contact_mm, scale(tip_mm, touch.normal));
    let start = add(aim, scale(-STANDOFF_MM, touch.approach));
    let gap = |travel: f64| {
        let center = add(start, scale(travel, touch.approach));
        least_distance(session, touch, center) - tip_mm
    };
    // The gap falls as the ball comes nearer, from half a millimetre to below zero.
    let (mut open, mut shut) = (0.0, 2.0 * STANDOFF_MM);
    for _ in 0..60 {
        let middle = 0.5 * (open + shut);
        if gap(middle) > 0.0 {
            open = middle;
        } else {
            shut = middle;
        }
    }
    add(start, scale(0.5 * (open + shut), touch.approach))
}

/// Least distance of a point from the real surface, by a search that walks over it with ever
/// smaller steps.
fn least_distance(session: &Session, touch: &Touch, from: [f64; 3]) -> f64 {
    let distance = |at: [f64; 2]| {
        let on = surface(session, touch, at);
        norm(&add(on, scale(-1.0, from)))
    };
    let mut at = [0.0; 2];
    let mut best = distance(at);
    let mut step = SEARCH_STEP_MM;
    // The distance is flat to second order at the foot: steps of 1e-7 mm leave 1e-15 mm.
    while step > 1e-7 {
        let trials = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
        let next = trials
            .map(|d| [at[0] + d[0], at[1] + d[1]])
            .map(|p| (distance(p), p))
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("there are four");
        if next.0 < best {
            (best, at) = next;
        } else {
            step *= 0.5;
        }
    }
    best
}

/// Point of the real surface, by two coordinates about the nominal contact.
fn surface(session: &Session, touch: &Touch, [u, v]: [f64; 2]) -> [f64; 3] {
    match session.shape {
        Shape::Sphere { radius_mm } => {
            let [first, second] = tangents(touch.normal);
            let about = add(touch.contact_mm, add(scale(u, first), scale(v, second)));
            let up = scale(1.0 / norm(&about), about);
            scale(radius_mm + form(session, up, scale(radius_mm, up)), up)
        }
        Shape::Bowl { radius_mm } => {
            let (x, y) = (touch.contact_mm[0] + u, touch.contact_mm[1] + v);
            let z = (x * x + y * y) / (2.0 * radius_mm);
            let place = scale(1.0 / BOWL_REACH_MM, [x, y, 0.0]);
            [x, y, z + form(session, place, [x, y, z])]
        }
    }
}

/// By how much the real surface is higher: `place` in units of the part, `at` in mm.
fn form(session: &Session, place: [f64; 3], at: [f64; 3]) -> f64 {
    let of = session.flaws().map(|flaw| match flaw {
        Flaw::PartLobes(size) => {
            size * place[0] * (place[0] * place[0] - 3.0 * place[1] * place[1])
        }
        Flaw::Waves(size, length) => size * (TAU * at[0] / length).cos(),
        Flaw::Patch(low, width) => {
            let off = add(at, scale(-1.0, patch_mm(session)));
            -low * (-off.iter().map(|v| v * v).sum::<f64>() / (width * width)).exp()
        }
        _ => 0.0,
    });
    of[0] + of[1]
}

/// The middle of a patch, half way between the top and the rim of what is touched.
fn patch_mm(session: &Session) -> [f64; 3] {
    match session.shape {
        Shape::Sphere { radius_mm } => scale(radius_mm, [0.6, -0.35, (1.0f64 - 0.4825).sqrt()]),
        Shape::Bowl { radius_mm } => [20.0, -12.0, 544.0 / (2.0 * radius_mm)],
    }
}

fn tangents(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let helper = if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let first = cross(normal, helper);
    let first = scale(1.0 / norm(&first), first);
    [first, cross(normal, first)]
}

/// Root mean square over check touches of the noise along the normal, mm.
pub(crate) fn check_noise_mm(touches: &[Touch]) -> f64 {
    let squares: Vec<f64> =
        touches.iter().filter(|t| t.is_check).map(|t| t.noise_mm * t.noise_mm).collect();
    (squares.iter().sum::<f64>() / as_f64(squares.len().max(1))).sqrt()
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The search ends within 1e-7 mm of the foot; the bisection within 1e-17 mm of the gap.
    #[test]
    fn a_sound_probe_on_a_sound_part_reads_the_nominal_centre() {
        for shape in [Shape::Sphere { radius_mm: 25.0 }, Shape::Bowl { radius_mm: 120.0 }] {
            let session = Session { shape, noise_mm: 0.0, ..Session::new(3) };
            for touch in simulate(&session) {
                assert!(touch.signal_mm.abs() < 1e-10, "{touch:?}");
            }
        }
    }

    /// Without noise a touch that is made again where it was made reads the same.
    #[test]
    fn a_touch_made_again_reads_the_same() {
        let flaw = Flaw::Bending(5e-3);
        let session = Session { flaw, oblique_rad: 0.5, noise_mm: 0.0, ..Session::new(3) };
        let touches = simulate(&session);
        let meant = |t: &Touch| Meant {
            contact_mm: t.contact_mm,
            normal: t.normal,
            approach: t.approach,
            feed_mm_per_min: t.feed_mm_per_min,
        };
        let again = touch_again(&session, &touches.iter().map(meant).collect::<Vec<_>>(), 5);
        for (touch, read_mm) in touches.iter().zip(again) {
            let off = add(read_mm, scale(-1.0, touch.read_mm));
            // The same steps in the same order: nothing but round-off.
            assert!(norm(&off) < 1e-12, "{off:?}");
        }
    }

    /// A ball that comes in at 30° to the normal still touches with the point on the normal.
    #[test]
    fn the_way_of_a_ball_does_not_move_its_contact() {
        let session = Session { oblique_rad: 0.5, noise_mm: 0.0, ..Session::new(3) };
        for touch in simulate(&session) {
            assert!(touch.signal_mm.abs() < 1e-10, "{touch:?}");
        }
    }
}
