//! The tracker problem that all solvers get: displacements from many stations to the reflectors
//! of a body on a rotary axis.

use std::fs;
use std::path::Path;

use anyhow::Result;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Stations, reflectors and steps of a problem.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub(super) name: &'static str,
    pub(super) stations: usize,
    pub(super) reflectors: usize,
    pub(super) steps: usize,
}

/// Noise of a displacement.
const NOISE_MM: f64 = 5e-4;
/// Motion of a reflector on the body from step to step.
const LOOSENESS_MM: f64 = 2e-4;
/// How far off the start is: stations, and all else.
const START_MM: [f64; 2] = [1.0, 0.5];
/// A point on the axis.
const ORIGIN_MM: Vector = [400.0, 400.0, 750.0];
/// Where the stations are, as shares of 800 mm × 800 mm × 500 mm.
const STATIONS: [[f64; 3]; 8] = [
    [0.05, 0.08, 0.05],
    [0.95, 0.10, 0.15],
    [0.15, 0.92, 0.10],
    [0.88, 0.90, 0.80],
    [0.10, 0.12, 0.95],
    [0.92, 0.15, 0.85],
    [0.12, 0.88, 0.90],
    [0.55, 0.45, 0.02],
];
/// Reflectors by azimuth in degrees, radius and height in mm.
const REFLECTORS: [[f64; 3]; 4] =
    [[-90.0, 150.0, -60.0], [-35.0, 210.0, 70.0], [-140.0, 180.0, 40.0], [-75.0, 250.0, -20.0]];

type Vector = [f64; 3];

/// Unknowns of a problem, in the order of its files.
struct Unknowns {
    stations: Vec<Vector>,
    /// By station, then reflector.
    dead_paths: Vec<f64>,
    /// By pair of reflectors.
    distances: Vec<f64>,
    /// By step, then reflector.
    points: Vec<Vector>,
    /// Where the drawing has the axis and what is on it.
    drawing: Drawing,
}

/// The axis without its error motion.
struct Drawing {
    /// Two points on the axis, 1 mm apart.
    axis: [Vector; 2],
    /// Every reflector at angle 0.
    reflectors: Vec<Vector>,
}

impl Drawing {
    fn points(&mut self) -> impl Iterator<Item = &mut Vector> {
        self.axis.iter_mut().chain(&mut self.reflectors)
    }
}

impl Unknowns {
    fn flat(&self) -> Vec<f64> {
        let mut numbers = self.stations.concat();
        numbers.extend(&self.dead_paths);
        numbers.extend(&self.distances);
        numbers.extend(self.points.concat());
        numbers
    }
}

/// Simulates a problem and writes it: `dims.txt`, and `obs.bin`, `init.bin` and `truth.bin` as
/// little-endian numbers in mm; for those who ask for a drawing, as a calibration does, in
/// `drawing.bin` two points on the axis and all reflectors at angle 0, of which the latter are off by
/// as much as their start.
pub(super) fn write(size: Size, seed: u64, folder: &Path) -> Result<()> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = truth(size, &mut rng);
    to_gauge(&mut truth);
    let Size { stations, reflectors, steps, .. } = size;
    let mut displacements = Vec::new();
    for (n, point) in truth.points.iter().enumerate() {
        for (i, station) in truth.stations.iter().enumerate() {
            let dead_path = truth.dead_paths[i * reflectors + n % reflectors];
            displacements.push(distance(point, station) - dead_path + NOISE_MM * normal(&mut rng));
        }
    }
    let mut start = truth.flat();
    for (n, value) in start.iter_mut().enumerate() {
        *value += START_MM[usize::from(n >= 3 * stations)] * normal(&mut rng);
    }
    for fixed in [0, 1, 2, 4, 5, 8] {
        start[fixed] = 0.0;
    }
    fs::create_dir_all(folder)?;
    fs::write(folder.join("dims.txt"), format!("{stations} {reflectors} {steps}\n"))?;
    write_numbers(&folder.join("obs.bin"), &displacements)?;
    write_numbers(&folder.join("init.bin"), &start)?;
    let mut drawing = truth.drawing.axis.concat();
    drawing.extend(
        truth.drawing.reflectors.concat().iter().map(|v| v + START_MM[1] * normal(&mut rng)),
    );
    write_numbers(&folder.join("drawing.bin"), &drawing)?;
    write_numbers(&folder.join("truth.bin"), &truth.flat())
}

fn write_numbers(file: &Path, numbers: &[f64]) -> Result<()> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    Ok(fs::write(file, bytes)?)
}

/// Numbers of a file that [`write()`] or a solver has written.
pub(super) fn read_numbers(file: &Path) -> Result<Vec<f64>> {
    let bytes = fs::read(file)?;
    Ok(bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn truth(size: Size, rng: &mut ChaCha8Rng) -> Unknowns {
    let scale = [800.0, 800.0, 500.0];
    let stations = STATIONS[..size.stations]
        .iter()
        .map(|s| std::array::from_fn(|c| (s[c] + rng.random_range(-0.05..0.05)) * scale[c]))
        .collect();
    let body: Vec<Vector> = REFLECTORS[..size.reflectors]
        .iter()
        .map(|[azimuth_deg, radius, height]| {
            let azimuth = azimuth_deg.to_radians() + rng.random_range(-0.1..0.1);
            let radius = radius + rng.random_range(-5.0..5.0);
            let height = height + rng.random_range(-5.0..5.0);
            [radius * azimuth.cos(), height, radius * azimuth.sin()]
        })
        .collect();
    let tilt: Vector = std::array::from_fn(|_| rng.random_range(-2e-3..2e-3));
    // Axis error motion: three harmonics of some µm in each direction.
    let motion: [[[f64; 2]; 3]; 3] = std::array::from_fn(|_| {
        std::array::from_fn(|_| {
            [rng.random_range(2e-3..8e-3), rng.random_range(0.0..std::f64::consts::TAU)]
        })
    });
    let place = |[x, y, z]: Vector| -> Vector {
        let leaned = cross(&tilt, &[x, y, z]);
        std::array::from_fn(|c| [x, y, z][c] + leaned[c] + ORIGIN_MM[c])
    };
    let drawing = Drawing {
        axis: [ORIGIN_MM, place([0.0, 1.0, 0.0])],
        reflectors: body.iter().map(|home| place(*home)).collect(),
    };
    let mut points = Vec::new();
    #[expect(clippy::cast_precision_loss, reason = "steps are few")]
    let angle = |k: usize| (k as f64 / (size.steps - 1) as f64 - 0.5) * std::f64::consts::PI;
    for k in 0..size.steps {
        let (sin, cos) = angle(k).sin_cos();
        let error: Vector = std::array::from_fn(|c| {
            let harmonic =
                |(n, [amplitude, phase]): (f64, [f64; 2])| amplitude * (n * angle(k) + phase).cos();
            [1.0, 2.0, 3.0].into_iter().zip(motion[c]).map(harmonic).sum()
        });
        for [x, y, z] in &body {
            let turned =
                [cos * x + sin * z + error[0], y + error[1], -sin * x + cos * z + error[2]];
            points.push(place(turned).map(|v| v + LOOSENESS_MM * normal(rng)));
        }
    }
    let dead_paths =
        (0..size.stations * size.reflectors).map(|_| rng.random_range(50.0..150.0)).collect();
    let mut distances = Vec::new();
    for (a, first) in body.iter().enumerate() {
        distances.extend(body[a + 1..].iter().map(|second| distance(first, second)));
    }
    Unknowns { stations, dead_paths, distances, points, drawing }
}

/// Moves everything to the frame of the first three stations: the first is its origin, the
/// second lies on its x axis, the third in its xy plane.
fn to_gauge(unknowns: &mut Unknowns) {
    let origin = unknowns.stations[0];
    let from_origin = |v: &Vector| -> Vector { std::array::from_fn(|c| v[c] - origin[c]) };
    let x = unit(&from_origin(&unknowns.stations[1]));
    let z = unit(&cross(&x, &from_origin(&unknowns.stations[2])));
    let axes = [x, cross(&z, &x), z];
    let Unknowns { stations, points, drawing, .. } = unknowns;
    for v in stations.iter_mut().chain(points).chain(drawing.points()) {
        let offset = from_origin(v);
        *v = axes.map(|axis| dot(&axis, &offset));
    }
    unknowns.stations[0] = [0.0; 3];
    unknowns.stations[1][1] = 0.0;
    unknowns.stations[1][2] = 0.0;
    unknowns.stations[2][2] = 0.0;
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: &Vector) -> Vector {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

fn distance(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
