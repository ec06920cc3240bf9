//! Mistakes between two frames, and in poses of a flange.

use super::{
    COPIED, EXCHANGED, FROM, INCH, INCREMENTS, LABELS, Mistake, POINT, QUATERNION, ROUNDED, ROWS,
    SESSION, SIGN, STUCK, TO, UNIT, XYZ, of,
};
use crate::blunders::tables::{
    copied, exchanged, in_increments, moved_in_a_third, neighbours_exchanged, of_another_session,
    pasted, point_lost, rounded, rows_exchanged, scaled, scaled_in_a_third, setting_scaled,
    shifted, sorted, stuck,
};

pub(super) fn pairs() -> Vec<Mistake> {
    vec![
        of("a column in inches", UNIT, |f, _| scaled(f, ("pairs.csv", &["to_x_mm"]), INCH)),
        of("a table in metres", UNIT, |f, _| scaled(f, ("pairs.csv", TO), 1e-3)),
        of("two columns exchanged", EXCHANGED, |f, _| exchanged(f, ("pairs.csv", &TO[..2]))),
        of("an axis mirrored", SIGN, |f, _| scaled(f, ("pairs.csv", &["to_y_mm"]), -1.0)),
        of("rows shifted by one", ROWS, |f, _| shifted(f, ("pairs.csv", TO))),
        of("two points exchanged", LABELS, |f, draw| {
            rows_exchanged(f, ("pairs.csv", TO), draw.seed)
        }),
        of("a column of the other table in inches", UNIT, |f, _| {
            scaled(f, ("pairs.csv", &["from_z_mm"]), INCH)
        }),
        of("the other table in µm", UNIT, |f, _| scaled(f, ("pairs.csv", FROM), 1e3)),
        of("both tables in metres", UNIT, |f, _| {
            scaled(f, ("pairs.csv", &[FROM, TO].concat()), 1e-3)
        }),
        of("noise in µm", UNIT, |f, _| setting_scaled(f, "point_mm", 1e3)),
        of("one column shifted by one", ROWS, |f, _| shifted(f, ("pairs.csv", &TO[2..]))),
        of("a column is stuck", STUCK, |f, _| stuck(f, ("pairs.csv", &TO[..1]), 0.5)),
        of("a table of another session", SESSION, |f, draw| {
            of_another_session(f, ("pairs.csv", TO), draw.other)
        }),
        of("a third of the points of another session", SESSION, |f, _| {
            moved_in_a_third(f, ("pairs.csv", TO), 0.4)
        }),
        of("a column copied over another", COPIED, |f, _| copied(f, ("pairs.csv", &TO[1..]))),
        of("a decimal point lost", POINT, |f, draw| {
            point_lost(f, ("pairs.csv", &["from_x_mm"]), draw.seed)
        }),
        of("a column of the other sign in a third of the rows", SIGN, |f, _| {
            scaled_in_a_third(f, ("pairs.csv", &TO[..1]), -1.0)
        }),
        of("a third of the rows in inches", UNIT, |f, _| {
            scaled_in_a_third(f, ("pairs.csv", TO), INCH)
        }),
        of("neighbours exchanged in a third of the rows", LABELS, |f, _| {
            neighbours_exchanged(f, ("pairs.csv", TO))
        }),
        of("a block pasted twice", COPIED, |f, _| pasted(f, ("pairs.csv", TO))),
        of("coordinates in increments", INCREMENTS, |f, _| in_increments(f, ("pairs.csv", TO))),
        of("a column rounded to a tenth", ROUNDED, |f, _| rounded(f, ("pairs.csv", &TO[..1]), 1)),
        of("a table sorted by its x", SESSION, |f, _| sorted(f, ("pairs.csv", TO))),
    ]
}

/// Poses of a flange.
pub(super) fn poses() -> Vec<Mistake> {
    const POSES: &str = "poses.csv";
    vec![
        of("positions in inches", UNIT, |f, _| scaled(f, (POSES, XYZ), INCH)),
        of("z in metres", UNIT, |f, _| scaled(f, (POSES, &["z_mm"]), 1e-3)),
        of("distances in inches", UNIT, |f, _| {
            scaled(f, ("distances.csv", &["distance_mm"]), INCH)
        }),
        of("x and y exchanged", EXCHANGED, |f, _| exchanged(f, (POSES, &XYZ[..2]))),
        of("y mirrored", SIGN, |f, _| scaled(f, (POSES, &["y_mm"]), -1.0)),
        of("scalar part last", EXCHANGED, |f, _| exchanged(f, (POSES, QUATERNION))),
        of("inverse orientations", SIGN, |f, _| scaled(f, (POSES, &QUATERNION[1..]), -1.0)),
        of("positions shifted by one", ROWS, |f, _| shifted(f, (POSES, XYZ))),
        of("places of two poses exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (POSES, &["place"]), draw.seed)
        }),
        of("positions of another session", SESSION, |f, draw| {
            of_another_session(f, (POSES, XYZ), draw.other)
        }),
    ]
}
