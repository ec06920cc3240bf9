//! Many cases on one page, behind a table of error before → after.

use super::input::Published;
use super::markup::Markup;
use super::number::{NONE, significant, with_expanded};
use super::page::{CASE_MARKS, SUMMARY_MARKS, document};
use super::section::{Cell, Kind, change, table};
use super::summary::{Rms, Summary};
use super::unit::Shown;

/// One case of an index: its line in the table, and its page's content.
#[derive(Clone, Debug)]
pub struct IndexEntry {
    /// The line.
    pub summary: Summary,
    content: String,
}

/// Why a file cannot be part of an index.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadPageError {
    /// It does not hold the marks that a rendered page has.
    #[error("not a report page: write one with `truing loop CASE --report FILE.html`")]
    NotAReport,
    /// Its summary is not what this version writes.
    #[error("the page's summary cannot be read: write the page again with this version")]
    Summary(#[source] serde_json::Error),
}

impl IndexEntry {
    /// Reads back a page that [`render`](super::render) wrote.
    ///
    /// The content is repeated as it stands: give it pages of your own making only.
    ///
    /// # Errors
    ///
    /// [`ReadPageError`] where the text is not such a page.
    pub fn from_page(page: &str) -> Result<Self, ReadPageError> {
        let content = between(page, CASE_MARKS).ok_or(ReadPageError::NotAReport)?;
        let json = between(page, SUMMARY_MARKS).ok_or(ReadPageError::NotAReport)?;
        let summary = serde_json::from_str(json).map_err(ReadPageError::Summary)?;
        Ok(Self { summary, content: content.to_string() })
    }
}

fn between<'a>(text: &'a str, (start, end): (&str, &str)) -> Option<&'a str> {
    let (_, rest) = text.split_once(start)?;
    rest.split_once(end).map(|(inside, _)| inside)
}

/// Renders one page over many cases: a table, then each case's page folded up below it.
#[must_use]
pub fn render_index(title: &str, introduction: &str, entries: &[IndexEntry]) -> String {
    let mut body = Markup::new();
    body.open("header", &[]);
    body.element("h1", &[], title);
    if !introduction.is_empty() {
        body.element("p", &[("class", &"lede")], introduction);
    }
    body.close("header");
    if entries.is_empty() {
        body.element("p", &[("class", &"quiet")], "No case.");
    } else {
        overview(&mut body, entries);
    }
    for (i, entry) in entries.iter().enumerate() {
        folded(&mut body, i, entry);
    }
    document(title, "index", &body)
}

fn overview(out: &mut Markup, entries: &[IndexEntry]) {
    table(
        out,
        "Error before → after on data the fit never saw, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
        &[
            ("case", Kind::Name),
            ("before", Kind::Number),
            ("after", Kind::Number),
            ("unit", Kind::Unit),
            ("change", Kind::Number),
            ("published", Kind::Words),
            ("verdict", Kind::Words),
            ("added", Kind::Words),
            ("unseen", Kind::Words),
            ("kind", Kind::Unit),
            ("source", Kind::Words),
        ],
        entries.iter().enumerate().map(|(i, entry)| line(i, &entry.summary)),
    );
}

fn line(index: usize, summary: &Summary) -> Vec<Cell> {
    let typical = best(&summary.before).unwrap_or(0.0);
    let shown = Shown::for_size(&summary.unit, typical);
    let after = summary.after.as_ref();
    let text = |value: &Option<String>| Cell::new(value.as_deref().unwrap_or(NONE));
    let changed = match (summary.before.held_out, after.and_then(|a| a.held_out)) {
        (Some(before), Some(after)) if !summary.added.is_empty() => {
            Cell::number(change(before, after), after / before - 1.0)
        }
        _ => Cell::new(NONE),
    };
    vec![
        Cell::linked(&summary.title, format!("#case-{}", index + 1)),
        error(&shown, Some(&summary.before)),
        error(&shown, after),
        Cell::new(&shown.unit),
        changed,
        Cell::new(summary.published.as_ref().map_or(NONE.to_string(), published)),
        text(&summary.verdict),
        Cell::new(added(summary)),
        text(&summary.hold_out),
        Cell::new(&summary.kind),
        text(&summary.source),
    ]
}

fn best(rms: &Rms) -> Option<f64> {
    rms.held_out.or(rms.train)
}

fn error(shown: &Shown, rms: Option<&Rms>) -> Cell {
    let Some((rms, value)) = rms.and_then(|r| Some((r, best(r)?))) else {
        return Cell::new(NONE);
    };
    let (sort, value) = (value, value * shown.factor);
    let text = match (rms.held_out, rms.held_out_std) {
        (Some(_), Some(std)) => {
            let (value, expanded) = with_expanded(value, std * shown.factor);
            if expanded == NONE { value } else { format!("{value} ± {expanded}") }
        }
        (Some(_), None) => significant(value, 3),
        (None, _) => format!("{} (fitted)", significant(value, 3)),
    };
    Cell::number(text, sort)
}

fn published(published: &Published) -> String {
    format!("{} ({})", published.text, published.source)
}

fn added(summary: &Summary) -> String {
    let class = |names: &Vec<String>| names.join(" or ");
    match summary.added.len() {
        0 if summary.after.is_none() => NONE.to_string(),
        0 => "nothing".to_string(),
        _ => summary.added.iter().map(class).collect::<Vec<_>>().join("; "),
    }
}

fn folded(out: &mut Markup, index: usize, entry: &IndexEntry) {
    out.open("details", &[("class", &"folded")]);
    out.open("summary", &[]);
    out.name(&entry.summary.title);
    out.close("summary");
    // Inside, so that following the link from the table opens it.
    out.open("div", &[("id", &format!("case-{}", index + 1))]);
    out.own_output(&entry.content);
    out.close("div");
    out.close("details");
}
