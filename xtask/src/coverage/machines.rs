//! Rotary axes, workpieces and touch probes.

use super::situation::{Simulated, Situation, Truth, size_of_effect, truth};
use crate::generators::vector::{add, rotate, scale};
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::probe_comp::probe::{self, Session};
use crate::kinds::probe_comp::probe_tables;
use crate::kinds::tracker_lm::tracer::{self, Run};
use crate::kinds::tracker_lm::tracer_physics::elsewhere;
use crate::kinds::tracker_lm::tracer_run::{Defect, Measured};
use crate::kinds::tracker_lm::tracer_tables::tables;

/// Thirteen angles keep a loop at a fraction of a second.
const ANGLES: usize = 13;
/// Every fourth touch is only judged: nine are fitted.
const NINE: usize = 12;

pub(super) fn situations() -> Vec<Situation> {
    let tracker = |name, effect, make| Situation { krate: "tracker-lm", name, effect, make };
    let pose = |name, effect, make| Situation { krate: "pose-icp", name, effect, make };
    let probe = |name, effect, make| Situation { krate: "probe-comp", name, effect, make };
    vec![
        tracker("nothing missing", None, |seed| of_run(&run(seed))),
        tracker("a beam lost and found, 6 µm", Some("dead-path-jump"), |seed| {
            of_run(&Run { defect: Defect::DeadPathJump(1, 2, 6, 0.006), ..run(seed) })
        }),
        tracker("glass path of the reflectors, 12 µm", Some("incidence"), |seed| {
            of_run(&Run { defect: Defect::Incidence(0.012), ..run(seed) })
        }),
        tracker("wavelength, 150 ppm, stations known to 0.5 µm", Some("range-scale"), |seed| {
            let defect = Defect::RangeScale(150e-6);
            of_run(&Run { defect, stations_off_mm: 5e-4, ..run(seed) })
        }),
        pose("nothing missing", None, |seed| of_mirror(&Mirror::new(seed))),
        pose("nothing missing, near-sphere, side not touched", None, |seed| {
            of_mirror(&Mirror { radius_mm: 480.0, sides: false, ..Mirror::new(seed) })
        }),
        pose("nine touches, near-sphere, side not touched", None, |seed| {
            of_mirror(&Mirror {
                radius_mm: 480.0,
                sides: false,
                n_points: NINE,
                ..Mirror::new(seed)
            })
        }),
        pose("saddle, 6 µm", Some("astigmatism"), |seed| {
            let flaw = mirror::Flaw::Astigmatism([6e-3, -2e-3]);
            of_mirror(&Mirror { flaw, ..Mirror::new(seed) })
        }),
        pose("three lobes, 6 µm", Some("trefoil"), |seed| {
            let flaw = mirror::Flaw::Trefoil([5e-3, 3e-3]);
            of_mirror(&Mirror { flaw, ..Mirror::new(seed) })
        }),
        pose("a patch 10 µm low, 15 mm wide", Some("patch"), |seed| {
            let flaw = mirror::Flaw::Bump(-0.01, 15.0);
            of_mirror(&Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
        }),
        pose("the spindle reaches its temperature, 12 µm", Some("drift"), |seed| {
            let flaw = mirror::Flaw::Settling(0.012, 0.1);
            of_mirror(&Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
        }),
        probe("nothing missing", None, |seed| of_session(&Session::new(seed))),
        probe("stylus gives way, 6 µm", Some("bending"), |seed| {
            of_session(&Session { flaw: probe::Flaw::Bending(6e-3), ..Session::new(seed) })
        }),
        probe("axes out of square", Some("squareness"), |seed| {
            let flaw = probe::Flaw::Squareness([4e-4, -3e-4, 2e-4]);
            of_session(&Session { flaw, ..Session::new(seed) })
        }),
        probe("ball larger, oblique approaches", Some("tip-radius"), |seed| {
            let flaw = probe::Flaw::Ball(5e-3);
            of_session(&Session { flaw, oblique_rad: 0.5, ..Session::new(seed) })
        }),
    ]
}

/// The axis is declared perfect, and is not where the drawing has it.
pub(super) fn axis_off_its_place() -> Situation {
    Situation {
        krate: "tracker-lm",
        name: "perfect axis, 0.5 mm and 0.5 mrad from its place",
        effect: Some("axis-location"),
        make: |seed| {
            let by_mm = [0.3, 0.0, -0.4];
            let tilt_rad = [3e-4, 0.0, 4e-4];
            let defect = Defect::AxisMoved(by_mm, tilt_rad);
            let moved = Run { defect, perfect: true, ..run(seed) };
            let measured = tracer::simulate(&moved);
            let (files, mut truths) = of_run(&moved);
            // The six errors are of the axis that was declared, and true ones are not; reflectors stand
            // beside it as the first angle has them.
            truths.retain(|truth| !truth.name.ends_with("of the axis"));
            let reflectors = truths.iter_mut().filter(|truth| truth.name == "reflectors");
            for (truth, known) in reflectors.zip(beside_declared(&measured, by_mm, tilt_rad)) {
                truth.known = known;
            }
            for (k, known) in [0.3, -0.4, 3e-4, 4e-4].into_iter().enumerate() {
                let at = "estimates.axis_location";
                let name = if k < 2 { "place of the axis" } else { "direction of the axis" };
                truths.push(truth(
                    name,
                    format!("{at}.values.{k}"),
                    format!("{at}.std.{k}"),
                    known,
                ));
            }
            (files, truths)
        },
    }
}

/// Coordinates of all reflectors, in the frame of the declared axis, as they stand at the first angle
/// about the axis that there is.
fn beside_declared(
    measured: &Measured,
    by_mm: [f64; 3],
    tilt_rad: [f64; 3],
) -> impl Iterator<Item = f64> {
    let (origin_mm, direction) = elsewhere(measured.origin_mm, measured.direction, by_mm, tilt_rad);
    let (first_deg, _) = measured.steps[0];
    let first_rad = first_deg.to_radians();
    let from_declared_mm = add(origin_mm, scale(-1.0, measured.origin_mm));
    measured.mounts_mm.iter().flat_map(move |(place, _)| {
        let stands_mm = add(from_declared_mm, rotate(direction, first_rad, *place));
        rotate(measured.direction, -first_rad, stands_mm)
    })
}

fn run(seed: u64) -> Run {
    Run { n_angles: ANGLES, ..Run::new(seed) }
}

/// Errors of the axis, stations and reflectors.
fn of_run(run: &Run) -> Simulated {
    let measured = tracer::simulate(run);
    let mut truths = Vec::new();
    for (k, (displacement, rotation)) in measured.errors.iter().enumerate().skip(1) {
        for (c, name) in ["x", "y", "z"].iter().enumerate() {
            let at = format!("estimates.axis_errors.{k}");
            let (value, std) = (format!("{at}.e_{name}_mm"), format!("{at}.std_e_{name}_mm"));
            truths.push(truth("displacements of the axis", value, std, displacement[c]));
        }
        for (c, name) in ["a", "b", "c"].iter().enumerate() {
            let at = format!("estimates.axis_errors.{k}");
            let (value, std) = (format!("{at}.e_{name}_rad"), format!("{at}.std_e_{name}_rad"));
            truths.push(truth("rotations of the axis", value, std, rotation[c]));
        }
    }
    for (list, name, places) in [
        ("stations", "stations", &measured.stations_mm),
        ("mounts", "reflectors", &measured.mounts_mm),
    ] {
        for (i, (place, _)) in places.iter().enumerate() {
            for (c, axis) in ["x", "y", "z"].iter().enumerate() {
                let at = format!("estimates.{list}.{i}");
                let (value, std) = (format!("{at}.{axis}_mm"), format!("{at}.std_xyz_mm.{c}"));
                truths.push(truth(name, value, std, place[c]));
            }
        }
    }
    (tables(run, &measured), truths)
}

fn of_mirror(mirror: &Mirror) -> Simulated {
    let touched = mirror::simulate(mirror);
    let mut truths: Vec<Truth> = (["x_mm", "y_mm", "z_mm", "alpha_deg", "beta_deg"].into_iter())
        .zip(touched.pose)
        .map(|(name, known)| {
            let label = match name {
                "z_mm" => "height",
                "x_mm" | "y_mm" => "lateral position",
                _ => "tilts",
            };
            let at = "estimates.pose";
            let (value, std) = (format!("{at}.{name}"), format!("{at}.std_{name}"));
            Truth {
                interval: Some(format!("{at}.interval_95.{name}")),
                ..truth(label, value, std, known)
            }
        })
        .collect();
    if let mirror::Flaw::Bump(height_mm, _) = mirror.flaw {
        truths.push(size_of_effect(0, 1e3 * height_mm));
    }
    let mut files = vec![("case.toml", touched.case_toml), ("points.csv", touched.points_csv)];
    files.extend(touched.edge_csv.map(|text| ("edge.csv", text)));
    (files, truths)
}

/// The part is as drawn: every deviation is zero.
fn of_session(session: &Session) -> Simulated {
    let touches = probe::simulate(session);
    let truths = (0..touches.len())
        .map(|i| {
            let at = format!("estimates.touches.{i}");
            let label =
                if touches[i].is_check { "deviations, judged" } else { "deviations, fitted" };
            truth(label, format!("{at}.deviation_mm"), format!("{at}.std_deviation_mm"), 0.0)
        })
        .collect();
    let files = vec![
        ("case.toml", probe_tables::case_toml(session)),
        ("touches.csv", probe_tables::touches_csv(session, &touches)),
    ];
    (files, truths)
}
