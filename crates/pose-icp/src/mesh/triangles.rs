use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::cloud::check_points;
use crate::{RegisterError, Side};

/// Twice the area over the square of the longest edge below which a face has no normal: a thousand
/// times what rounding leaves of coordinates a thousand edges from the origin.
const MIN_RELATIVE_AREA: f64 = 1e-10;

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
