use std::f64::consts::TAU;
use std::fmt::Write as _;

use nalgebra::{Affine3, Isometry3, Point3, Vector3, convert};

use super::block::{Piece, pieces};
use super::error::{ProgramError, Refused};
use super::modal::{Coordinates, Modal, Motion, known};
use crate::PoseStart;

/// How a corrected program is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramOptions {
    /// Chords that take the place of arcs stay this close to them.
    pub chord_mm: f64,
    /// Decimals of the coordinates written.
    pub decimals: usize,
}

impl Default for ProgramOptions {
    /// Chords to 1 µm, four decimals: below what a machine resolves.
    fn default() -> Self {
        Self { chord_mm: 1e-3, decimals: 4 }
    }
}

/// What takes machine coordinates of the planned part to those of the part as it lies.
#[must_use]
pub fn machine_correction(planned: &PoseStart, found: &PoseStart) -> Isometry3<f64> {
    found.machine_from_workpiece() * planned.machine_from_workpiece().inverse()
}

/// Moves the points of a path.
#[must_use]
pub fn correct_points(correction: &Isometry3<f64>, points_mm: &[Point3<f64>]) -> Vec<Point3<f64>> {
    points_mm.iter().map(|p| correction * p).collect()
}

/// Most decimals that a coordinate may have.
const MOST_DECIMALS: usize = 9;
/// Most chords of one arc.
const MOST_CHORDS: f64 = 1e5;
/// Largest corrected coordinate, in mm: a kilometre is beyond any machine.
const MOST_MM: f64 = 1e6;
/// Share of its radius by which an arc's end may miss: controllers allow some 0.1 %.
const ARC_MISS: f64 = 2e-3;
/// Ends of an arc closer than this share of its radius make a full circle.
const FULL_CIRCLE: f64 = 1e-9;

/// Moves every G0, G1, G2, G3 and G38.2 to G38.5 of a program; comments and all other words stay.
///
/// A tilt takes arcs out of their plane, so they become chords, whose G1 stands in the first one.
/// Moves are read absolute (G90) or incremental (G91), centres as G90.1 or G91.1 say, lengths in
/// mm (G21, the default) or inches (G20).
///
/// # Errors
///
/// [`ProgramError::Line`] with the first line that cannot be corrected: canned cycles, rotary
/// axes, cutter compensation, offsets by program, macros, and moves before X, Y and Z are known: a
/// touch (G38.2 to G38.5) ends anywhere, and what it moved has to be given again.
pub fn correct_program(
    program: &str,
    correction: &Isometry3<f64>,
    options: &ProgramOptions,
) -> Result<String, ProgramError> {
    correct_program_for_machine(program, &convert(*correction), options)
}

/// As [`correct_program`], for a machine whose axes are long or out of square: `correction` takes a
/// planned point to where the machine reads the real one.
///
/// # Errors
///
/// As [`correct_program`].
pub fn correct_program_for_machine(
    program: &str,
    correction: &Affine3<f64>,
    options: &ProgramOptions,
) -> Result<String, ProgramError> {
    Ok(read(program, correction, options)?.0)
}

/// A point to which a program moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramPoint {
    /// Line of the program, from 1.
    pub line: usize,
    /// Where it goes.
    pub point_mm: Point3<f64>,
    /// Whether it goes there in feed (G1, G2, G3), and not rapidly or to touch.
    pub in_feed: bool,
}

/// Points to which a program moves, in its own coordinates; of arcs, those of its chords.
///
/// # Errors
///
/// As [`correct_program`].
pub fn program_points(
    program: &str,
    options: &ProgramOptions,
) -> Result<Vec<ProgramPoint>, ProgramError> {
    Ok(read(program, &Affine3::identity(), options)?.1)
}

/// The corrected program, and the points of the planned one.
fn read(
    program: &str,
    correction: &Affine3<f64>,
    options: &ProgramOptions,
) -> Result<(String, Vec<ProgramPoint>), ProgramError> {
    let chord_mm = options.chord_mm;
    if chord_mm.is_nan() || chord_mm <= 0.0 || chord_mm.is_infinite() {
        let (name, needed) = ("chord tolerance", "positive");
        return Err(ProgramError::InvalidOption { name, needed, value: chord_mm });
    }
    if options.decimals > MOST_DECIMALS {
        let (name, needed) = ("number of decimals", "at most 9");
        #[expect(clippy::cast_precision_loss, reason = "a number for a message")]
        let value = options.decimals as f64;
        return Err(ProgramError::InvalidOption { name, needed, value });
    }
    let modal = Modal::default();
    let mut writer = Writer { correction, options, modal, written: None, points: Vec::new() };
    let mut out = String::with_capacity(2 * program.len());
    for (index, line) in program.split_inclusive('\n').enumerate() {
        let body = line.trim_end_matches(['\n', '\r']);
        let end = &line[body.len()..];
        let refused = |reason| ProgramError::Line { line: index + 1, reason };
        let known = writer.points.len();
        writer.line(body, end, &mut out).map_err(refused)?;
        writer.points[known..].iter_mut().for_each(|point| point.line = index + 1);
    }
    Ok((out, writer.points))
}

struct Writer<'a> {
    correction: &'a Affine3<f64>,
    options: &'a ProgramOptions,
    modal: Modal,
    /// Corrected position that the words written so far lead to, in the program's unit.
    written: Option<Vector3<f64>>,
    points: Vec<ProgramPoint>,
}

impl Writer<'_> {
    fn line(&mut self, body: &str, end: &str, out: &mut String) -> Result<(), Refused> {
        let pieces = pieces(body)?;
        let unit_before = self.modal.mm_per_unit;
        let coordinates = self.modal.take(&pieces)?;
        self.convert_units(unit_before);
        if !coordinates.moves(self.modal.motion) {
            out.push_str(body);
            out.push_str(end);
            return Ok(());
        }
        let motion = self.modal.motion.ok_or(Refused::NoMotion)?;
        let from = known(self.modal.position);
        let target = self.modal.target(&coordinates);
        let to = known(target).ok_or(Refused::UnknownPosition)?;
        let path = if motion.is_arc() {
            self.chords(motion, &coordinates, from.ok_or(Refused::UnknownPosition)?, to)?
        } else {
            vec![to]
        };
        for (k, point) in path.iter().enumerate() {
            let point_mm = Point3::from(point * self.modal.mm_per_unit);
            let in_feed = motion.is_arc() || motion == Motion::Linear;
            self.points.push(ProgramPoint { line: 0, point_mm, in_feed });
            let words = self.words(point)?;
            if k == 0 {
                rewrite(&pieces, motion.is_arc(), &words, out);
            } else {
                out.push_str(&words);
            }
            out.push_str(if end.is_empty() && k + 1 < path.len() { "\n" } else { end });
        }
        if motion.is_arc() {
            // The arcs were written as lines, and the next block may rely on the motion in force.
            self.modal.motion = Some(motion);
        }
        if motion == Motion::Probing {
            // A touch ends anywhere on its way: of what it moves, nothing is known then.
            let before = self.modal.position;
            self.modal.position =
                std::array::from_fn(|k| target[k].filter(|_| before[k] == target[k]));
            self.written = self.written.filter(|_| known(self.modal.position).is_some());
        } else {
            self.modal.position = target;
        }
        Ok(())
    }

    fn convert_units(&mut self, before: f64) {
        let factor = before / self.modal.mm_per_unit;
        for axis in self.modal.position.iter_mut().flatten() {
            *axis *= factor;
        }
        self.written = self.written.map(|w| w * factor);
    }

    /// Words of the corrected point, absolute or as a step from what was written before.
    fn words(&mut self, planned: &Vector3<f64>) -> Result<String, Refused> {
        let unit = self.modal.mm_per_unit;
        let corrected_mm = (self.correction * Point3::from(planned * unit)).coords;
        for (axis, &value) in ['X', 'Y', 'Z'].into_iter().zip(corrected_mm.iter()) {
            if value.is_nan() || value.abs() > MOST_MM {
                return Err(Refused::TooFar { axis, value, limit: MOST_MM });
            }
        }
        let corrected = corrected_mm / unit;
        let from = match self.written {
            Some(written) if self.modal.is_incremental => written,
            _ => Vector3::zeros(),
        };
        let mut text = String::new();
        let mut reached = from;
        let scale = 10.0_f64.powi(i32::try_from(self.options.decimals).unwrap_or(0));
        for (k, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            // Steps are taken from where rounding left the one before, so that none adds up.
            let step = ((corrected[k] - from[k]) * scale).round() / scale + 0.0;
            reached[k] += step;
            let blank = if k == 0 { "" } else { " " };
            let _ = write!(text, "{blank}{name}{step:.*}", self.options.decimals);
        }
        self.written = Some(reached);
        Ok(text)
    }

    /// Points along an arc, its end last.
    fn chords(
        &self,
        motion: Motion,
        coordinates: &Coordinates,
        from: Vector3<f64>,
        to: Vector3<f64>,
    ) -> Result<Vec<Vector3<f64>>, Refused> {
        let across = self.modal.across;
        // Right-handed axes of the plane: XY, ZX, YZ.
        let (first, second) = ((across + 1) % 3, (across + 2) % 3);
        let flat = |p: &Vector3<f64>| [p[first], p[second]];
        let sign = if motion == Motion::Clockwise { -1.0 } else { 1.0 };
        let (a, b) = (flat(&from), flat(&to));
        let center = match coordinates.radius {
            Some(radius) => center_of(a, b, radius, sign).ok_or(Refused::NoCenter)?,
            None => self.center(coordinates, [first, second], a)?,
        };
        let arm = |p: [f64; 2]| [p[0] - center[0], p[1] - center[1]];
        let (start, end) = (arm(a), arm(b));
        let (radius, reach) = (start[0].hypot(start[1]), end[0].hypot(end[1]));
        if radius.is_nan() || radius <= 0.0 || (radius - reach).abs() > ARC_MISS * radius {
            return Err(Refused::Arc { start: radius, end: reach });
        }
        let angle = start[1].atan2(start[0]);
        let mut sweep = (sign * (end[1].atan2(end[0]) - angle)).rem_euclid(TAU);
        if (b[0] - a[0]).hypot(b[1] - a[1]) <= FULL_CIRCLE * radius {
            sweep = TAU;
        }
        // A chord over the angle θ is r (1 − cos θ/2) from its arc.
        let sagitta = (self.options.chord_mm / self.modal.mm_per_unit / radius).min(1.0);
        let widest = 2.0 * (1.0 - sagitta).acos();
        let count = (sweep / widest).ceil().max(1.0);
        if count.is_nan() || count > MOST_CHORDS {
            return Err(Refused::TooManyChords { limit: MOST_CHORDS });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1e5")]
        let n = count as usize;
        let mut path = Vec::with_capacity(n);
        for k in 1..n {
            #[expect(clippy::cast_precision_loss, reason = "at most 1e5")]
            let share = k as f64 / count;
            let (sin, cos) = (angle + sign * sweep * share).sin_cos();
            let size = radius + (reach - radius) * share;
            let mut point = from + (to - from) * share;
            point[first] = center[0] + size * cos;
            point[second] = center[1] + size * sin;
            path.push(point);
        }
        path.push(to);
        Ok(path)
    }

    fn center(
        &self,
        coordinates: &Coordinates,
        axes: [usize; 2],
        from: [f64; 2],
    ) -> Result<[f64; 2], Refused> {
        let given = axes.map(|axis| coordinates.center[axis]);
        if given.iter().all(Option::is_none) {
            return Err(Refused::NoCenter);
        }
        Ok(std::array::from_fn(|k| match given[k] {
            Some(at) if self.modal.has_absolute_centers => at,
            Some(offset) => from[k] + offset,
            None => from[k],
        }))
    }
}

/// Centre of an arc of a given radius; a negative one takes the long way round.
fn center_of(a: [f64; 2], b: [f64; 2], radius: f64, sign: f64) -> Option<[f64; 2]> {
    let chord = [b[0] - a[0], b[1] - a[1]];
    let length = chord[0].hypot(chord[1]);
    let height2 = radius * radius - 0.25 * length * length;
    // An arc over its diameter may miss by rounding of its words.
    let rounding = ARC_MISS * radius * radius;
    if length == 0.0 || height2 < -rounding {
        return None;
    }
    let height = height2.max(0.0).sqrt() * sign * radius.signum();
    Some([
        0.5 * (a[0] + b[0]) - height * chord[1] / length,
        0.5 * (a[1] + b[1]) + height * chord[0] / length,
    ])
}

/// Writes a block with new coordinates in the place of its first old ones.
fn rewrite(pieces: &[Piece<'_>], is_arc: bool, words: &str, out: &mut String) {
    let is_coordinate = |letter: char| "XYZ".contains(letter) || is_arc && "IJKR".contains(letter);
    let mut is_written = false;
    let mut skip_blank = false;
    let mut has_linear = false;
    for piece in pieces {
        match *piece {
            Piece::Word { letter, .. } if is_coordinate(letter) => {
                if is_written {
                    skip_blank = true;
                } else {
                    // The motion in force may be an arc's: the chord says its own.
                    out.push_str(if is_arc && !has_linear { "G1 " } else { "" });
                    out.push_str(words);
                    is_written = true;
                }
            }
            Piece::Word { letter: 'G', value, .. } if is_arc && is_arc_code(value) => {
                out.push_str("G1");
                has_linear = true;
            }
            Piece::Word { text, .. } => {
                skip_blank = false;
                out.push_str(text);
            }
            Piece::Kept(text) => {
                if skip_blank && text.trim().is_empty() {
                    continue;
                }
                out.push_str(text);
            }
        }
    }
}

fn is_arc_code(code: f64) -> bool {
    (code - 2.0).abs() < 0.05 || (code - 3.0).abs() < 0.05
}
