//! Well-formed, self-contained, complete whatever is missing, small whatever is measured.

use model_discrepancy::{Closure, ErrorSummary, HoldOut, Layout, State, Verdict};
use nalgebra::{DMatrix, DVector};

use super::sample::{four_displacements, long_log, nothing_missing, photogrammetry};
use super::{parse, section, text_of};
use crate::{Evidence, ReportInput, render};

/// A page is to open at once in a browser and to fit in a mail.
const MOST_BYTES: usize = 2_000_000;

fn pages() -> Vec<String> {
    let samples = [photogrammetry(), four_displacements(), nothing_missing(), long_log(50)];
    samples.iter().flat_map(|s| [render(&s.closed()), render(&s.solved())]).collect()
}

#[test]
fn pages_are_well_formed_and_load_nothing() {
    for page in pages() {
        let document = parse(&page);
        for node in document.descendants().filter(roxmltree::Node::is_element) {
            for name in ["src", "srcset", "data", "poster", "xlink:href"] {
                assert_eq!(node.attribute(name), None, "{}", node.tag_name().name());
            }
            let is_within = |href: &str| {
                let saved = href.starts_with("data:text/csv;") && node.has_attribute("download");
                saved || href.starts_with('#')
            };
            assert!(node.attribute("href").is_none_or(is_within));
            assert!(!node.has_tag_name("link"));
        }
        for address in ["http://", "https://", "url(", "@import"] {
            assert!(!page.contains(address), "{address}");
        }
    }
}

#[test]
fn sections_come_in_reading_order() {
    let page = render(&photogrammetry().closed());
    let document = parse(&page);
    let headings: Vec<String> =
        document.descendants().filter(|n| n.has_tag_name("h2")).map(text_of).collect();
    let expected = [
        "Error on data the fit never saw",
        "Where the errors point",
        "What was added, and how sure that is",
        "What is left",
        "Warnings",
        "What cannot be told apart, and which measurement would",
        "Residual of the declared model",
        "Residual with the added effects",
        "What was measured",
        "Declared model",
        "How each candidate effect scored",
        "Error, step by step",
        "What these data cannot show",
    ];
    assert_eq!(headings, expected);
}

#[test]
fn contents_lead_to_every_section() {
    for page in pages() {
        let document = parse(&page);
        let ids: Vec<&str> = document.descendants().filter_map(|n| n.attribute("id")).collect();
        let nav = document.descendants().find(|n| n.has_tag_name("nav")).unwrap();
        let links: Vec<&str> = nav.descendants().filter_map(|a| a.attribute("href")).collect();
        let headings = document.descendants().filter(|n| n.has_tag_name("h2")).count();
        assert_eq!(links.len(), headings);
        for link in &links {
            let found = ids.iter().filter(|id| **id == &link[1..]).count();
            assert_eq!(found, 1, "{link} in {ids:?}");
        }
    }
}

#[test]
fn every_picture_says_what_it_shows() {
    for page in pages() {
        let document = parse(&page);
        for svg in document.descendants().filter(|n| n.has_tag_name("svg")) {
            let spoken = svg.attribute("role") == Some("img")
                && svg.attribute("aria-label").is_some_and(|l| l.len() > 10);
            assert!(spoken || svg.attribute("aria-hidden") == Some("true"));
        }
    }
}

fn empty_error() -> ErrorSummary {
    ErrorSummary {
        train_rms: f64::NAN,
        held_out_rms: f64::NAN,
        held_out_std: f64::NAN,
        hold_out: HoldOut::Nested,
        unit: String::new(),
        chi2_per_dof: None,
        chi2_interval: None,
    }
}

fn empty_closure() -> Closure {
    Closure {
        before: empty_error(),
        after: empty_error(),
        steps: vec![],
        passes: vec![],
        verdict: Verdict::NothingMissing,
        remaining: vec![],
        lack_of_fit: None,
        odd_check: None,
        not_observable: vec![],
        confusability: DMatrix::zeros(0, 0),
        confusable_ids: vec![],
        state: State { base: DVector::zeros(0), amplitudes: vec![] },
        covariance: DMatrix::zeros(0, 0),
        columns: vec![],
        empirical: vec![],
        jacobian: DMatrix::zeros(0, 0),
        variance_factor: 1.0,
        degrees_of_freedom: None,
        alternatives: vec![],
        residuals_before: vec![],
        residuals_after: vec![],
        warnings: vec![],
    }
}

#[test]
fn a_case_without_anything_still_makes_a_page() {
    let (layout, closure) = (Layout::default(), empty_closure());
    for evidence in [Evidence::Closed(&closure), Evidence::Solved { residuals: &[] }] {
        let page = render(&ReportInput {
            title: "",
            kind: "",
            source: None,
            mistakes: &[],
            as_read: None,
            description: &[],
            measured: &[],
            declared: &[],
            parameters: &[],
            layout: &layout,
            components: &[],
            residual: "",
            group_noun: "",
            evidence,
            covariates: &[],
            plots: &[],
            form: None,
            budget: None,
            published: None,
            story: None,
            simulated: false,
            warnings: &[],
        });
        let document = parse(&page);
        let residual = section(&document, "Residual of the declared model");
        assert!(text_of(residual).contains("There is no residual to draw."));
        assert!(!residual.descendants().any(|n| n.has_tag_name("svg")), "an empty plot");
        assert!(!page.contains("NaN"));
    }
}

#[test]
fn a_long_log_stays_small_and_says_what_is_not_drawn() {
    const SAMPLES_PER_PRESS: usize = 5000;
    let page = render(&long_log(SAMPLES_PER_PRESS).closed());
    assert!(page.len() < MOST_BYTES, "{} bytes for 200 000 observations", page.len());
    assert!(page.contains("Of 200\u{202f}000 readings of a component, 1 in 667 is shown"));
    assert!(page.contains("The best 12 of 42 candidates are drawn."));
    // Two that were significant and six more are shown at once.
    assert!(page.contains("34 more that were not significant"));
}

/// The text that a `data:` address holds.
fn decoded(address: &str) -> String {
    let (_, encoded) = address.split_once(',').unwrap();
    let mut bytes = Vec::new();
    let mut rest = encoded.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let digits = [rest.next().unwrap(), rest.next().unwrap()];
                u8::from_str_radix(std::str::from_utf8(&digits).unwrap(), 16).unwrap()
            }
            byte => byte,
        });
    }
    String::from_utf8(bytes).unwrap()
}

/// The first file that a section offers.
fn saved(page: &str, heading: &str) -> (String, String) {
    let document = parse(page);
    let link = section(&document, heading)
        .descendants()
        .find(|n| n.has_attribute("download"))
        .unwrap_or_else(|| panic!("no data under «{heading}»"));
    (link.attribute("download").unwrap().into(), decoded(link.attribute("href").unwrap()))
}

/// Numbers of the files are written to seven digits.
const WRITTEN: f64 = 1e-6;

#[test]
fn pictures_offer_their_numbers() {
    let sample = photogrammetry();
    let page = render(&sample.closed());
    let (name, csv) = saved(&page, "Residual with the added effects");
    assert_eq!(name, "residual-with-the-added-effects.csv");
    let mut lines = csv.lines();
    let head = lines.next().unwrap();
    assert!(head.starts_with("point,use,\"residual x, mm\",\"residual y, mm\""), "{head}");
    let mut found = 0;
    for (i, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        for component in 0..3 {
            let expected = sample.closure.residuals_after[3 * i + component];
            let value: f64 = cells[2 + component].parse().unwrap();
            assert!((value - expected).abs() <= WRITTEN * expected.abs(), "{line}: {expected}");
            found += 1;
        }
    }
    assert_eq!(found, sample.closure.residuals_after.len());

    let document = parse(&page);
    let figures = document.descendants().filter(|n| n.has_tag_name("section")).filter(|s| {
        s.descendants().any(|n| n.attribute("class").is_some_and(|c| c.starts_with("plot")))
    });
    for section in figures {
        let offers = section.descendants().any(|n| n.has_attribute("download"));
        assert!(offers, "{}", text_of(section));
    }
}

#[test]
fn of_a_long_log_one_row_in_several_is_offered_and_that_is_said() {
    let sample = long_log(50);
    let page = render(&sample.closed());
    let (_, csv) = saved(&page, "Residual of the declared model");
    let all = sample.layout.observations.len();
    let document = parse(&page);
    let said = text_of(section(&document, "Residual of the declared model"));
    assert!(csv.lines().count() < all, "{all}");
    assert!(said.contains("data as CSV (one row in "), "{said}");
}
