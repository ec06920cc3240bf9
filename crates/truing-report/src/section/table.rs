//! Tables.

use crate::markup::{Markup, Px};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Names, also those out of a user's file.
    Name,
    /// Numbers, aligned right.
    Number,
    /// Units and other short words that stay on one line.
    Unit,
    /// Sentences.
    Words,
}

/// One cell.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    text: String,
    sort: Option<f64>,
    /// Address of what the text names.
    link: Option<String>,
    /// Share of a first bar that a second one has; drawn below the text.
    share: Option<f64>,
}

impl Cell {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), sort: None, link: None, share: None }
    }

    /// A number as written, and as sorted by.
    pub(crate) fn number(text: impl Into<String>, sort: f64) -> Self {
        Self { sort: sort.is_finite().then_some(sort), ..Self::new(text) }
    }

    pub(crate) fn linked(text: impl Into<String>, link: String) -> Self {
        Self { link: Some(link), ..Self::new(text) }
    }

    /// Text above two bars, the second `share` times as long as the first; sorted by the share.
    pub(crate) fn bars(text: impl Into<String>, share: f64) -> Self {
        Self { share: share.is_finite().then_some(share), ..Self::number(text, share) }
    }
}

/// Names and values without a head.
pub(crate) fn facts(out: &mut Markup, facts: impl IntoIterator<Item = (String, String)>) {
    out.open("table", &[("class", &"facts")]);
    out.open("tbody", &[]);
    for (name, value) in facts {
        out.open("tr", &[]);
        write_cell(out, &Cell::new(name), Kind::Name, true);
        write_cell(out, &Cell::new(value), Kind::Words, false);
        out.close("tr");
    }
    out.close("tbody");
    out.close("table");
}

/// A table that scrolls sideways where the page is too narrow for it.
pub(crate) fn table(
    out: &mut Markup,
    caption: &str,
    columns: &[(&str, Kind)],
    rows: impl IntoIterator<Item = Vec<Cell>>,
) {
    out.open(
        "div",
        &[("class", &"scroll"), ("tabindex", &"0"), ("role", &"region"), ("aria-label", &caption)],
    );
    out.open("table", &[("class", &"sortable")]);
    out.element("caption", &[], caption);
    out.open("thead", &[]);
    out.open("tr", &[]);
    for (title, kind) in columns {
        out.element("th", &[("scope", &"col"), ("class", &class(*kind))], title);
    }
    out.close("tr");
    out.close("thead");
    out.open("tbody", &[]);
    for cells in rows {
        out.open("tr", &[]);
        for (i, (cell, (_, kind))) in cells.iter().zip(columns).enumerate() {
            write_cell(out, cell, *kind, i == 0);
        }
        out.close("tr");
    }
    out.close("tbody");
    out.close("table");
    out.close("div");
}

fn write_cell(out: &mut Markup, cell: &Cell, kind: Kind, heads: bool) {
    let tag = if heads { "th" } else { "td" };
    let class = class(kind);
    let sort = cell.sort.map(|v| format!("{v:e}"));
    let mut attributes: Vec<(&str, &dyn std::fmt::Display)> = vec![("class", &class)];
    if heads {
        attributes.push(("scope", &"row"));
    }
    if let Some(sort) = &sort {
        attributes.push(("data-sort", sort));
    }
    out.open(tag, &attributes);
    match &cell.link {
        Some(link) => out.element("a", &[("href", link)], &cell.text),
        None if kind == Kind::Name => out.named_prose(&cell.text),
        None => out.prose(&cell.text),
    }
    if let Some(share) = cell.share {
        bars(out, share);
    }
    out.close(tag);
}

/// Length of the longer bar and height of each, in SVG units.
const BAR: (f64, f64) = (120.0, 6.0);

/// Two bars, one below the other; whoever cannot see them reads the numbers above.
fn bars(out: &mut Markup, share: f64) {
    let (longest, height) = BAR;
    let longer = share.max(1.0);
    let view = format!("0 0 {longest} {}", Px(2.5 * height));
    out.open("svg", &[("class", &"bars"), ("viewBox", &view), ("aria-hidden", &"true")]);
    for (row, (length, class)) in [(1.0, "was"), (share, "is")].into_iter().enumerate() {
        let y = if row == 0 { 0.0 } else { 1.5 * height };
        out.leaf(
            "rect",
            &[
                ("class", &class),
                ("x", &Px(0.0)),
                ("y", &Px(y)),
                // A bar that is not seen would look like one that was forgotten.
                ("width", &Px((longest * length / longer).max(1.0))),
                ("height", &Px(height)),
            ],
        );
    }
    out.close("svg");
}

fn class(kind: Kind) -> &'static str {
    match kind {
        Kind::Name => "name",
        Kind::Number => "num",
        Kind::Unit => "unit",
        Kind::Words => "words",
    }
}
