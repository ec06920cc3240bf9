//! A laser tracer's stations, dead paths and targets from displacements: time of one solution.
//!
//! Without arguments it solves scenes that it makes up. With a folder, as `cargo xtask bench
//! peers` writes it, and a number of runs, it prints a line of JSON per run for comparison with
//! other solvers, and leaves the solution beside the problem.
#![expect(clippy::print_stdout, reason = "its lines are what it is for")]
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use std::path::Path;
use std::time::Instant;

use least_squares::{
    BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, BorderedSolution, Pattern,
    solve_bordered,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Coordinates of the first three stations that fix the frame.
const GAUGE: [usize; 6] = [0, 1, 2, 4, 5, 8];
/// Runs of a scene without arguments; the least time counts.
const RUNS: usize = 20;
/// Stations, targets and steps of the scenes without arguments.
const SCENES: [[usize; 3]; 3] = [[6, 3, 37], [8, 4, 361], [8, 4, 3601]];

/// `J` targets on one body seen from `I` stations at every step. Shared are stations (3 each),
/// dead paths (by station, then target) and distances between targets (by pair); a block holds
/// the targets of one step.
struct Tracker<const I: usize, const J: usize> {
    /// By step, target and station, in mm.
    displacements_mm: Vec<f64>,
    patterns: Vec<Pattern>,
}

impl<const I: usize, const J: usize> Tracker<I, J> {
    const PAIRS: usize = J * (J - 1) / 2;

    fn new(displacements_mm: Vec<f64>) -> Self {
        let mut pattern = Pattern::new();
        for j in 0..J {
            for i in 0..I {
                let dead_path = 3 * I + i * J + j;
                pattern.push(
                    &[3 * j, 3 * j + 1, 3 * j + 2],
                    &[3 * i, 3 * i + 1, 3 * i + 2, dead_path],
                );
            }
        }
        for (n, (a, b)) in pairs(J).enumerate() {
            let (a, b) = (3 * a, 3 * b);
            pattern.push(&[a, a + 1, a + 2, b, b + 1, b + 2], &[3 * I + I * J + n]);
        }
        Self { displacements_mm, patterns: vec![pattern] }
    }
}

fn pairs(targets: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..targets).flat_map(move |a| (a + 1..targets).map(move |b| (a, b)))
}

#[inline(always)]
fn difference(a: &[f64], b: &[f64]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}

/// Coordinates of all stations, side by side.
#[inline(always)]
fn stations<const I: usize>(shared: &[f64]) -> [[f64; I]; 3] {
    let mut stations = [[0.0; I]; 3];
    for (i, station) in shared[..3 * I].as_chunks::<3>().0.iter().enumerate() {
        for c in 0..3 {
            stations[c][i] = station[c];
        }
    }
    stations
}

/// From all stations to a target, and how far.
#[inline(always)]
fn sights<const I: usize>(target: &[f64], stations: &[[f64; I]; 3]) -> ([[f64; I]; 3], [f64; I]) {
    let (mut offsets, mut ranges) = (*stations, [0.0; I]);
    for i in 0..I {
        for c in 0..3 {
            offsets[c][i] = target[c] - stations[c][i];
        }
        ranges[i] = squared([offsets[0][i], offsets[1][i], offsets[2][i]]).sqrt();
    }
    (offsets, ranges)
}

impl<const I: usize, const J: usize> BorderedProblem for Tracker<I, J> {
    fn shared_dim(&self) -> usize {
        3 * I + I * J + Self::PAIRS
    }

    fn block_dim(&self) -> usize {
        3 * J
    }

    fn block_count(&self) -> usize {
        self.displacements_mm.len() / (I * J)
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    #[inline(always)]
    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let measured = &self.displacements_mm[block * I * J..][..I * J];
        let (dead_paths, distances) = shared[3 * I..].split_at(I * J);
        let (ranges, rigid) = out.split_at_mut(I * J);
        let stations = stations::<I>(shared);
        for j in 0..J {
            let (_, range) = sights(&point[3 * j..][..3], &stations);
            for i in 0..I {
                ranges[j * I + i] = range[i] - measured[j * I + i] - dead_paths[i * J + j];
            }
        }
        for (n, (a, b)) in pairs(J).enumerate() {
            let distance = squared(difference(&point[3 * a..][..3], &point[3 * b..][..3])).sqrt();
            rigid[n] = distance - distances[n];
        }
    }

    #[inline(always)]
    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let measured = &self.displacements_mm[block * I * J..][..I * J];
        let (dead_paths, distances) = shared[3 * I..].split_at(I * J);
        let (ranges, rigid) = rows.residuals.split_at_mut(I * J);
        let (of_ranges, of_rigid) = rows.by_block.split_at_mut(3 * I * J);
        let stations = stations::<I>(shared);
        for j in 0..J {
            let (offsets, range) = sights(&point[3 * j..][..3], &stations);
            let mut inverse = [0.0; I];
            for i in 0..I {
                inverse[i] = 1.0 / range[i];
            }
            for i in 0..I {
                let row = j * I + i;
                ranges[row] = range[i] - measured[row] - dead_paths[i * J + j];
                for c in 0..3 {
                    let cosine = offsets[c][i] * inverse[i];
                    of_ranges[3 * row + c] = cosine;
                    rows.by_shared[4 * row + c] = -cosine;
                }
                rows.by_shared[4 * row + 3] = -1.0;
            }
        }
        for (n, (a, b)) in pairs(J).enumerate() {
            let offset = difference(&point[3 * a..][..3], &point[3 * b..][..3]);
            let distance = squared(offset).sqrt();
            let inverse = 1.0 / distance;
            rigid[n] = distance - distances[n];
            for c in 0..3 {
                of_rigid[6 * n + c] = offset[c] * inverse;
                of_rigid[6 * n + 3 + c] = -offset[c] * inverse;
            }
            rows.by_shared[4 * I * J + n] = -1.0;
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [folder, runs, ..] if !folder.starts_with('-') => {
            from_folder(Path::new(folder), runs.parse().expect("a number of runs"));
        }
        _ => made_up(arguments.iter().any(|a| a == "--test")),
    }
}

/// Times the scenes that this program makes up; only the smallest when merely tested.
fn made_up(is_test: bool) {
    for [stations, targets, steps] in SCENES.into_iter().take(if is_test { 1 } else { 3 }) {
        let runs = if is_test { 1 } else { RUNS };
        let (displacements_mm, start) = simulate(stations, targets, steps);
        let timed = repeat([stations, targets], displacements_mm, &start, runs);
        let least = timed.iter().map(|run| run.ms).fold(f64::INFINITY, f64::min);
        println!("{stations} stations, {targets} targets, {steps} steps: {least:.3} ms");
        println!("{}", timed[0].fit.report);
    }
}

fn from_folder(folder: &Path, runs: usize) {
    let read = |name: &str| -> Vec<f64> {
        let bytes = std::fs::read(folder.join(name)).expect("the problem's files");
        bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
    };
    let text = std::fs::read_to_string(folder.join("dims.txt")).expect("the problem's sizes");
    let sizes: Vec<usize> = text.split_whitespace().map(|n| n.parse().expect("sizes")).collect();
    let shared = 3 * sizes[0] + sizes[0] * sizes[1] + sizes[1] * (sizes[1] - 1) / 2;
    let mut numbers = read("init.bin");
    let blocks = numbers.split_off(shared);
    let start = BorderedPoint { shared: numbers, blocks };
    let timed = repeat([sizes[0], sizes[1]], read("obs.bin"), &start, runs);
    let peak_kib = peak_kib();
    for Timed { ms, cpu_ms, fit } in &timed {
        println!(
            "{{\"ms\":{ms},\"cpu_ms\":{cpu_ms},\"cost\":{:e},\"evaluations\":{},\
             \"jacobians\":{},\"peak_kib\":{peak_kib}}}",
            fit.report.final_cost,
            1 + fit.report.residual_evaluations,
            fit.report.jacobian_evaluations
        );
    }
    let point = &timed[0].fit.point;
    let numbers = point.shared.iter().chain(&point.blocks);
    let bytes: Vec<u8> = numbers.flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(folder.join("truing.bin"), bytes).expect("the problem's folder is writable");
}

/// One run.
struct Timed {
    ms: f64,
    /// Time of all threads together.
    cpu_ms: f64,
    fit: BorderedSolution,
}

/// Time that the threads of this process have run for; NaN where the system does not say.
fn cpu_ms() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let run_ns = |thread: std::fs::DirEntry| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    threads.flatten().filter_map(run_ns).sum::<f64>() / 1e6
}

/// The most memory that this process has had, in KiB; nought where the system does not say.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().split(' ').next()?.parse().ok()).unwrap_or(0)
}

fn repeat(
    sizes: [usize; 2],
    displacements_mm: Vec<f64>,
    start: &BorderedPoint,
    runs: usize,
) -> Vec<Timed> {
    match sizes {
        [6, 3] => timed(&Tracker::<6, 3>::new(displacements_mm), start, runs),
        [8, 4] => timed(&Tracker::<8, 4>::new(displacements_mm), start, runs),
        other => panic!("no program for {other:?} stations and targets"),
    }
}

fn timed<P: BorderedProblem>(problem: &P, start: &BorderedPoint, runs: usize) -> Vec<Timed> {
    let options = BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() };
    (0..runs)
        .map(|_| {
            let start = start.clone();
            let cpu_before = cpu_ms();
            let clock = Instant::now();
            let fit = solve_bordered(problem, start, &options).expect("a well-posed problem");
            let ms = clock.elapsed().as_secs_f64() * 1e3;
            Timed { ms, cpu_ms: cpu_ms() - cpu_before, fit }
        })
        .collect()
}

/// Displacements of a scene of about a metre with 0.5 µm of noise, and a start some 0.5 mm off.
fn simulate(stations: usize, targets: usize, steps: usize) -> (Vec<f64>, BorderedPoint) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut shared = vec![0.0; 3 * stations];
    for (c, v) in shared.iter_mut().enumerate() {
        let corner =
            [800.0, 700.0, 500.0][c % 3] * f64::from(u8::from((c / 3) >> (c % 3) & 1 == 1));
        *v = corner + rng.random_range(-60.0..60.0);
    }
    for i in GAUGE {
        shared[i] = 0.0;
    }
    let mut uniform = |half: f64| rng.random_range(-half..half);
    shared.extend((0..stations * targets).map(|_| 100.0 + uniform(50.0)));
    let body: Vec<[f64; 3]> = (0..targets).map(|_| [0; 3].map(|_| uniform(250.0))).collect();
    for (a, b) in pairs(targets) {
        shared.push(squared(difference(&body[a], &body[b])).sqrt());
    }
    let (mut displacements, mut blocks) = (Vec::new(), Vec::new());
    for step in 0..steps {
        #[expect(clippy::cast_precision_loss, reason = "steps are few")]
        let (sin, cos) = (std::f64::consts::PI * step as f64 / steps as f64).sin_cos();
        for (j, [x, y, z]) in body.iter().enumerate() {
            let target = [400.0 + cos * x + sin * z, 400.0 + y, 750.0 - sin * x + cos * z];
            for i in 0..stations {
                let range = squared(difference(&target, &shared[3 * i..][..3])).sqrt();
                let dead_path = shared[3 * stations + i * targets + j];
                displacements.push(range - dead_path + uniform(8.7e-4));
            }
            blocks.extend(target.map(|v| v + uniform(0.9)));
        }
    }
    for (c, v) in shared.iter_mut().enumerate() {
        if !GAUGE.contains(&c) {
            *v += uniform(0.9);
        }
    }
    (displacements, BorderedPoint { shared, blocks })
}
