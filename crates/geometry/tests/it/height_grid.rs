//! Measured heights under a bicubic spline.

use geometry::nalgebra::{Point2, Point3, Vector2, Vector3};
use geometry::{GeometryError, HeightGrid, Line, Polynomial, Surface};

const COLUMNS: usize = 21;
const ROWS: usize = 17;
/// Heights of 10 mm, curvatures of 0.02 /mm: a thousand roundings.
const EXACT_MM: f64 = 1e-11;

fn grid(height: impl Fn(f64, f64) -> f64) -> HeightGrid {
    let (origin, spacing) = (Point2::new(-20.0, -12.0), Vector2::new(2.0, 1.5));
    let heights: Vec<f64> = (0..COLUMNS * ROWS)
        .map(|k| {
            let at = |n: usize| f64::from(u32::try_from(n).expect("few places"));
            height(origin.x + spacing.x * at(k % COLUMNS), origin.y + spacing.y * at(k / COLUMNS))
        })
        .collect();
    HeightGrid::new(origin, spacing, COLUMNS, &heights).expect("the grid is sound")
}

fn quadric() -> (HeightGrid, Polynomial) {
    let terms = [(0, 0, 1.5), (1, 0, 0.1), (2, 0, 0.01), (1, 1, -0.004), (0, 2, -0.006)];
    let polynomial = Polynomial::new(1.0, terms).expect("the terms are sound");
    (grid(|x, y| polynomial.sag_mm(x, y)), polynomial)
}

#[test]
fn quadratics_are_repeated() {
    let (grid, exact) = quadric();
    for (x, y) in [(0.0, 0.0), (-19.3, 11.2), (7.77, -3.1), (20.0, 12.0), (-20.0, -12.0)] {
        assert!((grid.sag_mm(x, y) - exact.sag_mm(x, y)).abs() < EXACT_MM, "({x}, {y})");
        let query = Point3::new(0.9 * x, 0.9 * y, exact.sag_mm(x, y) + 3.0);
        let (found, known) =
            (grid.closest_point(&query).unwrap(), exact.closest_point(&query).unwrap());
        assert!((found.point_mm - known.point_mm).norm() < EXACT_MM, "{found:?} {known:?}");
        assert!((found.signed_distance_mm - known.signed_distance_mm).abs() < EXACT_MM);
        let (found, known) = (grid.curvature(&query).unwrap(), exact.curvature(&query).unwrap());
        assert!((found.major_per_mm - known.major_per_mm).abs() < 1e-12, "{found:?} {known:?}");
        assert!((found.minor_per_mm - known.minor_per_mm).abs() < 1e-12);
    }
}

#[test]
fn lines_meet_it_where_they_meet_the_quadratic() {
    let (grid, exact) = quadric();
    let along = [
        Vector3::new(0.0, 0.0, -1.0),
        Vector3::new(1.0, 0.3, -0.4),
        Vector3::new(-0.7, 1.0, 0.2),
        Vector3::new(1.0, 0.0, 0.02),
    ];
    for direction in along {
        for (x, y, z) in [(0.3, -0.4, 1.7), (-6.0, 4.0, 1.9), (9.0, -7.0, 2.5)] {
            let line = Line::new(Point3::new(x, y, z), direction).unwrap();
            let is_over = |p: &Point3<f64>| p.x.abs() < 20.0 && p.y.abs() < 12.0;
            let known: Vec<f64> = (exact.hits(&line).into_iter().flatten())
                .filter(|hit| is_over(&hit.point_mm))
                .map(|hit| hit.distance_mm)
                .collect();
            let found: Vec<f64> =
                grid.hits(&line).into_iter().flatten().map(|hit| hit.distance_mm).collect();
            assert_eq!(found.len(), known.len(), "{line:?}: {found:?} {known:?}");
            for (found, known) in found.iter().zip(&known) {
                assert!((found - known).abs() < 1e-9, "{line:?}: {found} {known}");
            }
            if let Some(first) = known.iter().find(|d| **d >= 0.0) {
                assert!((grid.first_hit(&line).unwrap().distance_mm - first).abs() < 1e-9);
            }
        }
    }
}

/// Between places a spline of spacing h is off by 5/384 h⁴ max z'''' along each axis: for waves of
/// 1 mm with a wave number of 0.2 /mm that is 3.3e-4 and 1e-4 mm; away from the ends.
#[test]
fn other_surfaces_to_the_fourth_order() {
    let height = |x: f64, y: f64| (0.2 * x).sin() * (0.2 * y).cos();
    let grid = grid(height);
    for i in -20..=20 {
        for j in -10..=10 {
            let (x, y) = (0.7 * f64::from(i), 0.7 * f64::from(j));
            assert!((grid.sag_mm(x, y) - height(x, y)).abs() < 4.5e-4, "({x}, {y})");
        }
    }
}

#[test]
fn beside_the_grid() {
    let (grid, _) = quadric();
    let near = grid.closest_point(&Point3::new(20.5, 0.0, 10.0)).unwrap();
    assert!(!near.inside_aperture || near.point_mm.x <= 20.0, "{near:?}");
    let far = grid.closest_point(&Point3::new(60.0, 0.0, 10.0));
    assert!(matches!(far, Err(GeometryError::OutsideAperture { .. })), "{far:?}");
    let past = Line::new(Point3::new(50.0, 0.0, 10.0), Vector3::new(0.0, 0.0, -1.0)).unwrap();
    assert_eq!(grid.hits(&past), Err(GeometryError::Misses));
}

#[test]
fn grids_that_are_none() {
    let (origin, spacing) = (Point2::origin(), Vector2::new(1.0, 1.0));
    let make =
        |spacing, columns, heights: &[f64]| HeightGrid::new(origin, spacing, columns, heights);
    let few = make(spacing, 3, &[0.0; 12]);
    assert_eq!(few, Err(GeometryError::InvalidGrid { columns: 3, rows: 4, heights: 12 }));
    assert!(matches!(make(spacing, 4, &[0.0; 17]), Err(GeometryError::InvalidGrid { .. })));
    assert!(matches!(make(spacing, 0, &[]), Err(GeometryError::InvalidGrid { .. })));
    let flat = make(Vector2::new(1.0, 0.0), 4, &[0.0; 16]);
    assert!(matches!(flat, Err(GeometryError::InvalidRadius { .. })));
    let nan = make(spacing, 4, &[f64::NAN; 16]);
    assert!(matches!(nan, Err(GeometryError::NonFinite { .. })));
}

/// Around the measured places a plane goes on as itself for three layers, so that nothing of the gap is
/// seen inside: heights of 10 mm, sums of 25 of them.
#[test]
fn a_plane_goes_on_over_gaps() {
    let plane = |x: f64, y: f64| 0.3 * x - 0.2 * y + 1.0;
    let at = |k: i32| f64::from(k) - 14.5;
    let places = || (0..30).flat_map(|j| (0..30).map(move |i| (at(i), at(j))));
    let heights: Vec<Option<f64>> =
        places().map(|(x, y)| (x.hypot(y) < 13.0).then(|| plane(x, y))).collect();
    let (origin, spacing) = (Point2::new(-14.5, -14.5), Vector2::new(1.0, 1.0));
    let round = HeightGrid::with_gaps(origin, spacing, 30, &heights).unwrap();
    for (x, y) in places() {
        let (u, v) = (0.7 * x + 0.1, 0.7 * y - 0.2);
        if u.hypot(v) < 9.0 {
            // What lies five places away counts by 0.27 to the fifth, of the bend beyond three layers.
            assert!((round.sag_mm(u, v) - plane(u, v)).abs() < 1e-2, "({u}, {v})");
        }
        if x.hypot(y) < 13.0 {
            assert!((round.sag_mm(x, y) - plane(x, y)).abs() < 1e-10, "({x}, {y})");
        } else if x.hypot(y) < 14.0 {
            // The first layer beyond: the plane through the places near it.
            assert!((round.sag_mm(x, y) - plane(x, y)).abs() < 1e-10, "({x}, {y})");
        }
    }
    assert_eq!(round.extent_mm(), [origin, Point2::new(14.5, 14.5)]);
    // One height alone goes on as it is, to the rounding of means of 25.
    let mut one = vec![None; 16];
    one[5] = Some(2.5);
    let flat = HeightGrid::with_gaps(origin, spacing, 4, &one).unwrap();
    assert!((flat.sag_mm(-12.3, -13.1) - 2.5).abs() < 1e-12);
    assert!(!flat.is_measured(-12.3, -13.1));
}
