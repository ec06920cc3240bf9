//! Forms and budgets.

use super::sample::photogrammetry;
use super::{parse, section, text_of};
use crate::{Budget, BudgetResult, Fact, Form, FormLimit, FormResult, ReportInput, render};

fn form() -> Form {
    let result = |symbol: &str, value, std, limit| FormResult {
        symbol: symbol.into(),
        name: format!("quantity {symbol}"),
        unit: "mm".into(),
        value,
        std,
        limit,
    };
    let limit = FormLimit { limit: 0.01, probability: Some(0.975), decision: "pass" };
    Form {
        title: "Test of positioning".into(),
        header: vec![("date".into(), Some("2026-03-01".into())), ("operator".into(), None)],
        conditions: vec![Fact { name: "targets".into(), value: "11".into() }],
        results: vec![
            result("A", Some(0.00812), Some(0.0005), Some(limit)),
            result("B", Some(0.001), None, None),
            result("M", None, None, None),
        ],
        compensated: vec![result("A", Some(0.0031), Some(0.0005), None)],
        notes: vec!["Of the readings as they are.".into()],
        rule: Some("It passes where it does.".into()),
    }
}

#[test]
fn a_form_hides_no_empty_field_and_shows_decisions() {
    let sample = photogrammetry();
    let form = form();
    let page = render(&ReportInput { form: Some(&form), ..sample.closed() });
    let document = parse(&page);
    let written = text_of(section(&document, "Test of positioning"));
    for expected in [
        "date2026-03-01",
        "operatornot declared",
        "targets11",
        "Aquantity A0.00810.0010mm0.0198\u{a0}%pass",
        "Bquantity B0.001000–mm–––",
        "Mquantity M––mm–––",
        "The same with the named effects taken off",
        // No limit is held against one of these: the second table has no columns for it.
        "Aquantity A0.00310.0010mm",
        "Of the readings as they are.",
        "Decision rule",
    ] {
        assert!(written.contains(expected), "{expected} in {written}");
    }
}

#[test]
fn without_limits_there_is_no_column_for_them() {
    let sample = photogrammetry();
    let mut form = form();
    form.results.iter_mut().for_each(|result| result.limit = None);
    form.rule = None;
    let page = render(&ReportInput { form: Some(&form), ..sample.closed() });
    let document = parse(&page);
    let written = text_of(section(&document, "Test of positioning"));
    assert!(!written.contains("limit") && !written.contains("Decision rule"), "{written}");
}

#[test]
fn a_budget_has_a_column_for_each_of_several_sources() {
    let sample = photogrammetry();
    let budget = |sources: &[&str]| Budget {
        draws: 1000,
        failed: 0,
        sources: sources.iter().map(|s| (*s).to_owned()).collect(),
        results: vec![BudgetResult {
            name: "x".into(),
            unit: "mm".into(),
            value: 1.25,
            linear_std: 0.01,
            std: 0.012,
            interval_95: [1.227, 1.273],
            by_source: vec![0.01; sources.len()],
        }],
    };
    let written = |budget: &Budget| {
        let page = render(&ReportInput { budget: Some(budget), ..sample.closed() });
        text_of(section(&parse(&page), "Uncertainty budget"))
    };
    let two = written(&budget(&["a.csv by sigma", "b.csv by sigma"]));
    assert!(two.contains("± of a.csv by sigma± of b.csv by sigma"), "{two}");
    assert!(two.contains("x1.2500.0200.0241.2271.2730.0200.020mm"), "{two}");
    let one = written(&budget(&["a.csv by sigma"]));
    assert!(!one.contains("± of") && one.contains("Simulated: a.csv by sigma."), "{one}");
}
