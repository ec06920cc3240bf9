//! Figures of ISO 230-2 against published runs and by laws, and runs of known errors through the loop.

use ft_center::{
    Approach, AxisFigures, AxisMotion, AxisReading, AxisRun, axis_coordinates, axis_figures,
    positioning_model,
};
use model_discrepancy::{
    Closure, Covariate, Model, Options, Quantity, State, Verdict, check_tangents, close_loop,
};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A published run: targets, then positions of five cycles at each, rising and falling, mm.
struct Published {
    targets: [f64; 5],
    rising: [[f64; 5]; 5],
    falling: [[f64; 5]; 5],
}

/// `github.com/paulscherrerinstitute/ecmccfg`, commit 2e51e0eaf6a2, `examples/mcu1025_fat_sat/report.md`.
const STAGE: Published = Published {
    targets: [15.0, 25.2, 35.4, 45.6, 55.8],
    rising: [
        [15.0033, 15.00452, 15.00085, 15.0033, 15.00595],
        [25.19933, 25.19913, 25.19933, 25.20015, 25.20117],
        [35.38477, 35.38762, 35.38395, 35.3864, 35.3866],
        [45.59182, 45.58978, 45.59263, 45.59263, 45.5908],
        [55.83882, 55.84025, 55.83964, 55.84086, 55.84005],
    ],
    falling: [
        [15.10035, 14.9721, 14.9721, 14.96966, 14.97251],
        [25.27803, 25.2132, 25.21259, 25.21748, 25.21422],
        [35.39639, 35.38803, 35.38926, 35.39252, 35.3915],
        [45.57387, 45.57041, 45.5649, 45.56939, 45.57061],
        [55.79315, 55.79499, 55.79132, 55.79193, 55.7958],
    ],
};

/// `github.com/anderssandstrom/ecmc_target_muts_logger`, commit 61b551aa5803,
/// `muts/data/week42_22/xyz/target_x_report_8A.md`.
const TARGET: Published = Published {
    targets: [-4.0, -2.0, 0.0, 2.0, 4.0],
    rising: [
        [-3.99861, -3.98366, -3.98366, -3.95012, -3.95335],
        [-2.00655, -1.98836, -1.98109, -1.9419, -1.93341],
        [-0.02782, -0.00802, -0.01005, 0.01986, 0.0344],
        [1.97474, 1.99616, 2.00181, 2.03495, 2.04909],
        [4.00316, 4.00397, 4.00963, 4.03024, 4.05165],
    ],
    falling: [
        [-4.10205, -4.01598, -3.99861, -3.99254, -3.96143],
        [-2.11969, -2.02392, -2.00251, -1.99968, -1.9617],
        [-0.13005, -0.02904, -0.01489, -0.01126, 0.01622],
        [1.94767, 1.97191, 1.98848, 2.00949, 2.02323],
        [3.94983, 3.98054, 3.98538, 4.01731, 4.03024],
    ],
};

fn readings(run: &Published) -> Vec<AxisReading> {
    let mut all = Vec::new();
    for cycle in 0..5 {
        for (approach, table) in [(Approach::Rising, run.rising), (Approach::Falling, run.falling)]
        {
            for (target, positions) in run.targets.iter().zip(table) {
                all.push(AxisReading {
                    name: format!("{target} {cycle} {approach:?}"),
                    target: *target,
                    deviation: positions[cycle] - target,
                    approach: Some(approach),
                });
            }
        }
    }
    all
}

fn value(found: &AxisFigures, symbol: &str) -> f64 {
    let figure = found.figures.iter().find(|f| f.symbol == symbol).expect("a figure of that name");
    figure.value.expect("a value")
}

/// What the reports print, rounded to 10 nm; sums of up to eight of such roundings.
const PRINTED_MM: f64 = 4e-5;

#[test]
fn figures_are_those_of_two_published_runs() {
    // E is not as those reports print it (the larger of E↑ and E↓, and in the first the smaller): by
    // ISO 230-2:2014, 3.20, it is the range over both directions, here of the printed means.
    let stage = [
        ("A", 0.23036),
        ("A rising", 0.05853),
        ("A falling", 0.23036),
        ("E", 0.03993 + 0.03016),
        ("E rising", 0.05405),
        ("E falling", 0.05727),
        ("R", 0.23036),
        ("R rising", 0.00751),
        ("R falling", 0.23036),
        ("B", 0.04649),
        ("B mean", 0.00829),
        ("M", 0.036),
    ];
    let target = [
        ("A", 0.24337),
        ("A rising", 0.14139),
        ("A falling", 0.24337),
        ("E", 0.02974 + 0.0338),
        ("E rising", 0.02806),
        ("E falling", 0.02646),
        ("R", 0.23715),
        ("R rising", 0.12529),
        ("R falling", 0.23715),
        ("B", 0.05124),
        ("B mean", 0.03544),
        ("M", 0.02226),
    ];
    for (run, printed) in [(STAGE, stage), (TARGET, target)] {
        let found = axis_figures(&readings(&run), 0.0);
        for (symbol, expected) in printed {
            let got = value(&found, symbol);
            assert!((got - expected).abs() < PRINTED_MM, "{symbol}: {got}, printed {expected}");
        }
    }
    // By target, of the first: mean, reversal, standard deviations and R_i.
    let found = axis_figures(&readings(&STAGE), 0.0);
    let printed = [
        (0.00046, 0.00624, 0.00188, 0.05759, 0.23036),
        (0.01346, -0.02728, 0.00085, 0.02853, 0.11413),
        (-0.0113, -0.00567, 0.00148, 0.00324, 0.01511),
        (-0.01932, 0.02169, 0.00124, 0.00323, 0.03063),
        (0.01668, 0.04649, 0.00076, 0.00193, 0.05185),
    ];
    for (t, (mean, reversal, s_rising, s_falling, r)) in found.targets.iter().zip(printed) {
        let got = [
            t.mean(),
            t.reversal().unwrap(),
            t.rising.unwrap().std.unwrap(),
            t.falling.unwrap().std.unwrap(),
            t.repeatability().unwrap(),
        ];
        for (got, expected) in got.into_iter().zip([mean, reversal, s_rising, s_falling, r]) {
            assert!((got - expected).abs() < PRINTED_MM, "{}: {got}, {expected}", t.target);
        }
    }
}

#[test]
fn figures_by_hand() {
    // Two targets, two cycles: x̄↑ = 2, −1; x̄↓ = −2, 1; s = √2 and √8 rising, √2 and 0 falling.
    let table: [(f64, Approach, [f64; 2]); 4] = [
        (0.0, Approach::Rising, [1.0, 3.0]),
        (10.0, Approach::Rising, [-3.0, 1.0]),
        (10.0, Approach::Falling, [1.0, 1.0]),
        (0.0, Approach::Falling, [-3.0, -1.0]),
    ];
    let readings: Vec<AxisReading> = (0..2)
        .flat_map(|cycle| {
            table.map(|(target, approach, x)| AxisReading {
                name: format!("{target} {approach:?} {cycle}"),
                target,
                deviation: x[cycle],
                approach: Some(approach),
            })
        })
        .collect();
    let found = axis_figures(&readings, 0.1);
    let (root2, root8) = (2f64.sqrt(), 8f64.sqrt());
    for (symbol, by_hand) in [
        ("E rising", 3.0),
        ("E falling", 3.0),
        ("E", 4.0),
        ("B", 4.0),
        ("B mean", 1.0),
        ("M", 0.0),
        ("R rising", 4.0 * root8),
        ("R falling", 4.0 * root2),
        ("R", (2.0 * root8 + 2.0).max(4.0 * root8).max(4.0 * root2 + 4.0)),
        ("A rising", (2.0 + 2.0 * root2).max(-1.0 + 2.0 * root8) - (-1.0 - 2.0 * root8)),
        ("A falling", 1.0 - (-2.0 - 2.0 * root2)),
        ("A", (2.0 + 2.0 * root2) - (-1.0 - 2.0 * root8)),
    ] {
        let got = value(&found, symbol);
        assert!((got - by_hand).abs() < 1e-12, "{symbol}: {got}, by hand {by_hand}");
    }
    // Pooled variance (2 + 8 + 2 + 0)/4 = 3; two readings a mean; a length standard of 0.1·10.
    let std = |symbol: &str| {
        found.figures.iter().find(|f| f.symbol == symbol).and_then(|f| f.std).unwrap()
    };
    let (of_mean, of_std) = ((3.0f64 / 2.0).sqrt(), (3.0f64 / 2.0).sqrt());
    let apart = root2 * of_mean;
    assert!((std("E") - apart.hypot(1.0)).abs() < 1e-12);
    assert!((std("B") - apart).abs() < 1e-12);
    assert!((std("M") - of_mean.hypot(1.0)).abs() < 1e-12);
    assert!((std("R rising") - 4.0 * of_std).abs() < 1e-12);
}

#[test]
fn laws_of_the_figures() {
    let plain = readings(&TARGET);
    let of = |readings: &[AxisReading]| axis_figures(readings, 0.0);
    let agree = |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e-12, "{what}: {a}, {b}");
    let symbols: Vec<&str> = of(&plain).figures.iter().map(|f| f.symbol).collect();
    // A shift of all readings changes nothing but the means by target.
    let shifted: Vec<AxisReading> =
        plain.iter().map(|r| AxisReading { deviation: r.deviation + 0.7, ..r.clone() }).collect();
    // The cycles in another order change nothing at all.
    let mut reordered = plain.clone();
    reordered.rotate_left(10);
    reordered.reverse();
    for symbol in &symbols {
        agree(value(&of(&shifted), symbol), value(&of(&plain), symbol), symbol);
        agree(value(&of(&reordered), symbol), value(&of(&plain), symbol), symbol);
    }
    for (a, b) in of(&shifted).targets.iter().zip(of(&plain).targets) {
        agree(a.mean(), b.mean() + 0.7, "mean");
        agree(a.reversal().unwrap(), b.reversal().unwrap(), "reversal");
    }
    // The axis counted the other way: targets, deviations and directions change sign.
    let mirrored: Vec<AxisReading> = plain
        .iter()
        .map(|r| AxisReading {
            name: r.name.clone(),
            target: -r.target,
            deviation: -r.deviation,
            approach: r.approach.map(|a| match a {
                Approach::Rising => Approach::Falling,
                Approach::Falling => Approach::Rising,
            }),
        })
        .collect();
    for [a, b] in [
        ["A", "A"],
        ["E", "E"],
        ["R", "R"],
        ["B", "B"],
        ["B mean", "B mean"],
        ["M", "M"],
        ["A rising", "A falling"],
        ["E rising", "E falling"],
        ["R rising", "R falling"],
    ] {
        agree(value(&of(&mirrored), a), value(&of(&plain), b), a);
    }
    // One way alone has no bidirectional figure.
    let one_way: Vec<AxisReading> =
        plain.into_iter().filter(|r| r.approach == Some(Approach::Rising)).collect();
    for figure in of(&one_way).figures {
        let is_one_way = figure.symbol.ends_with("rising");
        assert_eq!(figure.value.is_some(), is_one_way, "{}", figure.symbol);
    }
}

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
