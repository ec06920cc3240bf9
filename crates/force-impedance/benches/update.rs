//! Time of one cycle: forward kinematics, contact force, impedance, inverse kinematics.
//!
//! `cargo bench -p force-impedance --bench update`: criterion's median, then the distribution over
//! 10⁷ cycles timed one by one, then the instructions of a cycle where `valgrind` is installed.
//! `-- --count N` runs N cycles and nothing else, for a profiler.
#![expect(clippy::print_stdout, reason = "a bench prints its result")]
#![expect(clippy::unwrap_used, reason = "settings of a bench are known to be good")]

#[path = "../tests/it/usual_head.rs"]
mod usual_head;

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use criterion::Criterion;
use force_impedance::{Controller, ControllerSettings, ImpedanceParameters, Measurement};
use nalgebra::{Point3, Vector3};

use usual_head::head;

const PARAMETERS: ImpedanceParameters =
    ImpedanceParameters { mass_kg: 1.0, damping_ns_per_mm: 1.0, stiffness_n_per_mm: 0.0 };
/// Cycles prepared beforehand: a path of eight seconds, run over and over.
const N_INPUTS: usize = 8192;
const T: f64 = 1e-3;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|a| a == "--count") {
        let n = arguments.get(at + 1).and_then(|n| n.parse().ok()).unwrap_or(1_000_000);
        run(n);
        return;
    }
    let test = arguments.iter().any(|a| a == "--test");
    criterion();
    distribution(if test { 10_000 } else { 10_000_000 });
    instructions();
}

/// Instructions of one cycle: the difference of two counts, so that the start takes no part.
fn instructions() {
    const N_CYCLES: u64 = 20_000;
    let counted = counted(N_CYCLES).zip(counted(2 * N_CYCLES));
    match counted {
        Some((once, twice)) => println!("{} instructions a cycle", (twice - once) / N_CYCLES),
        None => println!("instructions not counted: valgrind is not installed"),
    }
}

/// Instructions of a run of `n` cycles.
fn counted(n: u64) -> Option<u64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(["--count", &n.to_string()])
        .output()
        .ok()?;
    let said = String::from_utf8_lossy(&output.stderr);
    let refs = said.lines().find_map(|line| line.split_once("refs:"))?.1;
    refs.trim().replace(',', "").parse().ok()
}

fn controller() -> Controller {
    Controller::new(head(), PARAMETERS, ControllerSettings::default()).unwrap()
}

/// A tool that follows a wavy surface, 20 µm behind and 30 N hard.
fn inputs() -> Vec<Measurement> {
    let head = head();
    let input = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / 8192.0;
        let tip_mm = Point3::new(0.2 * angle.sin(), -300.0 + 0.5 * angle.cos(), 0.1);
        let noise = f64::from(i * 7919 % 101) * 1e-3;
        Measurement {
            lengths_mm: Some(head.pose_at(&tip_mm).unwrap().lengths_mm),
            cells_n: Some([118.0 + noise, 121.0, 120.0 - noise, 30.0 + noise]),
            normal: Vector3::new(0.2 * angle.sin(), 1.0, 0.1).normalize(),
            reference_n: 30.0,
        }
    };
    (0..8192).map(input).collect()
}

fn criterion() {
    let mut criterion = Criterion::default().configure_from_args();
    let (head, inputs) = (head(), inputs());
    let mut at = 0;
    let mut controller = controller();
    criterion.bench_function("update with forces and inverse kinematics", |b| {
        b.iter(|| {
            at = (at + 1) % N_INPUTS;
            controller.update(black_box(&inputs[at]), T)
        });
    });
    criterion.bench_function("inverse kinematics", |b| {
        let tip_mm = Point3::new(0.3, -300.4, 0.1);
        b.iter(|| head.pose_at(black_box(&tip_mm)));
    });
    criterion.bench_function("forward kinematics, cold", |b| {
        let lengths_mm = [70.1, 69.8, 70.2, 180.4];
        b.iter(|| head.pose_of_lengths(black_box(&lengths_mm)));
    });
    criterion.bench_function("contact force at a pose", |b| {
        let pose = head.pose_at(&Point3::new(0.3, -300.4, 0.1)).unwrap();
        let (cells_n, normal) = ([100.0, 90.0, 110.0, 40.0], Vector3::y());
        b.iter(|| black_box(&head).balance(black_box(&pose)).contact(&cells_n, &normal));
    });
    criterion.final_summary();
}

/// Every cycle timed by itself; the clock's own time is measured the same way and taken off.
fn distribution(n: usize) {
    let inputs = inputs();
    let mut controller = controller();
    let mut clock = Histogram::new();
    for _ in 0..n.min(1_000_000) {
        let start = Instant::now();
        clock.add(start.elapsed().as_nanos());
    }
    let mut cycles = Histogram::new();
    for i in 0..n {
        let seen = &inputs[i % N_INPUTS];
        let start = Instant::now();
        black_box(controller.update(black_box(seen), T));
        cycles.add(start.elapsed().as_nanos());
    }
    let own = clock.quantile(0.5);
    let at = |share: f64| cycles.quantile(share).saturating_sub(own);
    println!(
        "{n} cycles one by one: median {} ns, p99 {} ns, p99.99 {} ns, worst {} µs \
         (the clock's {own} ns taken off)",
        at(0.5),
        at(0.99),
        at(0.9999),
        cycles.worst / 1000,
    );
}

/// Counts per nanosecond, up to 100 µs.
struct Histogram {
    counts: Vec<u64>,
    total: u64,
    worst: u128,
}

impl Histogram {
    fn new() -> Self {
        Self { counts: vec![0; 100_001], total: 0, worst: 0 }
    }

    fn add(&mut self, ns: u128) {
        let bin = usize::try_from(ns).unwrap_or(usize::MAX).min(self.counts.len() - 1);
        self.counts[bin] += 1;
        self.total += 1;
        self.worst = self.worst.max(ns);
    }

    fn quantile(&self, share: f64) -> usize {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let wanted = share * self.total as f64;
        let mut seen = 0;
        for (ns, count) in self.counts.iter().enumerate() {
            seen += count;
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            if seen as f64 >= wanted {
                return ns;
            }
        }
        self.counts.len()
    }
}

fn run(n: usize) {
    let inputs = inputs();
    let mut controller = controller();
    for i in 0..n {
        black_box(controller.update(black_box(&inputs[i % N_INPUTS]), T));
    }
}
