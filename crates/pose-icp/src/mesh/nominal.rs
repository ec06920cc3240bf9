use geometry::{Curvature, Foot, GeometryError, Hit, Line, Surface as GeometrySurface};
use nalgebra::{Point3, Unit, Vector3};

use super::border::Holes;
use super::surface::Surface;
use super::triangles::TriangleMesh;
use crate::RegisterError;

/// A mesh as the nominal surface of a part.
///
/// Its faces are flat: a touch beside an edge has the edge for its foot, and no curvature says how
/// large a ball may be. A foot on a border, or over a hole that is allowed, is outside the aperture.
#[derive(Clone, Debug)]
pub struct MeshSurface {
    surface: Surface,
    mesh: TriangleMesh,
}

/// Share of an edge, or of a distance, that rounding blurs.
const ROUNDING: f64 = 1e-12;

impl MeshSurface {
    /// Joins coinciding vertices, checks the faces and builds the search tree.
    ///
    /// # Errors
    ///
    /// As [`MeshTarget::new`](crate::MeshTarget::new).
    pub fn new(mesh: &TriangleMesh, holes: Holes) -> Result<Self, RegisterError> {
        let (mesh, surface) = Surface::checked(mesh, holes)?;
        Ok(Self { surface, mesh })
    }

    /// Where the line crosses a face (Möller and Trumbore 1997).
    fn crossing(&self, face: usize, line: &Line) -> Option<Hit> {
        let [a, b, c] = self.mesh.corners(face);
        let (along, across) = (b - a, c - a);
        let cross = line.direction.cross(&across);
        let determinant = along.dot(&cross);
        if determinant.abs() <= ROUNDING * along.norm() * across.norm() {
            return None;
        }
        let from = line.point_mm - a;
        let u = from.dot(&cross) / determinant;
        let turned = from.cross(&along);
        let v = line.direction.dot(&turned) / determinant;
        if u < -ROUNDING || v < -ROUNDING || u + v > 1.0 + ROUNDING {
            return None;
        }
        let distance_mm = across.dot(&turned) / determinant;
        let normal = Unit::new_normalize(self.mesh.area_vector(face));
        Some(Hit { distance_mm, point_mm: line.at(distance_mm), normal })
    }
}

impl GeometrySurface for MeshSurface {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        let argument = "query point";
        if !query_mm.coords.norm_squared().is_finite() {
            return Err(GeometryError::NonFinite { argument });
        }
        let face = self.surface.nearest_face(query_mm, f64::MAX);
        let face = face.ok_or(GeometryError::NonFinite { argument })?;
        let on = self.surface.foot(face, query_mm);
        let offset = query_mm - on.point;
        let side = on.normal.dot(&offset);
        let distance_mm = offset.norm();
        // Over an edge the gradient of the distance is along the offset, not along a face's normal.
        let is_over_face = side.abs() >= (1.0 - ROUNDING) * distance_mm;
        let normal = if is_over_face { on.normal } else { offset * side.signum() };
        Ok(Foot {
            point_mm: on.point,
            normal: Unit::new_normalize(normal),
            signed_distance_mm: distance_mm.copysign(side),
            inside_aperture: !on.is_on_border,
        })
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        let normal = self.closest_point(point_mm)?.normal;
        let first = Unit::new_normalize(normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
        Ok(Curvature {
            major_per_mm: 0.0,
            minor_per_mm: 0.0,
            major_direction: first,
            minor_direction: Unit::new_normalize(normal.cross(&first)),
        })
    }

    fn is_faceted(&self) -> bool {
        true
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        let crossing = |face| self.crossing(face, line);
        let mut hits: Vec<Hit> = (0..self.mesh.faces.len()).filter_map(crossing).collect();
        hits.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
        if hits.is_empty() { Err(GeometryError::Misses) } else { Ok(hits) }
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let (mut ahead, mut behind) = (None::<Hit>, None::<f64>);
        for hit in (0..self.mesh.faces.len()).filter_map(|face| self.crossing(face, ray)) {
            if hit.distance_mm < 0.0 {
                behind = Some(behind.map_or(-hit.distance_mm, |b| b.min(-hit.distance_mm)));
            } else if ahead.is_none_or(|h| hit.distance_mm < h.distance_mm) {
                ahead = Some(hit);
            }
        }
        ahead.ok_or(match behind {
            Some(distance_mm) => GeometryError::BehindRay { distance_mm },
            None => GeometryError::Misses,
        })
    }
}
