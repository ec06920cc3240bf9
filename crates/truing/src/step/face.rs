//! Faces of the parts of a file, each with the side on which its part is.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::StepProblem;
use super::exchange::Exchange;
use super::shown::Shown;
use super::surface::StepSurface;

/// A face of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFace {
    /// Name of the part in the file; empty where it has none.
    pub part: String,
    /// Length of the unit in which the file has it.
    pub unit_mm: f64,
    /// Number of the entity in the file.
    pub id: u64,
    /// Its line in the file, from 1.
    pub line: usize,
    /// Whether the normal that points out of the part is opposite to that of the surface.
    pub is_reversed: bool,
    /// Whether it belongs to a solid; else no side of it is that of the part, and the normal is that
    /// of the face as drawn.
    pub is_of_solid: bool,
    /// What it lies on, all of it, however much of that the face is; or why it is not known.
    pub surface: Result<StepSurface, StepProblem>,
}

/// What has been found on the way through a file.
struct Walk<'e, 'a> {
    exchange: &'e Exchange<'a>,
    faces: Vec<StepFace>,
    seen: HashSet<u64>,
    /// Several faces may lie on one.
    surfaces: HashMap<u64, Result<StepSurface, StepProblem>>,
}

/// What all faces of a representation have in common.
#[derive(Clone, Copy)]
struct Body<'n> {
    part: &'n str,
    unit_mm: f64,
    is_of_solid: bool,
    is_reversed: bool,
}

impl Exchange<'_> {
    /// Every face of every representation, in the order of the file.
    pub(super) fn faces(&self) -> Result<Vec<StepFace>, StepProblem> {
        let (seen, surfaces) = (HashSet::new(), HashMap::new());
        let mut walk = Walk { exchange: self, faces: Vec::new(), seen, surfaces };
        for id in &self.representations {
            walk.representation(*id)?;
        }
        if walk.faces.is_empty() { Err(StepProblem::NoFaces) } else { Ok(walk.faces) }
    }
}

impl Walk<'_, '_> {
    fn representation(&mut self, id: u64) -> Result<(), StepProblem> {
        let entity = self.exchange.entity(id, id)?;
        let record = entity.record();
        // Others only join a representation to what it is one of.
        let (Ok(items), Ok(context)) = (record.references(1), record.reference(2)) else {
            return Ok(());
        };
        let mut unit_mm = None;
        for item in items {
            if !self.seen.insert(item) {
                continue;
            }
            let item = self.exchange.entity(item, id)?;
            let record = item.record();
            let is_of_solid = matches!(record.keyword, "MANIFOLD_SOLID_BREP" | "BREP_WITH_VOIDS");
            let shells = match record.keyword {
                "MANIFOLD_SOLID_BREP" => vec![record.reference(1)?],
                "BREP_WITH_VOIDS" => {
                    let mut shells = vec![record.reference(1)?];
                    shells.extend(record.references(2)?);
                    shells
                }
                "SHELL_BASED_SURFACE_MODEL" | "FACE_BASED_SURFACE_MODEL" => record.references(1)?,
                _ => continue,
            };
            let unit_mm = match unit_mm {
                Some(unit_mm) => unit_mm,
                None => *unit_mm.insert(self.exchange.unit_mm(context, id)?),
            };
            let part = entity.record().text(0);
            let body = Body { part: &part, unit_mm, is_of_solid, is_reversed: false };
            for shell in shells {
                self.shell(shell, item.id, body)?;
            }
        }
        Ok(())
    }

    /// Faces of a shell, which may be turned over.
    fn shell(&mut self, id: u64, by: u64, body: Body<'_>) -> Result<(), StepProblem> {
        let mut shell = self.exchange.entity(id, by)?;
        let mut body = body;
        if let "ORIENTED_CLOSED_SHELL" | "ORIENTED_OPEN_SHELL" = shell.record().keyword {
            body.is_reversed ^= !shell.record().is_true(3)?;
            shell = self.exchange.entity(shell.record().reference(2)?, id)?;
        }
        if !self.seen.insert(shell.id) {
            return Ok(());
        }
        for face in shell.record().references(1)? {
            self.face(face, shell.id, body)?;
        }
        Ok(())
    }

    fn face(&mut self, id: u64, by: u64, body: Body<'_>) -> Result<(), StepProblem> {
        let mut face = self.exchange.entity(id, by)?;
        let mut is_reversed = body.is_reversed;
        if face.record().keyword == "ORIENTED_FACE" {
            is_reversed ^= !face.record().is_true(3)?;
            face = self.exchange.entity(face.record().reference(2)?, id)?;
        }
        let record = face.record();
        if !matches!(record.keyword, "ADVANCED_FACE" | "FACE_SURFACE") || !self.seen.insert(face.id)
        {
            return Ok(());
        }
        is_reversed ^= !record.is_true(3)?;
        let surface = record.reference(2)?;
        let exchange = self.exchange;
        let known = self.surfaces.entry(surface);
        let surface = known.or_insert_with(|| exchange.surface(surface, face.id, body.unit_mm));
        self.faces.push(StepFace {
            part: body.part.to_owned(),
            unit_mm: body.unit_mm,
            id: face.id,
            line: face.line,
            is_reversed,
            is_of_solid: body.is_of_solid,
            surface: surface.clone(),
        });
        Ok(())
    }
}

impl fmt::Display for StepFace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.surface {
            Ok(surface @ StepSurface::Plane { normal, .. }) => {
                let out = if self.is_reversed { -normal.into_inner() } else { normal.into_inner() };
                write!(f, "{surface}, facing {}", Shown(&out))
            }
            Ok(surface @ (StepSurface::Sphere { .. } | StepSurface::Cylinder { .. }))
                if self.is_reversed =>
            {
                write!(f, "{surface}, from inside")
            }
            Ok(surface) => surface.fmt(f),
            Err(problem) => write!(f, "unreadable: {problem}"),
        }
    }
}
