//! A mirror on a machine, touched by a ball probe.
//!
//! Written from what happens: the real surface is a height function, its normal comes from
//! differences, the ball sits on it along that normal, the pose moves it to the machine, and the
//! machine reads it with its own errors.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise, gaussian};
use crate::generators::vector::{add, dot, norm, rotate, scale};

/// What is wrong with probe, mirror or machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flaw {
    None,
    /// The ball is larger, mm.
    Tip(f64),
    /// The vertex radius is longer, mm.
    VertexRadius(f64),
    /// The conic constant is larger.
    Conic(f64),
    /// Saddle, cos and sin, mm at the rim.
    Astigmatism([f64; 2]),
    /// Coma, mm at the rim.
    Coma([f64; 2]),
    /// Three lobes, mm at the rim.
    Trefoil([f64; 2]),
    /// The axes read long, ratio.
    MachineScale([f64; 3]),
    /// The axes are not square: xy, xz, yz, rad.
    Squareness([f64; 3]),
    /// The spindle grows while it warms up, mm over the session.
    Drift(f64),
    /// The spindle reaches its temperature: mm in the end, with this share of the session as its time
    /// constant.
    Settling(f64, f64),
    /// The part is clamped anew before this touch, and lies elsewhere: mm.
    Clamped(usize, [f64; 3]),
    /// An axis reads long where the ball comes to the part from below along it, and short from above:
    /// which, and half of the difference, mm.
    Play(usize, f64),
    /// The same by the side from which the axis comes from the touch before.
    PlayBetween(usize, f64),
    /// One touch reads high along z, mm.
    BadPoint(usize, f64),
    /// Readings of z follow the air, mm per kelvin.
    Growth(f64),
    /// Rings left by a rotating tool: mm, period mm.
    Rings(f64, f64),
    /// A raised patch of the given width about (12, −9) mm, mm.
    Bump(f64, f64),
    /// The probe's ball settles by this much per percent of humidity, mm.
    Humidity(f64),
}

/// Everything that is wrong at the same time.
type Flaws = [Flaw; 2];

const NOMINAL: Flaws = [Flaw::None; 2];

/// A session.
#[derive(Clone, Debug)]
pub(crate) struct Mirror {
    pub radius_mm: f64,
    pub conic: f64,
    pub diameter_mm: f64,
    pub tip_mm: f64,
    /// Touches, every fourth of which is only judged.
    pub n_points: usize,
    /// Standard uncertainty of each coordinate of a touch, mm.
    pub noise_mm: f64,
    pub colour: Colour,
    pub declare_noise: bool,
    /// Whether the side is touched too.
    pub sides: bool,
    pub record_air: bool,
    pub flaw: Flaw,
    /// What is wrong besides.
    pub also: Flaw,
    pub seed: u64,
}

impl Mirror {
    /// R = 120 mm, Φ100, forty touches of 1 µm, nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            radius_mm: 120.0,
            conic: -1.0,
            diameter_mm: 100.0,
            tip_mm: 3.0,
            n_points: 48,
            noise_mm: 1e-3,
            colour: Colour::White,
            declare_noise: true,
            sides: true,
            record_air: false,
            flaw: Flaw::None,
            also: Flaw::None,
            seed,
        }
    }
}

impl Mirror {
    fn flaws(&self) -> Flaws {
        [self.flaw, self.also]
    }
}

/// What a session gave.
#[derive(Clone, Debug)]
pub(crate) struct Touched {
    pub case_toml: String,
    pub points_csv: String,
    pub edge_csv: Option<String>,
    /// x, y and z of the mirror's vertex in mm, and its tilts about x and y in degrees.
    pub pose: [f64; 5],
    /// Where each touch meets the nominal mirror, workpiece frame, mm.
    pub contacts_mm: Vec<[f64; 3]>,
    /// Normal there.
    pub normals: Vec<[f64; 3]>,
    /// Deviation of each reading along the nominal normal without noise, mm.
    pub signal_mm: Vec<f64>,
    pub is_check: Vec<bool>,
    /// Root mean square over check points of the noise along the normal, mm.
    pub check_noise_mm: f64,
}

/// Side touches are this far below the vertex, mm.
const SIDE_DEPTH_MM: f64 = 8.0;
/// Step of the differences that give normals, mm: the third derivative is below 1e-6 /mm².
const STEP_MM: f64 = 1e-3;
/// Seconds between touches.
const TOUCH_INTERVAL_S: f64 = 12.0;
/// Warming time constant of the spindle over the length of the session.
const WARMING_TIME: f64 = 2.0;
/// Share of the aperture's radius that is touched.
const TOUCHED_SHARE: f64 = 0.96;

/// Simulates a session.
pub(crate) fn simulate(mirror: &Mirror) -> Touched {
    let mut rng = ChaCha8Rng::seed_from_u64(mirror.seed);
    let pose = Pose::random(&mut rng);
    let places = places(mirror, &mut rng);
    let air = Air::simulate(mirror.n_points, &mut rng);
    let mut noises: Vec<Noise> = (0..3).map(|_| Noise::new(mirror.colour, &mut rng)).collect();
    let mut out = Touched {
        case_toml: case_toml(mirror),
        points_csv: String::new(),
        edge_csv: None,
        pose: pose.numbers(),
        contacts_mm: Vec::new(),
        normals: Vec::new(),
        signal_mm: Vec::new(),
        is_check: Vec::new(),
        check_noise_mm: 0.0,
    };
    let mut rows = Vec::new();
    let (mut n_checks, mut before) = (0.0, None);
    for (index, &[x, y]) in places.iter().enumerate() {
        let nominal = ball(mirror, &NOMINAL, x, y);
        let real = ball(mirror, &mirror.flaws(), x, y);
        let real = pose.map(real);
        let normal = pose.turn(normal(mirror, &NOMINAL, x, y));
        let moved = add(real, scale(-1.0, before.unwrap_or(real)));
        before = Some(real);
        let read = add(real, machine_error(mirror, &pose, real, index, &air));
        let read = add(read, play(mirror, normal, moved));
        let noise: [f64; 3] =
            std::array::from_fn(|axis| mirror.noise_mm * noises[axis].next(&mut rng));
        let off = add(read, scale(-1.0, pose.map(nominal)));
        let is_check = index % 4 == 3;
        if is_check {
            out.check_noise_mm += dot(noise, normal).powi(2);
            n_checks += 1.0;
        }
        rows.push(add(read, noise));
        out.contacts_mm.push([x, y, height(mirror, &NOMINAL, x, y)]);
        out.normals.push(normal);
        out.signal_mm.push(dot(off, normal));
        out.is_check.push(is_check);
    }
    out.check_noise_mm = (out.check_noise_mm / f64::max(n_checks, 1.0)).sqrt();
    out.points_csv = points_csv(mirror, &rows, &out.is_check, &air);
    out.edge_csv = mirror.sides.then(|| edge_csv(mirror, &pose, &mut rng));
    out
}

/// What the machine reads when it touches the mirror again, above places of the mirror, with noise
/// of its own; of flaws that need no time and no air.
pub(crate) fn touch_again(mirror: &Mirror, places: &[[f64; 2]], seed: u64) -> Vec<[f64; 3]> {
    let pose = Pose::random(&mut ChaCha8Rng::seed_from_u64(mirror.seed));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let air = Air::simulate(mirror.n_points + places.len(), &mut rng);
    (places.iter().enumerate())
        .map(|(index, &[x, y])| {
            let real = pose.map(ball(mirror, &mirror.flaws(), x, y));
            let error = machine_error(mirror, &pose, real, mirror.n_points + index, &air);
            let noise = std::array::from_fn(|_| mirror.noise_mm * gaussian(&mut rng));
            add(add(real, error), noise)
        })
        .collect()
}

/// Places spread evenly over a mirror.
pub(crate) fn even_places(mirror: &Mirror, count: usize) -> Vec<[f64; 2]> {
    let grid = Mirror { n_points: count, ..mirror.clone() };
    places(&grid, &mut ChaCha8Rng::seed_from_u64(mirror.seed))
}

/// Where and how the mirror lies.
struct Pose {
    tilts_rad: [f64; 2],
    at_mm: [f64; 3],
}

impl Pose {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let mut within = |size: f64| rng.random_range(-size..size);
        let tilts_rad = [within(8e-3), within(8e-3)];
        Self {
            tilts_rad,
            at_mm: [-499.0 + within(5.0), -475.0 + within(5.0), -285.0 + within(2.0)],
        }
    }

    fn numbers(&self) -> [f64; 5] {
        let ([x, y, z], [a, b]) = (self.at_mm, self.tilts_rad.map(f64::to_degrees));
        [x, y, z, a, b]
    }

    fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        let tilted = rotate([1.0, 0.0, 0.0], self.tilts_rad[0], v);
        rotate([0.0, 1.0, 0.0], self.tilts_rad[1], tilted)
    }

    fn map(&self, p: [f64; 3]) -> [f64; 3] {
        add(self.turn(p), self.at_mm)
    }
}

/// What the shop is like during the session.
struct Air {
    temperature_c: Vec<f64>,
    humidity_pct: Vec<f64>,
}

impl Air {
    fn simulate(n: usize, rng: &mut ChaCha8Rng) -> Self {
        let phase = rng.random_range(0.0..TAU);
        let wander = |size: f64, periods: f64, rng: &mut ChaCha8Rng| -> Vec<f64> {
            let at = |i: usize| size * (phase + TAU * periods * as_f64(i) / as_f64(n)).sin();
            (0..n).map(|i| at(i) + 0.1 * size * gaussian(rng)).collect()
        };
        let temperature_c = wander(0.6, 1.3, rng).iter().map(|t| 20.4 + t).collect();
        let humidity_pct = wander(4.0, 2.1, rng).iter().map(|h| 45.0 + h).collect();
        Self { temperature_c, humidity_pct }
    }
}

/// Points of a sunflower in random order, so that place and time do not run together.
fn places(mirror: &Mirror, rng: &mut ChaCha8Rng) -> Vec<[f64; 2]> {
    let n = mirror.n_points;
    let reach = 0.5 * TOUCHED_SHARE * mirror.diameter_mm;
    let mut places: Vec<[f64; 2]> = (0..n)
        .map(|i| {
            let radius = reach * ((as_f64(i) + 0.5) / as_f64(n)).sqrt();
            let (sin, cos) = (2.399_963 * as_f64(i)).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect();
    for i in (1..n).rev() {
        places.swap(i, rng.random_range(0..=i));
    }
    places
}

/// Height of the real surface over its vertex plane.
fn height(mirror: &Mirror, flaws: &Flaws, x: f64, y: f64) -> f64 {
    let (mut radius, mut conic) = (mirror.radius_mm, mirror.conic);
    for flaw in flaws {
        match flaw {
            Flaw::VertexRadius(longer) => radius += longer,
            Flaw::Conic(larger) => conic += larger,
            _ => {}
        }
    }
    let s = x * x + y * y;
    let sag = s / (radius * (1.0 + (1.0 - (1.0 + conic) * s / (radius * radius)).sqrt()));
    sag + flaws.iter().map(|flaw| form(mirror, *flaw, x, y)).sum::<f64>()
}

fn form(mirror: &Mirror, flaw: Flaw, x: f64, y: f64) -> f64 {
    let s = x * x + y * y;
    let (rho, theta) = (s.sqrt() / (0.5 * mirror.diameter_mm), y.atan2(x));
    let wave = |[cos, sin]: [f64; 2], lobes: f64| {
        cos * (lobes * theta).cos() + sin * (lobes * theta).sin()
    };
    match flaw {
        Flaw::Astigmatism(a) => rho.powi(2) * wave(a, 2.0),
        Flaw::Coma(a) => (3.0 * rho.powi(3) - 2.0 * rho) * wave(a, 1.0),
        Flaw::Trefoil(a) => rho.powi(3) * wave(a, 3.0),
        Flaw::Rings(size, period) => size * (TAU * s.sqrt() / period).cos(),
        Flaw::Bump(size, width) => {
            size * (-((x - 12.0).powi(2) + (y + 9.0).powi(2)) / (width * width)).exp()
        }
        _ => 0.0,
    }
}

fn normal(mirror: &Mirror, flaws: &Flaws, x: f64, y: f64) -> [f64; 3] {
    let z = |x: f64, y: f64| height(mirror, flaws, x, y);
    let slope_x = (z(x + STEP_MM, y) - z(x - STEP_MM, y)) / (2.0 * STEP_MM);
    let slope_y = (z(x, y + STEP_MM) - z(x, y - STEP_MM)) / (2.0 * STEP_MM);
    let n = [-slope_x, -slope_y, 1.0];
    scale(1.0 / norm(&n), n)
}

/// Centre of the ball that touches the surface above (x, y).
fn ball(mirror: &Mirror, flaws: &Flaws, x: f64, y: f64) -> [f64; 3] {
    let larger = flaws.iter().map(|flaw| if let Flaw::Tip(larger) = flaw { *larger } else { 0.0 });
    let tip = mirror.tip_mm + larger.sum::<f64>();
    add([x, y, height(mirror, flaws, x, y)], scale(tip, normal(mirror, flaws, x, y)))
}

/// What the machine reads beyond what is.
fn machine_error(mirror: &Mirror, pose: &Pose, at: [f64; 3], index: usize, air: &Air) -> [f64; 3] {
    // Errors of scale and squareness are zero where the machine was set, near the part.
    let arm = add(at, scale(-1.0, pose.at_mm));
    let of = |flaw: Flaw| match flaw {
        Flaw::MachineScale(s) => std::array::from_fn(|i| s[i] * arm[i]),
        Flaw::Squareness(g) => [g[0] * arm[1] + g[1] * arm[2], g[2] * arm[2], 0.0],
        Flaw::Drift(total) => {
            let time = as_f64(index) / as_f64(mirror.n_points - 1) / WARMING_TIME;
            let grown = (1.0 - (-time).exp()) / (1.0 - (-1.0 / WARMING_TIME).exp());
            [0.0, 0.0, total * grown]
        }
        Flaw::Settling(total, share) => {
            let time = as_f64(index) / as_f64(mirror.n_points - 1);
            [0.0, 0.0, total * (1.0 - (-time / share).exp())]
        }
        Flaw::Clamped(first, by) if index >= first => by,
        Flaw::BadPoint(bad, high) if bad == index => [0.0, 0.0, high],
        Flaw::Growth(per_k) => [0.0, 0.0, per_k * (air.temperature_c[index] - 20.0)],
        Flaw::Humidity(per_pct) => [0.0, 0.0, per_pct * (air.humidity_pct[index] - 45.0)],
        _ => [0.0; 3],
    };
    mirror.flaws().into_iter().map(of).fold([0.0; 3], add)
}

/// What axes read beyond what is after a way between two touches, the ball coming along the normal.
fn play(mirror: &Mirror, normal: [f64; 3], moved: [f64; 3]) -> [f64; 3] {
    let side = |way: f64| if way == 0.0 { 0.0 } else { way.signum() };
    let of = |flaw: Flaw| {
        let mut read = [0.0; 3];
        match flaw {
            Flaw::Play(axis, half) => read[axis] = half * side(-normal[axis]),
            Flaw::PlayBetween(axis, half) => read[axis] = half * side(moved[axis]),
            _ => {}
        }
        read
    };
    mirror.flaws().into_iter().map(of).fold([0.0; 3], add)
}

fn case_toml(mirror: &Mirror) -> String {
    let noise = if mirror.declare_noise {
        format!("\n[noise]\npoint_mm = {}\n", mirror.noise_mm)
    } else {
        String::new()
    };
    format!(
        "kind = \"pose-icp\"\n\n[surface]\nshape = \"asphere\"\nradius_mm = {:.1}\nconic = {:.2}\n\
         diameter_mm = {:.1}\n\n[probe]\ntip_radius_mm = {:.1}\n{noise}",
        mirror.radius_mm, mirror.conic, mirror.diameter_mm, mirror.tip_mm
    )
}

fn points_csv(mirror: &Mirror, rows: &[[f64; 3]], is_check: &[bool], air: &Air) -> String {
    let humid = mirror.flaws().iter().any(|flaw| matches!(flaw, Flaw::Humidity(_)));
    let mut text = "point,x_mm,y_mm,z_mm,use,time_s".to_owned();
    text.push_str(if mirror.record_air { ",air_c" } else { "" });
    text.push_str(if humid { ",humidity_pct" } else { "" });
    text.push('\n');
    for (i, [x, y, z]) in rows.iter().enumerate() {
        let usage = if is_check[i] { "check" } else { "fit" };
        let time = TOUCH_INTERVAL_S * as_f64(i);
        let _ = write!(text, "P{:02},{x:.5},{y:.5},{z:.5},{usage},{time}", i + 1);
        if mirror.record_air {
            let _ = write!(text, ",{:.3}", air.temperature_c[i]);
        }
        if humid {
            let _ = write!(text, ",{:.2}", air.humidity_pct[i]);
        }
        text.push('\n');
    }
    text
}

fn edge_csv(mirror: &Mirror, pose: &Pose, rng: &mut ChaCha8Rng) -> String {
    let reach = 0.5 * mirror.diameter_mm + mirror.tip_mm;
    let sides = [(0.0, -reach), (reach, 0.0), (0.0, reach), (-reach, 0.0)];
    let mut centers: Vec<[f64; 3]> = sides.iter().map(|&(x, y)| [x, y, -SIDE_DEPTH_MM]).collect();
    centers.push(ball(mirror, &mirror.flaws(), 0.0, 0.0));
    let mut text = "point,x_mm,y_mm,z_mm\n".to_owned();
    for (name, center) in ["front", "right", "back", "left", "centre"].iter().zip(centers) {
        let noise: [f64; 3] = std::array::from_fn(|_| mirror.noise_mm * gaussian(rng));
        let [x, y, z] = add(pose.map(center), noise);
        let _ = writeln!(text, "{name},{x:.5},{y:.5},{z:.5}");
    }
    text
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
