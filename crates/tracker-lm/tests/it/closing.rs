//! The loop on surveys with something wrong.

use model_discrepancy::{
    Closure, Model, State, Verdict, check_tangents, close_loop, std_over_names,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tracker_lm::{Approach, Noise, Options, Range, Step, Survey, TrackerModel};

use crate::scene::{Plan, Scene, gaussian, simulate};

fn options() -> Options {
    let noise = Noise { displacement_mm: Some(5e-4), station_mm: Some(4e-3), ..Noise::default() };
    Options { noise, ..Options::default() }
}

fn closed(survey: Survey) -> (TrackerModel, Closure) {
    closed_with(survey, &options())
}

fn closed_with(survey: Survey, options: &Options) -> (TrackerModel, Closure) {
    let model = TrackerModel::new(survey, None, Vec::new(), options).unwrap();
    let loop_options = model_discrepancy::Options { nested: false, ..Default::default() };
    let covariates = model.coordinates();
    let closure = close_loop(&model, &covariates, &loop_options).unwrap();
    (model, closure)
}

#[test]
fn tangents_are_derivatives() {
    let plan = Plan { angles: 7, both_ways: true, missing: 0.05, ..Plan::default() };
    let model = TrackerModel::new(simulate(&plan, 4).survey, None, Vec::new(), &options()).unwrap();
    let at = State::start(&model);
    // Rows are linear: central differences show rounding alone.
    assert!(check_tangents(&model, &at) < 1e-6);
}

#[test]
fn nothing_wrong_adds_nothing() {
    let (_, closure) = closed(simulate(&Plan::default(), 21).survey);
    assert!(closure.steps.is_empty(), "{:?}", closure.steps);
    assert_eq!(closure.verdict, Verdict::NothingMissing);
    // The mean of what is left counts one range each.
    assert!((closure.before.train_rms / 5e-4 - 1.0).abs() < 0.1, "{}", closure.before.train_rms);
}

/// Successive readings of a lock correlated by 0.7, as air and electronics make them.
fn remembering(seed: u64) -> Survey {
    let plan = Plan { noise_mm: 0.0, angles: 19, ..Plan::default() };
    let mut survey = simulate(&plan, seed).survey;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut last = std::collections::HashMap::new();
    for range in &mut survey.ranges {
        let new = gaussian(&mut rng);
        let state = last.entry((range.station, range.mount)).or_insert(new);
        *state = 0.7 * *state + (1.0_f64 - 0.49).sqrt() * new;
        range.displacement_mm += 5e-4 * *state;
    }
    survey
}

#[test]
fn readings_of_a_lock_that_remember_each_other_are_no_lost_beam() {
    let noise = Noise { station_mm: Some(4e-3), ..Noise::default() };
    let options = Options { noise, ..Options::default() };
    let wrong = (0..5)
        .map(|seed| closed_with(remembering(seed), &options).1)
        .filter(|closure| !closure.steps.is_empty())
        .count();
    // At one in twenty, two of five come up once in forty.
    assert!(wrong <= 1, "{wrong} of 5");
}

#[test]
fn a_lost_beam_is_found_where_it_was_lost() {
    let mut survey = simulate(&Plan::default(), 22).survey;
    for range in &mut survey.ranges {
        if range.station == 2 && range.mount == 1 && range.step >= 16 {
            range.displacement_mm += 0.004;
        }
    }
    let (_, closure) = closed(survey);
    assert_eq!(closure.steps[0].effect, "dead-path-jump");
    assert_eq!(closure.steps[0].subject.as_deref(), Some("S3-R2 at 17"));
    let jump = &closure.steps[0].parameters[0];
    assert!((jump.value.abs() - 4.0).abs() < 3.0 * jump.std, "{jump:?}");
}

#[test]
fn one_range_that_is_off_is_named_and_no_beam_was_lost() {
    // In the middle of a lock, and as much at its last step, after which nothing tells it from a lost beam.
    for (is_last, seed) in [(false, 23), (true, 24)] {
        let mut survey = simulate(&Plan::default(), seed).survey;
        let step = if is_last { survey.steps.len() - 1 } else { 7 };
        let is_it = |r: &Range| r.station == 2 && r.mount == 1 && r.step == step;
        let off = survey.ranges.iter_mut().find(|r| is_it(r)).unwrap();
        off.displacement_mm += 0.02;
        let (_, closure) = closed(survey);
        let [found] = &closure.steps[..] else { panic!("{:?}", closure.steps) };
        let subject = format!("S3-R2 at {}", step + 1);
        if is_last {
            let all = [vec![found.effect.clone()], found.indistinguishable_from.clone()].concat();
            assert!(all.contains(&"bad-point".to_owned()), "{all:?}");
            assert!(all.contains(&"dead-path-jump".to_owned()), "{all:?}");
        } else {
            assert_eq!((&*found.effect, found.subject.as_ref()), ("bad-point", Some(&subject)));
            assert!(found.indistinguishable_from.is_empty(), "{found:?}");
        }
        let size = &found.parameters[0];
        assert!((size.value.abs() - 20.0).abs() < 4.0 * size.std, "{size:?}");
        assert_eq!(closure.verdict, Verdict::Explained);
    }
}

/// The survey with a drive that turns, and gives way along a vector, by as much between either side.
fn with_play(scene: &Scene, play_rad: f64, give_mm: Vector3<f64>) -> Survey {
    let mut survey = scene.survey.clone();
    let axis = survey.axis.direction.into_inner();
    for range in &mut survey.ranges {
        let step = &survey.steps[range.step];
        let arm = crate::scene::rodrigues(&axis, step.angle_rad) * scene.mounts_mm[range.mount];
        let station = scene.stations_mm[range.station];
        let beam = (survey.axis.origin_mm.coords + arm - station).normalize();
        // Both show in a range by what they are along the beam.
        let moved = axis.cross(&arm) * play_rad + give_mm;
        let way = if step.approach == Some(Approach::Negative) { -0.5 } else { 0.5 };
        range.displacement_mm += way * moved.dot(&beam);
    }
    survey
}

/// The survey without the steps that a test does not keep.
fn keeping(mut survey: Survey, keep: impl Fn(&Step) -> bool) -> Survey {
    let kept: Vec<usize> = (0..survey.steps.len()).filter(|&s| keep(&survey.steps[s])).collect();
    survey.ranges.retain(|range| kept.contains(&range.step));
    for range in &mut survey.ranges {
        range.step = kept.iter().position(|s| *s == range.step).unwrap();
    }
    survey.steps = kept.iter().map(|&s| survey.steps[s].clone()).collect();
    survey
}

/// Seven steps back show six amplitudes: too few for a scatter of their own of every step, and without
/// the first step, which nothing repeats, no error of the axis is determined.
#[test]
fn a_few_steps_back_show_a_backlash_and_judge_it() {
    for seed in [23, 26, 29] {
        let plan = Plan { angles: 9, stations: 5, mounts: 3, both_ways: true, ..Plan::default() };
        let scene = simulate(&plan, seed);
        let give_mm = Vector3::new(6e-3, -3e-3, 4.5e-3);
        let once: Vec<u64> =
            [0, 7].iter().map(|&s| scene.survey.steps[s].angle_rad.to_bits()).collect();
        let survey = keeping(with_play(&scene, -60e-6, give_mm), |step| {
            let both = !once.contains(&step.angle_rad.to_bits());
            both || step.approach == Some(Approach::Positive)
        });
        let model = TrackerModel::new(survey, None, Vec::new(), &options()).unwrap();
        let nested = model_discrepancy::Options::default();
        let closure = close_loop(&model, &model.coordinates(), &nested).unwrap();
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        assert_eq!(names, ["backlash"], "{seed}");
        assert_eq!(closure.verdict, Verdict::Explained, "{seed}");
        // Noise of 0.5 µm, and six errors of every angle from fifteen ranges or thirty.
        assert!(closure.after.held_out_rms < 2.0 * 5e-4, "{}", closure.after.held_out_rms);
        assert!(closure.before.held_out_rms > 5.0 * closure.after.held_out_rms);
    }
}

#[test]
fn backlash_is_found_and_its_half_is_not_left_in_the_errors() {
    let plan = Plan { angles: 13, both_ways: true, ..Plan::default() };
    let scene = simulate(&plan, 23);
    let (model, closure) = closed(with_play(&scene, 20e-6, Vector3::zeros()));
    assert_eq!(closure.steps[0].effect, "backlash", "{:?}", closure.steps);
    let turn = closure.steps[0].parameters.iter().find(|p| p.name == "EBB").unwrap();
    assert!((turn.value - 20.0).abs() < 4.0 * turn.std, "{turn:?}");
    let found = model.calibration_with(&closure).unwrap();
    for (found, truth) in found.axis_errors.iter().zip(&scene.errors).skip(1) {
        let left = found.error - truth;
        let sigmas = found.sigmas();
        // The first angle carries half of the backlash: errors are relative to it.
        assert!((0..6).all(|c| left[c].abs() < 6.0 * sigmas[c] + if c == 4 { 11e-6 } else { 0.0 }));
    }
}

/// A survey of which a station rises by `height_mm` along a course: of the share of the run that has
/// passed, in whole steps or by the reading.
fn rising(station: usize, height_mm: f64, by_reading: bool, course: impl Fn(f64) -> f64) -> Survey {
    let scene = simulate(&Plan { angles: 19, ..Plan::default() }, 24);
    let mut survey = scene.survey.clone();
    let n = survey.ranges.len() as f64 - 1.0;
    for (index, range) in survey.ranges.iter_mut().enumerate().filter(|(_, r)| r.station == station)
    {
        let rotation = crate::scene::rodrigues(
            &scene.survey.axis.direction,
            scene.survey.steps[range.step].angle_rad,
        );
        let target = scene.survey.axis.origin_mm.coords + rotation * scene.mounts_mm[range.mount];
        let beam = (target - scene.stations_mm[station]).normalize();
        let passed = if by_reading { index as f64 / n } else { range.step as f64 / 18.0 };
        range.displacement_mm -= height_mm * course(passed) * beam.z;
    }
    survey
}

#[test]
fn a_station_on_a_warming_stand_is_found() {
    let (_, closure) = closed(rising(1, 0.010, false, |passed| passed));
    assert_eq!(closure.steps[0].effect, "station-drift", "{:?}", closure.steps);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("S2"), "{:?}", closure.steps);
    assert!(closure.steps[0].description.contains("steadily"), "{:?}", closure.steps);
}

#[test]
fn a_station_that_comes_to_rest_is_found_with_its_time_constant() {
    const SHARE: f64 = 0.15;
    let (_, closure) = closed(rising(2, 0.04, true, |passed| -(-passed / SHARE).exp_m1()));
    let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert_eq!(names, ["station-drift"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("S3"));
    assert_eq!(closure.verdict, Verdict::Explained);
    let said = closure.steps[0].description.split("τ = ").nth(1).expect("it comes to rest");
    let constant: f64 = said.split(' ').next().unwrap().parse().unwrap();
    // The curve is eighty times the noise high, seen at eight angles while it bends.
    assert!((constant / SHARE - 1.0).abs() < 0.2, "{constant}");
    let rise = &closure.steps[0].parameters[2];
    assert!((rise.value - 0.04).abs() < 4.0 * rise.std, "{rise:?}");
}

/// Displacements that read too long in proportion, 40 ppm where `is_touched`.
fn stretched(plan: &Plan, seed: u64, is_touched: impl Fn(&Range) -> bool) -> Survey {
    let mut survey = simulate(plan, seed).survey;
    for range in &mut survey.ranges {
        if is_touched(range) {
            range.displacement_mm *= 1.0 + 40e-6;
        }
    }
    survey
}

/// Only the stations' known places tell it from a larger network: to 1 µm they do, to 4 µm they
/// take up more than 99.8 % of it.
#[test]
fn a_wrong_wavelength_is_found_where_stations_are_known() {
    let plan = Plan { stations_off_mm: 1e-3, ..Plan::default() };
    let survey = stretched(&plan, 25, |_| true);
    let mut options = options();
    options.noise.station_mm = Some(1e-3);
    let (_, closure) = closed_with(survey, &options);
    assert_eq!(closure.steps[0].effect, "range-scale");
    let scale = &closure.steps[0].parameters[0];
    assert!((scale.value - 40.0).abs() < 4.0 * scale.std, "{scale:?}");
}

#[test]
fn one_station_in_bad_air_is_found() {
    let (_, closure) = closed(stretched(&Plan::default(), 26, |range| range.station == 3));
    assert_eq!(closure.steps[0].effect, "bad-station");
    assert_eq!(closure.steps[0].subject.as_deref(), Some("S4"));
    let scale = &closure.steps[0].parameters[0];
    assert!((scale.value - 40.0).abs() < 4.0 * scale.std, "{scale:?}");
}

#[test]
fn a_tracer_that_drifts_or_jumps_alone_is_told_from_a_station_that_moves() {
    let plan = Plan { angles: 19, ..Plan::default() };
    for (effect, subject) in [("range-drift", "S3"), ("dead-path-jump", "S3 at 12")] {
        // Two thirds of a micrometre a step, or 4 µm at once.
        let added_mm = |step: usize| match effect {
            "range-drift" => 0.012 / 18.0 * step as f64,
            _ if step >= 11 => 0.004,
            _ => 0.0,
        };
        let mut survey = simulate(&plan, 27).survey;
        for range in survey.ranges.iter_mut().filter(|r| r.station == 2) {
            range.displacement_mm += added_mm(range.step);
        }
        let (_, closure) = closed(survey);
        assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
        assert_eq!(closure.steps[0].effect, effect);
        assert_eq!(closure.steps[0].subject.as_deref(), Some(subject));
        assert_eq!(closure.verdict, Verdict::Explained);
    }
}

/// A beam that was lost for 0.3 mm is in all that the declared model fitted: about what was found, with the
/// same rows, the jump is what it was.
#[test]
fn about_a_beam_lost_for_long_the_model_has_the_same_rows() {
    const LOST_MM: f64 = 0.3;
    let mut survey = simulate(&Plan { angles: 9, ..Plan::default() }, 28).survey;
    for range in &mut survey.ranges {
        if range.station == 2 && range.mount == 1 && range.step >= 6 {
            range.displacement_mm += LOST_MM;
        }
    }
    let (model, closure) = closed(survey);
    let there = model.about_found(&closure.solution()).unwrap();
    assert_eq!(there.declared().layout, model.declared().layout);
    let options = model_discrepancy::Options { nested: false, ..Default::default() };
    let closure = close_loop(&there, &there.coordinates(), &options).unwrap();
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("S3-R2 at 7"));
    // A longer reading is a shorter dead path.
    let jump = &closure.steps[0].parameters[0];
    assert!((jump.value + 1e3 * LOST_MM).abs() < 4.0 * jump.std, "{jump:?}");
}

/// Where another name of a step explains the readings as well, every standard uncertainty reaches to what
/// the calibration would be by that name.
#[test]
fn uncertainties_reach_to_what_another_name_gives() {
    /// Of positions of a metre and their uncertainties of a µm: 1e3 mm · 2⁻⁵² over 1e-4 mm.
    const AGREE: f64 = 1e-8;
    let (model, mut closure) = closed(simulate(&Plan { angles: 9, ..Plan::default() }, 29).survey);
    let own = model.calibration_with(&closure).unwrap();
    let mut other = closure.clone();
    other.state.base[0] += 0.02;
    other.state.base[40] -= 0.01;
    let elsewhere = model.calibration_with(&other).unwrap();
    closure.alternatives = vec![other.solution()];
    let found = model.calibration_with(&closure).unwrap();
    let mut n_wider = 0;
    let mut reaches = |found: [f64; 2], own: [f64; 2], elsewhere: f64| {
        let [(at, std), (own_at, own_std)] =
            [found, own].map(|[at, variance]| (at, variance.sqrt()));
        let expected = std_over_names(own_std, std::iter::once(elsewhere - own_at));
        assert!((std - expected).abs() <= AGREE * expected, "{std} {expected} {own_std}");
        assert!(at.total_cmp(&own_at).is_eq());
        n_wider += usize::from(std > 1.1 * own_std);
    };
    for (k, error) in found.axis_errors.iter().enumerate().skip(1) {
        let (own, elsewhere) = (&own.axis_errors[k], &elsewhere.axis_errors[k]);
        for i in 0..6 {
            let of = |e: &tracker_lm::AxisError| [e.error[i], e.covariance[(i, i)]];
            reaches(of(error), of(own), elsewhere.error[i]);
        }
    }
    for (k, station) in found.stations.iter().enumerate() {
        let (own, elsewhere) = (&own.stations[k], &elsewhere.stations[k]);
        for i in 0..3 {
            let of = |s: &tracker_lm::StationEstimate| [s.position_mm[i], s.covariance_mm2[(i, i)]];
            reaches(of(station), of(own), elsewhere.position_mm[i]);
        }
    }
    // Some are, and not all.
    assert!((1..8 * 6 + 6 * 3).contains(&n_wider), "{n_wider}");
}
