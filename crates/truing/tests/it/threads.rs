//! The same bytes on any number of threads, more than the machine has included.

use std::fmt::Write as _;
use std::path::Path;

use tempfile::TempDir;

use crate::command::{Case, truing_on};

/// `--threads` stops at what the machine has; the pool of the process does not.
const THREADS: [usize; 4] = [1, 2, 3, 8];

/// Kinds of which the example leaves something to plan for.
const PLANNED: [&str; 4] = ["ft-center", "pose-icp", "probe-comp", "tracker-lm"];

/// Standard output and the report of a command on each number of threads.
fn same_on_all(arguments: &[&str], report: bool) {
    let mut answers = Vec::new();
    for threads in THREADS {
        let folder = TempDir::new().unwrap();
        let page = folder.path().join("page.html");
        let more: &[&str] = if report { &["--report", page.to_str().unwrap()] } else { &[] };
        let all = [arguments, &["--json", "--no-timing"], more].concat();
        let ended = truing_on(threads, &all);
        assert_eq!(ended.code, 0, "{arguments:?}: {}", ended.stderr);
        let page = if report { std::fs::read_to_string(&page).unwrap() } else { String::new() };
        answers.push((threads, ended.stdout, page));
    }
    let (_, first, first_page) = &answers[0];
    for (threads, answer, page) in &answers[1..] {
        assert!(answer == first, "{arguments:?} on {threads} threads: another answer");
        assert!(page == first_page, "{arguments:?} on {threads} threads: another report");
    }
}

#[test]
fn every_command_of_every_kind() {
    for (kind, _) in truing::kinds() {
        let case = Case::example(kind);
        let path = case.path().to_str().unwrap();
        same_on_all(&["check", path], false);
        same_on_all(&["loop", path], true);
        if PLANNED.contains(&kind) {
            same_on_all(&["plan", path], false);
        }
    }
}

/// The draws of a budget are shared out among the threads.
#[test]
fn draws_by_monte_carlo() {
    for kind in ["frame-fit", "pose-icp"] {
        let case = Case::example(kind);
        let path = case.path().to_str().unwrap();
        for command in ["solve", "loop"] {
            same_on_all(&[command, path, "--monte-carlo", "100"], true);
        }
    }
}

/// Hundreds of blocks, so that every thread has several chunks of them.
#[test]
fn a_calibration_of_an_axis() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    for case in ["mount-slip", "targets-flexure"] {
        let path = fixtures.join("tracker-lm").join(case);
        same_on_all(&["solve", path.to_str().unwrap()], false);
    }
}

/// Thousands of points in dozens of chunks, the tree built on several threads.
#[test]
fn a_registration_of_clouds_and_of_a_cloud_on_a_mesh() {
    const N: u32 = 120;
    let folder = TempDir::new().unwrap();
    let height = |x: f64, y: f64| 2.0 * (x / 5.0).sin() * (y / 6.0).cos() + x * y / 80.0;
    let write = |name: &str, off_mm: f64| {
        let mut text = String::new();
        for k in 0..N * N {
            let [x, y] = [k % N, k / N].map(|k| 40.0 * f64::from(k) / f64::from(N) - 20.0);
            let (x, y) = (x + off_mm, y - off_mm);
            let _ = writeln!(text, "{x} {y} {}", height(x, y) + off_mm);
        }
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("target.xyz", 0.0);
    write("source.xyz", 0.07);
    let mut mesh = String::new();
    for k in 0..N * N {
        let [x, y] = [k % N, k / N].map(|k| 40.0 * f64::from(k) / f64::from(N) - 20.0);
        let _ = writeln!(mesh, "v {x} {y} {}", height(x, y));
    }
    for k in (0..N * (N - 1)).filter(|k| k % N != N - 1).map(|k| k + 1) {
        let _ = writeln!(mesh, "f {k} {} {} {}", k + 1, k + 1 + N, k + N);
    }
    std::fs::write(folder.path().join("target.obj"), mesh).unwrap();
    let [source, cloud, mesh] = ["source.xyz", "target.xyz", "target.obj"]
        .map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    for method in ["point-to-plane", "symmetric"] {
        same_on_all(&["register", &source, &cloud, "--method", method], false);
    }
    same_on_all(&["register", &source, &mesh], false);
}
