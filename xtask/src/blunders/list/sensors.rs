//! Mistakes in presses, hanging tools and runs of an axis.

use super::{
    CLIPS, COPIED, EXCHANGED, FORCES, INCH, INCREMENTS, LABELS, MACHINE, MOMENTS, Mistake, POUND,
    QUATERNION, RADIAN, ROUNDED, ROWS, SESSION, SIDE, SIGN, STUCK, UNIT, of,
};
use crate::blunders::tables::{
    clipped, copied, end_shifted, exchanged, in_increments, of_another_machine, of_another_session,
    pasted, rounded, rows_exchanged, scaled, scaled_in_a_third, scaled_of_one, setting_scaled,
    shifted, stuck,
};

pub(super) fn presses() -> Vec<Mistake> {
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
        of("two presses exchanged", LABELS, |f, draw| {
            rows_exchanged(f, ("presses.csv", MACHINE), draw.seed)
        }),
        of("rows of presses shifted", ROWS, |f, _| shifted(f, ("presses.csv", MACHINE))),
        of("positions shifted from two fifths on", ROWS, |f, _| {
            end_shifted(f, ("presses.csv", MACHINE))
        }),
        of("mx clips", CLIPS, |f, _| clipped(f, (WRENCH, &["mx_nmm"]), 0.85)),
        of("sign of fz", SIGN, |f, _| scaled(f, (WRENCH, &["fz_n"]), -1.0)),
        of("x of the machine mirrored", SIGN, |f, _| {
            scaled(f, ("presses.csv", &["machine_x_mm"]), -1.0)
        }),
        of("contact plane on the other side", SIDE, |f, _| setting_scaled(f, "z0_mm", -1.0)),
        of("contact plane in inches", UNIT, |f, _| setting_scaled(f, "z0_mm", INCH)),
        of("my is stuck", STUCK, |f, _| stuck(f, (WRENCH, &["my_nmm"]), 0.5)),
        of("fz clips", CLIPS, |f, _| clipped(f, (WRENCH, &["fz_n"]), 0.8)),
        of("wrenches of another session", SESSION, |f, draw| {
            of_another_session(f, (WRENCH, &[FORCES, MOMENTS].concat()), draw.other)
        }),
        of("mx copied over my", COPIED, |f, _| copied(f, (WRENCH, &MOMENTS[..2]))),
        of("a third of the positions in inches", UNIT, |f, _| {
            scaled_in_a_third(f, ("presses.csv", MACHINE), INCH)
        }),
        of("positions pasted twice", COPIED, |f, _| pasted(f, ("presses.csv", MACHINE))),
        of("positions in increments", INCREMENTS, |f, _| {
            in_increments(f, ("presses.csv", MACHINE))
        }),
        of("positions rounded to a millimetre", ROUNDED, |f, _| {
            rounded(f, ("presses.csv", MACHINE), 0)
        }),
    ]
}

/// Displacements of an axis.
pub(super) fn displacements() -> Vec<Mistake> {
    const TABLE: &str = "displacements.csv";
    vec![
        of("solved in inches", UNIT, |f, _| scaled(f, (TABLE, &["solved_mm"]), INCH)),
        of("commanded in metres", UNIT, |f, _| scaled(f, (TABLE, &["commanded_mm"]), 1e-3)),
        of("commanded and solved exchanged", EXCHANGED, |f, _| {
            exchanged(f, (TABLE, &["commanded_mm", "solved_mm"]))
        }),
        of("sign of the solved", SIGN, |f, _| scaled(f, (TABLE, &["solved_mm"]), -1.0)),
        of("rows shifted by one", ROWS, |f, _| shifted(f, (TABLE, &["solved_mm"]))),
        of("two rows exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (TABLE, &["solved_mm"]), draw.seed)
        }),
        of("commanded in increments", INCREMENTS, |f, _| {
            in_increments(f, (TABLE, &["commanded_mm"]))
        }),
        of("solved is stuck", STUCK, |f, _| stuck(f, (TABLE, &["solved_mm"]), 0.5)),
    ]
}

/// A tool that hangs free.
pub(super) fn gravity() -> Vec<Mistake> {
    const TABLE: &str = "gravity.csv";
    vec![
        // All forces in another unit are a lighter tool, as good as any.
        of("fz in lbf", UNIT, |f, _| scaled(f, (TABLE, &["fz_n"]), POUND)),
        of("mx in N·in", UNIT, |f, _| scaled(f, (TABLE, &["mx_nmm"]), INCH)),
        of("moments in N·m", UNIT, |f, _| scaled(f, (TABLE, MOMENTS), 1e-3)),
        of("mx and my exchanged", EXCHANGED, |f, _| exchanged(f, (TABLE, &MOMENTS[..2]))),
        of("fx and fy exchanged", EXCHANGED, |f, _| exchanged(f, (TABLE, &FORCES[..2]))),
        of("sign of fz", SIGN, |f, _| scaled(f, (TABLE, &["fz_n"]), -1.0)),
        of("forces on the tool for those on the sensor", SIGN, |f, _| {
            scaled(f, (TABLE, &[FORCES, MOMENTS].concat()), -1.0)
        }),
        of("scalar part last", EXCHANGED, |f, _| exchanged(f, (TABLE, QUATERNION))),
        of("inverse orientations", SIGN, |f, _| scaled(f, (TABLE, &QUATERNION[1..]), -1.0)),
        of("wrenches shifted by one", ROWS, |f, _| {
            shifted(f, (TABLE, &[FORCES, MOMENTS].concat()))
        }),
        of("two poses exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (TABLE, QUATERNION), draw.seed)
        }),
        of("mx is stuck", STUCK, |f, _| stuck(f, (TABLE, &["mx_nmm"]), 0.5)),
        of("wrenches of another session", SESSION, |f, draw| {
            of_another_session(f, (TABLE, &[FORCES, MOMENTS].concat()), draw.other)
        }),
    ]
}

/// An axis by ISO 230-2.
pub(super) fn positions() -> Vec<Mistake> {
    const TABLE: &str = "positions.csv";
    const BOTH: &[&str] = &["target_mm", "actual_mm"];
    vec![
        of("positions in inches", UNIT, |f, _| scaled(f, (TABLE, &BOTH[1..]), INCH)),
        of("targets in metres", UNIT, |f, _| scaled(f, (TABLE, &BOTH[..1]), 1e-3)),
        of("the table in metres", UNIT, |f, _| scaled(f, (TABLE, BOTH), 1e-3)),
        of("a reversed axis", SIGN, |f, _| scaled(f, (TABLE, &BOTH[1..]), -1.0)),
        of("directions of the other sign", SIGN, |f, _| scaled(f, (TABLE, &["direction"]), -1.0)),
        of("targets and positions exchanged", EXCHANGED, |f, _| exchanged(f, (TABLE, BOTH))),
        of("positions shifted by one", ROWS, |f, _| shifted(f, (TABLE, &BOTH[1..]))),
        of("two rows exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (TABLE, &BOTH[1..]), draw.seed)
        }),
        of("the reading is stuck", STUCK, |f, _| stuck(f, (TABLE, &BOTH[1..]), 0.5)),
        of("targets of another session", SESSION, |f, draw| {
            of_another_session(f, (TABLE, &BOTH[..1]), draw.other)
        }),
        of("a third of the positions in inches", UNIT, |f, _| {
            scaled_in_a_third(f, (TABLE, &BOTH[1..]), INCH)
        }),
        of("positions in increments", INCREMENTS, |f, _| in_increments(f, (TABLE, &BOTH[1..]))),
        of("positions of another machine at the end", SESSION, |f, _| {
            of_another_machine(f, (TABLE, BOTH), [-6e-4, 0.05])
        }),
        of("positions rounded to a tenth", ROUNDED, |f, _| rounded(f, (TABLE, &BOTH[1..]), 1)),
    ]
}

/// Deviations of an axis by ISO 230-2.
pub(super) fn deviations() -> Vec<Mistake> {
    const TABLE: &str = "positions.csv";
    const BOTH: &[&str] = &["target_mm", "deviation_mm"];
    vec![
        of("deviations in µm", UNIT, |f, _| scaled(f, (TABLE, &BOTH[1..]), 1e3)),
        of("one cycle of the other sign", SIGN, |f, draw| {
            scaled_of_one(f, (TABLE, ["cycle", "deviation_mm"]), (-1.0, draw.seed))
        }),
        of("one direction of the other sign", SIGN, |f, draw| {
            scaled_of_one(f, (TABLE, ["direction", "deviation_mm"]), (-1.0, draw.seed))
        }),
        of("directions of the other sign", SIGN, |f, _| scaled(f, (TABLE, &["direction"]), -1.0)),
        of("directions of one cycle of the other sign", SIGN, |f, draw| {
            scaled_of_one(f, (TABLE, ["cycle", "direction"]), (-1.0, draw.seed))
        }),
        of("the reading is stuck", STUCK, |f, _| stuck(f, (TABLE, &BOTH[1..]), 0.7)),
        of("the reading clips", CLIPS, |f, _| clipped(f, (TABLE, &BOTH[1..]), 0.6)),
        of("deviations of another machine at the end", SESSION, |f, _| {
            of_another_machine(f, (TABLE, BOTH), [-6e-4, 0.05])
        }),
    ]
}

/// A rotary axis by ISO 230-2.
pub(super) fn angles() -> Vec<Mistake> {
    const TABLE: &str = "positions.csv";
    const BOTH: &[&str] = &["target_deg", "actual_deg"];
    vec![
        of("positions in radians", UNIT, |f, _| scaled(f, (TABLE, &BOTH[1..]), RADIAN)),
        of("targets in radians", UNIT, |f, _| scaled(f, (TABLE, &BOTH[..1]), RADIAN)),
        of("a reversed axis", SIGN, |f, _| scaled(f, (TABLE, &BOTH[1..]), -1.0)),
        of("positions shifted by one", ROWS, |f, _| shifted(f, (TABLE, &BOTH[1..]))),
        of("two rows exchanged", LABELS, |f, draw| {
            rows_exchanged(f, (TABLE, &BOTH[1..]), draw.seed)
        }),
        of("the reading is stuck", STUCK, |f, _| stuck(f, (TABLE, &BOTH[1..]), 0.5)),
    ]
}
