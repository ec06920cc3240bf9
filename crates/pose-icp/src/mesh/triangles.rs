use std::collections::HashMap;

use geometry::{DeviationAlong, HeightGrid};
use nalgebra::{Point3, Vector3};

use crate::cloud::check_points;
use crate::{RegisterError, Side};

/// Twice the area over the square of the longest edge below which a face has no normal: a thousand
/// times what rounding leaves of coordinates a thousand edges from the origin.
const MIN_RELATIVE_AREA: f64 = 1e-10;

/// Faces beyond which a mesh is not divided: half a gigabyte with its search tree.
const MOST_FACES: usize = 4_000_000;

/// Triangles over shared vertices, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TriangleMesh {
    /// Corners.
    pub vertices_mm: Vec<Point3<f64>>,
    /// Places of each face's corners in `vertices_mm`, from 0.
    pub faces: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Joins corners that coincide to the last bit, as faces from a file without indices do.
    #[must_use]
    pub fn welded(&self) -> Self {
        let mut places = HashMap::new();
        let mut vertices_mm = Vec::new();
        let joined: Vec<usize> = self
            .vertices_mm
            .iter()
            .map(|vertex| {
                // Adding zero makes −0 and 0 one.
                let key = [0, 1, 2].map(|k| (vertex[k] + 0.0).to_bits());
                *places.entry(key).or_insert_with(|| {
                    vertices_mm.push(*vertex);
                    vertices_mm.len() - 1
                })
            })
            .collect();
        #[expect(clippy::cast_possible_truncation, reason = "not above the place that it replaces")]
        let place = |v: u32| joined.get(v as usize).map_or(v, |&joined| joined as u32);
        let faces = self.faces.iter().map(|face| face.map(place)).collect();
        Self { vertices_mm, faces }
    }

    /// Checks that there are faces, that their corners exist and are finite, and that each face
    /// has an area.
    ///
    /// # Errors
    ///
    /// [`RegisterError::Empty`], [`RegisterError::InvalidPoint`], [`RegisterError::NoSuchVertex`],
    /// [`RegisterError::ZeroAreaFaces`]; `side` is who they blame.
    pub fn check(&self, side: Side) -> Result<(), RegisterError> {
        if self.faces.is_empty() || self.vertices_mm.is_empty() {
            return Err(RegisterError::Empty { side });
        }
        check_points(&self.vertices_mm, side)?;
        let n = self.vertices_mm.len();
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= n) {
                return Err(RegisterError::NoSuchVertex { side, face, vertex, vertices: n });
            }
        }
        let mut flat = (0..self.faces.len()).filter(|&face| self.is_flat(face));
        match flat.next() {
            Some(first) => {
                Err(RegisterError::ZeroAreaFaces { side, count: 1 + flat.count(), first })
            }
            None => Ok(()),
        }
    }

    /// The mesh with deviations measured over x and y added to what faces up, its faces divided until no edge
    /// there is longer than `edge_mm`; `None` where that makes more than four million.
    ///
    /// Along the normal, a corner moves along the mean normal of its faces by area. Beside the map, and where
    /// the mesh faces down, it stays as it is.
    #[must_use]
    pub fn formed(&self, map_mm: &HeightGrid, along: DeviationAlong, edge_mm: f64) -> Option<Self> {
        let mut mesh = self.welded();
        while mesh.has_edge_over(map_mm, edge_mm) {
            if mesh.faces.len() > MOST_FACES / 4 {
                return None;
            }
            mesh = mesh.divided();
        }
        let mut normals = vec![Vector3::zeros(); mesh.vertices_mm.len()];
        for (face, corners) in mesh.faces.iter().enumerate() {
            let area = mesh.area_vector(face);
            for &v in corners {
                normals[v as usize] += area;
            }
        }
        for (vertex, normal) in mesh.vertices_mm.iter_mut().zip(&normals) {
            if normal.z <= 0.0 || !map_mm.is_measured(vertex.x, vertex.y) {
                continue;
            }
            let up = match along {
                DeviationAlong::Normal => normal.normalize(),
                DeviationAlong::Z => Vector3::z(),
            };
            *vertex += up * map_mm.sag_mm(vertex.x, vertex.y);
        }
        Some(mesh)
    }

    /// Whether an edge over the map is longer than `edge_mm`.
    fn has_edge_over(&self, map_mm: &HeightGrid, edge_mm: f64) -> bool {
        let is_over = |p: &Point3<f64>| map_mm.is_measured(p.x, p.y);
        (0..self.faces.len()).any(|face| {
            let corners = self.corners(face);
            let center = Point3::from(corners.iter().map(|c| c.coords).sum::<Vector3<f64>>() / 3.0);
            // A face larger than the map may have it between its corners.
            let is_over =
                is_over(&center) || corners.iter().any(is_over) || self.spans(face, map_mm);
            let [a, b, c] = corners;
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            is_over && longest > edge_mm
        })
    }

    /// Whether the box around a face holds a part of the map's.
    fn spans(&self, face: usize, map_mm: &HeightGrid) -> bool {
        let corners = self.corners(face);
        let [low, high] = map_mm.extent_mm();
        let range = |k: usize| {
            let of = corners.map(|c| c[k]);
            (of.into_iter().fold(f64::MAX, f64::min), of.into_iter().fold(f64::MIN, f64::max))
        };
        (0..2).all(|k| range(k).0 <= high[k] && range(k).1 >= low[k])
    }

    /// Every face as four, by the middles of its edges.
    fn divided(&self) -> Self {
        let mut vertices_mm = self.vertices_mm.clone();
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for [a, b, c] in &self.faces {
            let [ab, bc, ca] = [[*a, *b], [*b, *c], [*c, *a]].map(|[from, to]| {
                *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                    let ends = [from, to].map(|v| self.vertices_mm[v as usize]);
                    vertices_mm.push(nalgebra::center(&ends[0], &ends[1]));
                    u32::try_from(vertices_mm.len() - 1).unwrap_or(u32::MAX)
                })
            });
            faces.extend([[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]);
        }
        Self { vertices_mm, faces }
    }

    pub(crate) fn corners(&self, face: usize) -> [Point3<f64>; 3] {
        self.faces[face].map(|v| self.vertices_mm[v as usize])
    }

    /// Normal of a face, of twice its area.
    pub(crate) fn area_vector(&self, face: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(face);
        (b - a).cross(&(c - a))
    }

    fn is_flat(&self, face: usize) -> bool {
        let [a, b, c] = self.corners(face);
        let longest =
            (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        // Also true for NaN.
        let has_area = self.area_vector(face).norm() > MIN_RELATIVE_AREA * longest;
        !has_area
    }
}
