//! Tables of cases that a foreign table can become.

/// One table of a kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) kind: &'static str,
    pub(super) file: &'static str,
    /// Columns without which it cannot be read.
    pub(super) needed: &'static [&'static str],
    pub(super) optional: &'static [&'static str],
}

/// The first table of a kind is the one meant where none is named, but for `ft-center`, of which no
/// table is more usual than another.
pub(super) const TARGETS: [Target; 16] = [
    Target {
        kind: "frame-fit",
        file: "pairs.csv",
        needed: &["point", "from_x_mm", "from_y_mm", "to_x_mm", "to_y_mm"],
        optional: &[
            "from_z_mm",
            "to_z_mm",
            "sigma_mm",
            "sigma_x_mm",
            "sigma_y_mm",
            "sigma_z_mm",
            "use",
            "body",
        ],
    },
    Target {
        kind: "ft-center",
        file: "presses.csv",
        needed: &["press", "machine_x_mm", "machine_y_mm", "use"],
        optional: &[],
    },
    Target {
        kind: "ft-center",
        file: "wrench.csv",
        needed: &["press", "time_s", "fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"],
        optional: &[],
    },
    Target {
        kind: "ft-center",
        file: "displacements.csv",
        needed: &["point", "commanded_mm", "solved_mm"],
        optional: &[],
    },
    Target {
        kind: "ft-center",
        file: "gravity.csv",
        needed: &[
            "pose", "qw", "qx", "qy", "qz", "fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm",
        ],
        optional: &[],
    },
    Target {
        kind: "positioning",
        file: "positions.csv",
        needed: &["target_mm", "actual_mm"],
        optional: &["point", "direction", "cycle"],
    },
    Target {
        kind: "tracker-lm",
        file: "ranges.csv",
        needed: &["station", "mount", "step", "angle_deg", "displacement_mm"],
        optional: &["time_s", "direction"],
    },
    Target {
        kind: "tracker-lm",
        file: "targets.csv",
        needed: &["station", "mount", "step", "angle_deg", "x_mm", "y_mm", "z_mm"],
        optional: &["time_s", "direction"],
    },
    Target {
        kind: "tracker-lm",
        file: "stations.csv",
        needed: &["station", "x_mm", "y_mm", "z_mm"],
        optional: &[],
    },
    Target {
        kind: "tracker-lm",
        file: "mounts.csv",
        needed: &["mount", "x_mm", "y_mm", "z_mm"],
        optional: &["body"],
    },
    Target {
        kind: "pose-icp",
        file: "points.csv",
        needed: &["point", "x_mm", "y_mm", "z_mm"],
        optional: &["use"],
    },
    Target {
        kind: "pose-icp",
        file: "edge.csv",
        needed: &["point", "x_mm", "y_mm", "z_mm"],
        optional: &[],
    },
    Target {
        kind: "probe-comp",
        file: "touches.csv",
        needed: &["touch", "x_mm", "y_mm", "z_mm"],
        optional: &["nx", "ny", "nz", "guide_x_mm", "guide_y_mm", "spindle_deg", "use"],
    },
    Target {
        kind: "probe-comp",
        file: "micro.csv",
        needed: &["touch", "k", "x_mm", "y_mm", "z_mm"],
        optional: &[],
    },
    Target {
        kind: "force-impedance",
        file: "log.csv",
        needed: &[
            "time_s", "l1_mm", "l2_mm", "l3_mm", "l4_mm", "f1_n", "f2_n", "f3_n", "f4_n", "nx",
            "ny", "nz",
        ],
        optional: &["reference_n", "segment"],
    },
    Target {
        kind: "force-impedance",
        file: "path.csv",
        needed: &["run", "time_s", "path_mm", "force_n", "reference_n"],
        optional: &[],
    },
];

/// Words by which a column is meant as well as by its own name.
pub(super) const SYNONYMS: [(&str, &[&str]); 7] = [
    ("point", &["name", "id", "label", "no", "nr", "number"]),
    ("touch", &["name", "id", "label", "no", "nr", "number", "point"]),
    ("press", &["name", "id", "label", "no", "nr", "number"]),
    ("time_s", &["t", "timestamp"]),
    ("commanded_mm", &["nominal", "target", "command"]),
    ("solved_mm", &["actual", "measured"]),
    ("reference_n", &["ref"]),
];

/// Tables of a kind.
pub(super) fn targets(kind: &str) -> impl Iterator<Item = &'static Target> {
    TARGETS.iter().filter(move |target| target.kind == kind)
}
