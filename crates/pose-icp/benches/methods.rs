//! The experiment of document [D] by its own method and by the exact one: accuracy, points, time.
//!
//! The mirror is its R = 480 mm, k = −1, Φ100, the machine's errors are those it states, heights are
//! judged at the places of its Table 4. With `--test` a few poses, to see that it runs.
#![expect(clippy::print_stdout, reason = "its table is what it is for")]

#[path = "../tests/it/machine_scene.rs"]
mod machine_scene;
#[path = "../tests/it/pose_scene.rs"]
#[expect(dead_code, reason = "the tests need more of it")]
mod pose_scene;

use std::time::Instant;

use geometry::AsphereShape;
use machine_scene::{Experiment, check_points, experiment};
use pose_icp::{
    Patch, PoseFit, PoseOptions, PoseStart, SampledFit, SampledMethod, SampledOptions, fit_pose,
    fit_pose_on_samples, height_at, optimal_ratio,
};
use pose_scene::{DIAMETER_MM, RADIUS_MM, TIP_MM, center_over, paraboloid, tip};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Fine spacing of the document.
const FINE_MM: f64 = 1e-3;

fn main() {
    let smoke = std::env::args().any(|a| a == "--test");
    let poses = |n: usize| if smoke { 1 } else { n };
    println!("{:<34} {:>11} {:>9}  poses  found", "method", "points", "memory");
    println!("{:>68} {:>9} {:>9} {:>12}", "p50 µm", "p99 µm", "worst µm", "median time");
    let two = |coarse_mm, patch| SampledMethod::TwoLevel { coarse_mm, fine_mm: FINE_MM, patch };
    let best = |patch| FINE_MM * optimal_ratio(DIAMETER_MM, 9, patch, FINE_MM);
    let [one, four] = [Patch::OneSpacing, Patch::TwoSpacings];
    let classical = |spacing_mm| SampledMethod::Classical { spacing_mm };
    print_predicted("classical, 5 µm", classical(5e-3));
    sampled("classical, 100 µm", classical(0.1), poses(20));
    sampled("two levels, 1 mm and 1 µm, c = 1", two(1.0, one), poses(20));
    if !smoke {
        sampled("two levels, 1 mm and 1 µm, c = 4", two(1.0, four), 5);
    }
    sampled("two levels, 172 µm and 1 µm, c = 1", two(best(one), one), poses(1000));
    sampled("two levels, 122 µm and 1 µm, c = 4", two(best(four), four), poses(1000));
    exact(poses(10_000));
}

/// Points and memory that are not worth running out of.
fn print_predicted(name: &str, method: SampledMethod) {
    println!("{name:<34} {}  not run: predicted", size(Some(method)));
}

/// Model points of all levels, and memory of the largest.
fn size(method: Option<SampledMethod>) -> String {
    let Some(method) = method else { return format!("{:>11} {:>9}", "–", "–") };
    let points: f64 = method.predicted_points(DIAMETER_MM, 9).iter().sum();
    let gigabytes = 1e-9 * method.predicted_bytes(DIAMETER_MM, 9);
    format!("{points:>11.3e} {gigabytes:>6.2} GB")
}

fn sampled(name: &str, method: SampledMethod, poses: usize) {
    let shape = AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], DIAMETER_MM);
    let options = SampledOptions { method, tip: tip(), ..SampledOptions::default() };
    let (part, exact_options) = (paraboloid(), PoseOptions::default());
    run(name, Some(method), poses, |scene| {
        let start = Instant::now();
        let found = fit_pose_on_samples(&shape, &scene.touches, &scene.side.start, &options);
        let seconds = start.elapsed().as_secs_f64();
        let height = |found: &SampledFit, [x, y, z]: [f64; 3]| {
            // A fit of its pose alone, to be asked for heights.
            let fit = at_pose(&part, &found.pose, &exact_options)?;
            height_at(&part, &fit, tip(), x, y, z).ok().map(|h| h.z_mm)
        };
        let found = found.ok()?;
        Some((seconds, errors(scene, |at| height(&found, at))?))
    });
}

/// The pose as a fit that holds everything.
fn at_pose(part: &pose_icp::Part, pose: &PoseStart, options: &PoseOptions) -> Option<PoseFit> {
    let held = pose_icp::PoseParameter::ALL.to_vec();
    let touch = pose_icp::Touch::new(center_over(pose, 0.0, 0.0, 0.0), 1.0);
    fit_pose(part, &[touch], pose, &PoseOptions { held, ..options.clone() }).ok()
}

fn exact(poses: usize) {
    let part = paraboloid();
    run("exact", None, poses, |scene| {
        let lateral = Some(scene.side.prior);
        let options = PoseOptions { tip: tip(), lateral, ..PoseOptions::default() };
        let start = Instant::now();
        let found = fit_pose(&part, &scene.touches, &scene.side.start, &options);
        let seconds = start.elapsed().as_secs_f64();
        let found = found.ok()?;
        let height =
            |[x, y, z]: [f64; 3]| height_at(&part, &found, tip(), x, y, z).ok().map(|h| h.z_mm);
        Some((seconds, errors(scene, height)?))
    });
}

/// Errors of height at the check points.
fn errors(scene: &Experiment, height: impl Fn([f64; 3]) -> Option<f64>) -> Option<Vec<f64>> {
    let error = |[x, y]: [f64; 2]| {
        let at = center_over(&scene.pose, x, y, TIP_MM);
        height([at.x, at.y, at.z]).map(|z_mm| (z_mm - at.z).abs())
    };
    check_points().into_iter().map(error).collect()
}

fn run(
    name: &str,
    method: Option<SampledMethod>,
    poses: usize,
    of: impl Fn(&Experiment) -> Option<(f64, Vec<f64>)>,
) {
    let mut rng = ChaCha8Rng::seed_from_u64(437);
    let scenes: Vec<_> = (0..poses).map(|_| experiment(&mut rng)).collect();
    let answers: Vec<_> = scenes.iter().filter_map(of).collect();
    let mut times: Vec<f64> = answers.iter().map(|a| a.0).collect();
    let mut errors: Vec<f64> = answers.iter().flat_map(|a| a.1.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    errors.sort_by(f64::total_cmp);
    let at = |sorted: &[f64], percent: usize| {
        sorted.get((sorted.len() * percent / 100).min(sorted.len().saturating_sub(1))).copied()
    };
    let um = |percent| at(&errors, percent).map_or(f64::NAN, |e| 1e3 * e);
    let median = at(&times, 50).map_or_else(|| "–".to_owned(), in_words);
    println!("{name:<34} {} {poses:>6} {:>6}", size(method), answers.len());
    println!("{:>68.2} {:>9.2} {:>9.2} {median:>12}", um(50), um(99), um(100));
}

fn in_words(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.1} µs", 1e6 * seconds)
    } else {
        format!("{:.1} ms", 1e3 * seconds)
    }
}
