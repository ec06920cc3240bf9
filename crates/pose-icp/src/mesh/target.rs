use nalgebra::Point3;

use super::border::Holes;
use super::surface::Surface;
use super::triangles::TriangleMesh;
use crate::cloud::{Foot, Found, NONE, Target, Wanted, register};
use crate::{PointCloud, RegisterError, RegisterOptions, Registration};

/// Share of the height over a border edge that a point may lie beside it; more is beside the mesh.
const SIDEWAYS_PER_HEIGHT: f64 = 0.2;

/// Rounding of a coordinate of a metre, a hundred times over.
const ON_THE_EDGE_MM: f64 = 1e-11;

/// What is left of a limit that a face met exactly, so that it is found again.
const JUST_BEYOND: f64 = 1.0 + 1e-9;

/// A mesh made ready to be registered onto.
#[derive(Clone, Debug)]
pub struct MeshTarget {
    surface: Surface,
}

impl MeshTarget {
    /// Joins coinciding vertices, checks the faces and builds the search tree.
    ///
    /// # Errors
    ///
    /// As [`TriangleMesh::check`]; [`RegisterError::MeshHoles`] unless they are to be skipped.
    pub fn new(mesh: &TriangleMesh, holes: Holes) -> Result<Self, RegisterError> {
        let (_, surface) = Surface::checked(mesh, holes)?;
        Ok(Self { surface })
    }
}

/// Moves a cloud onto a mesh.
///
/// As [`register_to_cloud`](crate::register_to_cloud), with the exact foot on the nearest triangle in
/// place of the nearest point.
///
/// # Errors
///
/// As [`register_to_cloud`](crate::register_to_cloud).
pub fn register_to_mesh(
    source: &PointCloud,
    target: &MeshTarget,
    options: &RegisterOptions,
) -> Result<Registration, RegisterError> {
    register(source, target, true, options)
}

impl Target for MeshTarget {
    fn search(&self, queries: &[Point3<f64>], wanted: &Wanted, found: &mut [Found]) {
        let limit_mm = wanted.limit_mm;
        let mut near = NONE;
        for (query, found) in queries.iter().zip(found) {
            let hint = if found.slot == NONE { near } else { found.slot };
            let slot = if hint == NONE {
                self.surface.nearest_face(query, limit_mm).unwrap_or(NONE)
            } else {
                let distance_mm = self.surface.distance_mm(hint, query);
                let bound_mm = (distance_mm * JUST_BEYOND).min(limit_mm);
                // None is nearer than the hint, but for rounding.
                let known = if distance_mm < limit_mm { hint } else { NONE };
                self.surface.nearest_face(query, bound_mm).unwrap_or(known)
            };
            *found = Found { slot, lead_mm: 0.0 };
            near = slot;
        }
    }

    fn foot(&self, slot: u32, query: &Point3<f64>) -> Foot {
        let on = self.surface.foot(slot, query);
        let offset = query - on.point;
        let height = on.normal.dot(&offset);
        let sideways = (offset.norm_squared() - height * height).max(0.0).sqrt();
        let allowed = ON_THE_EDGE_MM + SIDEWAYS_PER_HEIGHT * height.abs();
        let is_beside = on.is_on_border && sideways > allowed;
        Foot { point: on.point, normal: on.normal, is_beside }
    }

    fn spacing_mm(&self) -> f64 {
        0.0
    }
}
