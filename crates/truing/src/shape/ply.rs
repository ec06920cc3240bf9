use nalgebra::{Point3, Unit, Vector3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};
use pose_icp::{PointCloud, TriangleMesh};

use super::{Shape, ShapeProblem};

/// Vertices, and faces cut into fans of triangles where there are any.
pub(super) fn parse(bytes: &[u8]) -> Result<Shape, ShapeProblem> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(|_| ShapeProblem::Header { format: "PLY" })?;
    check_counts(&header, bytes.len())?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for element in header.elements.values() {
        let read = match element.name.as_str() {
            "vertex" => Parser::<Vertex>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|read| vertices = read),
            "face" => Parser::<Face>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|read| faces = read),
            _ => Parser::<Skipped>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|_| ()),
        };
        read.map_err(|error| malformed(&error))?;
    }
    if vertices.is_empty() {
        return Err(ShapeProblem::Nothing { what: "vertices" });
    }
    if faces.is_empty() {
        return cloud(&header, &vertices).map(Shape::Cloud);
    }
    mesh(&vertices, &faces).map(Shape::Mesh)
}

fn malformed(error: &ParseError) -> ShapeProblem {
    ShapeProblem::Malformed { format: "PLY", line: error.line() }
}

/// Memory is set aside for as many elements as the header says: it must be able to hold them.
fn check_counts(header: &Header, bytes: usize) -> Result<(), ShapeProblem> {
    match header.elements.values().map(|e| e.count).find(|&count| count > bytes) {
        Some(promised) => Err(ShapeProblem::TooShort { format: "PLY", promised, bytes }),
        None => Ok(()),
    }
}

fn cloud(header: &Header, vertices: &[Vertex]) -> Result<PointCloud, ShapeProblem> {
    let points_mm = vertices.iter().map(|v| Point3::from(v.position)).collect();
    let has = |name: &str| header.elements["vertex"].properties.contains_key(name);
    if !["nx", "ny", "nz"].into_iter().all(has) {
        return Ok(PointCloud::new(points_mm));
    }
    let normal = |(index, vertex): (usize, &Vertex)| {
        Unit::try_new(Vector3::from(vertex.normal), f64::MIN_POSITIVE)
            .ok_or(ShapeProblem::NoNormal { index })
    };
    let normals = vertices.iter().enumerate().map(normal).collect::<Result<_, _>>()?;
    Ok(PointCloud::with_normals(points_mm, normals))
}

fn mesh(vertices: &[Vertex], polygons: &[Face]) -> Result<TriangleMesh, ShapeProblem> {
    let mut faces = Vec::new();
    for (index, polygon) in polygons.iter().enumerate() {
        let corners = &polygon.corners;
        let exists = |&v: &i64| usize::try_from(v).is_ok_and(|v| v < vertices.len());
        if corners.len() < 3 || !corners.iter().all(exists) {
            return Err(ShapeProblem::Face { index });
        }
        let corner = |k: usize| u32::try_from(corners[k]).map_err(|_| ShapeProblem::Face { index });
        for k in 1..corners.len() - 1 {
            faces.push([corner(0)?, corner(k)?, corner(k + 1)?]);
        }
    }
    let vertices_mm = vertices.iter().map(|v| Point3::from(v.position)).collect();
    Ok(TriangleMesh { vertices_mm, faces })
}

struct Vertex {
    position: [f64; 3],
    normal: [f64; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        // A coordinate that the file does not give is no coordinate.
        Self { position: [f64::NAN; 3], normal: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ => return PropertyAccessResult::Set,
        };
        let Some(number) = number(&value) else { return PropertyAccessResult::Ignored };
        *place = number;
        PropertyAccessResult::Set
    }
}

fn number(value: &Property) -> Option<f64> {
    Some(match *value {
        Property::Float(v) => v.into(),
        Property::Double(v) => v,
        Property::Char(v) => v.into(),
        Property::UChar(v) => v.into(),
        Property::Short(v) => v.into(),
        Property::UShort(v) => v.into(),
        Property::Int(v) => v.into(),
        Property::UInt(v) => v.into(),
        _ => return None,
    })
}

struct Face {
    corners: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if name == "vertex_index" || name == "vertex_indices" {
            self.corners = match value {
                Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
                Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
                Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
                _ => return PropertyAccessResult::Ignored,
            };
        }
        PropertyAccessResult::Set
    }
}

/// An element that holds nothing of interest.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Set
    }
}
