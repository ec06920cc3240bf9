//! Text out of a user's file stays text; values that are not numbers stay out.

use std::collections::BTreeSet;

use model_discrepancy::{Group, Outcome};
use roxmltree::Node;

use super::sample::{Sample, four_displacements, photogrammetry};
use super::{parse, text_of};
use crate::{ExtraPlot, Fact, IndexEntry, Published, render, render_index};

const HOSTILE: &[&str] = &[
    "<script>alert(1)</script>",
    "\"><img src=x onerror=alert(1)>",
    "' onload='alert(1)",
    "</title></style></script><svg onload=alert(1)>",
    "<!--/truing:case--><!--",
    "]]> &amp; &#60;b&#62; &bogus;",
    "\u{202e}evil\u{2066}\u{7f}\u{9b}",
    "שלום עולם، مرحبا",
    "null\u{0} bell\u{7} escape\u{1b} not a character\u{ffff}",
    "line\nbreak\ttab `unpaired and `paired` ` code`",
    "{\"json\": \"</script>\"}\\",
];

/// The sample with every text that a user can choose replaced.
fn with_text(mut sample: Sample, text: &str) -> Sample {
    let own = || text.to_string();
    sample.title = own();
    sample.source = Some(own());
    sample.group_noun = own();
    sample.description = vec![own()];
    sample.measured = vec![Fact { name: own(), value: own() }];
    sample.declared = vec![own()];
    sample.components = vec![own(), own(), own()];
    sample.warnings = vec![own()];
    sample.published = Some(Published { text: own(), source: own(), rms: Some(0.1) });
    sample.layout.unit = own();
    sample.layout.groups =
        sample.layout.groups.iter().map(|g| Group { name: own(), role: g.role }).collect();
    for parameter in &mut sample.parameters {
        (parameter.name, parameter.unit) = (own(), own());
    }
    for covariate in &mut sample.covariates {
        covariate.name = own();
    }
    for plot in &mut sample.plots {
        if let ExtraPlot::Vectors(map) = plot {
            (map.title, map.caption, map.x_title, map.unit) = (own(), own(), own(), own());
            map.before.iter_mut().for_each(|a| a.name = own());
        }
    }
    let closure = &mut sample.closure;
    closure.warnings = vec![own()];
    closure.confusable_ids.iter_mut().for_each(|id| *id = own());
    closure.not_observable[0].aliased_with = vec![own()];
    for step in &mut closure.steps {
        step.effect = own();
        step.subject = Some(own());
        step.description = own();
        step.indistinguishable_from = vec![own()];
        step.separate_by = Some(own());
    }
    for score in closure.passes.iter_mut().flat_map(|p| &mut p.scores) {
        score.label = own();
    }
    sample
}

/// Names of elements and attributes; what a text could add if it were not escaped.
fn vocabulary(page: &str) -> BTreeSet<String> {
    let document = parse(page);
    let elements = document.descendants().filter(Node::is_element);
    let words = elements.flat_map(|n| {
        let attributes = n.attributes().map(|a| format!("@{}", a.name())).collect::<Vec<_>>();
        std::iter::once(n.tag_name().name().to_string()).chain(attributes)
    });
    words.collect()
}

fn script_count(page: &str) -> usize {
    parse(page).descendants().filter(|n| n.has_tag_name("script")).count()
}

#[test]
fn hostile_text_adds_no_markup() {
    let harmless = with_text(photogrammetry(), "plain text");
    let page = render(&harmless.closed());
    let mut expected = vocabulary(&page);
    expected.insert("code".to_string()); // A pair of backticks makes code of what it encloses.
    for text in HOSTILE {
        let page = render(&with_text(photogrammetry(), text).closed());
        let found = vocabulary(&page);
        let added: Vec<_> = found.difference(&expected).collect();
        assert!(added.is_empty(), "{text:?} adds {added:?}");
        assert_eq!(script_count(&page), 2, "{text:?}");
    }
}

#[test]
fn hostile_text_arrives_as_text() {
    for text in HOSTILE.iter().filter(|t| !t.contains(['\0', '\n', '\u{202e}'])) {
        let page = render(&with_text(photogrammetry(), text).closed());
        let document = parse(&page);
        let heading = document.descendants().find(|n| n.has_tag_name("h1")).unwrap();
        assert_eq!(text_of(heading), *text);
    }
}

#[test]
fn names_do_not_turn_the_direction_of_what_surrounds_them() {
    let page = render(&with_text(photogrammetry(), "\u{202e}evil \u{2067}name").closed());
    assert!(!page.contains(['\u{202e}', '\u{2067}']));
    let document = parse(&page);
    let heading = document.descendants().find(|n| n.has_tag_name("h1")).unwrap();
    assert!(heading.children().all(|c| c.has_tag_name("bdi")));
}

#[test]
fn hostile_pages_go_through_the_index() {
    let pages: Vec<String> =
        HOSTILE.iter().map(|t| render(&with_text(photogrammetry(), t).closed())).collect();
    let entries: Vec<IndexEntry> =
        pages.iter().map(|p| IndexEntry::from_page(p, "page.html").unwrap()).collect();
    for (entry, text) in entries.iter().zip(HOSTILE) {
        assert_eq!(entry.summary.title, *text);
    }
    let page = render_index(HOSTILE[0], HOSTILE[1], &entries);
    let document = parse(&page);
    let links: Vec<_> = document.descendants().filter_map(|n| n.attribute("href")).collect();
    assert_eq!(links, vec!["page.html"; HOSTILE.len()]);
    assert_eq!(script_count(&page), 1);
}

#[test]
fn a_very_long_name_is_cut_in_drawings_only() {
    const LENGTH: usize = 5000;
    let long = "x".repeat(LENGTH);
    let mut sample = photogrammetry();
    sample.closure.passes[0].scores[0].label.clone_from(&long);
    sample.covariates[0].name.clone_from(&long);
    let page = render(&sample.closed());
    let document = parse(&page);
    let labels = document.descendants().filter(|n| n.has_tag_name("text")).map(text_of);
    let longest = labels.map(|l| l.chars().count()).max().unwrap();
    assert!(longest < 200, "{longest} characters in a drawing 900 units wide");
    let cell = |n: &Node| n.has_tag_name("th") && text_of(*n) == long;
    assert!(document.descendants().any(|n| cell(&n)), "the table has the whole name");
}

/// Attributes that position something.
const NUMERIC: &[&str] =
    &["x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "r", "width", "height", "fill-opacity"];

fn assert_all_finite(page: &str) {
    assert!(!page.contains("NaN"), "NaN in the page");
    let document = parse(page);
    for node in document.descendants().filter(Node::is_element) {
        let inside_svg = node.ancestors().any(|a| a.has_tag_name("svg"));
        for attribute in node.attributes().filter(|_| inside_svg) {
            if NUMERIC.contains(&attribute.name()) {
                let value: f64 = attribute.value().parse().unwrap();
                assert!(value.is_finite() && value.abs() < 1e5, "{attribute:?}");
            }
            if attribute.name() == "d" {
                let letters = attribute.value().chars().filter(char::is_ascii_alphabetic);
                assert!(letters.clone().all(|c| "MLhmlz".contains(c)), "{attribute:?}");
            }
        }
    }
}

#[test]
fn values_that_are_not_numbers_are_not_drawn() {
    let poison = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e300, 1e-320];
    for bad in poison {
        let mut sample = photogrammetry();
        sample.closure.residuals_before[4] = bad;
        sample.closure.residuals_after[10] = bad;
        sample.covariates[0].values[3] = bad;
        sample.parameters[0].value = bad;
        sample.parameters[1].std = Some(bad);
        sample.parameters[2].after = Some((bad, bad));
        sample.closure.after.held_out_rms = bad;
        sample.closure.before.held_out_std = bad;
        sample.closure.before.chi2_per_dof = Some(bad);
        sample.closure.steps[0].p_value = bad;
        sample.closure.steps[0].parameters[0].std = bad;
        sample.closure.steps[0].stability.resampled = Some(bad);
        sample.closure.confusability[(1, 2)] = bad;
        for (i, score) in sample.closure.passes[0].scores.iter_mut().enumerate() {
            match i % 4 {
                0 => score.p_value = bad,
                1 => score.held_out_rms = bad,
                2 => score.f_statistic = bad,
                _ => (score.absorbed, score.outcome) = (bad, Outcome::Weaker),
            }
        }
        if let ExtraPlot::Vectors(map) = &mut sample.plots[0] {
            map.before[0].error[0] = bad;
            map.after[1].at[1] = bad;
        }
        let page = render(&sample.closed());
        assert_all_finite(&page);
        assert!(IndexEntry::from_page(&page, "").is_ok(), "{bad}");
    }
}

#[test]
fn a_residual_that_is_all_one_value_has_a_plot() {
    for value in [0.0, 0.3, -7e-12, 1e12] {
        let mut sample = four_displacements();
        sample.closure.residuals_before = vec![value; 4];
        sample.closure.residuals_after = vec![value; 4];
        sample.covariates[0].values = vec![1e9, 1e9, 1e9, 1e9 + 1e-6];
        assert_all_finite(&render(&sample.closed()));
    }
}

#[test]
fn residuals_that_do_not_fit_the_layout_do_no_harm() {
    let mut sample = photogrammetry();
    sample.closure.residuals_before.truncate(7);
    sample.closure.residuals_after.push(3.0);
    sample.covariates[1].values.truncate(2);
    sample.layout.rows[3].observation = 999;
    sample.layout.observations[5] = 999;
    sample.closure.confusable_ids.pop();
    sample.components.truncate(1);
    assert_all_finite(&render(&sample.closed()));
}
