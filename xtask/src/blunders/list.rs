//! The mistakes that are made, by kind of case.

use super::tables::{
    Files, clipped, exchanged, names_exchanged, on_another_clock, rows_exchanged, scaled,
    setting_scaled, shifted, stuck,
};

/// A mistake, and the words of which its name must have one.
pub(crate) struct Mistake {
    /// In words.
    pub(crate) what: &'static str,
    pub(crate) words: &'static [&'static str],
    /// Makes it; false where the case has no such thing.
    pub(crate) make: fn(&mut Files, u64) -> bool,
}

const UNIT: &[&str] = &["input:unit", "in another unit"];
const EXCHANGED: &[&str] = &["exchanged"];
const SIGN: &[&str] = &["opposite sign", "reversed"];
const ROWS: &[&str] = &["input:row-shift", "are shifted one row"];
const LABELS: &[&str] = &["labels"];
const CLIPS: &[&str] = &["input:saturation", "saturates"];
const STUCK: &[&str] = &["input:stuck", "is stuck"];
const CLOCK: &[&str] = &["input:clock", "the clock of"];
const DIAMETER: &[&str] = &["diameter"];
const SIDE: &[&str] = &["side", "opposite sign", "does not make a surface"];
const TO: &[&str] = &["to_x_mm", "to_y_mm", "to_z_mm"];
const FORCES: &[&str] = &["fx_n", "fy_n", "fz_n"];
const MOMENTS: &[&str] = &["mx_nmm", "my_nmm", "mz_nmm"];
const MACHINE: &[&str] = &["machine_x_mm", "machine_y_mm"];
const XYZ: &[&str] = &["x_mm", "y_mm", "z_mm"];
const INCH: f64 = 1.0 / 25.4;
const POUND: f64 = 1.0 / 4.448_221_615_260_5;

const fn of(
    what: &'static str,
    words: &'static [&'static str],
    make: fn(&mut Files, u64) -> bool,
) -> Mistake {
    Mistake { what, words, make }
}

/// Mistakes in cases of a kind.
pub(crate) fn mistakes(kind: &str) -> Vec<Mistake> {
    match kind {
        "frame-fit" => pairs(),
        "ft-center" => presses(),
        "force-impedance" => log(),
        "tracker-lm" => ranges(),
        "tracker-lm targets" => targets(),
        "pose-icp" => points("points.csv"),
        _ => points("touches.csv"),
    }
}

fn pairs() -> Vec<Mistake> {
    vec![
        of("a column in inches", UNIT, |f, _| scaled(f, ("pairs.csv", &["to_x_mm"]), INCH)),
        of("a table in metres", UNIT, |f, _| scaled(f, ("pairs.csv", TO), 1e-3)),
        of("two columns exchanged", EXCHANGED, |f, _| exchanged(f, ("pairs.csv", &TO[..2]))),
        of("an axis mirrored", SIGN, |f, _| scaled(f, ("pairs.csv", &["to_y_mm"]), -1.0)),
        of("rows shifted by one", ROWS, |f, _| shifted(f, ("pairs.csv", TO))),
        of("two points exchanged", LABELS, |f, seed| rows_exchanged(f, ("pairs.csv", TO), seed)),
    ]
}

fn presses() -> Vec<Mistake> {
    const WRENCH: &str = "wrench.csv";
    vec![
        of("fz in lbf", UNIT, |f, _| scaled(f, (WRENCH, &["fz_n"]), POUND)),
        of("forces in lbf", UNIT, |f, _| scaled(f, (WRENCH, FORCES), POUND)),
        of("mx in N·in", UNIT, |f, _| scaled(f, (WRENCH, &["mx_nmm"]), INCH)),
        of("moments in N·m", UNIT, |f, _| scaled(f, (WRENCH, MOMENTS), 1e-3)),
        of("mx and my exchanged", EXCHANGED, |f, _| exchanged(f, (WRENCH, &MOMENTS[..2]))),
        of("fx and fy exchanged", EXCHANGED, |f, _| exchanged(f, (WRENCH, &FORCES[..2]))),
        of("sign of mx", SIGN, |f, _| scaled(f, (WRENCH, &["mx_nmm"]), -1.0)),
        of("positions in inches", UNIT, |f, _| scaled(f, ("presses.csv", MACHINE), INCH)),
        of("two presses exchanged", LABELS, |f, seed| {
            rows_exchanged(f, ("presses.csv", MACHINE), seed)
        }),
        of("rows of presses shifted", ROWS, |f, _| shifted(f, ("presses.csv", MACHINE))),
        of("mx clips", CLIPS, |f, _| clipped(f, (WRENCH, &["mx_nmm"]), 0.85)),
    ]
}

fn log() -> Vec<Mistake> {
    const LOG: &str = "log.csv";
    vec![
        of("f1 and f2 exchanged", EXCHANGED, |f, _| exchanged(f, (LOG, &["f1_n", "f2_n"]))),
        of("l1 and l3 exchanged", EXCHANGED, |f, _| exchanged(f, (LOG, &["l1_mm", "l3_mm"]))),
        of("f4 in lbf", UNIT, |f, _| scaled(f, (LOG, &["f4_n"]), POUND)),
        of("reference in lbf", UNIT, |f, _| scaled(f, (LOG, &["reference_n"]), POUND)),
        of("sign of the reference", SIGN, |f, _| scaled(f, (LOG, &["reference_n"]), -1.0)),
        of("normals mirrored", SIGN, |f, _| scaled(f, (LOG, &["nz"]), -1.0)),
        of("normals inward", SIGN, |f, _| scaled(f, (LOG, &["nx", "ny", "nz"]), -1.0)),
        of("f1 clips", CLIPS, |f, _| clipped(f, (LOG, &["f1_n"]), 0.8)),
        of("f3 is stuck", STUCK, |f, _| stuck(f, (LOG, &["f3_n"]), 0.5)),
        of("l1 and l4 exchanged", EXCHANGED, |f, _| exchanged(f, (LOG, &["l1_mm", "l4_mm"]))),
        of("clock of the reference ahead", CLOCK, |f, seed| {
            on_another_clock(f, (LOG, "reference_n"), ([-0.06, 0.0, 0.0], seed))
        }),
        of("clock of the reference late", CLOCK, |f, seed| {
            on_another_clock(f, (LOG, "reference_n"), ([0.25, 0.0, 0.0], seed))
        }),
        of("clock of the reference fast", CLOCK, |f, seed| {
            on_another_clock(f, (LOG, "reference_n"), ([0.0, 0.004, 0.0], seed))
        }),
        of("clock of the reference jitters", CLOCK, |f, seed| {
            on_another_clock(f, (LOG, "reference_n"), ([0.0, 0.0, 0.03], seed))
        }),
    ]
}

fn ranges() -> Vec<Mistake> {
    const RANGES: &str = "ranges.csv";
    vec![
        of("displacements in inches", UNIT, |f, _| scaled(f, (RANGES, &["displacement_mm"]), INCH)),
        of("sign of the displacements", SIGN, |f, _| {
            scaled(f, (RANGES, &["displacement_mm"]), -1.0)
        }),
        of("angles in radians", UNIT, |f, _| {
            scaled(f, (RANGES, &["angle_deg"]), std::f64::consts::PI / 180.0)
        }),
        of("sense of the angles", SIGN, |f, _| scaled(f, (RANGES, &["angle_deg"]), -1.0)),
        of("two stations exchanged", LABELS, |f, seed| {
            names_exchanged(f, (RANGES, "station"), seed)
        }),
        of("two mounts exchanged", LABELS, |f, seed| names_exchanged(f, (RANGES, "mount"), seed)),
        of("stations in metres", UNIT, |f, _| scaled(f, ("stations.csv", XYZ), 1e-3)),
        of("x and z of the mounts", EXCHANGED, |f, _| {
            exchanged(f, ("mounts.csv", &["x_mm", "z_mm"]))
        }),
        of("rows shifted by one", ROWS, |f, _| shifted(f, (RANGES, &["displacement_mm"]))),
    ]
}

fn targets() -> Vec<Mistake> {
    const TARGETS: &str = "targets.csv";
    vec![
        of("points in inches", UNIT, |f, _| scaled(f, (TARGETS, XYZ), INCH)),
        of("z in metres", UNIT, |f, _| scaled(f, (TARGETS, &["z_mm"]), 1e-3)),
        of("x and y exchanged", EXCHANGED, |f, _| exchanged(f, (TARGETS, &XYZ[..2]))),
        of("z mirrored", SIGN, |f, _| scaled(f, (TARGETS, &["z_mm"]), -1.0)),
        of("two mounts exchanged", LABELS, |f, seed| names_exchanged(f, (TARGETS, "mount"), seed)),
        of("sense of the angles", SIGN, |f, _| scaled(f, (TARGETS, &["angle_deg"]), -1.0)),
    ]
}

/// Touches of a part, in a table of that name.
fn points(table: &str) -> Vec<Mistake> {
    let mut all = if table == "points.csv" {
        vec![
            of("x in inches", UNIT, |f, _| scaled(f, ("points.csv", &["x_mm"]), INCH)),
            of("z in metres", UNIT, |f, _| scaled(f, ("points.csv", &["z_mm"]), 1e-3)),
            of("z mirrored", SIDE, |f, _| scaled(f, ("points.csv", &["z_mm"]), -1.0)),
            of("x and z exchanged", EXCHANGED, |f, _| {
                exchanged(f, ("points.csv", &["x_mm", "z_mm"]))
            }),
            of("z shifted by one", ROWS, |f, _| shifted(f, ("points.csv", &["z_mm"]))),
        ]
    } else {
        vec![
            of("x in inches", UNIT, |f, _| scaled(f, ("touches.csv", &["x_mm"]), INCH)),
            of("z in metres", UNIT, |f, _| scaled(f, ("touches.csv", &["z_mm"]), 1e-3)),
            of("z mirrored", SIDE, |f, _| scaled(f, ("touches.csv", &["z_mm"]), -1.0)),
            of("x and z exchanged", EXCHANGED, |f, _| {
                exchanged(f, ("touches.csv", &["x_mm", "z_mm"]))
            }),
            of("z shifted by one", ROWS, |f, _| shifted(f, ("touches.csv", &["z_mm"]))),
        ]
    };
    all.push(of("diameter of the ball for its radius", DIAMETER, |f, _| {
        setting_scaled(f, "tip_radius_mm", 2.0)
    }));
    all.push(of("vertex radius of the other sign", SIDE, |f, _| {
        setting_scaled(f, "radius_mm", -1.0)
    }));
    all
}
