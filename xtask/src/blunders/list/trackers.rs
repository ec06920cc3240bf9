//! Mistakes in surveys of a rotary axis.

use super::{
    AXIS, CLIPS, EXCHANGED, GAIN, INCH, LABELS, Mistake, RADIAN, ROUNDED, ROWS, SESSION, SIGN,
    STUCK, UNIT, XYZ, of,
};
use crate::blunders::tables::{
    clipped_of_one, exchanged, names_exchanged, of_another_session, rounded, scaled,
    scaled_in_a_third, scaled_of_one, setting_scaled, setting_to, shifted, stuck,
};

pub(super) fn ranges() -> Vec<Mistake> {
    const RANGES: &str = "ranges.csv";
    vec![
        of("displacements in inches", UNIT, |f, _| scaled(f, (RANGES, &["displacement_mm"]), INCH)),
        of("sign of the displacements", SIGN, |f, _| {
            scaled(f, (RANGES, &["displacement_mm"]), -1.0)
        }),
        of("angles in radians", UNIT, |f, _| scaled(f, (RANGES, &["angle_deg"]), RADIAN)),
        of("sense of the angles", SIGN, |f, _| scaled(f, (RANGES, &["angle_deg"]), -1.0)),
        of("two stations exchanged", LABELS, |f, draw| {
            names_exchanged(f, (RANGES, "station"), draw.seed)
        }),
        of("two mounts exchanged", LABELS, |f, draw| {
            names_exchanged(f, (RANGES, "mount"), draw.seed)
        }),
        of("stations in metres", UNIT, |f, _| scaled(f, ("stations.csv", XYZ), 1e-3)),
        of("x and z of the mounts", EXCHANGED, |f, _| {
            exchanged(f, ("mounts.csv", &["x_mm", "z_mm"]))
        }),
        of("rows shifted by one", ROWS, |f, _| shifted(f, (RANGES, &["displacement_mm"]))),
        of("axis declared the other way round", AXIS, |f, _| setting_scaled(f, "direction", -1.0)),
        of("another axis declared", AXIS, |f, _| setting_to(f, "direction", "[0.0, 0.0, 1.0]")),
        of("mounts in inches", UNIT, |f, _| scaled(f, ("mounts.csv", XYZ), INCH)),
        of("x of the stations mirrored", SIGN, |f, _| scaled(f, ("stations.csv", &["x_mm"]), -1.0)),
        of("angles of two steps exchanged", LABELS, |f, draw| {
            names_exchanged(f, (RANGES, "angle_deg"), draw.seed)
        }),
        of("displacements are stuck", STUCK, |f, _| stuck(f, (RANGES, &["displacement_mm"]), 0.8)),
        of("displacements of another session", SESSION, |f, draw| {
            of_another_session(f, (RANGES, &["displacement_mm"]), draw.other)
        }),
        of("stations of another session", SESSION, |f, draw| {
            of_another_session(f, ("stations.csv", XYZ), draw.other)
        }),
        of("mounts of another session", SESSION, |f, draw| {
            of_another_session(f, ("mounts.csv", XYZ), draw.other)
        }),
        of("displacements of the other sign in a third of the rows", SIGN, |f, _| {
            scaled_in_a_third(f, (RANGES, &["displacement_mm"]), -1.0)
        }),
        of("displacements rounded to a tenth", ROUNDED, |f, _| {
            rounded(f, (RANGES, &["displacement_mm"]), 1)
        }),
        of("displacements of one station doubled", GAIN, |f, draw| {
            scaled_of_one(f, (RANGES, ["station", "displacement_mm"]), (2.0, draw.seed))
        }),
        of("displacements of one station clip", CLIPS, |f, draw| {
            clipped_of_one(f, (RANGES, ["station", "displacement_mm"]), (0.6, draw.seed))
        }),
        of("displacements of one station in metres", UNIT, |f, draw| {
            scaled_of_one(f, (RANGES, ["station", "displacement_mm"]), (1e-3, draw.seed))
        }),
    ]
}

pub(super) fn targets() -> Vec<Mistake> {
    const TARGETS: &str = "targets.csv";
    vec![
        of("points in inches", UNIT, |f, _| scaled(f, (TARGETS, XYZ), INCH)),
        of("z in metres", UNIT, |f, _| scaled(f, (TARGETS, &["z_mm"]), 1e-3)),
        of("x and y exchanged", EXCHANGED, |f, _| exchanged(f, (TARGETS, &XYZ[..2]))),
        of("z mirrored", SIGN, |f, _| scaled(f, (TARGETS, &["z_mm"]), -1.0)),
        of("y of one station mirrored", SIGN, |f, draw| {
            scaled_of_one(f, (TARGETS, ["station", "y_mm"]), (-1.0, draw.seed))
        }),
        of("two mounts exchanged", LABELS, |f, draw| {
            names_exchanged(f, (TARGETS, "mount"), draw.seed)
        }),
        of("sense of the angles", SIGN, |f, _| scaled(f, (TARGETS, &["angle_deg"]), -1.0)),
        of("angles in radians", UNIT, |f, _| scaled(f, (TARGETS, &["angle_deg"]), RADIAN)),
        of("axis declared the other way round", AXIS, |f, _| setting_scaled(f, "direction", -1.0)),
        of("another axis declared", AXIS, |f, _| setting_to(f, "direction", "[0.0, 0.0, 1.0]")),
        of("mounts in inches", UNIT, |f, _| scaled(f, ("mounts.csv", XYZ), INCH)),
        of("points shifted by one", ROWS, |f, _| shifted(f, (TARGETS, XYZ))),
        of("angles of two steps exchanged", LABELS, |f, draw| {
            names_exchanged(f, (TARGETS, "angle_deg"), draw.seed)
        }),
        of("points are stuck", STUCK, |f, _| stuck(f, (TARGETS, XYZ), 0.8)),
        of("points of another session", SESSION, |f, draw| {
            of_another_session(f, (TARGETS, XYZ), draw.other)
        }),
        of("mounts of another session", SESSION, |f, draw| {
            of_another_session(f, ("mounts.csv", XYZ), draw.other)
        }),
    ]
}
