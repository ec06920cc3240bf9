//! Edges with a face on one side only, and whether they enclose holes.

use std::collections::BTreeMap;

use super::triangles::TriangleMesh;

/// What to do about holes in a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Holes {
    /// A mesh with holes is an error.
    #[default]
    Refuse,
    /// Points over a hole take no part, as those beside the mesh.
    Skip,
}

/// Squared length of a rim over 4π times the area that it bounds, below which the surface is a body
/// with a hole rather than a sheet: 1 for a flat disc, ½ for half a sphere.
const MIN_RIM_OF_SHEET: f64 = 0.01;

/// Borders of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// For each face, whether its edges from corner 0, 1 and 2 have no face beyond them.
    pub(super) edges: Vec<[bool; 3]>,
    /// Loops of border edges beyond the one that a sheet has.
    pub(super) n_holes: usize,
}

impl Border {
    /// Of a mesh whose coinciding vertices are joined.
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let mut count = BTreeMap::new();
        for face in &mesh.faces {
            for k in 0..3 {
                *count.entry(edge(face, k)).or_insert(0_u32) += 1;
            }
        }
        let is_border = |face: &[u32; 3], k| count[&edge(face, k)] == 1;
        let edges = mesh.faces.iter().map(|face| [0, 1, 2].map(|k| is_border(face, k))).collect();
        let rim: Vec<[u32; 2]> = count.iter().filter(|e| *e.1 == 1).map(|e| *e.0).collect();
        let n_holes = holes(mesh, &rim);
        Self { edges, n_holes }
    }
}

/// Corners of the edge from corner `k`, the lower number first.
fn edge(face: &[u32; 3], k: usize) -> [u32; 2] {
    let (a, b) = (face[k], face[(k + 1) % 3]);
    [a.min(b), a.max(b)]
}

fn holes(mesh: &TriangleMesh, rim: &[[u32; 2]]) -> usize {
    if rim.is_empty() {
        return 0;
    }
    let n = mesh.vertices_mm.len();
    let mut pieces = Sets::new(n);
    for &[a, b, c] in &mesh.faces {
        pieces.join(a, b);
        pieces.join(b, c);
    }
    let mut loops = Sets::new(n);
    for &[a, b] in rim {
        loops.join(a, b);
    }
    // Rims of each piece, by length.
    let mut rims = BTreeMap::<u32, BTreeMap<u32, f64>>::new();
    for &[a, b] in rim {
        let length = (mesh.vertices_mm[a as usize] - mesh.vertices_mm[b as usize]).norm();
        let piece = rims.entry(pieces.root(a)).or_default();
        *piece.entry(loops.root(a)).or_insert(0.0) += length;
    }
    let mut areas = BTreeMap::new();
    for (face, corners) in mesh.faces.iter().enumerate() {
        *areas.entry(pieces.root(corners[0])).or_insert(0.0) += mesh.area_vector(face).norm() / 2.0;
    }
    let of_piece = |(piece, rims): (&u32, &BTreeMap<u32, f64>)| {
        let longest = rims.values().fold(0.0_f64, |l, &r| l.max(r));
        let sheet = 4.0 * std::f64::consts::PI * areas[piece] * MIN_RIM_OF_SHEET;
        rims.len() - usize::from(longest * longest >= sheet)
    };
    rims.iter().map(of_piece).sum()
}

/// Disjoint sets of vertices.
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(n: usize) -> Self {
        Self { parent: (0..).take(n).collect() }
    }

    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.parent[vertex as usize] != vertex {
            let grandparent = self.parent[self.parent[vertex as usize] as usize];
            self.parent[vertex as usize] = grandparent;
            vertex = grandparent;
        }
        vertex
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The lower number leads, so that the outcome does not depend on the order.
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
