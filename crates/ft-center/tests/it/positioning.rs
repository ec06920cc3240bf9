//! Runs of known errors of an axis through the loop.

use ft_center::{Approach, AxisMotion, AxisReading, AxisRun, axis_coordinates, positioning_model};
use model_discrepancy::{
    Closure, Covariate, Model, Options, ParameterEstimate, Quantity, State, Verdict,
    check_tangents, close_loop,
};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Twelve targets at uneven places, five cycles there and back; the deviation is what `error` says of
/// target, direction and share of the run that has passed, with noise of `sigma`.
pub(crate) fn run(seed: u64, sigma: f64, error: impl Fn(f64, f64, f64) -> f64) -> Vec<AxisReading> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let targets: Vec<f64> =
        (0..12).map(|i| 40.0 * f64::from(i) + rng.random_range(0.0..9.0)).collect();
    let mut all = Vec::new();
    for cycle in 0..5 {
        let up = targets.iter().map(|t| (*t, Approach::Rising));
        for (target, approach) in up.chain(targets.iter().rev().map(|t| (*t, Approach::Falling))) {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let passed = f64::from(u32::try_from(all.len()).unwrap()) / 119.0;
            all.push(AxisReading {
                name: format!("{target:.1} {approach:?} {cycle}"),
                target,
                deviation: error(target, approach.sign(), passed) + sigma * noise,
                approach: Some(approach),
            });
        }
    }
    all
}

pub(crate) const SIGMA_MM: f64 = 0.001;

pub(crate) fn closed(
    readings: &[AxisReading],
    covariates: &[Covariate],
    lead: Option<f64>,
) -> Closure {
    closed_with(readings, None, covariates, lead)
}

fn closed_with(
    readings: &[AxisReading],
    cycles: Option<&[usize]>,
    covariates: &[Covariate],
    lead: Option<f64>,
) -> Closure {
    let run = AxisRun { readings, motion: AxisMotion::Linear, lead, cycles, covariates };
    let model = positioning_model(&run, &run.shown(), Some(SIGMA_MM)).unwrap();
    let mut along = axis_coordinates(&run, "target_mm");
    along.extend(covariates.iter().cloned());
    close_loop(&model, &along, &Options { nested: false, ..Options::default() }).unwrap()
}

pub(crate) fn named(closure: &Closure) -> Vec<String> {
    closure.steps.iter().map(|step| step.effect.clone()).collect()
}

pub(crate) fn amplitude(closure: &Closure, step: usize, parameter: usize) -> f64 {
    closure.steps[step].parameters[parameter].value
}

#[test]
fn tangents_are_derivatives() {
    let readings = run(3, SIGMA_MM, |_, _, _| 0.0);
    let temperature = Covariate::recorded(
        "screw_c",
        Quantity::Temperature,
        (0..readings.len()).map(|i| 20.0 + 0.01 * i as f64).collect(),
    );
    let run = AxisRun {
        readings: &readings,
        motion: AxisMotion::Linear,
        lead: Some(10.0),
        cycles: None,
        covariates: &[temperature],
    };
    let model = positioning_model(&run, &run.shown(), None).unwrap();
    let mut at = State::start(&model);
    for (k, amplitudes) in at.amplitudes.iter_mut().enumerate() {
        *amplitudes = DVector::from_fn(amplitudes.len(), |i, _| 1e-3 * (k + 2 * i) as f64);
    }
    assert!(check_tangents(&model, &at) < 1e-7);
    assert_eq!(model.declared().base.len(), 0);
}

#[test]
fn a_zero_of_its_own_in_every_cycle_is_no_drift_and_no_reversal() {
    // Set anew before each of five cycles of 24 readings, and found a few µm off.
    let zeros_mm = [0.004, -0.007, 0.011, -0.002, -0.009];
    let cycles: Vec<usize> = (0..120).map(|i| i / 24).collect();
    let cycle =
        |passed: f64| (0..4).filter(|c| passed * 119.0 > 23.5 + 24.0 * f64::from(*c)).count();
    let of = |passed: f64| zeros_mm[cycle(passed)];
    for seed in 31..36 {
        let readings = run(seed, SIGMA_MM, |_, _, passed| of(passed));
        let closure = closed_with(&readings, Some(&cycles), &[], None);
        assert_eq!(named(&closure), ["cycle-zero"], "{seed}");
        assert_eq!(closure.verdict, Verdict::Explained);
        for (cycle, zero_mm) in zeros_mm.iter().enumerate() {
            // Five standard uncertainties of 24 readings of 1 µm.
            let off = amplitude(&closure, 0, cycle) - 1e3 * zero_mm;
            assert!(off.abs() < 5.0 / 24_f64.sqrt(), "{seed}, cycle {cycle}: {off}");
        }
    }
    // Beside a reversal, both; and a pitch error is not taken for it.
    let both = run(36, SIGMA_MM, |_, way, passed| of(passed) + 0.003 * way);
    let mut names = named(&closed_with(&both, Some(&cycles), &[], None));
    names.sort();
    assert_eq!(names, ["cycle-zero", "reversal"]);
    let pitch = run(37, SIGMA_MM, |t, _, _| 40e-6 * t);
    assert_eq!(named(&closed_with(&pitch, Some(&cycles), &[], None)), ["pitch-error"]);
}

#[test]
fn what_an_axis_does_is_named_with_its_size() {
    let nothing = closed(&run(11, SIGMA_MM, |_, _, _| 0.0), &[], None);
    assert_eq!(nothing.verdict, Verdict::NothingMissing, "{:?}", named(&nothing));

    // Sizes to four standard uncertainties of 120 readings of 1 µm.
    let pitch = closed(&run(12, SIGMA_MM, |t, _, _| 40e-6 * t), &[], None);
    assert_eq!(named(&pitch), ["pitch-error"]);
    assert!((amplitude(&pitch, 0, 0) - 40.0).abs() < 1.4, "{:?}", pitch.steps);

    // About a place at which it does not count from zero: no table of twelve deviations.
    let about = closed(&run(12, SIGMA_MM, |t, _, _| 40e-6 * (t - 220.0)), &[], None);
    assert_eq!(named(&about), ["pitch-error"]);
    assert!((amplitude(&about, 0, 1) - 40.0).abs() < 2.8, "{:?}", about.steps);

    let reversal = closed(&run(13, SIGMA_MM, |_, way, _| 0.5 * 0.012 * way), &[], None);
    assert_eq!(named(&reversal), ["reversal"]);
    assert!((amplitude(&reversal, 0, 0) - 12.0).abs() < 0.8, "{:?}", reversal.steps);

    // Where zero was set from below: no offset beside it.
    let falling = |_: f64, way: f64, _: f64| if way < 0.0 { -0.012 } else { 0.0 };
    let one_side = closed(&run(13, SIGMA_MM, falling), &[], None);
    assert_eq!(named(&one_side), ["reversal"]);
    assert_eq!(one_side.steps[0].subject.as_deref(), Some("falling"));
    assert!((amplitude(&one_side, 0, 0) - 12.0).abs() < 0.8, "{:?}", one_side.steps);

    let by_place =
        closed(&run(14, SIGMA_MM, |t, way, _| 0.5 * way * (0.004 + 0.02 * t / 450.0)), &[], None);
    assert_eq!(named(&by_place), ["reversal", "backlash-by-place"]);
    // The targets span 440 to 450 mm.
    assert!((amplitude(&by_place, 1, 0) - 10.0).abs() < 1.6, "{:?}", by_place.steps);

    // A reversal that is there after some travel: half of it is missing 65 mm after the turn.
    let last = std::cell::Cell::new((0.0, 0.0, 0.0));
    let error = |t: f64, way: f64, _: f64| {
        let (way_before, target_before, turned_at) = last.get();
        let turned_at = if way * way_before > 0.0 { turned_at } else { target_before };
        last.set((way, t, turned_at));
        0.5 * 0.02 * way * -(-(t - turned_at).abs() / 90.0).exp_m1()
    };
    let lag = closed(&run(23, SIGMA_MM, error), &[], None);
    let mut names = named(&lag);
    names.sort();
    assert_eq!(names, ["hysteresis", "reversal"], "{:?}", lag.steps);

    let places = [3.0, -7.0, 6.0, 1.0, -4.0, 9.0, -2.0, 5.0, -8.0, 0.0, 4.0, -6.0];
    let place = |t: f64| (0..12_u8).rev().find(|i| t >= 40.0 * f64::from(*i)).unwrap();
    let of_place = |t: f64| 1e-3 * places[usize::from(place(t))];
    let profile = closed(&run(15, SIGMA_MM, |t, way, _| of_place(t) + 0.01 * way), &[], None);
    let mut names = named(&profile);
    names.sort();
    assert_eq!(names, ["profile", "reversal"]);
    assert_eq!(profile.verdict, Verdict::Explained);

    let wave = |t: f64| 0.006 * (std::f64::consts::TAU * t / 130.0).sin();
    let found = closed(&run(16, SIGMA_MM, |t, _, _| wave(t)), &[], None);
    assert_eq!(named(&found), ["cyclic-error"]);
    // All readings had a part in finding the period, which nobody has to look for where it is declared.
    let looked_for = |closure: &Closure| closure.warnings.iter().any(|w| w.contains("looked for"));
    assert!(looked_for(&found), "{:?}", found.warnings);
    let screw = |t: f64| 0.006 * (std::f64::consts::TAU * t / 10.0).sin();
    let told = closed(&run(17, SIGMA_MM, |t, _, _| screw(t)), &[], Some(10.0));
    assert_eq!(named(&told), ["cyclic-error"]);
    assert!(!looked_for(&told), "{:?}", told.warnings);
    assert!((amplitude(&told, 0, 1) - 6.0).abs() < 0.6, "{:?}", told.steps);

    let drift = closed(&run(18, SIGMA_MM, |t, _, passed| 25e-6 * t * passed), &[], None);
    assert_eq!(named(&drift), ["drift"]);
    assert!((amplitude(&drift, 0, 1) - 25.0).abs() < 3.0, "{:?}", drift.steps);

    // A screw that has warmed up after a third of the run, under a profile and a reversal.
    let warm = |t: f64, passed: f64| (-0.004 + 30e-6 * t) * -(-passed / 0.15).exp_m1();
    let error = |t: f64, way: f64, passed: f64| warm(t, passed) + of_place(t) + 0.01 * way;
    let settling = closed(&run(22, SIGMA_MM, error), &[], None);
    let mut names = named(&settling);
    names.sort();
    assert_eq!(names, ["drift", "profile", "reversal"], "{:?}", settling.verdict);
    let at = named(&settling).iter().position(|name| name == "drift").unwrap();
    assert_eq!(settling.steps[at].subject.as_deref(), Some("settling"));
    assert!((amplitude(&settling, at, 1) - 30.0).abs() < 4.0, "{:?}", settling.steps);

    // Homed anew in the middle of a cycle, by a quarter of a hundredth.
    let homed =
        |t: f64, _: f64, passed: f64| of_place(t) - 0.0025 * f64::from(u8::from(passed > 0.4));
    let session = closed(&run(24, SIGMA_MM, homed), &[], None);
    let mut names = named(&session);
    names.sort();
    assert_eq!(names, ["profile", "session-shift"], "{:?}", session.verdict);
    let at = named(&session).iter().position(|name| name == "session-shift").unwrap();
    let shift = &session.steps[at].parameters[0];
    assert!((shift.value + 2.5).abs() < 4.0 * shift.std, "{shift:?}");

    let mut rng = ChaCha8Rng::seed_from_u64(19);
    let warm: Vec<f64> = (0..120).map(|_| 20.0 + rng.random_range(0.0..6.0)).collect();
    let mut readings = run(19, SIGMA_MM, |_, _, _| 0.0);
    for (reading, t) in readings.iter_mut().zip(&warm) {
        reading.deviation += 11e-6 * reading.target * (t - 20.0);
    }
    let column = Covariate::recorded("screw_c", Quantity::Temperature, warm);
    let thermal = closed(&readings, &[column], None);
    assert_eq!(named(&thermal), ["temperature"]);
    assert!((amplitude(&thermal, 0, 1) - 11.0).abs() < 0.6, "{:?}", thermal.steps);

    let mut readings = run(20, SIGMA_MM, |_, _, _| 0.0);
    readings[57].deviation += 0.03;
    let bad = closed(&readings, &[], None);
    assert_eq!(named(&bad), ["bad-point"]);
    assert_eq!(bad.steps[0].subject.as_deref(), Some(readings[57].name.as_str()));
}

/// Friction that is taken up over some travel, from wherever the axis stood before the first reading (Dahl 1968).
#[test]
fn friction_that_is_taken_up_over_a_travel_is_a_lag_and_no_drift() {
    let state = std::cell::Cell::new((0.0, f64::NAN));
    let error = |t: f64, _: f64, _: f64| {
        let (taken_up, before): (f64, f64) = state.get();
        let moved = if before.is_nan() { 0.0 } else { t - before };
        let left = (-moved.abs() / 75.0).exp();
        let taken_up = taken_up * left + moved.signum() * (1.0 - left);
        state.set((taken_up, t));
        0.01 * taken_up
    };
    let lag = closed(&run(31, SIGMA_MM, error), &[], None);
    let mut names = named(&lag);
    names.sort();
    assert_eq!(names, ["hysteresis", "reversal"], "{:?}", lag.steps);
    assert_eq!(lag.verdict, Verdict::Explained);
    let found = lag.steps.iter().find(|step| step.effect == "hysteresis").unwrap();
    // It lags by twice as much after a turn as where it starts from rest; to four standard uncertainties.
    for (index, expected) in [(0, 20.0), (1, 10.0)] {
        let lag: &ParameterEstimate = &found.parameters[index];
        assert!((lag.value - expected).abs() < 4.0 * lag.std, "{:?}", found.parameters);
    }
}

#[test]
fn a_rotary_axis_is_in_seconds_of_arc() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut readings = Vec::new();
    for cycle in 0..3 {
        for step in 0..24 {
            let target = 15.0 * f64::from(if cycle % 2 == 0 { step } else { 23 - step });
            let noise: f64 = StandardNormal.sample(&mut rng);
            let turned = target.to_radians();
            readings.push(AxisReading {
                name: format!("{cycle} {step}"),
                target,
                deviation: 4.0 * turned.cos() - 3.0 * turned.sin() + 0.5 * noise,
                approach: Some(if cycle % 2 == 0 { Approach::Rising } else { Approach::Falling }),
            });
        }
    }
    let run = AxisRun {
        readings: &readings,
        motion: AxisMotion::Rotary,
        lead: None,
        cycles: None,
        covariates: &[],
    };
    let model = positioning_model(&run, &run.shown(), Some(0.5)).unwrap();
    let options = Options { nested: false, ..Options::default() };
    let closure = close_loop(&model, &axis_coordinates(&run, "target_deg"), &options).unwrap();
    assert_eq!(named(&closure), ["cyclic-error"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("once per turn of the axis"));
    // Four standard uncertainties of half a second over √36.
    assert!((amplitude(&closure, 0, 0) - 4.0).abs() < 0.35, "{:?}", closure.steps);
    assert!((amplitude(&closure, 0, 1) + 3.0).abs() < 0.35, "{:?}", closure.steps);
}

/// Targets at whole turns of the screw: the sine over a turn is nothing but round-off there.
#[test]
fn a_wave_that_the_targets_do_not_show_has_no_size() {
    const LEAD_MM: f64 = 10.0;
    let readings: Vec<AxisReading> = run(17, SIGMA_MM, |_, _, _| 0.006)
        .into_iter()
        .map(|r| AxisReading { target: LEAD_MM * (r.target / LEAD_MM).round(), ..r })
        .collect();
    let closure = closed(&readings, &[], Some(LEAD_MM));
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    for parameter in &closure.steps[0].parameters {
        // 6 µm, and no more than four standard uncertainties of 120 readings of 1 µm.
        assert!((parameter.value.abs() - 6.0).abs() < 0.37, "{:?}", closure.steps);
    }
}

/// The time constant is fitted like an amplitude: what would only make up for one that is a little off is
/// no pitch error beside the drift.
#[test]
fn a_drift_that_comes_to_rest_needs_nothing_beside_it() {
    for seed in 20..32 {
        let settled = run(seed, SIGMA_MM, |_, _, passed| 0.020 * -(-passed / 0.04).exp_m1());
        let closure = closed(&settled, &[], None);
        assert_eq!(named(&closure), ["drift"], "{seed}: {:?}", closure.steps);
    }
}

/// Of one run in one direction nothing tells what goes with time from what goes with the place, nor from which side.
#[test]
fn a_bow_read_once_from_one_side_is_no_drift_and_no_reversal() {
    for seed in 0..10 {
        let bow = |target: f64, _, _| 0.02 * (target / 250.0 - 1.0).powi(2);
        let mut readings = run(seed, SIGMA_MM, bow);
        readings.truncate(12);
        let closure = closed(&readings, &[], None);
        let is_of_time = |name: &&String| *name == "drift" || name.starts_with("backlash");
        let named = named(&closure);
        assert!(!named.iter().any(|name| is_of_time(&name)), "{named:?}");
    }
}

/// The scale error of a run that has a reversal, too, looks another from side to side by the bad reading alone.
#[test]
fn a_bad_reading_is_found_beside_a_scale_error_and_a_reversal() {
    let mut found = 0;
    for seed in 0..20 {
        let error =
            |target: f64, way: f64, _| 7e-3 * f64::from(u8::from(way < 0.0)) - 1e-5 * target;
        let mut readings = run(seed, SIGMA_MM, error);
        readings[67].deviation += 0.13;
        let closure = closed(&readings, &[], None);
        let names = named(&closure);
        let has = |id: &str| names.iter().any(|name| name == id);
        found += usize::from(has("bad-point") && has("reversal") && has("pitch-error"));
    }
    assert!(found >= 18, "{found}");
}
