//! What the loop makes of touches.

use std::sync::Arc;

use geometry::Plane;
use model_discrepancy::{
    Closure, Covariate, Model, Options, Proposal, Quantity, State, Verdict, check_tangents,
    close_loop,
};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use probe_comp::{BallTouch, Nominal, ProbeModel, Side};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene::{
    TIP_MM, bowl, bowl_height, directions, let_down, measured, noise, normal_of, point_of,
    reference_sphere, setup,
};

const SIGMA_MM: f64 = 1e-3;
/// Central differences over steps of the amplitudes on surfaces of radius 25 mm and more.
const DIFFERENCE_TOL: f64 = 1e-5;

/// A touch of the reference sphere along `approach`, larger or later as `late_mm` says.
fn sphere_touch(
    outward: &Vector3<f64>,
    approach: Unit<Vector3<f64>>,
    late_mm: f64,
    rng: &mut ChaCha8Rng,
) -> BallTouch {
    let at = Point3::new(40.0, -20.0, 15.0) + outward * (25.0 + TIP_MM);
    let read = at + approach.into_inner() * late_mm + noise(SIGMA_MM, rng);
    BallTouch { approach: Some(approach), ..BallTouch::new(read, SIGMA_MM) }
}

fn closed(nominal: Nominal, touches: Vec<BallTouch>, columns: &[Covariate]) -> Closure {
    let model = ProbeModel::new(setup(nominal), measured(touches), columns).unwrap();
    close_loop(&model, &model.all_covariates(), &Options::default()).unwrap()
}

fn names(closure: &Closure, step: usize) -> Vec<&str> {
    let step = &closure.steps[step];
    let rivals = step.indistinguishable_from.iter().map(String::as_str);
    std::iter::once(step.effect.as_str()).chain(rivals).collect()
}

#[test]
fn derivatives_agree_with_differences_for_every_effect_and_proposal() {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let recorded = [
        ("time_s", Quantity::Time),
        ("feed_mm_per_min", Quantity::Other),
        ("part_c", Quantity::Temperature),
    ]
    .map(|(name, quantity)| {
        let values = (0..14).map(|i| 20.0 + f64::from(i * i % 11)).collect();
        Covariate::recorded(name, quantity, values)
    });
    let on_sphere = directions(14)
        .iter()
        .map(|u| {
            let approach = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3) * -u;
            let mut touch = sphere_touch(u, Unit::new_normalize(approach), 0.0, &mut rng);
            touch.spindle_rad = rng.random_range(-3.0..3.0);
            touch
        })
        .collect();
    let on_bowl = (0..14)
        .map(|i| {
            let (x, y) = (3.0 * f64::from(i) - 20.0, f64::from(i * i % 13) - 6.0);
            BallTouch::new(let_down(bowl_height, x, y, TIP_MM), SIGMA_MM)
        })
        .collect();
    for (nominal, touches) in [(reference_sphere(Side::Along), on_sphere), (bowl(), on_bowl)] {
        let model = ProbeModel::new(setup(nominal), measured(touches), &recorded).unwrap();
        let mut models: Vec<Box<dyn Model>> = vec![Box::new(model.clone())];
        models.extend(model.proposals().iter().filter_map(Proposal::model));
        assert!(models.len() > 8, "{}", models.len());
        for model in models {
            let mut at = State::start(&*model);
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
            for amplitude in at.amplitudes.iter_mut().flat_map(|a| a.iter_mut()) {
                *amplitude = rng.random_range(-1e-6..1e-6);
            }
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
        }
    }
}

#[test]
fn ball_and_pretravel_on_a_sphere_are_one_class() {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    let touches = directions(60)
        .iter()
        .map(|u| sphere_touch(u, Unit::new_normalize(-u), 0.02, &mut rng))
        .collect();
    let closure = closed(reference_sphere(Side::Along), touches, &[]);
    let found = names(&closure, 0);
    assert!(found.contains(&"tip-radius") && found.contains(&"pretravel"), "{found:?}");
    assert_eq!(closure.steps.len(), 1);
    assert!(closure.steps[0].separate_by.is_some());
    assert_eq!(closure.verdict, Verdict::Explained);
}

/// Lobes of the part and lobes of the probe, seen by touches that come from other directions than
/// the normal.
#[test]
fn directions_of_approach_tell_the_part_from_the_probe() {
    let lobes = |v: &Vector3<f64>| v.x * (v.x * v.x - 3.0 * v.y * v.y);
    let approach = |i: usize, u: &Vector3<f64>| {
        let tangent = u.cross(&Vector3::ith(u.iamin(), 1.0)).normalize();
        let turn = Rotation3::from_axis_angle(
            &Unit::new_normalize(*u),
            2.4 * f64::from(u32::try_from(i).unwrap()),
        );
        Rotation3::from_axis_angle(&Unit::new_normalize(turn * tangent), 0.6)
            * Unit::new_normalize(-u)
    };
    for (of_part, expected) in [(true, "form"), (false, "lobing")] {
        let mut rng = ChaCha8Rng::seed_from_u64(33);
        let touches = directions(60)
            .iter()
            .enumerate()
            .map(|(i, u)| {
                let approach = approach(i, u);
                if of_part {
                    let mut touch = sphere_touch(u, approach, 0.0, &mut rng);
                    touch.center_mm += u * (8e-3 * lobes(u));
                    return touch;
                }
                let side = approach.xy().norm();
                let height = if side > 0.0 { lobes(&approach) / (side * side) } else { 0.0 };
                sphere_touch(u, approach, 8e-3 * height, &mut rng)
            })
            .collect();
        let closure = closed(reference_sphere(Side::Along), touches, &[]);
        let of_one_kind = names(&closure, 0).iter().all(|name| name.starts_with(expected));
        assert!(of_one_kind, "{:?}", closure.steps);
        assert_eq!(closure.verdict, Verdict::Explained);
    }
}

#[test]
fn a_reading_that_comes_late_shows_by_the_feed() {
    let mut rng = ChaCha8Rng::seed_from_u64(34);
    let feeds: Vec<f64> = (0..48).map(|_| [60.0, 120.0, 300.0][rng.random_range(0..3)]).collect();
    let touches: Vec<BallTouch> = directions(48)
        .iter()
        .zip(&feeds)
        .map(|(u, feed)| sphere_touch(u, Unit::new_normalize(-u), 2e-3 * feed / 60.0, &mut rng))
        .collect();
    let column = Covariate::recorded("feed_mm_per_min", Quantity::Other, feeds);
    let closure = closed(reference_sphere(Side::Along), touches.clone(), &[column]);
    assert_eq!(names(&closure, 0), ["latency"]);
    let time = &closure.steps[0].parameters[0];
    assert!((time.value - 2.0).abs() < 4.0 * time.std && time.unit == "ms", "{time:?}");
    // Without the column it cannot be seen, and the answer says what would show it.
    let blind = closed(reference_sphere(Side::Along), touches, &[]);
    let unseen = blind.not_observable.iter().find(|n| n.effect == "latency").unwrap();
    assert!(unseen.separate_by.as_ref().unwrap().contains("feed"), "{unseen:?}");
}

#[test]
fn nothing_is_found_where_nothing_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(35);
    let touches = directions(50)
        .iter()
        .map(|u| sphere_touch(u, Unit::new_normalize(-u), 0.0, &mut rng))
        .collect();
    let closure = closed(reference_sphere(Side::Along), touches, &[]);
    assert_eq!(closure.verdict, Verdict::NothingMissing);
}

/// Touches round the equator of a sphere, in a plane but for noise, see no form in its height, and
/// no scale of the axis along it.
#[test]
fn touches_in_a_plane_are_not_blamed_on_what_they_do_not_see() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let oval_mm = 0.02;
    let touches = (0..90)
        .map(|i| {
            let angle = 0.07 * f64::from(i);
            let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let mut touch = sphere_touch(&outward, Unit::new_normalize(-outward), 0.0, &mut rng);
            touch.center_mm += outward * (oval_mm * (2.0 * angle).cos());
            touch
        })
        .collect();
    let closure = closed(reference_sphere(Side::Along), touches, &[]);
    assert!(names(&closure, 0).contains(&"form"), "{:?}", names(&closure, 0));
    assert_eq!(closure.steps.len(), 1);
    let largest = closure.steps[0].parameters.iter().map(|p| p.value.abs()).fold(0.0, f64::max);
    assert!(largest < 2.0 * oval_mm * 1e3, "{largest} µm");
    assert!(closure.not_observable.iter().any(|e| e.effect == "axis-scale [z]"));
}

/// On a plane the noise of two readings decides which lies higher: a way that is taken from the readings
/// follows the residual, and a reversal of z would be found in noise.
#[test]
fn noise_has_no_reversal() {
    for seed in 51..57 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let touches = (0..50)
            .map(|_| {
                let [x, y] = [(); 2].map(|()| rng.random_range(-100.0..100.0));
                BallTouch::new(Point3::new(x, y, TIP_MM) + noise(SIGMA_MM, &mut rng), SIGMA_MM)
            })
            .collect();
        let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
        let closure = closed(Nominal::new(Arc::new(plane), Side::Along), touches, &[]);
        assert!(closure.steps.is_empty(), "{seed}: {:?}", closure.steps);
    }
}

/// A bent part is bent about its own origin: where the touches lie beside it, it is not turned as well.
#[test]
fn a_form_about_the_origin_of_the_part_is_no_turn_of_its_frame() {
    let mut rng = ChaCha8Rng::seed_from_u64(58);
    let touches = (0..60)
        .map(|_| {
            let (x, y): (f64, f64) = (rng.random_range(-18.0..30.0), rng.random_range(-24.0..24.0));
            let bent_mm = 0.02 * (x * x - y * y) / 900.0;
            let up = normal_of(bowl_height, x, y);
            let center = point_of(bowl_height, x, y) + up * (TIP_MM + bent_mm * up.z);
            BallTouch::new(center + noise(SIGMA_MM, &mut rng), SIGMA_MM)
        })
        .collect();
    let closure = closed(bowl(), touches, &[]);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert!(names(&closure, 0).contains(&"astigmatism"), "{:?}", closure.steps);
}

/// The ball comes along the normal, so that the way of an axis is that of the normal, whatever touch was before.
#[test]
fn a_reversal_by_the_approach_is_no_scale() {
    let half_mm = 0.006;
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let late = |outward: &Vector3<f64>| -half_mm * outward.y.signum() * outward.y;
    let touches = directions(120)
        .iter()
        .map(|outward| {
            sphere_touch(outward, Unit::new_normalize(-outward), -late(outward), &mut rng)
        })
        .collect();
    let closure = closed(reference_sphere(Side::Along), touches, &[]);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert_eq!(names(&closure, 0), ["reversal"], "{:?}", closure.steps);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("y, by approach"));
    let y = &closure.steps[0].parameters[0];
    assert!((y.value - 1e3 * half_mm).abs() < 4.0 * y.std && y.name == "y", "{y:?}");
}

/// A sphere far from the origin, touched from all sides, of which each touch comes late by so much for each mm from its
/// middle.
fn of_far_sphere(seed: u64, late: impl Fn(&Vector3<f64>) -> f64) -> Closure {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let touches = directions(60)
        .iter()
        .map(|outward| {
            let late_mm = late(outward) * (25.0 + TIP_MM);
            sphere_touch(outward, Unit::new_normalize(-outward), late_mm, &mut rng)
        })
        .collect();
    closed(reference_sphere(Side::Along), touches, &[])
}

/// Square about the part, as the workpiece frame was found with the same axes: one cause, and not a form of five
/// amplitudes.
#[test]
fn squareness_about_a_part_far_from_the_origin_is_named() {
    let square = 300e-6;
    // x reads γ·y from the part on: farther along the normal.
    let closure = of_far_sphere(72, |outward| -square * outward.y * outward.x);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert_eq!(names(&closure, 0), ["squareness", "form"], "{:?}", closure.steps);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("about the part"));
    let xy = &closure.steps[0].parameters[0];
    assert!((xy.value - 1e6 * square).abs() < 4.0 * xy.std && xy.name == "xy", "{xy:?}");
}

/// The same of an axis that reads long: without its own name a bending and a form of five amplitudes bear it.
#[test]
fn a_scale_about_a_part_far_from_the_origin_is_named() {
    let scale = 300e-6;
    let closure = of_far_sphere(73, |outward| -scale * outward.x * outward.x);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert_eq!(closure.steps[0].effect, "axis-scale");
    assert_eq!(closure.steps[0].subject.as_deref(), Some("x, about the part"));
    let x = &closure.steps[0].parameters[0];
    assert!((x.value - 1e6 * scale).abs() < 4.0 * x.std && x.name == "x", "{x:?}");
}

/// A shallow part shows a hundredth to a twenty-fifth of the square of a motion along x or y: its reversal must have
/// its own name, or a scale, a drift or a turn bears it.
#[test]
fn a_reversal_that_a_shallow_part_shows_is_no_scale() {
    let half_mm = 0.04;
    for seed in 61..65 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut before = f64::NEG_INFINITY;
        let touches = (0..50)
            .map(|_| {
                let [x, y] = [(); 2].map(|()| rng.random_range(-30.0..30.0));
                let up = normal_of(bowl_height, x, y);
                let center = point_of(bowl_height, x, y) + up * TIP_MM;
                let way = if center.x > before { 1.0 } else { -1.0 };
                before = center.x;
                let late = Vector3::x() * (half_mm * way) + noise(SIGMA_MM, &mut rng);
                BallTouch::new(center + late, SIGMA_MM)
            })
            .collect();
        let closure = closed(bowl(), touches, &[]);
        assert_eq!(closure.steps.len(), 1, "{seed}: {:?}", closure.steps);
        assert_eq!(names(&closure, 0), ["reversal"], "{seed}: {:?}", closure.steps);
        let x = &closure.steps[0].parameters[0];
        assert!((x.value - 1e3 * half_mm).abs() < 4.0 * x.std && x.name == "x", "{x:?}");
    }
}

/// Dirt that the ball picks up makes it larger wherever it touches: no way that the machine has moved does the same.
#[test]
fn a_ball_that_is_larger_from_one_touch_on_is_a_session_of_the_trigger() {
    let mut rng = ChaCha8Rng::seed_from_u64(36);
    let touches = directions(60)
        .iter()
        .enumerate()
        .map(|(i, u)| {
            let early_mm = if i < 25 { 0.0 } else { -0.02 };
            sphere_touch(u, Unit::new_normalize(-u), early_mm, &mut rng)
        })
        .collect();
    let time_s = (0..60).map(|i| 4.0 * f64::from(i)).collect();
    let time = Covariate::recorded("time_s", Quantity::Time, time_s);
    let closure = closed(reference_sphere(Side::Along), touches, &[time]);
    let [step] = &closure.steps[..] else { panic!("{:?}", closure.steps) };
    let subject = step.subject.as_deref().unwrap();
    assert!(step.effect == "session-shift" && subject.starts_with("trigger, from "), "{step:?}");
    assert!(step.description.contains("dirt on the ball"), "{}", step.description);
    let travel = &step.parameters[0];
    assert!((travel.value + 20.0).abs() < 4.0 * travel.std, "{travel:?}");
    assert_eq!(closure.verdict, Verdict::Explained);
}
