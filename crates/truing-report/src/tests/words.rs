//! Numbers and sentences for people.

use model_discrepancy::{Outcome, ParameterEstimate};
use proptest::prelude::*;

use super::sample::{four_displacements, long_log, photogrammetry};
use super::{parse, section, text_of};
use crate::axis::{Range, ticks};
use crate::markup::{shorten, text_width};
use crate::number::{count, p_value, percent, plural, significant, trimmed, with_expanded};
use crate::unit::{Shown, column_title};
use crate::{Evidence, render, thin, trend, with_size};

#[test]
fn numbers_have_the_digits_that_mean_something() {
    assert_eq!(significant(0.280_19, 3), "0.280");
    assert_eq!(significant(-0.000_123_456, 3), "−0.000123");
    assert_eq!(significant(1.234e-7, 3), "1.23×10⁻⁷");
    assert_eq!(significant(1e300, 2), "1.0×10³⁰⁰");
    assert_eq!(significant(123_456.7, 3), "123000");
    assert_eq!(significant(-0.0, 3), "0");
    assert_eq!(significant(f64::NAN, 3), "–");
    assert_eq!(trimmed(0.02, 3), "0.02");
    assert_eq!(trimmed(20.0, 3), "20");
    assert_eq!(trimmed(1e-9, 3), "1.00×10⁻⁹");
}

#[test]
fn values_end_where_their_uncertainty_does() {
    let shown = |value, std| {
        let (value, expanded) = with_expanded(value, std);
        format!("{value} ± {expanded}")
    };
    // k = 2: the standard uncertainty doubles.
    assert_eq!(shown(-429.13, 2.31), "−429.1 ± 4.6");
    assert_eq!(shown(0.280_19, 0.031), "0.280 ± 0.062");
    assert_eq!(shown(123_456.0, 610.0), "123500 ± 1200");
    assert_eq!(shown(0.000_001_2, 0.000_000_2), "0.00000120 ± 0.00000040");
    assert_eq!(shown(5.0, 0.0), "5.000 ± –");
    assert_eq!(shown(5.0, f64::NAN), "5.000 ± –");
}

#[test]
fn significances_percents_and_counts_read_well() {
    assert_eq!(p_value(0.0), "< 10⁻¹⁶");
    assert_eq!(p_value(3.2e-7), "3×10⁻⁷");
    assert_eq!(p_value(0.0041), "0.0041");
    assert_eq!(p_value(0.57), "0.57");
    assert_eq!(percent(0.9996), "> 99.9\u{a0}%");
    assert_eq!(percent(0.995), "99.5\u{a0}%");
    assert_eq!(percent(1.0), "100\u{a0}%");
    assert_eq!(percent(0.001), "< 1\u{a0}%");
    assert_eq!(count(1234), "1234");
    assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
    assert_eq!(plural("press"), "presses");
    assert_eq!(plural("touch"), "touches");
    assert_eq!(plural("point"), "points");
    assert_eq!(plural("לוח"), "לוח");
}

#[test]
fn small_errors_are_shown_in_small_units() {
    let shown = |unit: &str, size: f64| {
        let shown = Shown::for_size(unit, size);
        format!("{} {}", significant(size * shown.factor, 2), shown.unit)
    };
    assert_eq!(shown("mm", 0.28), "0.28 mm");
    assert_eq!(shown("mm", 0.048), "48 µm");
    assert_eq!(shown("mm", 4.8e-6), "4.8 nm");
    assert_eq!(shown("N", 0.068), "68 mN");
    assert_eq!(shown("rad", 4.1e-6), "4.1 µrad");
    assert_eq!(shown("ppm", 0.01), "0.010 ppm");
    assert_eq!(shown("mm", 0.0), "0 mm");
    assert_eq!(column_title("temperature_c"), "temperature, °C");
    assert_eq!(column_title("speed_mm_per_s"), "speed, mm/s");
    assert_eq!(column_title("_mm"), "_mm");
    assert_eq!(column_title("direction"), "direction");
}

#[test]
fn a_pure_number_has_no_unit() {
    assert_eq!(
        with_size("the constant is larger", &[(4.0, 0.5, "1")]),
        "the constant is larger: 4.0 ± 1.0"
    );
    assert_eq!(with_size("it is longer", &[(4.0, 0.5, "mm")]), "it is longer: 4.0 ± 1.0 mm");
}

#[test]
fn labels_that_differ_at_their_end_still_do_when_cut() {
    let cut = |text| shorten(text, 100.0, 12.0);
    assert_ne!(cut("load-shift [press number 17]"), cut("load-shift [press number 18]"));
    assert_eq!(cut("scale"), "scale");
}

#[test]
fn a_class_of_names_is_not_given_as_one_name() {
    let page = render(&four_displacements().closed());
    let document = parse(&page);
    let lede = text_of(document.descendants().find(|n| n.has_tag_name("header")).unwrap());
    assert!(lede.contains("moment-gain (or one of 2 effects that look the same here)"), "{lede}");
    let apart = "What cannot be told apart, and which measurement would";
    let apart = text_of(section(&document, apart));
    assert!(apart.contains("moment-gain · force-gain · frame-scale"), "{apart}");
    assert!(apart.contains("To tell them apart: press at a second load."), "{apart}");
    let headline = text_of(section(&document, "Error on data the fit never saw"));
    assert!(headline.contains("too few to repeat the choice"), "{headline}");
    assert!(headline.contains("Published: 0.280 mm rms (document [A], Table 4)."), "{headline}");
}

#[test]
fn the_first_sentence_gives_the_clearest_of_many_amplitudes() {
    let mut sample = four_displacements();
    let step = &mut sample.closure.steps[0];
    let one = step.parameters[0].clone();
    let of = |(name, value): (&str, f64)| ParameterEstimate {
        name: name.to_owned(),
        value,
        std: 1.0,
        ..one.clone()
    };
    step.parameters =
        [("EXB", 0.1), ("EYB", 15.0), ("EZB", -9.0), ("EAB", 0.2), ("EBB", -118.0), ("ECB", 7.0)]
            .map(of)
            .to_vec();
    let page = render(&sample.closed());
    let document = parse(&page);
    let lede = text_of(document.descendants().find(|n| n.has_tag_name("header")).unwrap());
    assert!(lede.contains("EYB 15") && lede.contains("EBB −118"), "{lede}");
    assert!(lede.contains("and 2 less clear") && !lede.contains("EXB"), "{lede}");
}

#[test]
fn what_is_left_and_what_is_warned_of_is_said() {
    let page = render(&long_log(20).closed());
    let document = parse(&page);
    let left = text_of(section(&document, "What is left"));
    for expected in ["still has structure", "time, s", "periodic", "3×10⁻⁵", "autocorrelated"]
    {
        assert!(left.contains(expected), "{expected} in {left}");
    }
    let warnings = text_of(section(&document, "Warnings"));
    assert!(warnings.contains("31 of 500 samples below the force gate"));
    assert!(warnings.contains("no [noise] moment_nmm"));
    let hidden = text_of(section(&document, "What these data cannot show"));
    assert!(hidden.contains("frame tx, frame ty") && hidden.contains("press at a second load"));
}

#[test]
fn what_was_added_has_its_uncertainty() {
    let page = render(&photogrammetry().closed());
    let document = parse(&page);
    let added = text_of(section(&document, "What was added, and how sure that is"));
    for expected in ["−429.1", "4.6", "ppm", "p < 10⁻¹⁶", "in 100\u{a0}% of the repetitions"]
    {
        assert!(added.contains(expected), "{expected} in {added}");
    }
}

#[test]
fn passes_are_headed_by_what_they_added_and_shown_once() {
    let mut sample = photogrammetry();
    let passes = &mut sample.closure.passes;
    passes[0].scores[1].outcome = Outcome::Added;
    // After a covariate was looked for in vain the catalogue is scored again, with the same result.
    passes.push(passes[1].clone());
    let page = render(&sample.closed());
    let document = parse(&page);
    let scores = section(&document, "How each candidate effect scored");
    let headings: Vec<String> =
        scores.descendants().filter(|n| n.has_tag_name("h3")).map(text_of).collect();
    let expected = ["Pass 1: scale and anisotropic-scale added", "Pass 2: nothing added"];
    assert_eq!(headings, expected);
}

#[test]
fn a_solve_does_not_speak_of_effects() {
    let mut sample = photogrammetry();
    sample.plots.clear();
    let input = sample.solved();
    assert!(matches!(input.evidence, Evidence::Solved { .. }));
    let page = render(&input);
    let document = parse(&page);
    let article = document.descendants().find(|n| n.has_tag_name("article")).unwrap();
    for word in ["added", "candidate", "told apart"] {
        assert!(!text_of(article).contains(word), "{word}");
    }
}

proptest! {
    #[test]
    fn ticks_are_distinct_round_and_inside(
        low in -1e6..1e6f64,
        exponent in -9..9i32,
        mantissa in 1.0..10.0f64,
        most in 2..10usize,
    ) {
        let range = Range::of([low, low + mantissa * 10f64.powi(exponent)]).unwrap();
        let found = ticks(range, most);
        prop_assert!((2..=6.max(most + 1)).contains(&found.len()), "{} of {most}", found.len());
        let slack = 1e-6 * range.span();
        for tick in &found {
            prop_assert!(range.low - slack <= tick.at && tick.at <= range.high + slack);
        }
        for pair in found.windows(2) {
            prop_assert!(pair[0].at < pair[1].at);
            prop_assert_ne!(&pair[0].label, &pair[1].label);
        }
    }

    #[test]
    fn labels_are_cut_to_their_room(text in ".{0,60}", width in 20.0..300.0f64) {
        let cut = shorten(&text, width, 12.0);
        prop_assert!(text_width(&cut, 12.0) <= width.max(text_width("…", 12.0)));
        prop_assert!(cut == text || cut.contains('…'));
    }

    #[test]
    fn thinning_keeps_the_extremes(
        values in prop::collection::vec(-1e3..1e3f64, 1..500),
        limit in 2..100usize,
    ) {
        let kept = thin::envelope(&values, limit);
        prop_assert!(kept.len() <= limit.max(2) + 2);
        prop_assert!(kept.windows(2).all(|w| w[0] < w[1]));
        let largest = |v: &mut dyn Iterator<Item = f64>| v.fold(f64::NEG_INFINITY, f64::max);
        let smallest = |v: &mut dyn Iterator<Item = f64>| v.fold(f64::INFINITY, f64::min);
        let mut drawn = kept.iter().map(|i| values[*i]);
        let (low, high) = (smallest(&mut drawn.clone()), largest(&mut drawn));
        prop_assert!(values.iter().all(|v| (low..=high).contains(v)));
    }

    #[test]
    fn spreads_enclose_their_readings(
        values in prop::collection::vec(-1e3..1e3f64, 1..300),
        most in 1..50usize,
    ) {
        let points: Vec<[f64; 2]> = (0u32..).zip(&values).map(|(i, v)| [f64::from(i), *v]).collect();
        let spreads = trend::spreads(&points, most);
        prop_assert!(spreads.len() <= most);
        for s in &spreads {
            prop_assert!(s.all[0] <= s.two_thirds[0] && s.two_thirds[1] <= s.all[1]);
        }
        let highest = spreads.iter().map(|s| s.all[1]).fold(f64::NEG_INFINITY, f64::max);
        let lowest = spreads.iter().map(|s| s.all[0]).fold(f64::INFINITY, f64::min);
        prop_assert!(values.iter().all(|v| (lowest..=highest).contains(v)));
    }
}
