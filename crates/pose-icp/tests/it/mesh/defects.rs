//! Meshes that must be refused, by name.

use nalgebra::Point3;
use pose_icp::{Holes, MeshTarget, RegisterError, Side, TriangleMesh, sample_surface};

use super::shapes::{sheet, wedge};

fn refusal(mesh: &TriangleMesh) -> RegisterError {
    MeshTarget::new(mesh, Holes::Refuse).unwrap_err()
}

#[test]
fn no_faces() {
    let empty = TriangleMesh::default();
    assert_eq!(refusal(&empty), RegisterError::Empty { side: Side::Target });
    assert_eq!(
        sample_surface(&empty, 10).unwrap_err(),
        RegisterError::Empty { side: Side::Source }
    );
}

#[test]
fn faces_without_area() {
    let mut mesh = wedge();
    mesh.faces[3] = [0, 5, 5];
    // Three corners in a row.
    mesh.vertices_mm.extend([Point3::new(20.0, 0.0, 0.0), Point3::new(40.0, 0.0, 0.0)]);
    mesh.faces.push([0, 8, 9]);
    let expected = RegisterError::ZeroAreaFaces { side: Side::Target, count: 2, first: 3 };
    assert_eq!(refusal(&mesh), expected);
    assert!(expected.to_string().contains("remove them"));
}

#[test]
fn vertices_that_are_not_there_or_not_finite() {
    let mut mesh = wedge();
    mesh.faces[7][1] = 8;
    let error = refusal(&mesh);
    assert!(matches!(error, RegisterError::NoSuchVertex { face: 7, vertex: 8, .. }), "{error}");
    mesh = wedge();
    mesh.vertices_mm[2].z = f64::NAN;
    assert!(matches!(refusal(&mesh), RegisterError::InvalidPoint { index: 2, .. }));
}

#[test]
fn holes_are_counted_and_borders_are_none() {
    assert!(MeshTarget::new(&wedge(), Holes::Refuse).is_ok());
    assert!(MeshTarget::new(&sheet(12, &[]), Holes::Refuse).is_ok());
    let torn = sheet(12, &[(3, 3), (3, 4), (8, 6)]);
    assert_eq!(refusal(&torn), RegisterError::MeshHoles { count: 2 });
    assert!(MeshTarget::new(&torn, Holes::Skip).is_ok());
    // A notch in the border is no hole.
    assert!(MeshTarget::new(&sheet(12, &[(0, 3)]), Holes::Refuse).is_ok());
}

#[test]
fn a_body_with_one_face_missing_has_a_hole() {
    let mut fine = TriangleMesh::default();
    // A ball of 40 × 80 facets.
    let at = |i: u32, j: u32| {
        let (polar, azimuth) = (
            f64::from(i) * std::f64::consts::PI / 40.0,
            f64::from(j % 80) * std::f64::consts::TAU / 80.0,
        );
        Point3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()) * 20.0
    };
    let mut add = |corners: [Point3<f64>; 3]| {
        let first = u32::try_from(fine.vertices_mm.len()).unwrap();
        fine.vertices_mm.extend(corners);
        fine.faces.push([first, first + 1, first + 2]);
    };
    let pole = |z: f64| Point3::new(0.0, 0.0, z);
    for j in 0..80 {
        add([pole(20.0), at(1, j), at(1, j + 1)]);
        add([pole(-20.0), at(39, j + 1), at(39, j)]);
        for i in 1..39 {
            add([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            add([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    assert!(MeshTarget::new(&fine, Holes::Refuse).is_ok());
    fine.faces.remove(2000);
    assert_eq!(refusal(&fine), RegisterError::MeshHoles { count: 1 });
}

#[test]
fn welding_joins_what_coincides() {
    let mesh = wedge();
    let loose = TriangleMesh {
        vertices_mm: mesh.faces.iter().flatten().map(|&v| mesh.vertices_mm[v as usize]).collect(),
        faces: (0..12).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
    };
    let welded = loose.welded();
    assert_eq!(welded.vertices_mm.len(), 8);
    for (a, b) in mesh.faces.iter().zip(&welded.faces) {
        let corners =
            |mesh: &TriangleMesh, face: &[u32; 3]| face.map(|v| mesh.vertices_mm[v as usize]);
        assert_eq!(corners(&mesh, a), corners(&welded, b));
    }
}
