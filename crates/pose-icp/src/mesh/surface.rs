//! The one place where parry's vectors meet nalgebra's.

use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{CompositeShapeRef, TriMesh, TrianglePointLocation};

use super::border::{Border, Holes};
use super::triangles::TriangleMesh;
use crate::RegisterError;
use crate::cloud::Side;

/// A mesh under parry's bounding volume hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    mesh: TriMesh,
    normals: Vec<Vector3<f64>>,
    border: Border,
}

/// Point of a face.
pub(super) struct OnFace {
    pub(super) point: Point3<f64>,
    pub(super) normal: Vector3<f64>,
    /// Whether it lies on an edge beyond which there is nothing.
    pub(super) is_on_border: bool,
}

impl Surface {
    /// Joins coinciding vertices, checks the faces and builds the search tree; the mesh as joined
    /// comes with it.
    pub(super) fn checked(
        mesh: &TriangleMesh,
        holes: Holes,
    ) -> Result<(TriangleMesh, Self), RegisterError> {
        mesh.check(Side::Target)?;
        let mesh = mesh.welded();
        let border = Border::of(&mesh);
        if border.n_holes > 0 && holes == Holes::Refuse {
            return Err(RegisterError::MeshHoles { count: border.n_holes });
        }
        let surface = Self::new(&mesh, border)?;
        Ok((mesh, surface))
    }

    fn new(mesh: &TriangleMesh, border: Border) -> Result<Self, RegisterError> {
        let normals = (0..mesh.faces.len()).map(|f| mesh.area_vector(f).normalize()).collect();
        let vertices = mesh.vertices_mm.iter().map(to_parry).collect();
        let parry = TriMesh::new(vertices, mesh.faces.clone())
            .map_err(|_| RegisterError::Empty { side: Side::Target })?;
        Ok(Self { mesh: parry, normals, border })
    }

    /// Face nearest to a point, if one is nearer than the limit.
    pub(super) fn nearest_face(&self, point: &Point3<f64>, limit_mm: f64) -> Option<u32> {
        CompositeShapeRef(&self.mesh)
            .project_local_point(to_parry(point), limit_mm, false)
            .map(|found| found.0)
    }

    pub(super) fn distance_mm(&self, face: u32, point: &Point3<f64>) -> f64 {
        let triangle = self.mesh.triangle(face);
        triangle.distance_to_local_point(to_parry(point), false)
    }

    pub(super) fn foot(&self, face: u32, point: &Point3<f64>) -> OnFace {
        let triangle = self.mesh.triangle(face);
        let (projected, location) =
            triangle.project_local_point_and_get_location(to_parry(point), false);
        let [ab, bc, ca] = self.border.edges[face as usize];
        let is_on_border = match location {
            TrianglePointLocation::OnEdge(0, _) => ab,
            TrianglePointLocation::OnEdge(1, _) => bc,
            TrianglePointLocation::OnEdge(_, _) => ca,
            TrianglePointLocation::OnVertex(0) => ca || ab,
            TrianglePointLocation::OnVertex(1) => ab || bc,
            TrianglePointLocation::OnVertex(_) => bc || ca,
            TrianglePointLocation::OnFace(..) | TrianglePointLocation::OnSolid => false,
        };
        let at = projected.point;
        OnFace {
            point: Point3::new(at.x, at.y, at.z),
            normal: self.normals[face as usize],
            is_on_border,
        }
    }
}

fn to_parry(point: &Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}
