//! Mistakes in logs and strokes of a head.

use super::{
    CELLS, CLIPS, CLOCK, COPIED, DIAMETER, EXCHANGED, INCH, LABELS, LENGTHS, Mistake, POINT, POUND,
    REVERSED, ROWS, SESSION, SIGN, STUCK, UNIT, of,
};
use crate::blunders::tables::{
    averaged, blocks_exchanged, clipped, copied, exchanged, exchanged_at_end, half_up, late,
    of_another_session, on_another_clock, reversed_of_one, scaled, scaled_in_a_third,
    setting_scaled, setting_to, settings_exchanged, shifted, shifted_up, stuck,
};

pub(super) fn log() -> Vec<Mistake> {
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
        of("clock of the reference ahead", CLOCK, |f, draw| {
            on_another_clock(f, (LOG, "reference_n"), ([-0.06, 0.0, 0.0], draw.seed))
        }),
        of("clock of the reference late", CLOCK, |f, draw| {
            on_another_clock(f, (LOG, "reference_n"), ([0.25, 0.0, 0.0], draw.seed))
        }),
        of("clock of the reference fast", CLOCK, |f, draw| {
            on_another_clock(f, (LOG, "reference_n"), ([0.0, 0.004, 0.0], draw.seed))
        }),
        of("clock of the reference jitters", CLOCK, |f, draw| {
            on_another_clock(f, (LOG, "reference_n"), ([0.0, 0.0, 0.03], draw.seed))
        }),
        of("reference one row early", &["input:row-shift", "input:clock"], |f, _| {
            shifted_up(f, (LOG, &["reference_n"]))
        }),
        of("f4 one row down", ROWS, |f, _| shifted(f, (LOG, &["f4_n"]))),
        of("references of two strips exchanged", LABELS, |f, draw| {
            blocks_exchanged(f, (LOG, "segment", &["reference_n"]), draw.seed)
        }),
        of("l1 in inches", UNIT, |f, _| scaled(f, (LOG, &["l1_mm"]), INCH)),
        of("lengths in metres", UNIT, |f, _| scaled(f, (LOG, LENGTHS), 1e-3)),
        of("cells in lbf", UNIT, |f, _| scaled(f, (LOG, CELLS), POUND)),
        of("sign of f2", SIGN, |f, _| scaled(f, (LOG, &["f2_n"]), -1.0)),
        of("nx and nz exchanged", EXCHANGED, |f, _| exchanged(f, (LOG, &["nx", "nz"]))),
        of("reference clips", CLIPS, |f, _| clipped(f, (LOG, &["reference_n"]), 0.8)),
        of("reference is stuck", STUCK, |f, _| stuck(f, (LOG, &["reference_n"]), 0.5)),
        of("l4 is stuck", STUCK, |f, _| stuck(f, (LOG, &["l4_mm"]), 0.5)),
        of("diameter of the bracket for its radius", DIAMETER, |f, _| {
            setting_scaled(f, "bracket_radius_mm", 2.0)
        }),
        of("weight of the head in kg", UNIT, |f, _| setting_scaled(f, "weight_n", 1.0 / 9.806_65)),
        of("reference of another session", SESSION, |f, draw| {
            of_another_session(f, (LOG, &["reference_n"]), draw.other)
        }),
        of("cells of another session", SESSION, |f, draw| {
            of_another_session(f, (LOG, CELLS), draw.other)
        }),
        of("f1 of the other sign in a third of the rows", SIGN, |f, _| {
            scaled_in_a_third(f, (LOG, &CELLS[..1]), -1.0)
        }),
        of("half of the reference five rows early", ROWS, |f, _| {
            half_up(f, (LOG, &["reference_n"]), 5)
        }),
        of("mean of every strip for the reference", STUCK, |f, _| {
            averaged(f, (LOG, "segment", "reference_n"))
        }),
        of("f2 twelve samples late", ROWS, |f, _| late(f, (LOG, &["f2_n"]), 12)),
        of("the reference on another range in a third of the rows", POINT, |f, _| {
            scaled_in_a_third(f, (LOG, &["reference_n"]), 0.1)
        }),
        of("radii of head and bracket exchanged", EXCHANGED, |f, _| {
            settings_exchanged(f, ["head_radius_mm", "bracket_radius_mm"])
        }),
        of("f1 and f3 exchanged in the last two fifths", EXCHANGED, |f, _| {
            exchanged_at_end(f, (LOG, &["f1_n", "f3_n"]))
        }),
        of("f1 copied over f3", COPIED, |f, _| copied(f, (LOG, &["f1_n", "f3_n"]))),
        of("legs numbered one further", EXCHANGED, |f, _| {
            setting_to(f, "leg_angles_deg", "[210.0, 330.0, 90.0]")
        }),
    ]
}

/// Strokes along a path.
pub(super) fn strokes() -> Vec<Mistake> {
    const PATH: &str = "path.csv";
    vec![
        of("force in lbf", UNIT, |f, _| scaled(f, (PATH, &["force_n"]), POUND)),
        of("reference in kgf", UNIT, |f, _| scaled(f, (PATH, &["reference_n"]), 1.0 / 9.806_65)),
        of("sign of the force", SIGN, |f, _| scaled(f, (PATH, &["force_n"]), -1.0)),
        of("path and force exchanged", EXCHANGED, |f, _| {
            exchanged(f, (PATH, &["path_mm", "force_n"]))
        }),
        of("references of two strokes exchanged", LABELS, |f, draw| {
            blocks_exchanged(f, (PATH, "run", &["reference_n"]), draw.seed)
        }),
        of("force of one stroke upside down", REVERSED, |f, draw| {
            reversed_of_one(f, (PATH, ["run", "force_n"]), draw.seed)
        }),
        of("force clips", CLIPS, |f, _| clipped(f, (PATH, &["force_n"]), 0.75)),
        of("force is stuck", STUCK, |f, _| stuck(f, (PATH, &["force_n"]), 0.5)),
    ]
}
