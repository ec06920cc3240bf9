//! Batch solve against a plain sum over the same arrays, and the time of a monitor's update.
//!
//! `cargo bench -p ft-center`; with `--test` everything runs once, on few samples.
#![expect(clippy::print_stdout, reason = "a bench prints its result")]
#![expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use ft_center::{Monitor, MonitorOptions, Platform, Sample, WrenchArrays, solve_batch};
use geometry::Wrench;
use nalgebra::{Point3, Vector3};

const REPEATS: usize = 9;

fn main() {
    let test = std::env::args().any(|a| a == "--test");
    let samples = if test { 10_000 } else { 10_000_000 };
    batch(samples, if test { 1 } else { REPEATS });
    monitor(if test { 1000 } else { 2_000_000 });
}

fn wrench(i: usize) -> Wrench {
    let (sin, cos) = (i as f64 * 0.01).sin_cos();
    let at = Point3::new(12.0 + cos, -7.0 + sin, 30.0);
    Wrench::of_force(Vector3::new(3.0, 1.0, -40.0 + sin), &at)
}

fn batch(samples: usize, repeats: usize) {
    let mut columns: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(samples));
    for i in 0..samples {
        for (column, value) in columns.iter_mut().zip(wrench(i).to_vector().iter()) {
            column.push(*value);
        }
    }
    let [fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm] = &columns;
    let arrays = WrenchArrays { fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm };
    let bytes = 48.0 * samples as f64;
    let rate = |time: Duration| bytes / time.as_secs_f64() / 1e9;
    // Interleaved, so that a busy machine slows both alike.
    let (mut sums, mut solves) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        sums.push(timed(|| {
            black_box(columns.iter().map(|c| plain_sum(black_box(c))).sum::<f64>());
        }));
        solves.push(timed(|| {
            black_box(solve_batch(black_box(&arrays), 30.0, 5.0)).expect("a press");
        }));
    }
    let (sum, solve) = (median(sums), median(solves));
    println!("plain sum    {:6.2} GB/s  ({samples} samples)", rate(sum));
    println!("solve_batch  {:6.2} GB/s  {:.2} of the sum", rate(solve), rate(solve) / rate(sum));
}

/// Sum in eight lanes, as fast as memory gives it.
fn plain_sum(values: &[f64]) -> f64 {
    let (chunks, rest) = values.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for chunk in chunks {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += value;
        }
    }
    lanes.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

fn monitor(samples: usize) {
    let stream: Vec<_> =
        (0..samples).map(|i| Sample { time_s: i as f64 * 1e-3, wrench: wrench(i) }).collect();
    let platform = Platform::Plane { z0_mm: 30.0 };
    let mut monitor = Monitor::new(platform, MonitorOptions::default()).expect("valid settings");
    let time = timed(|| {
        for sample in &stream {
            black_box(monitor.update(black_box(sample)));
        }
    });
    println!("monitor      {:6.1} ns per update", time.as_secs_f64() * 1e9 / samples as f64);
}

fn timed(run: impl FnOnce()) -> Duration {
    let start = Instant::now();
    run();
    start.elapsed()
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}
