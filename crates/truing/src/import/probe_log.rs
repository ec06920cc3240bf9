use std::fmt::Write as _;
use std::path::Path;

use crate::Error;
use crate::case::{Location, Problem, quote};
use crate::file::{MAX_BYTES, read_text};

/// Numbers of a line of a LinuxCNC probe log: X Y Z A B C U V W.
const PER_LINE: usize = 9;
/// Coordinates from this magnitude on are slips.
const MAX_MM: f64 = 1e9;

/// What is asked of the touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProbeLogKind {
    /// How far the part is off: a case of kind `probe-comp`.
    #[default]
    ProbeComp,
    /// Where the part lies: a case of kind `pose-icp`.
    PoseIcp,
}

/// What a probe log does not say of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeLogSettings {
    /// Kind of the case.
    pub kind: ProbeLogKind,
    /// Feed towards the part, where it was the same for every touch.
    pub feed_mm_per_min: Option<f64>,
    /// Radius of the ball.
    pub tip_radius_mm: f64,
    /// Length of the log's unit.
    pub unit_mm: f64,
}

/// Touches of a probe log, and the files of a case that holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedTouches {
    /// Touches found.
    pub n_touches: usize,
    /// Name and text of each file.
    pub files: Vec<(&'static str, String)>,
}

/// Reads the log that LinuxCNC writes between `(PROBEOPEN file)` and `(PROBECLOSE)`.
///
/// Each line holds the nine axis positions of a trigger, X Y Z A B C U V W, in the units of the
/// program and the coordinate system that was active; the ball's centre is X Y Z.
///
/// # Errors
///
/// [`Error::NotRead`]; [`Error::Case`] with the line that is no such record.
pub fn import_probe_log(
    path: &Path,
    settings: &ProbeLogSettings,
) -> Result<ImportedTouches, Error> {
    let centers = centers_mm(path, settings.unit_mm)?;
    let (file, name, letter) = match settings.kind {
        ProbeLogKind::ProbeComp => ("touches.csv", "touch", 'T'),
        ProbeLogKind::PoseIcp => ("points.csv", "point", 'P'),
    };
    let mut table = format!("{name},x_mm,y_mm,z_mm");
    table.push_str(if settings.feed_mm_per_min.is_some() { ",feed_mm_per_min\n" } else { "\n" });
    for (n, [x, y, z]) in (1..).zip(&centers) {
        let _ = write!(table, "{letter}{n},{x},{y},{z}");
        if let Some(feed) = settings.feed_mm_per_min {
            let _ = write!(table, ",{feed}");
        }
        table.push('\n');
    }
    let case = case_toml(settings);
    Ok(ImportedTouches {
        n_touches: centers.len(),
        files: vec![("case.toml", case), (file, table)],
    })
}

/// Centres of the ball in a log, of which there is one at least.
pub(super) fn centers_mm(path: &Path, unit_mm: f64) -> Result<Vec<[f64; 3]>, Error> {
    let text = read_text(path, MAX_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    let mut centers = Vec::new();
    for (line, record) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let center = center(record).map_err(|message| wrong(path, line + 1, message))?;
        centers.push(center.map(|v| v * unit_mm));
    }
    if centers.is_empty() {
        let message = "the log holds no touches; LinuxCNC writes one line per G38.n between \
                       (PROBEOPEN file) and (PROBECLOSE)";
        let problem = Problem::WrongValue { message: message.to_owned() };
        return Err(Error::case(Location::file(path), problem));
    }
    Ok(centers)
}

/// X, Y and Z of a record.
fn center(record: &str) -> Result<[f64; 3], String> {
    let words: Vec<&str> = record.split_whitespace().collect();
    if words.len() != PER_LINE {
        let found = words.len();
        return Err(format!(
            "expected the {PER_LINE} numbers X Y Z A B C U V W of a LinuxCNC probe log, found {found}"
        ));
    }
    let mut numbers = [0.0; PER_LINE];
    for (number, word) in numbers.iter_mut().zip(&words) {
        *number = (word.parse::<f64>().ok())
            .filter(|v| v.abs() < MAX_MM)
            .ok_or_else(|| format!("expected a number below {MAX_MM:e}, found {}", quote(word)))?;
    }
    Ok([numbers[0], numbers[1], numbers[2]])
}

fn wrong(path: &Path, line: usize, message: String) -> Error {
    Error::case(Location::file(path).line(line), Problem::WrongValue { message })
}

fn case_toml(settings: &ProbeLogSettings) -> String {
    let tip_radius_mm = settings.tip_radius_mm;
    let (kind, purpose, frame, shapes) = match settings.kind {
        ProbeLogKind::ProbeComp => (
            "probe-comp",
            "where each is, and how far the part is off there",
            "in the coordinate system in which it was probed",
            "# plane (point_mm, normal), sphere (radius_mm, center_mm, side), asphere (radius_mm, conic,\n\
             # coefficients, diameter_mm), polynomial (unit_mm, terms), mesh (file).\n\
             [surface]\nshape = \"plane\"\n",
        ),
        ProbeLogKind::PoseIcp => (
            "pose-icp",
            "where the part lies",
            "in coordinates of its own",
            "# asphere (radius_mm, conic, coefficients, diameter_mm), polynomial (unit_mm, terms), mesh (file).\n\
             [surface]\nshape = \"mesh\"\nfile = \"part.stl\"\n",
        ),
    };
    format!(
        "# Touches of a LinuxCNC probe log: {purpose}.\n\
         kind = \"{kind}\"\n\n\
         # The part as drawn, {frame}: write its shape here.\n\
         {shapes}\n[probe]\ntip_radius_mm = {tip_radius_mm}\n"
    )
}
