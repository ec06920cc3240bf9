//! What a run of an axis cannot tell, and what only another look at it shows.

use ft_center::{Approach, AxisMotion, AxisReading, AxisRun, positioning_model};
use model_discrepancy::{Closure, Options, Shown, Verdict, close_loop};

use crate::positioning::{SIGMA_MM, amplitude, closed, named, run};

/// Every second of them, as five of six targets in ten have it.
fn at_six_targets(readings: &[AxisReading]) -> Vec<AxisReading> {
    let mut targets: Vec<f64> = readings.iter().map(|r| r.target).collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup();
    let kept: Vec<f64> = targets.into_iter().step_by(2).collect();
    readings.iter().filter(|r| kept.contains(&r.target)).cloned().collect()
}

fn wave(target: f64, period_mm: f64) -> f64 {
    (std::f64::consts::TAU * target / period_mm).sin()
}

#[test]
fn a_period_between_the_targets_is_a_rival_of_their_own_deviations() {
    let readings = at_six_targets(&run(31, SIGMA_MM, |t, _, _| 0.02 * wave(t, 33.0)));
    let of = |lead| closed(&readings, &[], lead);
    let unresolved = of(None);
    assert_eq!(named(&unresolved), ["profile"]);
    let rivals = &unresolved.steps[0].indistinguishable_from;
    assert!(rivals.iter().any(|name| name.starts_with("cyclic-error")), "{rivals:?}");
    // Whoever declares the lead is told.
    let told = of(Some(33.0));
    assert_eq!(named(&told), ["cyclic-error"]);
    assert!(told.steps[0].indistinguishable_from.is_empty());
}

/// A curve along the travel needs no screw.
#[test]
fn a_smooth_profile_has_no_such_rival() {
    let readings = run(32, SIGMA_MM, |t, _, _| 0.03 * (t / 450.0 - 0.5).powi(3));
    let closure = closed(&readings, &[], None);
    let rivals = closure.steps.iter().flat_map(|step| &step.indistinguishable_from);
    assert_eq!(rivals.filter(|name| name.contains("resolve")).count(), 0, "{:?}", closure.steps);
}

/// A deviation of its own at each of twelve targets is also all that a wave and a wrong length do.
#[test]
fn two_effects_take_the_place_of_a_table_of_deviations() {
    let readings = run(33, SIGMA_MM, |t, _, _| 0.008 * wave(t, 130.0) + 30e-6 * (t - 225.0));
    let closure = closed(&readings, &[], None);
    let mut names = named(&closure);
    names.sort();
    assert_eq!(names, ["cyclic-error", "pitch-error"], "{:?}", closure.steps);
}

/// The travel counts from −1 at its lower end to 1 at its upper one, wherever the axis has its zero, and
/// each reversal is half a step: the third amplitude is that of the second Legendre polynomial.
#[test]
fn a_reversal_by_place_is_along_the_travel() {
    for low in [-250.0, 0.0, 1000.0] {
        let at = |along: f64, side: Approach| AxisReading {
            name: format!("{along} {side:?}"),
            target: low + 250.0 * (along + 1.0),
            deviation: 0.0,
            approach: Some(side),
        };
        let places = [-1.0, -0.5, 0.0, 0.5, 1.0];
        let readings: Vec<_> = places
            .iter()
            .flat_map(|p| [at(*p, Approach::Rising), at(*p, Approach::Falling)])
            .collect();
        let run = AxisRun {
            readings: &readings,
            motion: AxisMotion::Linear,
            lead: None,
            cycles: None,
            covariates: &[],
        };
        let terms = run.terms(&run.shown());
        let by_place = terms.iter().find(|t| t.effect.id == "backlash-by-place").unwrap();
        for (i, reading) in readings.iter().enumerate() {
            let (along, half) = (places[i / 2], 0.5 * reading.approach.unwrap().sign());
            let legendre = 0.5 * (3.0 * along * along - 1.0);
            // Multiples of 2⁻⁵: exact.
            assert_eq!(by_place.columns[0][i].to_bits(), (half * along).to_bits(), "{reading:?}");
            assert_eq!(
                by_place.columns[1][i].to_bits(),
                (half * legendre).to_bits(),
                "{reading:?}"
            );
        }
    }
}

/// Only what turns has an error that repeats with its turn, and only 120° of it show one.
#[test]
fn a_turn_shows_on_rotary_axes_that_make_a_third_of_one() {
    let turns = |motion: AxisMotion, range: f64| {
        let readings: Vec<_> = (0..=4)
            .map(|i| AxisReading {
                name: i.to_string(),
                target: range * f64::from(i) / 4.0,
                deviation: 0.0,
                approach: None,
            })
            .collect();
        let run =
            AxisRun { readings: &readings, motion, lead: None, cycles: None, covariates: &[] };
        let terms = run.terms(&run.shown());
        let turning = |text: &String| text.ends_with("per turn of the axis");
        terms.iter().filter(|t| t.effect.subject.as_ref().is_some_and(turning)).count()
    };
    assert_eq!(turns(AxisMotion::Rotary, 120.0), 2);
    assert_eq!(turns(AxisMotion::Rotary, 100.0), 0);
    assert_eq!(turns(AxisMotion::Linear, 500.0), 0);
}

/// Closes the loop, and anew with the courses that show beside what was found.
fn settled(readings: &[AxisReading]) -> (Closure, Shown) {
    let run =
        AxisRun { readings, motion: AxisMotion::Linear, lead: None, cycles: None, covariates: &[] };
    let close = |shown: &Shown| {
        let model = positioning_model(&run, shown, Some(SIGMA_MM)).unwrap();
        let options = Options { nested: false, ..Options::default() };
        let closure = close_loop(&model, &[], &options).unwrap();
        let there = run.shown_beside(shown, &model, &closure.state);
        (closure, there)
    };
    let shown = run.shown();
    let (_, there) = close(&shown);
    let (closure, last) = close(&there);
    assert_eq!(last, there, "not settled");
    (closure, there)
}

/// There and back once: no target is read twice from one side, and the axis was homed anew on its way.
#[test]
fn a_session_shows_in_a_single_cycle() {
    let homed = |_: f64, _: f64, passed: f64| 0.02 * f64::from(u8::from(passed > 0.3));
    let all = run(34, SIGMA_MM, |_, _, _| 0.0);
    let once: Vec<AxisReading> = (all[..24].iter().enumerate())
        .map(|(i, r)| AxisReading {
            deviation: r.deviation + homed(0.0, 0.0, i as f64 / 24.0),
            ..r.clone()
        })
        .collect();
    assert!(once.iter().any(|r| r.approach == Some(Approach::Falling)));
    let (closure, _) = settled(&once);
    assert_eq!(named(&closure), ["session-shift"], "{:?}", closure.steps);
    assert_eq!(closure.verdict, Verdict::Explained);
    // To four standard uncertainties.
    let std = closure.steps[0].parameters[0].std;
    assert!((amplitude(&closure, 0, 0) - 20.0).abs() < 4.0 * std, "{:?}", closure.steps);
}

/// Read once from one side in the order of its targets, a drift is a pitch error; read again in the
/// opposite order, as the answer says, it is not.
#[test]
fn a_drift_read_in_the_order_of_the_targets_says_what_would_tell_it_from_a_pitch_error() {
    let all = run(35, SIGMA_MM, |_, _, _| 0.0);
    let drifting = |reading: &AxisReading, k: usize, side: Option<Approach>| AxisReading {
        name: k.to_string(),
        deviation: reading.deviation + 2e-3 * k as f64,
        approach: side,
        ..reading.clone()
    };
    let rising = Some(Approach::Rising);
    let up: Vec<AxisReading> = all.iter().filter(|r| r.approach == rising).cloned().collect();
    let once: Vec<_> = up[..12].iter().enumerate().map(|(k, r)| drifting(r, k, rising)).collect();
    let confused = closed(&once, &[], None);
    let step = &confused.steps[0];
    let names: Vec<&str> = std::iter::once(step.effect.as_str())
        .chain(step.indistinguishable_from.iter().map(String::as_str))
        .collect();
    assert!(names.contains(&"drift") && names.iter().any(|n| n.starts_with("pitch-error")));
    let advice = step.separate_by.as_deref();
    assert!(advice.is_some_and(|text| text.contains("every target")), "{advice:?}");

    let back = up[12..24].iter().rev().enumerate().map(|(k, r)| drifting(r, 12 + k, rising));
    let told = closed(&once.iter().cloned().chain(back).collect::<Vec<_>>(), &[], None);
    assert_eq!(named(&told), ["drift"], "{:?}", told.steps);
    let rivals = &told.steps[0].indistinguishable_from;
    assert!(!rivals.iter().any(|n| n.starts_with("pitch-error")), "{rivals:?}");
}

/// From one side alone half a reversal is an offset; the answer says how it would not be.
#[test]
fn an_offset_read_from_one_side_says_what_would_tell_it_from_a_reversal() {
    let mut one_sided = run(36, SIGMA_MM, |_, _, _| 0.02);
    one_sided.retain(|r| r.approach == Some(Approach::Rising));
    let closure = closed(&one_sided, &[], None);
    let step = &closure.steps[0];
    let is_rival = |wanted: &str| step.indistinguishable_from.iter().any(|name| name == wanted);
    assert!(is_rival("reversal") || step.effect == "reversal", "{step:?}");
    let advice = step.separate_by.as_deref();
    assert!(advice.is_some_and(|text| text.contains("from the other side")), "{step:?}");
}

/// Over a third of a turn an eccentric scale and a bent one read alike: the answer has both names.
#[test]
fn over_part_of_a_turn_a_parabola_and_a_wave_per_turn_are_rivals() {
    const ARC_DEG: f64 = 120.0;
    let bent = |share: f64| 10.0 * 4.0 * share * (1.0 - share);
    let eccentric = |share: f64| {
        let turned = |share: f64| (ARC_DEG * (share - 0.5)).to_radians().cos();
        25.0 * (turned(share) - turned(0.0))
    };
    for error in [&bent as &dyn Fn(f64) -> f64, &eccentric] {
        // Of 450 mm a third of a turn, of a micrometre half a second.
        let noise = run(36, 0.5, |_, _, _| 0.0);
        let targets = || noise.iter().map(|r| r.target);
        let (first, last) =
            (targets().fold(f64::INFINITY, f64::min), targets().fold(0.0, f64::max));
        let share = |target: f64| (target - first) / (last - first);
        let readings: Vec<AxisReading> = noise
            .iter()
            .map(|r| AxisReading {
                target: ARC_DEG * share(r.target),
                deviation: r.deviation + error(share(r.target)),
                ..r.clone()
            })
            .collect();
        let motion = AxisMotion::Rotary;
        let run =
            AxisRun { readings: &readings, motion, lead: None, cycles: None, covariates: &[] };
        let model = positioning_model(&run, &run.shown(), Some(0.5)).unwrap();
        let options = Options { nested: false, ..Options::default() };
        let closure = close_loop(&model, &[], &options).unwrap();
        let step = &closure.steps[0];
        let of = |step: &model_discrepancy::Step| format!("{} {:?}", step.effect, step.subject);
        let all = [vec![of(step)], step.rivals.clone()].concat();
        let has = |name: &str, subject: &str| {
            all.iter().any(|of| of.contains(name) && of.contains(subject))
        };
        assert!(has("profile", "a parabola"), "{all:?}");
        assert!(has("cyclic-error", "per turn of the axis"), "{all:?}");
    }
}
