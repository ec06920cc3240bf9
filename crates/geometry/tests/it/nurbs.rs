//! NURBS surfaces: against shapes that they repeat exactly, differences, and brute force.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use geometry::nalgebra::{Point3, Unit, Vector3};
use geometry::{GeometryError, Line, Nurbs, Surface};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Parts of 100 mm, a thousand operations.
const EXACT_TOL_MM: f64 = 1e-11;
/// The contact of a ball on exact data.
const CONTACT_TOL_MM: f64 = 1e-10;
/// Round-off of products of 25 mm by 50 mm, and one operation more.
const POLE_TOL_MM2: f64 = 5e-13;

/// A circle of nine points: x, y and weight.
const CIRCLE: [[f64; 3]; 9] = [
    [1.0, 0.0, 1.0],
    [1.0, 1.0, FRAC_1_SQRT_2],
    [0.0, 1.0, 1.0],
    [-1.0, 1.0, FRAC_1_SQRT_2],
    [-1.0, 0.0, 1.0],
    [-1.0, -1.0, FRAC_1_SQRT_2],
    [0.0, -1.0, 1.0],
    [1.0, -1.0, FRAC_1_SQRT_2],
    [1.0, 0.0, 1.0],
];
const QUARTERS: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];

/// A profile in the xz plane, turned about z.
fn turned(profile: &[[f64; 3]], degree: usize, knots: Vec<f64>) -> Nurbs {
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for [r, z, w] in profile {
        for [x, y, v] in &CIRCLE {
            points.push(Point3::new(r * x, r * y, *z));
            weights.push(w * v);
        }
    }
    Nurbs::new([2, degree], [QUARTERS.to_vec(), knots], &points, &weights)
        .expect("the net is sound")
}

fn cylinder(radius_mm: f64) -> Nurbs {
    let profile = [[radius_mm, -40.0, 1.0], [radius_mm, 40.0, 1.0]];
    turned(&profile, 1, vec![0.0, 0.0, 1.0, 1.0])
}

fn sphere(radius_mm: f64) -> Nurbs {
    let half = [6, 7, 0, 1, 2].map(|k: usize| CIRCLE[k]);
    let profile = half.map(|[r, z, w]| [r * radius_mm, z * radius_mm, w]);
    turned(&profile, 2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0])
}

fn torus(major_mm: f64, minor_mm: f64) -> Nurbs {
    let profile = CIRCLE.map(|[r, z, w]| [major_mm + minor_mm * r, minor_mm * z, w]);
    turned(&profile, 2, QUARTERS.to_vec())
}

/// A bumpy sheet over 80 × 80 mm with random heights and weights.
fn sheet(degrees: [usize; 2], bumps_mm: f64, rng: &mut ChaCha8Rng) -> Nurbs {
    let count = 9;
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for j in 0..count {
        for i in 0..count {
            let [x, y] = [i, j].map(|k| 10.0 * f64::from(k) - 40.0);
            let z = (x * x - 0.4 * y * y) / 160.0 + bumps_mm * rng.random_range(-1.0..1.0);
            points.push(Point3::new(x, y, z));
            weights.push(rng.random_range(0.7..1.4));
        }
    }
    let knots = degrees.map(|d| Nurbs::clamped_knots(d, usize::try_from(count).expect("nine")));
    Nurbs::new(degrees, knots, &points, &weights).expect("the net is sound")
}

fn place(surface: &Nurbs, rng: &mut ChaCha8Rng) -> [f64; 2] {
    surface.domain().map(|[from, to]| rng.random_range(from..to))
}

fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let [z, turn] = [rng.random_range(-1.0..1.0), rng.random_range(0.0..TAU)];
    let side = f64::sqrt(1.0 - z * z);
    Vector3::new(side * turn.cos(), side * turn.sin(), z)
}

#[test]
fn weights_of_the_control_points_sum_to_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for degree in 1..=8 {
        let count = degree + 4;
        let at = |k: usize| f64::from(u8::try_from(k).unwrap());
        let mut knots = Nurbs::clamped_knots(degree, count);
        // Uneven, with one repeated.
        if degree > 1 {
            knots[degree + 1] = knots[degree + 2];
        }
        knots[degree + 3] += 0.3;
        let other = Nurbs::clamped_knots(2, 4);
        let points: Vec<_> =
            (0..count * 4).map(|k| Point3::new(at(k % count), at(k / count), 7.0)).collect();
        let weights: Vec<f64> = points.iter().map(|_| rng.random_range(0.2..5.0)).collect();
        let surface = Nurbs::new([degree, 2], [knots, other], &points, &weights).unwrap();
        for _ in 0..50 {
            let [u, v] = place(&surface, &mut rng);
            let jet = surface.jet(u, v).unwrap();
            assert!((jet.point_mm.z - 7.0).abs() < 1e-13);
            assert!(jet.tangents_mm.iter().chain(&jet.bends_mm).all(|d| d.z.abs() < 1e-11));
        }
    }
}

#[test]
fn derivatives_agree_with_differences() {
    /// Step of the differences and what their truncation, third derivatives below 1e3 mm, leaves.
    const STEP: f64 = 1e-5;
    const TOL_MM: f64 = 1e-5;
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for degrees in [[1, 1], [2, 3], [3, 3], [5, 2], [4, 6]] {
        let surface = sheet(degrees, 4.0, &mut rng);
        for _ in 0..40 {
            let [u, v] = place(&surface, &mut rng);
            let at = |a: f64, b: f64| surface.jet(u + a, v + b);
            // Across a knot the highest derivatives jump.
            let near_knot = |t: f64| (t - t.round()).abs() < 2.0 * STEP;
            if near_knot(u) || near_knot(v) {
                continue;
            }
            let jet = at(0.0, 0.0).unwrap();
            for (d, step) in [[STEP, 0.0], [0.0, STEP]].into_iter().enumerate() {
                let (up, down) = (at(step[0], step[1]).unwrap(), at(-step[0], -step[1]).unwrap());
                let first = (up.point_mm - down.point_mm) / (2.0 * STEP);
                assert!((first - jet.tangents_mm[d]).norm() < TOL_MM);
                for other in 0..2 {
                    let second = (up.tangents_mm[other] - down.tangents_mm[other]) / (2.0 * STEP);
                    assert!((second - jet.bends_mm[d + other]).norm() < TOL_MM, "{degrees:?}");
                }
            }
        }
    }
}

#[test]
fn a_cylinder_is_a_cylinder() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let surface = cylinder(25.0);
    for _ in 0..300 {
        let [turn, z] = [rng.random_range(0.0..TAU), rng.random_range(-39.0..39.0)];
        let out = Vector3::new(turn.cos(), turn.sin(), 0.0);
        let on = Point3::from(out * 25.0 + Vector3::z() * z);
        let gap = rng.random_range(-20.0..30.0);
        let foot = surface.closest_point(&(on + out * gap)).unwrap();
        assert!((foot.point_mm - on).norm() < EXACT_TOL_MM, "{turn}");
        assert!((foot.normal.into_inner() - out).norm() < EXACT_TOL_MM);
        assert!((foot.signed_distance_mm - gap).abs() < EXACT_TOL_MM);
        assert!(foot.inside_aperture);
        let curvature = surface.curvature(&on).unwrap();
        assert!(curvature.major_per_mm.abs() < EXACT_TOL_MM);
        assert!((curvature.minor_per_mm + 1.0 / 25.0).abs() < EXACT_TOL_MM);
        assert!(curvature.major_direction.z.abs() > 1.0 - EXACT_TOL_MM);
    }
    let beyond = surface.closest_point(&Point3::new(26.0, 0.0, 60.0));
    assert!(matches!(beyond, Err(GeometryError::OutsideAperture { .. })), "{beyond:?}");
    let axis = surface.closest_point(&Point3::new(0.0, 0.0, 3.0));
    assert!(matches!(axis, Err(GeometryError::AmbiguousFoot { .. })), "{axis:?}");
}

#[test]
fn a_sphere_is_a_sphere_up_to_its_poles() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let surface = sphere(25.0);
    let near_pole = |rng: &mut ChaCha8Rng| {
        let size = 10.0_f64.powf(rng.random_range(-9.0..-1.0));
        (Vector3::z() + direction(rng) * size).normalize()
    };
    let poles = [Vector3::z(), -Vector3::z()];
    let random: Vec<_> = (0..400)
        .map(|k| if k % 2 == 0 { direction(&mut rng) } else { near_pole(&mut rng) })
        .collect();
    for out in poles.into_iter().chain(random) {
        let gap = rng.random_range(-20.0..30.0);
        let on = Point3::from(out * 25.0);
        let foot = surface.closest_point(&(on + out * gap));
        let foot = foot.unwrap_or_else(|e| panic!("{out:?} {gap}: {e}"));
        // The tangent along u vanishes with the distance from the axis, and round-off of 625 mm²
        // is divided by it; nearer than that, the pole itself is as good.
        let off_axis = on.coords.xy().norm();
        let tol = CONTACT_TOL_MM.max((POLE_TOL_MM2 / off_axis).min(2.0 * off_axis));
        assert!((foot.point_mm - on).norm() < tol, "{out:?}: {foot:?}");
        assert!((foot.signed_distance_mm - gap).abs() < EXACT_TOL_MM, "{out:?}");
        assert!((foot.normal.into_inner() - out).norm() < tol, "{out:?}: {foot:?}");
    }
    let center = surface.closest_point(&Point3::origin());
    assert!(matches!(center, Err(GeometryError::AmbiguousFoot { .. })), "{center:?}");
}

#[test]
fn a_torus_is_a_torus() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (major, minor) = (40.0, 12.0);
    let surface = torus(major, minor);
    for _ in 0..300 {
        let [turn, about] = [rng.random_range(0.0..TAU), rng.random_range(0.0..TAU)];
        let side = Vector3::new(turn.cos(), turn.sin(), 0.0);
        let out = side * about.cos() + Vector3::z() * about.sin();
        let on = Point3::from(side * major + out * minor);
        let gap = rng.random_range(-10.0..15.0);
        let foot = surface.closest_point(&(on + out * gap)).unwrap();
        assert!((foot.point_mm - on).norm() < EXACT_TOL_MM);
        assert!((foot.signed_distance_mm - gap).abs() < EXACT_TOL_MM);
        let curvature = surface.curvature(&on).unwrap();
        let mut expected = [-1.0 / minor, -about.cos() / (major + minor * about.cos())];
        expected.sort_by(f64::total_cmp);
        assert!((curvature.minor_per_mm - expected[0]).abs() < EXACT_TOL_MM);
        assert!((curvature.major_per_mm - expected[1]).abs() < EXACT_TOL_MM);
    }
    // Both sides of the hole are as near.
    let middle = surface.closest_point(&Point3::new(0.0, 0.0, 1.0));
    assert!(matches!(middle, Err(GeometryError::AmbiguousFoot { .. })), "{middle:?}");
}

#[test]
fn balls_that_touch_a_sheet_are_put_back_where_they_touched() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for degrees in [[3, 3], [2, 4], [5, 5]] {
        let surface = sheet(degrees, 0.5, &mut rng);
        for _ in 0..200 {
            let [u, v] = place(&surface, &mut rng);
            let on = surface.jet(u, v).unwrap().point_mm;
            let ball = surface.offset_point(u, v, 3.0).unwrap();
            let foot = surface.closest_point(&ball).unwrap();
            assert!((foot.point_mm - on).norm() < CONTACT_TOL_MM);
            assert!((foot.signed_distance_mm - 3.0).abs() < CONTACT_TOL_MM);
            let found = surface.closest_place(&ball).unwrap();
            assert!((found[0] - u).abs() < 1e-10 && (found[1] - v).abs() < 1e-10);
        }
    }
}

#[test]
fn no_point_of_a_bumpy_sheet_is_nearer_than_its_foot() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut answered, mut refused) = (0, 0);
    for _ in 0..3 {
        let surface = sheet([3, 3], 12.0, &mut rng);
        let [[_, last], _] = surface.domain();
        let dense: Vec<Point3<f64>> = (0..=160)
            .flat_map(|i| (0..=160).map(move |j| [i, j]))
            .map(|at| at.map(|k| last * f64::from(k) / 160.0))
            .map(|[u, v]| surface.jet(u, v).unwrap().point_mm)
            .collect();
        for _ in 0..60 {
            let lateral = [rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0)];
            let query = Point3::new(lateral[0], lateral[1], rng.random_range(-30.0..30.0));
            match surface.closest_point(&query) {
                Ok(foot) => {
                    let nearest = dense.iter().map(|p| (p - query).norm()).fold(1e9, f64::min);
                    assert!(foot.signed_distance_mm.abs() <= nearest + EXACT_TOL_MM);
                    answered += 1;
                }
                Err(GeometryError::OutsideAperture { .. }) => refused += 1,
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(answered > 150, "{answered} answered, {refused} beside");
}

/// A net as a CAD program writes it: 240 × 200 control points over 600 × 420 mm, with waves of 40 mm
/// and of 570 mm.
#[test]
fn feet_on_a_net_of_real_size_are_the_nearest() {
    const COUNTS: [u32; 2] = [240, 200];
    let height =
        |x: f64, y: f64| 20.0 * (x / 90.0).sin() * (y / 110.0).cos() + 0.3 * (x / 7.0).sin();
    let along = |k: u32, count: u32| f64::from(k) / f64::from(count - 1) - 0.5;
    let points: Vec<Point3<f64>> = (0..COUNTS[1])
        .flat_map(|j| (0..COUNTS[0]).map(move |i| [i, j]))
        .map(|[i, j]| [600.0 * along(i, COUNTS[0]), 420.0 * along(j, COUNTS[1])])
        .map(|[x, y]| Point3::new(x, y, height(x, y)))
        .collect();
    let knots = COUNTS.map(|count| Nurbs::clamped_knots(3, count as usize));
    let surface = Nurbs::new([3, 3], knots, &points, &vec![1.0; points.len()]).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..300 {
        let [u, v] = place(&surface, &mut rng);
        let on = surface.jet(u, v).unwrap().point_mm;
        let foot = surface.closest_point(&surface.offset_point(u, v, 3.0).unwrap()).unwrap();
        assert!((foot.point_mm - on).norm() < CONTACT_TOL_MM);
    }
    let [[_, last_u], [_, last_v]] = surface.domain();
    let dense: Vec<Point3<f64>> = (0..=600)
        .flat_map(|i| (0..=420).map(move |j| [f64::from(i) / 600.0, f64::from(j) / 420.0]))
        .map(|[i, j]| surface.jet(i * last_u, j * last_v).unwrap().point_mm)
        .collect();
    for _ in 0..40 {
        let [x, y, z] = [250.0, 180.0, 120.0].map(|most| rng.random_range(-most..most));
        let query = Point3::new(x, y, z);
        let foot = surface.closest_point(&query).unwrap();
        let nearest = dense.iter().map(|p| (p - query).norm()).fold(1e9, f64::min);
        assert!(foot.signed_distance_mm.abs() <= nearest + EXACT_TOL_MM);
    }
}

#[test]
fn halfway_between_two_walls_no_foot_is_made_up() {
    // A gutter: a half cylinder, and queries on the plane and the line where feet are not single.
    let half: [[f64; 3]; 5] = [CIRCLE[4], CIRCLE[5], CIRCLE[6], CIRCLE[7], CIRCLE[8]];
    let rows = [-30.0, 30.0];
    let points: Vec<_> = rows
        .iter()
        .flat_map(|y| half.map(|[x, z, _]| Point3::new(20.0 * x, *y, 20.0 * z)))
        .collect();
    let weights: Vec<_> = rows.iter().flat_map(|_| half.map(|[_, _, w]| w)).collect();
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
    let gutter = Nurbs::new([2, 1], knots, &points, &weights).unwrap();
    let on_axis = gutter.closest_point(&Point3::new(0.0, 4.0, 0.0));
    assert!(matches!(on_axis, Err(GeometryError::AmbiguousFoot { .. })), "{on_axis:?}");
    // A hair beside it the answer is the true one.
    let foot = gutter.closest_point(&Point3::new(0.0, 4.0, -1e-3)).unwrap();
    assert!((foot.point_mm - Point3::new(0.0, 4.0, -20.0)).norm() < 1e-7);

    let ridge = |z: f64| {
        let heights = [6.0, 0.0, 6.0];
        let at = |k: usize| [-10.0, 0.0, 10.0][k];
        let points: Vec<_> =
            (0..9).map(|k| Point3::new(at(k % 3), at(k / 3), heights[k % 3])).collect();
        let knots = [0, 1].map(|_| Nurbs::clamped_knots(2, 3));
        let surface = Nurbs::new([2, 2], knots, &points, &[1.0; 9]).unwrap();
        surface.closest_point(&Point3::new(0.0, 1.0, z))
    };
    // z = 3 + 3 (x/10)²: centre of curvature 1/κ = 16.7 mm above the bottom.
    assert!((ridge(10.0).unwrap().point_mm.z - 3.0).abs() < EXACT_TOL_MM);
    let beyond = ridge(25.0);
    let refused = matches!(
        beyond,
        Err(GeometryError::AmbiguousFoot { .. } | GeometryError::OutsideAperture { .. })
    );
    assert!(refused, "{beyond:?}");
}

#[test]
fn lines_meet_a_sphere_where_they_must() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let surface = sphere(25.0);
    for _ in 0..100 {
        let aim = Point3::from(direction(&mut rng) * rng.random_range(0.0..22.0));
        let along = Unit::new_normalize(direction(&mut rng));
        let line = Line { point_mm: aim - along.into_inner() * 60.0, direction: along };
        let hits = surface.hits(&line).unwrap();
        assert_eq!(hits.len(), 2);
        let middle = -along.dot(&(line.point_mm.coords));
        let half =
            (625.0 - (line.point_mm + along.into_inner() * middle).coords.norm_squared()).sqrt();
        assert!((hits[0].distance_mm - (middle - half)).abs() < CONTACT_TOL_MM);
        assert!((hits[1].distance_mm - (middle + half)).abs() < CONTACT_TOL_MM);
        let first = surface.first_hit(&line).unwrap();
        assert!((first.distance_mm - hits[0].distance_mm).abs() < CONTACT_TOL_MM);
    }
    let beside = Line { point_mm: Point3::new(30.0, 0.0, 0.0), direction: Vector3::z_axis() };
    assert_eq!(surface.hits(&beside), Err(GeometryError::Misses));
    let along = Line { point_mm: Point3::new(25.0, 0.0, 0.0), direction: Vector3::z_axis() };
    assert_eq!(cylinder(25.0).hits(&along), Err(GeometryError::LineInSurface));
}

#[test]
fn flipping_turns_the_normal_and_nothing_else() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let surface = sheet([3, 2], 1.0, &mut rng);
    let flipped = surface.flipped();
    let query = Point3::new(3.0, -8.0, 9.0);
    let (one, other) = (surface.closest_point(&query), flipped.closest_point(&query));
    let (one, other) = (one.unwrap(), other.unwrap());
    assert!((one.point_mm - other.point_mm).norm() < EXACT_TOL_MM);
    assert!((one.normal.into_inner() + other.normal.into_inner()).norm() < EXACT_TOL_MM);
    assert!((one.signed_distance_mm + other.signed_distance_mm).abs() < EXACT_TOL_MM);
}

#[test]
fn nets_that_are_no_surface() {
    let knots = || Nurbs::clamped_knots(2, 4);
    let points: Vec<_> =
        (0..16).map(|k| Point3::new(f64::from(k % 4), f64::from(k / 4), 0.0)).collect();
    let weights = vec![1.0; 16];
    let with = |degrees, u: Vec<f64>, points: &[Point3<f64>], weights: &[f64]| {
        Nurbs::new(degrees, [u, knots()], points, weights).map(|_| ())
    };
    assert_eq!(with([2, 2], knots(), &points, &weights), Ok(()));
    let error = |result: Result<(), GeometryError>| result.unwrap_err();
    assert!(matches!(
        error(with([0, 2], knots(), &points, &weights)),
        GeometryError::InvalidDegree { degree: 0, .. }
    ));
    assert!(matches!(
        error(with([16, 2], knots(), &points, &weights)),
        GeometryError::InvalidDegree { degree: 16, .. }
    ));
    let few = with([2, 2], vec![0.0; 5], &points, &weights);
    assert_eq!(error(few), GeometryError::TooFewKnots { direction: "u", got: 5, needed: 6 });
    let back = with([2, 2], vec![0.0, 0.0, 0.0, 2.0, 1.0, 3.0, 3.0], &points, &weights);
    assert_eq!(error(back), GeometryError::KnotsDecrease { direction: "u", index: 4 });
    let all_same = with([2, 2], vec![1.0; 7], &points, &weights);
    assert!(matches!(error(all_same), GeometryError::KnotRepeated { .. }));
    let torn = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    let net: Vec<_> =
        (0..24).map(|k| Point3::new(f64::from(k % 6), f64::from(k / 6), 0.0)).collect();
    assert!(matches!(
        error(with([2, 2], torn, &net, &[1.0; 24])),
        GeometryError::KnotRepeated { index: 3, .. }
    ));
    let nan = vec![0.0, 0.0, 0.0, f64::NAN, 2.0, 2.0, 2.0];
    assert!(matches!(error(with([2, 2], nan, &points, &weights)), GeometryError::NonFinite { .. }));
    let short = with([2, 2], knots(), &points[..15], &weights);
    assert!(matches!(
        error(short),
        GeometryError::InvalidNet { columns: 4, rows: 4, points: 15, .. }
    ));
    for weight in [0.0, -1.0] {
        let mut weights = weights.clone();
        weights[5] = weight;
        let refused = error(with([2, 2], knots(), &points, &weights));
        assert_eq!(refused, GeometryError::InvalidWeight { index: 5, weight });
    }
    let mut infinite = points.clone();
    infinite[3].y = f64::INFINITY;
    assert!(matches!(
        error(with([2, 2], knots(), &infinite, &weights)),
        GeometryError::NonFinite { .. }
    ));
    let rows_on_a_line: Vec<_> = points.iter().map(|p| Point3::new(p.x, 0.0, 0.0)).collect();
    assert!(matches!(
        error(with([2, 2], knots(), &rows_on_a_line, &weights)),
        GeometryError::NoNormal { .. }
    ));
    let at_a_point = vec![Point3::new(1.0, 2.0, 3.0); 16];
    assert!(matches!(
        error(with([2, 2], knots(), &at_a_point, &weights)),
        GeometryError::NoNormal { .. }
    ));
    let flat = Nurbs::new([2, 2], [knots(), knots()], &points, &weights).unwrap();
    assert!(matches!(flat.jet(-0.1, 0.0), Err(GeometryError::OutsideKnots { .. })));
    let query = flat.closest_point(&Point3::new(f64::NAN, 0.0, 0.0));
    assert!(matches!(query, Err(GeometryError::NonFinite { .. })));
}
