//! `calibrate` on a folder of `cargo xtask bench --peers`: time of what a user calls.
//!
//! `calibrate FOLDER RUNS free-points|joint` prints a line of JSON per run, with the most memory that
//! the process has had, and leaves the places of stations and reflectors beside the problem. Without
//! a folder there is nothing to do.
#![expect(clippy::print_stdout, reason = "its lines are what it is for")]

use std::path::Path;
use std::time::Instant;

use tracker_lm::nalgebra::{Point3, UnitQuaternion, Vector3};
use tracker_lm::{
    AxisLetter, Calibration, Formulation, Gauge, Mount, Noise, Options, Range, RotaryAxis, Station,
    Step, Survey, calibrate,
};

/// Standard uncertainty of a range, and of a distance between reflectors from step to step.
const NOISE_MM: f64 = 5e-4;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [folder, runs, formulation, ..] = &arguments[..]
        && !folder.starts_with('-')
    {
        let formulation = match formulation.as_str() {
            "free-points" => Formulation::FreePoints,
            _ => Formulation::Joint,
        };
        from_folder(Path::new(folder), runs.parse().expect("a number of runs"), formulation);
    }
}

fn from_folder(folder: &Path, runs: usize, formulation: Formulation) {
    let survey = read(folder);
    let noise = Noise { displacement_mm: Some(NOISE_MM), ..Noise::default() };
    let options = Options { formulation, gauge: Gauge::Minimal, noise, ..Options::default() };
    let mut found = None;
    for _ in 0..runs {
        let cpu_before = cpu_ms();
        let clock = Instant::now();
        let calibration = calibrate(&survey, &options).expect("a well-posed problem");
        let ms = clock.elapsed().as_secs_f64() * 1e3;
        let report = &calibration.report;
        println!(
            "{{\"ms\":{ms},\"cpu_ms\":{},\"cost\":{:e},\"evaluations\":{},\"jacobians\":{},\
             \"peak_kib\":{}}}",
            cpu_ms() - cpu_before,
            report.final_cost * NOISE_MM.powi(2),
            1 + report.residual_evaluations,
            report.jacobian_evaluations,
            peak_kib()
        );
        found = Some(calibration);
    }
    let places = places(&survey, &found.expect("at least one run"));
    let bytes: Vec<u8> = places.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(folder.join("calibrate.bin"), bytes).expect("the folder is writable");
}

/// The problem as a survey: stations where the start has them, reflectors where the drawing has them.
fn read(folder: &Path) -> Survey {
    let numbers = |name: &str| -> Vec<f64> {
        let bytes = std::fs::read(folder.join(name)).expect("the problem's files");
        bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
    };
    let sizes = std::fs::read_to_string(folder.join("dims.txt")).expect("the problem's sizes");
    let sizes: Vec<usize> = sizes.split_whitespace().map(|n| n.parse().expect("a size")).collect();
    let [stations, mounts, steps] = sizes[..] else { panic!("three sizes") };
    let points = |numbers: &[f64]| -> Vec<Point3<f64>> {
        numbers.chunks_exact(3).map(Point3::from_slice).collect()
    };
    let drawing = points(&numbers("drawing.bin"));
    let axis =
        RotaryAxis::new(AxisLetter::B, drawing[0], drawing[1] - drawing[0]).expect("an axis");
    let at = |name: String, nominal_mm: Point3<f64>| Station { name, nominal_mm };
    let start = points(&numbers("init.bin")[..3 * stations]);
    let stations: Vec<_> =
        start.into_iter().enumerate().map(|(i, p)| at(format!("S{i}"), p)).collect();
    let mount = |(j, p): (usize, &Point3<f64>)| Mount {
        name: format!("R{j}"),
        nominal_mm: Point3::from(p - drawing[0]),
    };
    let mounts: Vec<_> = drawing[2..2 + mounts].iter().enumerate().map(mount).collect();
    #[expect(clippy::cast_precision_loss, reason = "steps are few")]
    let angle = |k: usize| (k as f64 / (steps - 1) as f64 - 0.5) * std::f64::consts::PI;
    let step = |k: usize| Step { name: k.to_string(), angle_rad: angle(k), approach: None };
    let of_stations = stations.len();
    let range = |(n, displacement_mm): (usize, f64)| Range {
        station: n % of_stations,
        mount: n / of_stations % mounts.len(),
        step: n / of_stations / mounts.len(),
        displacement_mm,
    };
    let ranges = numbers("obs.bin").into_iter().enumerate().map(range).collect();
    Survey { axis, second: None, stations, steps: (0..steps).map(step).collect(), ranges, mounts }
}

/// Every reflector at every step, as its place and the errors of the axis give it.
fn places(survey: &Survey, calibration: &Calibration) -> Vec<f64> {
    let origin = survey.axis.origin_mm.coords;
    let mut places = Vec::new();
    for error in &calibration.axis_errors {
        let moved: Vector3<f64> = error.error.fixed_rows::<3>(0).into_owned();
        let turn = UnitQuaternion::from_scaled_axis(error.error.fixed_rows::<3>(3).into_owned());
        let turned = turn * survey.axis.rotation(error.angle_rad);
        for mount in &calibration.mounts {
            let at = origin + moved + turned * mount.position_mm.coords;
            places.extend(at.iter().copied());
        }
    }
    places
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
