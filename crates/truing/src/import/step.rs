use std::fmt::Write as _;
use std::path::Path;

use geometry::{Plane, Sphere};

use super::probe_log::ProbeLogKind;
use crate::Error;
use crate::case::faces_down;
use crate::step::{StepFace, StepFaces, StepNet, StepProblem, StepSurface, read_step};

/// Which face of a STEP file becomes the part of a case, and of which case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepImport {
    /// Number of the face in the order of the file, from 1; `None` where there is only one.
    pub face: Option<usize>,
    /// Kind of the case.
    pub kind: ProbeLogKind,
    /// Radius of the ball.
    pub tip_radius_mm: f64,
}

/// A face as files of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedFace {
    /// What the face lies on.
    pub words: String,
    /// `[surface]` and `side`, as they stand in `case.toml`.
    pub surface: String,
    /// `case.toml`.
    pub case: (&'static str, String),
    /// Control points; `None` for a shape that has none.
    pub control: Option<(&'static str, String)>,
    /// What is not as one might think.
    pub notes: Vec<String>,
}

/// Makes a case of a face of a STEP file: the whole surface that the face lies on, in mm and in the
/// coordinates of its part, touched from the side to which the part is not.
///
/// # Errors
///
/// [`Error::NotRead`], [`Error::Step`].
pub fn import_step(path: &Path, import: &StepImport) -> Result<ImportedFace, Error> {
    let step = read_step(path)?;
    let fail = |problem| Error::Step { path: path.to_owned(), problem: Box::new(problem) };
    let (number, face) = chosen(&step.faces, import.face).map_err(fail)?;
    let surface = face.surface.as_ref().map_err(|problem| fail(problem.clone()))?;
    let drawn = drawn(number, face, surface).map_err(fail)?;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let name = name.escape_debug();
    let origin = format!(
        "# Face {number} (#{}, line {}) of {name}, sha256 {}:\n# {face}.\n",
        face.id, face.line, step.input.sha256
    );
    let (kind, purpose) = match import.kind {
        ProbeLogKind::ProbeComp => ("probe-comp", "touches.csv"),
        ProbeLogKind::PoseIcp => ("pose-icp", "points.csv"),
    };
    let Drawn { shape, side, control } = drawn;
    let side = side.map_or_else(String::new, |side| format!("side = \"{side}\"\n"));
    let case = format!(
        "{origin}# The whole surface behind the face; where the face ends is not known here.\n\
         kind = \"{kind}\"\n\n{shape}\n[probe]\ntip_radius_mm = {}\n{side}\n\
         # Touches in the part's own coordinates belong into {purpose}.\n",
        import.tip_radius_mm
    );
    let surface_keys = format!("{shape}[probe]\n{side}");
    Ok(ImportedFace {
        words: face.to_string(),
        surface: surface_keys,
        case: ("case.toml", case),
        control: control.map(|table| ("control.csv", format!("{origin}{table}"))),
        notes: notes(&step, face),
    })
}

fn chosen(faces: &[StepFace], asked: Option<usize>) -> Result<(usize, &StepFace), StepProblem> {
    let n_faces = faces.len();
    match (asked, faces) {
        (None, [only]) => Ok((1, only)),
        (None, _) => Err(StepProblem::WhichFace { n_faces }),
        (Some(asked), _) => {
            let face = asked.checked_sub(1).and_then(|index| faces.get(index));
            face.map(|face| (asked, face)).ok_or(StepProblem::NoSuchFace { asked, n_faces })
        }
    }
}

fn notes(step: &StepFaces, face: &StepFace) -> Vec<String> {
    let mut notes = Vec::new();
    if step.is_assembly {
        notes.push(
            "the file places its parts in an assembly; the face is in the coordinates of its own part"
                .to_owned(),
        );
    }
    if !face.is_of_solid {
        notes.push(
            "the face is of no solid, so that the file does not say on which side the part is: see \
             that `side` is the one that is touched"
                .to_owned(),
        );
    }
    notes
}

/// A surface as a case has it.
struct Drawn {
    /// `[surface]`.
    shape: String,
    side: Option<&'static str>,
    /// Table of control points.
    control: Option<String>,
}

fn drawn(number: usize, face: &StepFace, surface: &StepSurface) -> Result<Drawn, StepProblem> {
    let (id, line) = (face.id, face.line);
    let refused = |source| StepProblem::Surface { line, id, source };
    match surface {
        StepSurface::Net(net) => net_drawn(net, face.is_reversed),
        StepSurface::Plane { point_mm, normal } => {
            let out = if face.is_reversed { -normal.into_inner() } else { normal.into_inner() };
            let [x, y, z] = [point_mm.x, point_mm.y, point_mm.z].map(unsigned);
            let [nx, ny, nz] = [out.x, out.y, out.z].map(unsigned);
            Plane::new(*point_mm, out).map_err(refused)?;
            let shape = format!(
                "[surface]\nshape = \"plane\"\npoint_mm = [{x:?}, {y:?}, {z:?}]\n\
                 normal = [{nx:?}, {ny:?}, {nz:?}]\n"
            );
            Ok(Drawn { shape, side: Some("+z"), control: None })
        }
        StepSurface::Sphere { center_mm, radius_mm } => {
            Sphere::new(*center_mm, *radius_mm).map_err(refused)?;
            let [x, y, z] = [center_mm.x, center_mm.y, center_mm.z].map(unsigned);
            let side = if face.is_reversed { "inside" } else { "outside" };
            let shape = format!(
                "[surface]\nshape = \"sphere\"\nradius_mm = {radius_mm:?}\n\
                 center_mm = [{x:?}, {y:?}, {z:?}]\nside = \"{side}\"\n"
            );
            Ok(Drawn { shape, side: None, control: None })
        }
        _ => Err(StepProblem::NoShape { line, number, words: surface.to_string() }),
    }
}

/// A B-spline with its normal out of the part.
fn net_drawn(net: &StepNet, is_reversed: bool) -> Result<Drawn, StepProblem> {
    let flipped;
    let out = if is_reversed {
        flipped = net.flipped();
        &flipped
    } else {
        net
    };
    let (id, line) = (net.id, net.line);
    let nurbs = out.nurbs().map_err(|source| StepProblem::Surface { line, id, source })?;
    // A case turns every surface up; the side is then the one to which the part is not.
    let side = if faces_down(&nurbs) { "-z" } else { "+z" };
    let [u, v] = out.degrees;
    let mut shape = format!("[surface]\nshape = \"nurbs\"\ndegree = [{u}, {v}]\n");
    for (name, knots) in ["knots_u", "knots_v"].into_iter().zip(&out.knots) {
        let lines: Vec<String> = knots.chunks(PER_LINE).map(row).collect();
        let _ = writeln!(shape, "{name} = [\n    {},\n]", lines.join(",\n    "));
    }
    let is_rational = out.is_rational();
    let mut table = "i,j,x_mm,y_mm,z_mm".to_owned();
    table.push_str(if is_rational { ",weight\n" } else { "\n" });
    for (index, (point, weight)) in out.points_mm.iter().zip(&out.weights).enumerate() {
        let (i, j) = (index % out.counts[0] + 1, index / out.counts[0] + 1);
        let [x, y, z] = [point.x, point.y, point.z].map(unsigned);
        let _ = write!(table, "{i},{j},{x},{y},{z}");
        if is_rational {
            let _ = write!(table, ",{weight}");
        }
        table.push('\n');
    }
    Ok(Drawn { shape, side: Some(side), control: Some(table) })
}

/// Knots on a line.
const PER_LINE: usize = 10;

fn row(knots: &[f64]) -> String {
    knots.iter().map(|knot| format!("{:?}", unsigned(*knot))).collect::<Vec<_>>().join(", ")
}

/// A zero without a sign.
fn unsigned(value: f64) -> f64 {
    value + 0.0
}
