//! Tables.

use crate::report::markup::Markup;

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
    /// Address within the page.
    link: Option<String>,
}

impl Cell {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), sort: None, link: None }
    }

    /// A number as written, and as sorted by.
    pub(crate) fn number(text: impl Into<String>, sort: f64) -> Self {
        Self { text: text.into(), sort: sort.is_finite().then_some(sort), link: None }
    }

    pub(crate) fn linked(text: impl Into<String>, link: String) -> Self {
        Self { text: text.into(), sort: None, link: Some(link) }
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
    out.close(tag);
}

fn class(kind: Kind) -> &'static str {
    match kind {
        Kind::Name => "name",
        Kind::Number => "num",
        Kind::Unit => "unit",
        Kind::Words => "words",
    }
}
