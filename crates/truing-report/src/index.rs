//! Many cases on one page: measured data first, simulated cases folded by kind, each line a link.

use std::collections::BTreeMap;

use super::error_rms::Rms;
use super::markup::Markup;
use super::number::{NONE, significant, with_expanded};
use super::page::{CASE_MARKS, INDEX, SUMMARY_MARKS, document};
use super::section::{Cell, Kind, change, table};
use super::summary::Summary;
use super::unit::Shown;

/// One case of an index: its line in a table.
#[derive(Clone, Debug)]
pub struct IndexEntry {
    /// The line.
    pub summary: Summary,
    /// Address of the case's own page, relative to the index.
    pub link: String,
    /// What is not as recorded beside the case; `None` where nothing was compared.
    pub findings: Option<Vec<String>>,
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
    /// Reads the summary out of a page that [`render`](super::render) wrote and that the index
    /// will find at `link`.
    ///
    /// # Errors
    ///
    /// [`ReadPageError`] where the text is not such a page.
    pub fn from_page(page: &str, link: impl Into<String>) -> Result<Self, ReadPageError> {
        between(page, CASE_MARKS).ok_or(ReadPageError::NotAReport)?;
        let json = between(page, SUMMARY_MARKS).ok_or(ReadPageError::NotAReport)?;
        let summary = serde_json::from_str(json).map_err(ReadPageError::Summary)?;
        Ok(Self { summary, link: link.into(), findings: None })
    }
}

fn between<'a>(text: &'a str, (start, end): (&str, &str)) -> Option<&'a str> {
    let (_, rest) = text.split_once(start)?;
    rest.split_once(end).map(|(inside, _)| inside)
}

/// Renders one page over many cases.
///
/// Cases whose provenance asks a question come first, a row each; then other cases that were not
/// simulated; then simulated ones, folded by kind. Where findings are given, the page closes with
/// the count of cases that are as recorded.
#[must_use]
pub fn render_index(title: &str, introduction: &str, entries: &[IndexEntry]) -> String {
    let mut body = Markup::new();
    body.open("header", &[]);
    body.element("h1", &[], title);
    if !introduction.is_empty() {
        body.element("p", &[("class", &"lede")], introduction);
    }
    count(&mut body, entries);
    body.close("header");
    if entries.is_empty() {
        body.element("p", &[("class", &"quiet")], "No case.");
    }
    let asked: Vec<&IndexEntry> = entries.iter().filter(|e| e.summary.story.is_some()).collect();
    if !asked.is_empty() {
        body.element("h2", &[], "Measured data");
        stories(&mut body, &asked);
    }
    let of = |simulated: bool| {
        move |e: &&IndexEntry| e.summary.story.is_none() && e.summary.simulated == simulated
    };
    let others: Vec<&IndexEntry> = entries.iter().filter(of(false)).collect();
    if !others.is_empty() {
        let title = if asked.is_empty() { "Cases" } else { "Other cases" };
        body.element("h2", &[], title);
        overview(&mut body, &others);
    }
    let mut kinds: BTreeMap<&str, Vec<&IndexEntry>> = BTreeMap::new();
    for entry in entries.iter().filter(of(true)) {
        kinds.entry(&entry.summary.kind).or_default().push(entry);
    }
    if !kinds.is_empty() {
        body.element("h2", &[], "Simulated cases, by kind");
    }
    for (kind, entries) in kinds {
        folded(&mut body, kind, &entries);
    }
    count(&mut body, entries);
    document(title, INDEX, &body)
}

/// «89 of 89 cases as recorded», where that was asked.
fn count(out: &mut Markup, entries: &[IndexEntry]) {
    let judged: Vec<_> = entries.iter().filter_map(|e| e.findings.as_ref()).collect();
    if judged.is_empty() {
        return;
    }
    let as_recorded = judged.iter().filter(|findings| findings.is_empty()).count();
    let class = if as_recorded == judged.len() { "verdict good" } else { "verdict open" };
    out.open("p", &[("class", &"count")]);
    let text = format!("{as_recorded} of {} as recorded", judged.len());
    out.element("span", &[("class", &class)], &text);
    out.close("p");
}

/// One row a set: picture, question, error, what else is known of it.
fn stories(out: &mut Markup, entries: &[&IndexEntry]) {
    table(
        out,
        "Error on data the fit never saw, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
        &[
            ("data", Kind::Name),
            ("question", Kind::Words),
            ("error before → after", Kind::Words),
            ("independent calculation", Kind::Words),
            ("named", Kind::Words),
            ("verdict", Kind::Words),
            ("what stays open", Kind::Words),
        ],
        entries.iter().map(|entry| story(entry)),
    );
}

fn story(entry: &IndexEntry) -> Vec<Cell> {
    let summary = &entry.summary;
    let story = summary.story.clone().unwrap_or_default();
    let text = |value: Option<String>| Cell::new(value.unwrap_or_else(|| NONE.to_owned()));
    vec![
        Cell::linked(&summary.title, entry.link.clone()),
        text(story.question),
        Cell::bars(before_after(summary), shrinking(summary)),
        text(story.independent),
        Cell::new(added(summary)),
        Cell::new(verdict(entry)),
        text(story.open),
    ]
}

/// The verdict, and what is not as recorded.
fn verdict(entry: &IndexEntry) -> String {
    let verdict = entry.summary.verdict.clone().unwrap_or_else(|| NONE.to_owned());
    match entry.findings.as_deref() {
        None | Some([]) => verdict,
        Some(findings) => format!("{verdict}. NOT AS RECORDED: {}", findings.join("; ")),
    }
}

fn before_after(summary: &Summary) -> String {
    let shown = Shown::for_size(&summary.unit, smallest(summary));
    let of = |rms| error(&shown, rms).0;
    let after = summary.after.as_ref();
    format!("{} → {} {}", of(Some(&summary.before)), of(after), shown.unit)
}

/// The smaller of both errors: the unit must suit it.
fn smallest(summary: &Summary) -> f64 {
    let after = summary.after.as_ref().and_then(best);
    let before = best(&summary.before).unwrap_or(0.0);
    before.min(after.unwrap_or(f64::INFINITY))
}

/// What share of the error is left.
fn shrinking(summary: &Summary) -> f64 {
    let after = summary.after.as_ref().and_then(best);
    after.zip(best(&summary.before)).map_or(f64::NAN, |(after, before)| after / before)
}

fn overview(out: &mut Markup, entries: &[&IndexEntry]) {
    table(
        out,
        "Error on data the fit never saw, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
        &[
            ("case", Kind::Name),
            ("before", Kind::Number),
            ("after", Kind::Number),
            ("unit", Kind::Unit),
            ("change", Kind::Number),
            ("added", Kind::Words),
            ("verdict", Kind::Words),
            ("source", Kind::Words),
        ],
        entries.iter().map(|entry| line(entry)),
    );
}

fn line(entry: &IndexEntry) -> Vec<Cell> {
    let summary = &entry.summary;
    let typical = best(&summary.before).unwrap_or(0.0);
    let shown = Shown::for_size(&summary.unit, typical);
    let after = summary.after.as_ref();
    let changed = match (summary.before.held_out, after.and_then(|a| a.held_out)) {
        (Some(before), Some(after)) if !summary.added.is_empty() => {
            Cell::number(change(before, after), after / before - 1.0)
        }
        _ => Cell::new(NONE),
    };
    let number = |rms| match error(&shown, rms) {
        (text, Some(sort)) => Cell::number(text, sort),
        (text, None) => Cell::new(text),
    };
    vec![
        Cell::linked(&summary.title, entry.link.clone()),
        number(Some(&summary.before)),
        number(after),
        Cell::new(&shown.unit),
        changed,
        Cell::new(added(summary)),
        Cell::new(verdict(entry)),
        Cell::new(source(summary)),
    ]
}

fn source(summary: &Summary) -> String {
    let source = summary.source.as_deref().unwrap_or(NONE);
    match &summary.published {
        Some(published) => format!("{source}, which prints {}", published.text),
        None => source.to_owned(),
    }
}

fn best(rms: &Rms) -> Option<f64> {
    rms.held_out.or(rms.train)
}

/// An error as written, and as sorted by.
fn error(shown: &Shown, rms: Option<&Rms>) -> (String, Option<f64>) {
    let Some((rms, value)) = rms.and_then(|r| Some((r, best(r)?))) else {
        return (NONE.to_owned(), None);
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
    (text, Some(sort))
}

fn added(summary: &Summary) -> String {
    let class = |names: &Vec<String>| names.join(" or ");
    match summary.added.len() {
        0 if summary.after.is_none() => NONE.to_string(),
        0 => "nothing".to_string(),
        _ => summary.added.iter().map(class).collect::<Vec<_>>().join("; "),
    }
}

/// A table that opens on demand, and by itself where a case in it is not as recorded.
fn folded(out: &mut Markup, kind: &str, entries: &[&IndexEntry]) {
    let judged: Vec<_> = entries.iter().filter_map(|e| e.findings.as_ref()).collect();
    let as_recorded = judged.iter().filter(|findings| findings.is_empty()).count();
    if as_recorded == judged.len() {
        out.open("details", &[("class", &"folded")]);
    } else {
        out.open("details", &[("class", &"folded"), ("open", &"open")]);
    }
    out.open("summary", &[]);
    out.name(kind);
    let counted = match judged.len() {
        0 => format!(": {} cases", entries.len()),
        all => format!(": {} cases, {as_recorded} of {all} as recorded", entries.len()),
    };
    out.text(&counted);
    out.close("summary");
    overview(out, entries);
    out.close("details");
}
