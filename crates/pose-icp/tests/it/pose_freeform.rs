//! Parts that are no surfaces of revolution: all six parameters are determined.

use std::sync::Arc;

use geometry::{
    AsphereShape, DeviationAlong, EulerAngles, GeometryError, HeightGrid, Line, Polynomial, Surface,
};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use pose_icp::{
    Holes, MeshSurface, Part, PoseError, PoseOptions, PoseStart, Tip, Touch, TriangleMesh,
    fit_pose, height_at, start_from_touches,
};

use crate::pose_scene::{RADIUS_MM, center_over, to_machine};

const TIP: Tip = Tip { radius_mm: 1.5, side: pose_icp::TipSide::Above };

fn truth() -> PoseStart {
    PoseStart {
        position_mm: Vector3::new(120.4, -80.2, 30.7),
        angles: EulerAngles { alpha_rad: 6e-3, beta_rad: -4e-3, gamma_rad: 0.02 },
    }
}

/// A saddle with a wave on it, in units of 40 mm.
fn height(x: f64, y: f64) -> f64 {
    let (u, v) = (x / 40.0, y / 40.0);
    3.0 * u * u - 2.0 * v * v + 0.8 * u * v + 1.1 * u * u * u - 0.9 * v * v * u
}

fn saddle() -> Polynomial {
    let terms = [(2, 0, 3.0), (0, 2, -2.0), (1, 1, 0.8), (3, 0, 1.1), (1, 2, -0.9)];
    Polynomial::new(40.0, terms).unwrap()
}

fn places() -> Vec<[f64; 2]> {
    (0..7_i32)
        .flat_map(|i| (0..7_i32).map(move |j| [i - 3, j - 3].map(|k| 11.0 * f64::from(k))))
        .collect()
}

/// Ball centres over the analytic surface, by its analytic slope.
fn touches(at: &[[f64; 2]]) -> Vec<Touch> {
    at.iter()
        .map(|&[x, y]| {
            let (u, v) = (x / 40.0, y / 40.0);
            let slope_x = (6.0 * u + 0.8 * v + 3.3 * u * u - 0.9 * v * v) / 40.0;
            let slope_y = (-4.0 * v + 0.8 * u - 1.8 * v * u) / 40.0;
            let normal = Vector3::new(-slope_x, -slope_y, 1.0).normalize();
            let local = Vector3::new(x, y, height(x, y)) + normal * TIP.radius_mm;
            Touch::new(to_machine(&truth(), local), 1e-3)
        })
        .collect()
}

fn options() -> PoseOptions {
    PoseOptions { tip: TIP, held: vec![], ..PoseOptions::default() }
}

#[test]
fn a_polynomial_shows_all_six_parameters() {
    let part = Part::freeform(Arc::new(saddle()));
    let touches = touches(&places());
    let start = start_from_touches(&part, &touches, TIP, 0.0).unwrap();
    let fit = fit_pose(&part, &touches, &start, &options()).unwrap();
    // Well determined: round-off of coordinates of 100 mm.
    assert!((fit.pose.position_mm - truth().position_mm).norm() < 1e-9);
    assert!((fit.pose.angles.gamma_rad - truth().angles.gamma_rad).abs() < 1e-10);
    assert_eq!(fit.singular_values.len(), 6);
    let at = touches[10].center_mm;
    let height = height_at(&part, &fit, TIP, at.x, at.y, at.z + 0.5).unwrap();
    assert!((height.z_mm - at.z).abs() < 1e-9);
}

#[test]
fn a_plane_leaves_three_motions_free() {
    let flat = Polynomial::new(1.0, [(0, 0, 0.0)]).unwrap();
    let part = Part::freeform(Arc::new(flat));
    let touches: Vec<Touch> =
        places().iter().map(|[x, y]| Touch::new(Point3::new(*x, *y, 1.5), 1e-3)).collect();
    let start = PoseStart::level(Vector3::zeros(), 0.0);
    let error = fit_pose(&part, &touches, &start, &options()).unwrap_err();
    let PoseError::Undetermined { directions } = &error else { panic!("{error}") };
    assert_eq!(directions.len(), 3);
}

/// Grid of the saddle, `n` cells of `step_mm` a side.
fn mesh(n: i32, step_mm: f64) -> TriangleMesh {
    let coordinate = |k: i32| (f64::from(k) - 0.5 * f64::from(n)) * step_mm;
    let vertices_mm = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| [coordinate(i), coordinate(j)]))
        .map(|[x, y]| Point3::new(x, y, height(x, y)))
        .collect();
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let at = |i: i32, j: i32| u32::try_from(i * (n + 1) + j).unwrap();
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriangleMesh { vertices_mm, faces }
}

#[test]
fn a_mesh_gives_the_pose_to_what_its_facets_leave() {
    let surface = MeshSurface::new(&mesh(90, 1.0), Holes::Refuse).unwrap();
    let part = Part::mesh(surface);
    let touches = touches(&places());
    let start = start_from_touches(&part, &touches, TIP, 0.0).unwrap();
    let fit = fit_pose(&part, &touches, &start, &options()).unwrap();
    // Chords of 1 mm across a radius of some 200 mm are 0.6 µm off at most; rolling on them, a
    // ball of 1.5 mm adds a hundredth of that. Laterally the slopes of a tenth magnify it.
    assert!((fit.pose.position_mm - truth().position_mm).norm() < 10e-3);
    assert!((fit.pose.angles.gamma_rad - truth().angles.gamma_rad).abs() < 2e-4);
    assert!(fit.residuals_mm.iter().all(|r| r.abs() < 2e-3), "{:?}", fit.residuals_mm);
}

#[test]
fn lines_meet_a_mesh_where_they_meet_its_faces() {
    let surface = MeshSurface::new(&mesh(10, 2.0), Holes::Refuse).unwrap();
    let down = Line::new(Point3::new(3.3, -2.1, 50.0), -Vector3::z()).unwrap();
    let hit = surface.first_hit(&down).unwrap();
    // Chords of 2 mm: 0.003 mm.
    assert!((hit.point_mm.z - height(3.3, -2.1)).abs() < 5e-3);
    assert_eq!(surface.hits(&down).unwrap().len(), 1);
    let beside = Line::new(Point3::new(30.0, 0.0, 50.0), -Vector3::z()).unwrap();
    assert_eq!(surface.hits(&beside), Err(GeometryError::Misses));
    let up = Line::new(Point3::new(3.3, -2.1, 50.0), Vector3::z()).unwrap();
    assert!(matches!(surface.first_hit(&up), Err(GeometryError::BehindRay { .. })));
    assert!(!surface.closest_point(&Point3::new(30.0, 0.0, 0.0)).unwrap().inside_aperture);
}

/// A part knows whether deviations were measured of it; they are added to what was drawn.
#[test]
fn a_map_of_deviations_lies_on_the_drawn_surface() {
    let drawn = Part::freeform(Arc::new(saddle()));
    assert!(!drawn.has_form_map());
    let raised_mm = 2e-3;
    let map =
        HeightGrid::new(Point2::new(-60.0, -60.0), Vector2::repeat(20.0), 7, &[raised_mm; 49]);
    let formed = drawn.clone().with_form_map(map.unwrap(), DeviationAlong::Z);
    assert!(formed.has_form_map());
    for [x, y] in places() {
        let at = Point3::new(x, y, height(x, y) + raised_mm);
        let foot = formed.surface().closest_point(&at).unwrap();
        // Round-off of coordinates of 50 mm.
        assert!(foot.signed_distance_mm.abs() < 1e-12, "{}", foot.signed_distance_mm);
    }
}

/// A segment far off its axis: the touches lie about its aperture, and so does the start. The ball moves
/// them by its radius times the slope.
#[test]
fn a_start_has_the_aperture_under_its_touches() {
    let shape = AsphereShape {
        aperture_center_mm: Point2::new(90.0, -40.0),
        ..AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], 40.0)
    };
    let middle = shape.aperture_center_mm;
    let truth = PoseStart::level(Vector3::new(210.0, 35.0, -12.0), 0.4);
    let around = [[15.0, 0.0], [0.0, 15.0], [-15.0, 0.0], [0.0, -15.0], [0.0, 0.0]];
    let touches: Vec<Touch> = (around.iter())
        .map(|[x, y]| center_over(&truth, middle.x + x, middle.y + y, TIP.radius_mm))
        .map(|center_mm| Touch::new(center_mm, 1e-3))
        .collect();
    let start = start_from_touches(&Part::asphere(shape).unwrap(), &touches, TIP, 0.4).unwrap();
    let off_mm = (start.position_mm - truth.position_mm).xy().norm();
    let slope = 90.0f64.hypot(40.0) / RADIUS_MM;
    assert!(off_mm < TIP.radius_mm * slope, "{off_mm}");
}
