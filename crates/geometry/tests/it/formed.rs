//! A nominal surface and a measured map as one.

use std::sync::Arc;

use geometry::nalgebra::{Point2, Point3, Unit, Vector2, Vector3};
use geometry::{
    Asphere, AsphereShape, Curvature, DeviationAlong, FormedSurface, GeometryError, HeightGrid,
    Line, Nurbs, Plane, Polynomial, Surface,
};

const HALF: i32 = 30;
const SPACING_MM: f64 = 2.0;
/// Distances of 100 mm: a thousand roundings.
const EXACT_MM: f64 = 1e-11;

/// A map of a few µm with waves of 25 mm, larger than life to show its slopes.
fn wavy(x: f64, y: f64) -> f64 {
    0.02 * (0.25 * x).sin() * (0.2 * y).cos() + 1e-4 * x
}

fn map(height: impl Fn(f64, f64) -> f64) -> HeightGrid {
    let at = |k: i32| f64::from(k) * SPACING_MM;
    let heights: Vec<f64> = (-HALF..=HALF)
        .flat_map(|j| (-HALF..=HALF).map(move |i| (i, j)))
        .map(|(i, j)| height(at(i), at(j)))
        .collect();
    let origin = Point2::new(at(-HALF), at(-HALF));
    let columns = usize::try_from(2 * HALF + 1).expect("it is positive");
    HeightGrid::new(origin, Vector2::repeat(SPACING_MM), columns, &heights)
        .expect("the shape is sound")
}

fn bowl() -> Arc<dyn Surface> {
    let shape = AsphereShape::on_axis(120.0, -0.6, vec![2e-8], 110.0);
    Arc::new(Asphere::new(shape).expect("the shape is sound"))
}

fn saddle() -> Arc<dyn Surface> {
    let terms = [(2, 0, 20.0), (0, 2, -12.0), (1, 1, 5.0), (3, 0, 2.0)];
    Arc::new(Polynomial::new(60.0, terms).expect("the shape is sound"))
}

/// A bicubic patch over 100 × 100 mm.
fn patch() -> Arc<dyn Surface> {
    let knots = Nurbs::clamped_knots(3, 5);
    let at = |k: usize| 25.0 * f64::from(u32::try_from(k).expect("few places")) - 50.0;
    let points: Vec<Point3<f64>> = (0..25)
        .map(|k| {
            let (x, y) = (at(k % 5), at(k / 5));
            Point3::new(x, y, 4e-3 * x * x - 2e-3 * x * y + 1e-5 * y * y * y)
        })
        .collect();
    let patch = Nurbs::new([3, 3], [knots.clone(), knots], &points, &[1.0; 25])
        .expect("the shape is sound");
    let up = patch.normal(0.5, 0.5).is_ok_and(|n| n.z > 0.0);
    Arc::new(if up { patch } else { patch.flipped() })
}

fn tilted() -> Arc<dyn Surface> {
    Arc::new(
        Plane::new(Point3::new(0.0, 0.0, 1.0), Vector3::new(0.2, -0.1, 1.0))
            .expect("the shape is sound"),
    )
}

fn nominals() -> [Arc<dyn Surface>; 4] {
    [bowl(), saddle(), patch(), tilted()]
}

const BOTH: [DeviationAlong; 2] = [DeviationAlong::Normal, DeviationAlong::Z];

fn places() -> impl Iterator<Item = (f64, f64)> {
    (0..40_u32).map(|k| {
        let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
        let r = 6.0 * f64::from(k).sqrt();
        (r * cos, r * sin)
    })
}

/// A point of the sum by its definition, over a foot of the nominal surface.
fn point_of_sum(
    nominal: &dyn Surface,
    map: &HeightGrid,
    along: DeviationAlong,
    x: f64,
    y: f64,
) -> Point3<f64> {
    let upright = Line::new(Point3::new(x, y, 500.0), -Vector3::z()).expect("the shape is sound");
    let on = nominal.hits(&upright).expect("the shape is sound")[0];
    let w = map.sag_mm(on.point_mm.x, on.point_mm.y);
    match along {
        DeviationAlong::Normal => on.point_mm + on.normal.into_inner() * w,
        DeviationAlong::Z => on.point_mm + Vector3::z() * w,
    }
}

fn difference<T>(h: f64, f: impl Fn(f64) -> T) -> T
where
    T: std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) * (1.0 / (12.0 * h))
}

/// Normals by differences of the definition: h⁴ of the fifth derivatives and round-off over h.
const NORMAL_TOL: f64 = 3e-10;

#[test]
fn points_above_the_sum_are_found_at_their_distance_along_its_normal() {
    let map = map(wavy);
    for (nominal, along) in nominals().into_iter().flat_map(|n| BOTH.map(|a| (n.clone(), a))) {
        let sum = FormedSurface::new(nominal.clone(), map.clone(), along);
        for (x, y) in places() {
            let at = |x: f64, y: f64| point_of_sum(&*nominal, &map, along, x, y);
            let on = at(x, y);
            let h = 1e-2;
            let by_x = difference(h, |d| at(x + d, y).coords);
            let by_y = difference(h, |d| at(x, y + d).coords);
            let normal = by_x.cross(&by_y).normalize();
            for distance in [-3.0, 0.0, 4.0] {
                let foot =
                    sum.closest_point(&(on + normal * distance)).expect("the shape is sound");
                assert!((foot.signed_distance_mm - distance).abs() < EXACT_MM, "{x} {y}: {foot:?}");
                let limit = NORMAL_TOL * (1.0 + distance.abs());
                assert!(
                    (foot.point_mm - on).norm() < 4.0 * limit,
                    "{along:?} {x} {y}: {foot:?} {on}"
                );
                assert!((foot.normal.into_inner() - normal).norm() < NORMAL_TOL, "{x} {y}");
                assert!(foot.inside_aperture);
            }
        }
    }
}

/// Cubic splines bend anew at every place of the map, where a difference of the normal over 1e-5 mm is off by
/// 1.6e-4 /mm² of it; curvatures along the normal leave out 0.02 mm · 5.5e-5 /mm² · 5e-3.
const TURN_TOL_PER_MM: f64 = 2e-8;

#[test]
fn the_normal_is_the_gradient_and_turns_with_the_curvature() {
    let map = map(wavy);
    for (nominal, along) in nominals().into_iter().flat_map(|n| BOTH.map(|a| (n.clone(), a))) {
        let sum = FormedSurface::new(nominal.clone(), map.clone(), along);
        for (x, y) in places() {
            let on = point_of_sum(&*nominal, &map, along, x, y);
            let query = on + Vector3::new(0.3, -0.2, 2.0);
            let foot = sum.closest_point(&query).expect("the shape is sound");
            let distance = |k: usize| {
                difference(1e-2, |d| {
                    let moved = query + Vector3::ith(k, d);
                    sum.closest_point(&moved).expect("the shape is sound").signed_distance_mm
                })
            };
            let gradient = Vector3::from_fn(|k, _| distance(k));
            // Knots of the map within the step leave a third derivative of 3e-4 /mm² and h² of it.
            assert!((gradient - foot.normal.into_inner()).norm() < 1e-8, "{x} {y}: {gradient}");
            let foot = sum.closest_point(&on).expect("the shape is sound");
            let Curvature { major_per_mm, minor_per_mm, major_direction, minor_direction } =
                sum.curvature(&on).expect("the shape is sound");
            for (kappa, t) in [(major_per_mm, major_direction), (minor_per_mm, minor_direction)] {
                assert!(t.dot(&foot.normal).abs() < 1e-12);
                let normal = |d: f64| {
                    let moved = on + t.into_inner() * d;
                    sum.closest_point(&moved).expect("the shape is sound").normal.into_inner()
                };
                let turn = difference(1e-5, normal);
                let error = (turn + t.into_inner() * kappa).norm();
                assert!(error < TURN_TOL_PER_MM, "{along:?} {x} {y}: {error:e} beside {kappa}");
            }
        }
    }
}

/// Where the sum has a name of its own: a bowl with a quadratic along z is another bowl.
#[test]
fn a_bowl_with_a_focus_along_z_is_the_bowl_of_another_radius() {
    let flat = Polynomial::new(1.0, [(2, 0, 1e-3), (0, 2, 1e-3)]).expect("the shape is sound");
    let bent =
        Polynomial::new(1.0, [(2, 0, 1.02e-3), (0, 2, 1.02e-3)]).expect("the shape is sound");
    let added = map(|x, y| 2e-5 * (x * x + y * y));
    let sum = FormedSurface::new(Arc::new(flat), added, DeviationAlong::Z);
    for (x, y) in places() {
        let query = Point3::new(x, y, 1e-3 * (x * x + y * y) + 5.0);
        let (found, known) = (
            sum.closest_point(&query).expect("the shape is sound"),
            bent.closest_point(&query).expect("the shape is sound"),
        );
        assert!((found.point_mm - known.point_mm).norm() < EXACT_MM, "{found:?} {known:?}");
        assert!((found.signed_distance_mm - known.signed_distance_mm).abs() < EXACT_MM);
        let on = known.point_mm;
        let (found, known) = (
            sum.curvature(&on).expect("the shape is sound"),
            bent.curvature(&on).expect("the shape is sound"),
        );
        assert!((found.major_per_mm - known.major_per_mm).abs() < 1e-12, "{found:?} {known:?}");
        assert!((found.minor_per_mm - known.minor_per_mm).abs() < 1e-12);
        let line = Line::new(query, Vector3::new(0.1, 0.3, -1.0)).expect("the shape is sound");
        let (found, known) = (
            sum.first_hit(&line).expect("the shape is sound"),
            bent.first_hit(&line).expect("the shape is sound"),
        );
        assert!((found.distance_mm - known.distance_mm).abs() < EXACT_MM, "{found:?} {known:?}");
        assert!((found.normal.into_inner() - known.normal.into_inner()).norm() < 1e-12);
    }
    let away = Line::new(Point3::new(0.0, 0.0, 5.0), Vector3::z()).expect("the shape is sound");
    assert!(matches!(sum.first_hit(&away), Err(GeometryError::BehindRay { .. })));
    let beside = Line::new(Point3::new(500.0, 0.0, 5.0), Vector3::z()).expect("the shape is sound");
    assert_eq!(sum.hits(&beside), Err(GeometryError::Misses));
}

#[test]
fn without_deviation_it_is_the_nominal_surface() {
    for (nominal, along) in nominals().into_iter().flat_map(|n| BOTH.map(|a| (n.clone(), a))) {
        let sum = FormedSurface::new(nominal.clone(), map(|_, _| 0.0), along);
        for (x, y) in places() {
            let on = point_of_sum(&*nominal, &map(|_, _| 0.0), along, x, y);
            let query = on + Vector3::new(0.5, 0.4, 3.0);
            let (found, known) = (
                sum.closest_point(&query).expect("the shape is sound"),
                nominal.closest_point(&query).expect("the shape is sound"),
            );
            assert!((found.point_mm - known.point_mm).norm() < EXACT_MM, "{found:?} {known:?}");
            assert!((found.signed_distance_mm - known.signed_distance_mm).abs() < EXACT_MM);
            let sideways = found.normal.into_inner() - known.normal.into_inner();
            assert!(sideways.norm() < 1e-13);
        }
    }
}

#[test]
fn a_map_with_gaps_is_the_surface_where_it_was_measured() {
    let at = |k: i32| f64::from(k) * SPACING_MM;
    let heights: Vec<Option<f64>> = (-HALF..=HALF)
        .flat_map(|j| (-HALF..=HALF).map(move |i| (at(i), at(j))))
        .map(|(x, y)| (x.hypot(y) < 50.0).then(|| wavy(x, y)))
        .collect();
    let origin = Point2::new(at(-HALF), at(-HALF));
    let spacing = Vector2::repeat(SPACING_MM);
    let round = HeightGrid::with_gaps(origin, spacing, 61, &heights).expect("the shape is sound");
    assert!(round.is_measured(0.0, 0.0) && round.is_measured(30.0, -37.0));
    assert!(!round.is_measured(50.5, 0.0) && !round.is_measured(45.0, 45.0));
    // On the border of the last measured cell.
    assert!(round.is_measured(48.0, 0.0) && !round.is_measured(48.1, 0.0));
    assert!(!round.is_measured(1e3, 0.0));
    // Four places inside, what was filled in outside is gone: 0.27 a place, of bends of 5e-3 mm.
    let whole = map(wavy);
    for (x, y) in places().filter(|(x, y)| x.hypot(*y) < 40.0) {
        assert!((round.sag_mm(x, y) - whole.sag_mm(x, y)).abs() < 2e-5, "({x}, {y})");
    }
    let sum = FormedSurface::new(bowl(), round.clone(), DeviationAlong::Normal);
    assert!(
        sum.closest_point(&Point3::new(40.0, 0.0, 12.0))
            .expect("the shape is sound")
            .inside_aperture
    );
    assert!(
        !sum.closest_point(&Point3::new(46.0, 28.0, 20.0))
            .expect("the shape is sound")
            .inside_aperture
    );
    let none = HeightGrid::with_gaps(origin, spacing, 61, &vec![None; 61 * 61]);
    assert_eq!(none, Err(GeometryError::InvalidGrid { columns: 61, rows: 61, heights: 0 }));
    let ragged = HeightGrid::with_gaps(origin, spacing, 4, &[Some(0.0); 17]);
    assert!(matches!(ragged, Err(GeometryError::InvalidGrid { .. })));
}

#[test]
fn a_query_in_the_centre_of_curvature_has_no_foot() {
    let terms = [(2, 0, 5e-3), (0, 2, 5e-3)];
    let nominal: Arc<dyn Surface> =
        Arc::new(Polynomial::new(1.0, terms).expect("the shape is sound"));
    let sum = FormedSurface::new(nominal, map(|_, _| 0.01), DeviationAlong::Z);
    let center = sum.closest_point(&Point3::new(0.0, 0.0, 100.01));
    assert!(matches!(center, Err(GeometryError::AmbiguousFoot { .. })), "{center:?}");
    let nan = sum.closest_point(&Point3::new(f64::NAN, 0.0, 0.0));
    assert!(matches!(nan, Err(GeometryError::NonFinite { .. })));
    let up: Unit<Vector3<f64>> =
        sum.closest_point(&Point3::new(0.0, 0.0, 9.0)).expect("the shape is sound").normal;
    assert!((up.z - 1.0).abs() < 1e-15);
}
