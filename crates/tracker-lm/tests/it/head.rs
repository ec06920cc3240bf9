//! Both rotary axes of a head in one survey, against a head simulated without the crate's geometry.

use model_discrepancy::{Verdict, close_loop};
use nalgebra::{Matrix3, Matrix6, Point3, Vector2, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tracker_lm::{
    AxesRelation, AxisLetter, AxisModel, Formulation, Mount, Noise, Options, Range, RotaryAxis,
    SecondAxis, Station, Step, Survey, TrackerError, TrackerModel, calibrate, find_axis,
};

use crate::scene::{gaussian, rodrigues};

const NOISE_MM: f64 = 5e-4;
const STATION_MM: f64 = 4e-3;
/// Rounding of a metre in the residual over what holds the weakest direction.
const EXACT_MM: f64 = 1e-8;
const EXACT_RAD: f64 = 1e-10;

/// A line that something turns about.
#[derive(Clone, Copy)]
struct Line {
    origin: Vector3<f64>,
    direction: Vector3<f64>,
}

impl Line {
    fn turned(&self, angle: f64, point: Vector3<f64>) -> Vector3<f64> {
        self.origin + rodrigues(&self.direction, angle) * (point - self.origin)
    }
}

/// A fork head: C turns the fork, and in it B turns the spindle with the reflectors.
struct Head {
    /// Where the axes really are, C and B with C at its place.
    lines: [Line; 2],
    /// Angle at which each stands while the other turns.
    stand: [f64; 2],
    angles: [Vec<f64>; 2],
    /// Errors of the two as functions of their angles: displacement and rotation.
    errors: fn(usize, f64) -> (Vector3<f64>, Vector3<f64>),
}

fn letters() -> [AxisLetter; 2] {
    [AxisLetter::C, AxisLetter::B]
}

/// Declared: B crosses C 30 mm off.
fn declared() -> [Line; 2] {
    let c = Line { origin: Vector3::new(400.0, 400.0, 900.0), direction: Vector3::z() };
    let b = Line { origin: Vector3::new(430.0, 380.0, 650.0), direction: Vector3::y() };
    [c, b]
}

fn steps_of(from_deg: i32, to_deg: i32, by_deg: usize) -> Vec<f64> {
    (from_deg..=to_deg).step_by(by_deg).map(|a| f64::from(a).to_radians()).collect()
}

fn no_errors(_: usize, _: f64) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::zeros(), Vector3::zeros())
}

/// Some µm and µrad, by three harmonics.
fn errors(axis: usize, angle: f64) -> (Vector3<f64>, Vector3<f64>) {
    let wave = |i: usize, size: f64| {
        let phase = 1.3 * i as f64 + 0.7 * axis as f64;
        size * ((angle + phase).cos()
            + 0.5 * (2.0 * angle - phase).sin()
            + 0.2 * (3.0 * angle).cos())
    };
    (Vector3::from_fn(|i, _| wave(i, 5e-3)), Vector3::from_fn(|i, _| wave(i + 3, 20e-6)))
}

fn head(errors: fn(usize, f64) -> (Vector3<f64>, Vector3<f64>)) -> Head {
    let angles = [steps_of(-90, 90, 15), steps_of(-95, 105, 20)];
    Head { lines: declared(), stand: [0.0, 5_f64.to_radians()], angles, errors }
}

/// Moves a body by errors about a point.
fn by_errors(
    point: Vector3<f64>,
    about: Vector3<f64>,
    (moved, turn): (Vector3<f64>, Vector3<f64>),
) -> Vector3<f64> {
    let length = turn.norm();
    let rotation =
        if length > 0.0 { rodrigues(&(turn / length), length) } else { Matrix3::identity() };
    about + moved + rotation * (point - about)
}

struct Scene {
    survey: Survey,
}

/// Places of the tracer about the head.
const STATIONS: [[f64; 3]; 6] = [
    [40.0, 60.0, 30.0],
    [760.0, 80.0, 80.0],
    [110.0, 750.0, 50.0],
    [700.0, 720.0, 400.0],
    [80.0, 90.0, 480.0],
    [740.0, 120.0, 430.0],
];
/// Reflectors about the origin of B: below it, where the tool is.
const MOUNTS: [[f64; 3]; 4] =
    [[150.0, -40.0, -60.0], [-120.0, 60.0, -140.0], [40.0, 90.0, -230.0], [-60.0, -80.0, -20.0]];

fn simulate(head: &Head, noise_mm: f64, station_mm: f64, seed: u64) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let declared = declared();
    let mut off = |size: f64| Vector3::from_fn(|_, _| size * gaussian(&mut rng));
    let stations: Vec<Vector3<f64>> = STATIONS.map(Vector3::from).to_vec();
    let nominal: Vec<_> = stations.iter().map(|s| s + off(station_mm)).collect();
    let bodies: Vec<Vector3<f64>> = MOUNTS
        .iter()
        .map(|m| Vector3::from(*m) + off(if noise_mm > 0.0 { 0.3 } else { 0.0 }))
        .collect();
    let [c0, b0] = head.stand;
    let mut poses = vec![[c0, b0]];
    poses.extend(head.angles[0].iter().map(|c| [*c, b0]));
    poses.push([c0, b0]);
    poses.extend(head.angles[1].iter().map(|b| [c0, *b]));
    let dead: Vec<f64> =
        (0..stations.len() * bodies.len()).map(|_| rng.random_range(50.0..150.0)).collect();
    let mut ranges = Vec::new();
    for (step, [c, b]) in poses.iter().enumerate() {
        let since = |axis: usize, angle: f64, stand: f64| {
            let (here, there) = ((head.errors)(axis, angle), (head.errors)(axis, stand));
            (here.0 - there.0, here.1 - there.1)
        };
        for (mount, body) in bodies.iter().enumerate() {
            // Where the reflector is in the fork with B at zero; then B turns, then C.
            let [on_c, on_b] = head.lines;
            let place = declared[1].origin + body;
            let place = on_b.turned(*b, place);
            let place = by_errors(place, declared[1].origin, since(1, *b, b0));
            let place = on_c.turned(c - c0, place);
            let place = by_errors(place, declared[0].origin, since(0, *c, c0));
            for (station, at) in stations.iter().enumerate() {
                let displacement_mm = (place - at).norm() - dead[station * bodies.len() + mount]
                    + noise_mm * gaussian(&mut rng);
                ranges.push(Range { station, mount, step, displacement_mm });
            }
        }
    }
    let axis = |i: usize| {
        let Line { origin, direction } = declared[i];
        RotaryAxis::new(letters()[i], Point3::from(origin), direction).unwrap()
    };
    let survey = Survey {
        axis: axis(0),
        second: Some(SecondAxis {
            axis: axis(1),
            angles_rad: poses.iter().map(|p| p[1]).collect(),
        }),
        stations: (nominal.iter().enumerate())
            .map(|(i, s)| Station { name: format!("S{}", i + 1), nominal_mm: Point3::from(*s) })
            .collect(),
        mounts: (MOUNTS.iter().enumerate())
            .map(|(j, m)| Mount { name: format!("R{}", j + 1), nominal_mm: Point3::from(*m) })
            .collect(),
        steps: (poses.iter().enumerate())
            .map(|(n, p)| Step { name: (n + 1).to_string(), angle_rad: p[0], approach: None })
            .collect(),
        ranges,
    };
    Scene { survey }
}

fn options() -> Options {
    let noise =
        Noise { displacement_mm: Some(NOISE_MM), station_mm: Some(STATION_MM), rigid_mm: None };
    Options { noise, ..Options::default() }
}

/// Six errors of an axis at an angle against where it stands.
fn truth(axis: usize, angle: f64, stand: f64) -> Vector6<f64> {
    let (here, there) = (errors(axis, angle), errors(axis, stand));
    let (moved, turn) = (here.0 - there.0, here.1 - there.1);
    Vector6::new(moved.x, moved.y, moved.z, turn.x, turn.y, turn.z)
}

/// Without noise the errors of both axes come back to rounding.
#[test]
fn errors_of_both_axes_come_back() {
    let head = head(errors);
    let found = calibrate(&simulate(&head, 0.0, 0.0, 1).survey, &options()).unwrap();
    let second = found.second.unwrap();
    for (axis, found) in [&found.axis_errors, &second.axis_errors].into_iter().enumerate() {
        // The angle where an axis stands counts once.
        assert_eq!(found.len(), [13, 11][axis]);
        for error in found {
            let away = error.error - truth(axis, error.angle_rad, head.stand[axis]);
            assert!(
                away.fixed_rows::<3>(0).amax() < EXACT_MM,
                "{axis} {}: {away}",
                error.angle_rad
            );
            assert!(
                away.fixed_rows::<3>(3).amax() < EXACT_RAD,
                "{axis} {}: {away}",
                error.angle_rad
            );
        }
    }
}

/// Axes that stand elsewhere: places in the machine, and how they lie to each other.
#[test]
fn axes_off_their_places_are_located_and_related() {
    let mut head = head(no_errors);
    let [c, b] = declared();
    head.lines = [
        Line {
            origin: c.origin + Vector3::new(0.020, -0.011, 0.0),
            direction: Vector3::new(30e-6, -10e-6, 1.0).normalize(),
        },
        Line {
            origin: b.origin + Vector3::new(-0.015, 0.0, 0.008),
            direction: Vector3::new(-25e-6, 1.0, 40e-6).normalize(),
        },
    ];
    let found = calibrate(&simulate(&head, 0.0, 0.0, 2).survey, &options()).unwrap();
    let second = found.second.as_ref().unwrap();
    // Tilts of axes, rotations about x and y of C, about x and z of B; what is left is of second order.
    let of_c = found.location.as_ref().unwrap().errors;
    let of_b = second.location.as_ref().unwrap().errors;
    for (found, truth) in of_c.iter().zip([0.020, -0.011, 10e-6, 30e-6]) {
        assert!((found - truth).abs() < 1e-7, "{of_c}");
    }
    for (found, truth) in of_b.iter().zip([-0.015, 0.008, 40e-6, 25e-6]) {
        assert!((found - truth).abs() < 1e-7, "{of_b}");
    }
    // Offset and angle of two lines, from their coordinates.
    let [c, b] = head.lines;
    let normal = b.direction.cross(&c.direction).normalize();
    let offset = normal.dot(&(b.origin - c.origin));
    let square = b.direction.dot(&c.direction);
    let relation = second.relation.as_ref().unwrap();
    assert!((relation.nominal_offset_mm - 30.0).abs() < 1e-9);
    assert!((relation.direction.x - 1.0).abs() < 1e-9);
    assert!(
        (relation.nominal_offset_mm + relation.offset_error_mm - offset).abs() < 1e-6,
        "{relation:?}"
    );
    // A rotation of B about x by a positive angle turns it towards C: the cosine grows with it.
    assert!((relation.rotation_error_rad - square).abs() < 1e-8, "{relation:?} {square}");
}

/// Offset and rotation.
fn both(relation: &AxesRelation) -> Vector2<f64> {
    Vector2::new(relation.offset_error_mm, relation.rotation_error_rad)
}

/// Normalised squares of the errors of both axes at their last angles, and of how the axes lie to each
/// other, over sixty surveys; and how much better that is known than the places themselves.
#[test]
fn uncertainties_cover_both_axes() {
    const RUNS: u64 = 60;
    let head = head(errors);
    let (mut squares, mut of_relation) = ([0.0; 2], 0.0);
    let exact = calibrate(&simulate(&head, 0.0, 0.0, 1).survey, &options()).unwrap();
    let known = both(&exact.second.unwrap().relation.unwrap());
    for seed in 0..RUNS {
        let found =
            calibrate(&simulate(&head, NOISE_MM, STATION_MM, 100 + seed).survey, &options())
                .unwrap();
        let second = found.second.as_ref().unwrap();
        for (axis, errors) in [&found.axis_errors, &second.axis_errors].into_iter().enumerate() {
            let last = errors.last().unwrap();
            let away = last.error - truth(axis, last.angle_rad, head.stand[axis]);
            let inverse: Matrix6<f64> = last.covariance.try_inverse().unwrap();
            squares[axis] += away.dot(&(inverse * away));
        }
        let relation = second.relation.as_ref().unwrap();
        let away = both(relation) - known;
        of_relation += away.dot(&(relation.covariance.try_inverse().unwrap() * away));
        let place = |l: &tracker_lm::AxisLocation, i: usize| l.covariance[(i, i)].sqrt();
        let own = place(found.location.as_ref().unwrap(), 2)
            .hypot(place(second.location.as_ref().unwrap(), 2));
        // The frame of the stations tilts both axes alike, and does not turn one against the other.
        assert!(relation.covariance[(1, 1)].sqrt() < 0.5 * own, "{own} {}", relation.covariance);
    }
    // Means of χ² with 6 and 2 degrees of freedom within 3.3 standard deviations of theirs.
    let within = |mean: f64, dof: f64| (mean - dof).abs() < 3.3 * (2.0 * dof / RUNS as f64).sqrt();
    let mean = |sum: f64| sum / RUNS as f64;
    assert!(within(mean(squares[0]), 6.0) && within(mean(squares[1]), 6.0), "{squares:?}");
    assert!(within(mean(of_relation), 2.0), "{}", mean(of_relation));
}

/// The loop on a sound survey adds nothing, and names a lost beam with the errors of both axes kept.
#[test]
fn the_loop_closes_on_both_axes() {
    let head = head(errors);
    let mut survey = simulate(&head, NOISE_MM, STATION_MM, 7).survey;
    let closed = |survey: &Survey| {
        let model = TrackerModel::new(survey.clone(), None, Vec::new(), &options()).unwrap();
        let closure =
            close_loop(&model, &model.coordinates(), &model_discrepancy::Options::default())
                .unwrap();
        (model, closure)
    };
    let (_, closure) = closed(&survey);
    assert!(closure.steps.is_empty() && closure.verdict == Verdict::NothingMissing);
    // Lost in the middle of B's run.
    for range in &mut survey.ranges {
        if range.station == 2 && range.mount == 1 && range.step >= 20 {
            range.displacement_mm += 0.02;
        }
    }
    let (model, closure) = closed(&survey);
    let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert_eq!(names, ["dead-path-jump"], "{:?}", closure.steps);
    let found = model.calibration_with(&closure).unwrap();
    let second = found.second.unwrap();
    for (axis, found) in [&found.axis_errors, &second.axis_errors].into_iter().enumerate() {
        for error in found {
            let away = error.error - truth(axis, error.angle_rad, head.stand[axis]);
            for (away, std) in away.iter().zip(error.sigmas().iter()) {
                assert!(away.abs() <= 5.0 * std, "{axis}: {away} {std}");
            }
        }
    }
    assert!(second.relation.is_some() && second.location.is_some());
}

#[test]
fn what_two_axes_need_is_said() {
    let head = head(no_errors);
    let survey = simulate(&head, NOISE_MM, STATION_MM, 8).survey;
    let refused = |survey: &Survey| calibrate(survey, &options()).unwrap_err();

    // B never turned.
    let mut alone = survey.clone();
    let second = alone.second.as_mut().unwrap();
    second.angles_rad.fill(head.stand[1]);
    let error = refused(&alone);
    assert!(matches!(error, TrackerError::AxisStands { letter: 'B', .. }), "{error}");
    assert!(error.to_string().contains("axis B stands at 5.0000° at every step"), "{error}");

    // A step with both away.
    let mut both = survey.clone();
    both.second.as_mut().unwrap().angles_rad[3] = 0.5;
    let error = refused(&both);
    assert!(matches!(&error, TrackerError::BothAxesTurned { step, .. } if step == "4"), "{error}");

    // The pose where both stand is missing.
    let mut apart = survey.clone();
    let is_common = |step: usize| {
        let b = survey.second.as_ref().unwrap().angles_rad[step];
        survey.steps[step].angle_rad.total_cmp(&head.stand[0]).is_eq()
            && b.total_cmp(&head.stand[1]).is_eq()
    };
    apart.ranges.retain(|r| !is_common(r.step));
    let kept: Vec<usize> = (0..survey.steps.len()).filter(|&s| !is_common(s)).collect();
    apart.steps = kept.iter().map(|&s| survey.steps[s].clone()).collect();
    let angles = &survey.second.as_ref().unwrap().angles_rad;
    apart.second.as_mut().unwrap().angles_rad = kept.iter().map(|&s| angles[s]).collect();
    for range in &mut apart.ranges {
        range.step = kept.iter().position(|&s| s == range.step).unwrap();
    }
    let error = refused(&apart);
    assert!(matches!(error, TrackerError::NoCommonPose { .. }), "{error}");

    // Another model.
    for other in [
        Options { axis: AxisModel::Fixed, ..options() },
        Options { formulation: Formulation::FreePoints, ..options() },
    ] {
        assert_eq!(calibrate(&survey, &other).unwrap_err(), TrackerError::TwoAxesOtherwise);
    }
    let sought = find_axis(&survey, tracker_lm::Sought::Origin, &options());
    assert_eq!(sought.unwrap_err(), TrackerError::TwoAxesOtherwise);
    let mut short = survey.clone();
    short.second.as_mut().unwrap().angles_rad.pop();
    assert!(matches!(refused(&short), TrackerError::SecondAngles { .. }));

    // Reflectors on one line show no rotation about it.
    let mut line = survey;
    for (j, mount) in line.mounts.iter_mut().enumerate() {
        mount.nominal_mm = Point3::new(0.0, 40.0 * j as f64, 0.0);
    }
    assert!(matches!(refused(&line), TrackerError::CollinearMounts { .. }));
}
