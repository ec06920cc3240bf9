//! The cases of one machine taken together, as a page.

use super::forest::Forest;
use super::markup::Markup;
use super::number::{NONE, significant, with_expanded};
use super::page::document;
use super::section::{Cell, Kind, change, table};

/// Everything that the page of a machine shows.
#[derive(Clone, Debug)]
pub struct MachinePage<'a> {
    /// Title of the page: name of the machine.
    pub title: &'a str,
    /// The answer in one sentence.
    pub lede: &'a str,
    /// Effects of the machine.
    pub effects: &'a [MachineEffect],
    /// Every case with its errors.
    pub cases: &'a [MachineCase],
    /// Notes the user should read.
    pub warnings: &'a [String],
}

/// An effect with one amplitude for the data of all cases.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineEffect {
    /// Name, with its subject.
    pub name: String,
    /// What it does, and what it cannot be told apart from.
    pub description: String,
    /// Its amplitudes.
    pub amplitudes: Vec<MachineAmplitude>,
}

/// An amplitude as each case has it on its own, and as all have it.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineAmplitude {
    /// Name.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// Case, value and standard uncertainty, where its data determine it.
    pub by_case: Vec<(String, f64, f64)>,
    /// Value and standard uncertainty from all data.
    pub all: (f64, f64),
    /// Chance that cases which measure the same differ as much; `None` of fewer than two.
    pub agreement_p_value: Option<f64>,
}

/// Errors of a case on data the fit never saw.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineCase {
    /// Its folder.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// Unit of its errors.
    pub unit: String,
    /// Error of its declared model.
    pub before: f64,
    /// Error with the machine's effects as the other cases have them.
    pub with_others: Option<f64>,
    /// Error with the machine's effects, and what the case needs beside them.
    pub after: f64,
    /// What it needs beside them.
    pub beside: Vec<String>,
    /// What the loop on it alone names.
    pub named_alone: Vec<String>,
    /// Its verdict with the machine's effects.
    pub verdict: String,
}

/// Widths of a picture on a wide and on a narrow page; the style sheet shows one of the two.
const WIDTHS: [(f64, &str); 2] = [(900.0, "plot wide"), (352.0, "plot narrow")];

/// Renders the page of a machine, one self-contained HTML file.
#[must_use]
pub fn render_machine(page: &MachinePage) -> String {
    let mut body = Markup::new();
    body.open("header", &[]);
    body.element("h1", &[], page.title);
    body.element("p", &[("class", &"lede")], page.lede);
    body.close("header");
    if !page.warnings.is_empty() {
        body.open("ul", &[("class", &"warnings")]);
        page.warnings.iter().for_each(|warning| body.element("li", &[], warning));
        body.close("ul");
    }
    errors(&mut body, page.cases);
    for effect in page.effects {
        body.open("section", &[]);
        body.element("h2", &[], &effect.name);
        body.element("p", &[], &effect.description);
        for amplitude in &effect.amplitudes {
            amplitude_by_case(&mut body, amplitude);
        }
        body.close("section");
    }
    document(page.title, "page", &body)
}

fn errors(out: &mut Markup, cases: &[MachineCase]) {
    out.open("section", &[]);
    out.element("h2", &[], "Error on data the fit never saw");
    out.element(
        "p",
        &[],
        "Before: the case's declared model. By the others: with the machine's effects as the other \
         cases alone have them, so that no reading of the case had a part in their size. After: with \
         the machine's effects, and what the case needs beside them.",
    );
    let number = |value: f64| Cell::number(significant(value, 3), value);
    let names = |names: &[String]| {
        Cell::new(if names.is_empty() { NONE.to_owned() } else { names.join("; ") })
    };
    let row = |case: &MachineCase| {
        vec![
            Cell::new(case.name.clone()),
            Cell::new(case.kind.clone()),
            number(case.before),
            case.with_others.map_or_else(|| Cell::new(NONE), number),
            number(case.after),
            Cell::new(case.unit.clone()),
            Cell::new(change(case.before, case.after)),
            names(&case.named_alone),
            names(&case.beside),
            Cell::new(case.verdict.clone()),
        ]
    };
    table(
        out,
        "Root mean square, groups left out in turn",
        &[
            ("case", Kind::Name),
            ("kind", Kind::Name),
            ("before", Kind::Number),
            ("by the others", Kind::Number),
            ("after", Kind::Number),
            ("unit", Kind::Unit),
            ("change", Kind::Number),
            ("named by the case alone", Kind::Words),
            ("needed beside", Kind::Words),
            ("verdict", Kind::Words),
        ],
        cases.iter().map(row),
    );
    out.close("section");
}

/// An amplitude as every case has it: picture, and the numbers under it.
fn amplitude_by_case(out: &mut Markup, of: &MachineAmplitude) {
    out.element("h3", &[], &of.name);
    let all = ("all cases".to_owned(), of.all.0, of.all.1);
    let rows: Vec<(String, f64, f64)> = of.by_case.iter().chain([&all]).cloned().collect();
    let title = format!("{}, {}", of.name, of.unit);
    let alternative = format!("{title} as each case has it on its own, and as all have it");
    for (width, class) in WIDTHS {
        let forest = Forest { rows: &rows, title: &title, alternative: &alternative };
        out.append(&forest.draw(width, class));
    }
    let row = |(name, value, std): &(String, f64, f64)| {
        let (value, expanded) = with_expanded(*value, *std);
        vec![Cell::new(name.clone()), Cell::new(value), Cell::new(expanded), Cell::new(&*of.unit)]
    };
    table(
        out,
        "What each case says of it on its own (k\u{a0}=\u{a0}2)",
        &[("case", Kind::Name), ("value", Kind::Number), ("U", Kind::Number), ("unit", Kind::Unit)],
        rows.iter().map(row),
    );
    if let Some(p_value) = of.agreement_p_value {
        let chance = significant(p_value, 2);
        out.element(
            "p",
            &[],
            &format!(
                "Cases that measure the same differ by as much or more with a chance of {chance}."
            ),
        );
    }
}
