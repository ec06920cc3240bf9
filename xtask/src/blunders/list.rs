//! The mistakes that are made, by kind of case.

mod frames;
mod heads;
mod parts;
mod sensors;
mod trackers;

use super::tables::Files;

/// A mistake, and the words of which its name must have one.
pub(crate) struct Mistake {
    /// In words.
    pub(crate) what: &'static str,
    pub(crate) words: &'static [&'static str],
    /// Makes it; false where the case has no such thing.
    pub(crate) make: fn(&mut Files, &Draw<'_>) -> bool,
}

/// What a mistake is made from.
pub(crate) struct Draw<'f> {
    pub(crate) seed: u64,
    /// The same kind of case on another day.
    pub(crate) other: &'f Files,
}

const UNIT: &[&str] = &["input:unit", "in another unit"];
const EXCHANGED: &[&str] = &["exchanged"];
const SIGN: &[&str] = &["opposite sign", "reversed"];
const ROWS: &[&str] = &["input:row-shift", "are shifted one row"];
const REVERSED: &[&str] = &["input:row-shift", "in reverse order"];
const LABELS: &[&str] = &["labels"];
const CLIPS: &[&str] = &["input:saturation", "saturates"];
const STUCK: &[&str] = &["input:stuck", "is stuck", "are stuck"];
const CLOCK: &[&str] = &["input:clock", "the clock of"];
const GAIN: &[&str] = &["input:gain", "twice the reading"];
const DIAMETER: &[&str] = &["diameter"];
const DIAMETER_OR_HALF: &[&str] = &["diameter", "half of the radius"];
const SIDE: &[&str] = &["side", "opposite sign", "does not make a surface"];
const AXIS: &[&str] = &["does not fit `[axis] direction`", "another axis", "reversed"];
const NORMAL: &[&str] = &["input:normal", "inward"];
const COPIED: &[&str] = &["input:copied", "was copied"];
const ROUNDED: &[&str] = &["input:rounded"];
const INCREMENTS: &[&str] = &["input:increments", "each row a difference"];
const POINT: &[&str] = &["input:decimal-point", "decimal point"];
const SESSION: &[&str] = &["input:unmatched", "another session"];
const FROM: &[&str] = &["from_x_mm", "from_y_mm", "from_z_mm"];
const TO: &[&str] = &["to_x_mm", "to_y_mm", "to_z_mm"];
const QUATERNION: &[&str] = &["qw", "qx", "qy", "qz"];
const LENGTHS: &[&str] = &["l1_mm", "l2_mm", "l3_mm", "l4_mm"];
const CELLS: &[&str] = &["f1_n", "f2_n", "f3_n", "f4_n"];
const FORCES: &[&str] = &["fx_n", "fy_n", "fz_n"];
const MOMENTS: &[&str] = &["mx_nmm", "my_nmm", "mz_nmm"];
const MACHINE: &[&str] = &["machine_x_mm", "machine_y_mm"];
const XYZ: &[&str] = &["x_mm", "y_mm", "z_mm"];
const INCH: f64 = 1.0 / 25.4;
const RADIAN: f64 = std::f64::consts::PI / 180.0;
const POUND: f64 = 1.0 / 4.448_221_615_260_5;

const fn of(
    what: &'static str,
    words: &'static [&'static str],
    make: fn(&mut Files, &Draw<'_>) -> bool,
) -> Mistake {
    Mistake { what, words, make }
}

/// Mistakes in cases of a kind.
pub(crate) fn mistakes(kind: &str) -> Vec<Mistake> {
    match kind {
        "frame-fit" => frames::pairs(),
        "frame-fit poses" => frames::poses(),
        "ft-center" => sensors::presses(),
        "ft-center displacements" => sensors::displacements(),
        "ft-center gravity" => sensors::gravity(),
        "positioning" => sensors::positions(),
        "positioning deviations" => sensors::deviations(),
        "positioning rotary" => sensors::angles(),
        "force-impedance" => heads::log(),
        "force-impedance path" => heads::strokes(),
        "tracker-lm" => trackers::ranges(),
        "tracker-lm targets" => trackers::targets(),
        "pose-icp" => parts::part(parts::touched_points()),
        _ => parts::part(parts::touches()),
    }
}
