use nalgebra::{Point3, Vector3};
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::TrianglePointLocation;

use super::border::{Border, Holes};
use super::face_tree::{FaceTree, to_parry};
use super::triangles::TriangleMesh;
use crate::RegisterError;
use crate::cloud::Side;

/// A mesh under a search tree; faces are named by their place in it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    tree: FaceTree,
    normals: Vec<Vector3<f64>>,
    /// For each face, whether its edges from corner 0, 1 and 2 have no face beyond them.
    border_edges: Vec<[bool; 3]>,
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
        let surface = Self::new(&mesh, &border);
        Ok((mesh, surface))
    }

    fn new(mesh: &TriangleMesh, border: &Border) -> Self {
        let faces: Vec<_> = (0..mesh.faces.len()).map(|face| mesh.corners(face)).collect();
        let tree = FaceTree::new(&faces);
        let order = || tree.order().iter().map(|&face| face as usize);
        let normals = order().map(|face| mesh.area_vector(face).normalize()).collect();
        let border_edges = order().map(|face| border.edges[face]).collect();
        Self { tree, normals, border_edges }
    }

    /// Face nearest to a point, if one is nearer than the limit.
    pub(super) fn nearest_face(&self, point: &Point3<f64>, limit_mm: f64) -> Option<u32> {
        self.tree.nearest(point, limit_mm)
    }

    pub(super) fn distance_mm(&self, face: u32, point: &Point3<f64>) -> f64 {
        self.tree.triangle(face).distance_to_local_point(to_parry(point), false)
    }

    pub(super) fn foot(&self, face: u32, point: &Point3<f64>) -> OnFace {
        let triangle = self.tree.triangle(face);
        let (projected, location) =
            triangle.project_local_point_and_get_location(to_parry(point), false);
        let [ab, bc, ca] = self.border_edges[face as usize];
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
