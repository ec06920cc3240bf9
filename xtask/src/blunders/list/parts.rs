//! Mistakes in touches of a part, its drawing and its probe.

use super::{
    COPIED, DIAMETER, DIAMETER_OR_HALF, EXCHANGED, INCH, INCREMENTS, LABELS, Mistake, NORMAL,
    POINT, REVERSED, ROUNDED, ROWS, SESSION, SIDE, SIGN, STUCK, UNIT, XYZ, of,
};
use crate::blunders::tables::{
    copied, end_shifted, exchanged, in_increments, of_another_session, point_lost, reversed,
    rounded, rows_exchanged, scaled, scaled_in_a_third, setting_scaled, shifted, stuck,
};

/// Points of a part.
pub(super) fn touched_points() -> Vec<Mistake> {
    const POINTS: &str = "points.csv";
    vec![
        of("x in inches", UNIT, |f, _| scaled(f, (POINTS, &["x_mm"]), INCH)),
        of("z in metres", UNIT, |f, _| scaled(f, (POINTS, &["z_mm"]), 1e-3)),
        of("z mirrored", SIDE, |f, _| scaled(f, (POINTS, &["z_mm"]), -1.0)),
        of("x and z exchanged", EXCHANGED, |f, _| exchanged(f, (POINTS, &["x_mm", "z_mm"]))),
        of("z shifted by one", ROWS, |f, _| shifted(f, (POINTS, &["z_mm"]))),
        of("x shifted from two fifths on", ROWS, |f, _| end_shifted(f, (POINTS, &["x_mm"]))),
        of("points in metres", UNIT, |f, _| scaled(f, (POINTS, XYZ), 1e-3)),
        of("z of two points exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (POINTS, &["z_mm"]), draw.seed)
        }),
        of("x is stuck", STUCK, |f, _| stuck(f, (POINTS, &["x_mm"]), 0.5)),
        of("z of another session", SESSION, |f, draw| {
            of_another_session(f, (POINTS, &["z_mm"]), draw.other)
        }),
        of("side touches of another session", SESSION, |f, draw| {
            of_another_session(f, ("edge.csv", XYZ), draw.other)
        }),
        of("side touches in inches", UNIT, |f, _| scaled(f, ("edge.csv", XYZ), INCH)),
        of("x copied over y", COPIED, |f, _| copied(f, (POINTS, &XYZ[..2]))),
        of("a decimal point lost in z", POINT, |f, draw| {
            point_lost(f, (POINTS, &["z_mm"]), draw.seed)
        }),
        of("a third of the rows in inches", UNIT, |f, _| scaled_in_a_third(f, (POINTS, XYZ), INCH)),
        of("coordinates in increments", INCREMENTS, |f, _| in_increments(f, (POINTS, XYZ))),
        of("coordinates rounded to a tenth", ROUNDED, |f, _| rounded(f, (POINTS, XYZ), 1)),
    ]
}

/// Touches of a part.
pub(super) fn touches() -> Vec<Mistake> {
    const TOUCHES: &str = "touches.csv";
    const APPROACH: &[&str] = &["nx", "ny", "nz"];
    vec![
        of("x in inches", UNIT, |f, _| scaled(f, (TOUCHES, &["x_mm"]), INCH)),
        of("z in metres", UNIT, |f, _| scaled(f, (TOUCHES, &["z_mm"]), 1e-3)),
        of("z mirrored", SIDE, |f, _| scaled(f, (TOUCHES, &["z_mm"]), -1.0)),
        of("x and z exchanged", EXCHANGED, |f, _| exchanged(f, (TOUCHES, &["x_mm", "z_mm"]))),
        of("z shifted by one", ROWS, |f, _| shifted(f, (TOUCHES, &["z_mm"]))),
        of("x shifted from two fifths on", ROWS, |f, _| end_shifted(f, (TOUCHES, &["x_mm"]))),
        of("touches in metres", UNIT, |f, _| scaled(f, (TOUCHES, XYZ), 1e-3)),
        of("z of two touches exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (TOUCHES, &["z_mm"]), draw.seed)
        }),
        of("x is stuck", STUCK, |f, _| stuck(f, (TOUCHES, &["x_mm"]), 0.5)),
        of("z of another session", SESSION, |f, draw| {
            of_another_session(f, (TOUCHES, &["z_mm"]), draw.other)
        }),
        of("normals inward", NORMAL, |f, _| scaled(f, (TOUCHES, APPROACH), -1.0)),
        of("nx and nz exchanged", EXCHANGED, |f, _| exchanged(f, (TOUCHES, &["nx", "nz"]))),
        of("nz of the other sign", SIGN, |f, _| scaled(f, (TOUCHES, &["nz"]), -1.0)),
        of("x copied over y", COPIED, |f, _| copied(f, (TOUCHES, &XYZ[..2]))),
        of("a decimal point lost in z", POINT, |f, draw| {
            point_lost(f, (TOUCHES, &["z_mm"]), draw.seed)
        }),
        of("a third of the rows in inches", UNIT, |f, _| {
            scaled_in_a_third(f, (TOUCHES, XYZ), INCH)
        }),
        of("coordinates in increments", INCREMENTS, |f, _| in_increments(f, (TOUCHES, XYZ))),
        of("coordinates rounded to a tenth", ROUNDED, |f, _| rounded(f, (TOUCHES, XYZ), 1)),
        of("approaches in reverse order", REVERSED, |f, _| reversed(f, (TOUCHES, APPROACH))),
        of("approaches one row down", ROWS, |f, _| shifted(f, (TOUCHES, APPROACH))),
    ]
}

/// What is the same for every drawing and probe.
pub(super) fn part(mut all: Vec<Mistake>) -> Vec<Mistake> {
    all.push(of("diameter of the ball for its radius", DIAMETER, |f, _| {
        setting_scaled(f, "tip_radius_mm", 2.0)
    }));
    all.push(of("radius of the ball halved", DIAMETER_OR_HALF, |f, _| {
        setting_scaled(f, "tip_radius_mm", 0.5)
    }));
    all.push(of("vertex radius of the other sign", SIDE, |f, _| {
        setting_scaled(f, "radius_mm", -1.0)
    }));
    all.push(of("diameter of the vertex sphere for its radius", DIAMETER, |f, _| {
        setting_scaled(f, "radius_mm", 2.0)
    }));
    all.push(of("vertex radius in inches", UNIT, |f, _| setting_scaled(f, "radius_mm", INCH)));
    all
}
