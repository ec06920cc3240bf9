//! The page of a machine.

use super::{has_class, parse, section, text_of};
use crate::{MachineAmplitude, MachineCase, MachineEffect, MachinePage, render_machine};

fn effect() -> MachineEffect {
    MachineEffect {
        name: "axis-scale".to_owned(),
        description: "The axes <read> lengths in another unit.".to_owned(),
        amplitudes: vec![MachineAmplitude {
            name: "x".to_owned(),
            unit: "ppm".to_owned(),
            by_case: vec![("sphere".to_owned(), 12.0, 4.0), ("mirror".to_owned(), f64::NAN, 3.0)],
            all: (14.2, 1.5),
            agreement_p_value: Some(0.42),
        }],
    }
}

fn case(with_others: Option<f64>) -> MachineCase {
    MachineCase {
        name: "sphere".to_owned(),
        kind: "probe-comp".to_owned(),
        unit: "mm".to_owned(),
        before: 0.0042,
        with_others,
        after: 0.0011,
        beside: Vec::new(),
        named_alone: vec!["tip-radius".to_owned()],
        verdict: "explained".to_owned(),
    }
}

#[test]
fn it_says_what_each_case_has_and_what_all_have() {
    let (effects, cases) = ([effect()], [case(Some(0.0012)), case(None)]);
    let warnings = ["one & another".to_owned()];
    let page = MachinePage {
        title: "mill 3",
        lede: "2 cases: explained.",
        effects: &effects,
        cases: &cases,
        warnings: &warnings,
    };
    let html = render_machine(&page);
    let document = parse(&html);
    let of_effect = section(&document, "axis-scale");
    let text = text_of(of_effect);
    for expected in ["The axes <read> lengths", "all cases", "14.2", "3.0", "chance of 0.42"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // Wide and narrow; a value that is no number has a name and no mark.
    let pictures = of_effect.descendants().filter(|n| n.has_tag_name("svg"));
    let marks = |n: roxmltree::Node| n.descendants().filter(|m| has_class(*m, "big-dot")).count();
    assert_eq!(pictures.map(marks).collect::<Vec<_>>(), [2, 2]);
    let errors = text_of(section(&document, "Error on data the fit never saw"));
    assert!(errors.contains("0.00420") && errors.contains("tip-radius"), "{errors}");
    assert!(!html.contains("NaN"), "a number that is none");
}

#[test]
fn a_machine_of_which_nothing_is_known_has_a_page() {
    let page = MachinePage { title: "", lede: "", effects: &[], cases: &[], warnings: &[] };
    parse(&render_machine(&page));
}
