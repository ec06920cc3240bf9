//! A real LinuxCNC, with simulated axes, probes a simulated sphere; its latency is found.

use std::fmt::Write as _;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::command::{Case, truing};

/// A user of no rights, under whom LinuxCNC runs where a test is root.
const NOBODY: &str = "65534";
/// One program each, mm/min.
const FEEDS_MM_PER_MIN: [u32; 3] = [120, 600, 1800];
const PER_FEED: u32 = 10;
/// Servo period of `probe.ini`.
const SERVO_MS: f64 = 1.0;

#[test]
fn the_latency_of_a_linuxcnc_is_found_undeclared() {
    if !is_there() {
        return;
    }
    let case = Case::new(&[("probe.ngc", &program())]);
    run_linuxcnc(case.path());
    let touches = imported(&case);
    assert_eq!(touches.lines().count(), 31, "{touches}");
    case.write("touches.csv", touches);
    case.write(
        "case.toml",
        "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
         [probe]\ntip_radius_mm = 3.0\n",
    );
    let closed = case.json("loop");
    let steps = closed["steps"].as_array().unwrap();
    let names: Vec<&Value> = steps.iter().map(|step| &step["effect"]).collect();
    assert_eq!(names.first(), Some(&&Value::from("latency")), "{closed}");
    // The trigger falls anywhere in a cycle: half of one on average, a whole one at most.
    let found_ms = steps[0]["parameters"][0]["value"].as_f64().unwrap();
    assert!((0.25 * SERVO_MS..SERVO_MS).contains(&found_ms), "{closed}");
}

/// Whether LinuxCNC is installed and free; says so where not.
#[expect(clippy::print_stderr, reason = "a test that is skipped says so")]
fn is_there() -> bool {
    let quiet = |program: &str, argument: &str| {
        let mut command = Command::new(program);
        command.arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status()
    };
    let installed = quiet("linuxcnc", "-h").is_ok() && quiet("halcmd", "-h").is_ok();
    let in_use = quiet("pidof", "rtapi_app").is_ok_and(|status| status.success());
    if !installed || in_use {
        eprintln!("SKIPPED: LinuxCNC is not installed, or in use");
    }
    installed && !in_use
}

/// Touches of the upper half of a sphere about the origin, along its normal, one log per feed.
fn program() -> String {
    let mut text = "G21 G90 G64 P0.001\nG0 Z45\n".to_owned();
    for (n, feed) in (0..).zip(FEEDS_MM_PER_MIN) {
        let _ = writeln!(text, "(PROBEOPEN probe{feed}.log)");
        for k in 0..PER_FEED {
            let index = f64::from(3 * k + n);
            let up = 0.15 + 0.8 * (index + 0.5) / f64::from(3 * PER_FEED);
            let (sin, cos) = (2.4 * index).sin_cos();
            let side = (1.0 - up * up).sqrt();
            let at = |reach: f64| {
                let [x, y, z] = [side * cos, side * sin, up].map(|v| v * reach);
                format!("X{x:.5} Y{y:.5} Z{z:.5}")
            };
            // Down outside the sphere, fast to near it, and to it with the feed.
            let _ = writeln!(text, "G0 {}\nG0 {}\nF{feed}\nG38.2 {}", at(40.0), at(28.5), at(27.0));
            let _ = writeln!(text, "G0 {}\nG0 Z45", at(40.0));
        }
        text.push_str("(PROBECLOSE)\n");
    }
    text.push_str("M2\n");
    text
}

fn run_linuxcnc(folder: &Path) {
    let config = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/linuxcnc");
    for file in ["probe.ini", "probe.hal", "drive.py"] {
        fs::copy(config.join(file), folder.join(file)).unwrap();
    }
    fs::write(folder.join("tool.tbl"), "").unwrap();
    let all = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    for path in all.chain([folder.to_owned()]) {
        fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
    }
    let ended = Command::new("linuxcnc")
        .args(["-r", "probe.ini"])
        .env("RTAPI_UID", NOBODY)
        .env("RTAPI_FIFO_PATH", folder.join("fifo"))
        .env("HOME", folder)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert!(ended.status.success(), "{said}{}", String::from_utf8_lossy(&ended.stderr));
}

/// The logs of all feeds as one table.
fn imported(case: &Case) -> String {
    let mut table = String::new();
    for feed in FEEDS_MM_PER_MIN {
        let log = case.file(&format!("probe{feed}.log"));
        let made =
            truing(&["import", "probe-log", log.to_str().unwrap(), "--feed", &feed.to_string()]);
        assert_eq!(made.code, 0, "{}", made.stderr);
        let mut lines = made.stdout.lines();
        let header = lines.next().unwrap();
        if table.is_empty() {
            let _ = writeln!(table, "{header}");
        }
        for line in lines {
            let _ = writeln!(table, "F{feed}-{line}");
        }
    }
    table
}
