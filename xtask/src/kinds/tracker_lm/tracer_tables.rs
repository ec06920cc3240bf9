//! A simulated tracer run as the files of a case.

use std::fmt::Write as _;

use crate::kinds::tracker_lm::tracer::Run;
use crate::kinds::tracker_lm::tracer_run::Measured;

/// Files of a case folder, in the order of its page.
pub(crate) fn tables(run: &Run, measured: &Measured) -> Vec<(&'static str, String)> {
    vec![
        ("case.toml", case_toml(run, measured)),
        ("stations.csv", places("station", 'S', &measured.stations_mm)),
        ("mounts.csv", places("mount", 'R', &measured.mounts_mm)),
        ("ranges.csv", ranges_csv(run, measured)),
    ]
}

fn case_toml(run: &Run, measured: &Measured) -> String {
    let list = |v: [f64; 3], decimals: usize| {
        format!("[{:.decimals$}, {:.decimals$}, {:.decimals$}]", v[0], v[1], v[2])
    };
    let mut text = format!(
        "kind = \"tracker-lm\"\n\n[axis]\nletter = \"B\"\norigin_mm = {}\ndirection = {}\n",
        list(measured.origin_mm, 3),
        list(measured.direction, 15),
    );
    if run.station_dead_paths || run.perfect {
        text.push_str("\n[model]\n");
    }
    if run.station_dead_paths {
        text.push_str("dead_path = \"station\"\n");
    }
    if run.perfect {
        text.push_str("axis = \"fixed\"\n");
    }
    if run.declare_noise || run.declare_stations {
        text.push_str("\n[noise]\n");
    }
    if run.declare_noise {
        let _ = writeln!(text, "displacement_mm = {}", run.noise_mm);
    }
    if run.declare_stations {
        let _ = writeln!(text, "station_mm = {}", run.stations_off_mm);
    }
    text
}

fn places(what: &str, letter: char, places: &[([f64; 3], [f64; 3])]) -> String {
    let mut text = format!("{what},x_mm,y_mm,z_mm\n");
    for (i, (_, nominal)) in places.iter().enumerate() {
        let [x, y, z] = nominal;
        let _ = writeln!(text, "{letter}{},{x:.4},{y:.4},{z:.4}", i + 1);
    }
    text
}

fn ranges_csv(run: &Run, measured: &Measured) -> String {
    let mut text = String::from("station,mount,step,angle_deg,displacement_mm,time_s");
    text.push_str(if run.both_ways { ",direction" } else { "" });
    text.push_str(if run.record_air { ",air_c\n" } else { "\n" });
    for reading in &measured.readings {
        let (angle_deg, rising) = measured.steps[reading.step];
        let _ = write!(
            text,
            "S{},R{},{},{angle_deg},{:.6},{:.0}",
            reading.station + 1,
            reading.mount + 1,
            reading.step + 1,
            reading.displacement_mm,
            reading.time_s,
        );
        if run.both_ways {
            text.push_str(if rising { ",1" } else { ",-1" });
        }
        if run.record_air {
            let _ = write!(text, ",{:.3}", reading.air_c);
        }
        text.push('\n');
    }
    text
}
