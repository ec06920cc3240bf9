//! The page around the sections.

use std::fmt::Write;

use super::input::{ReportInput, Story};
use super::markup::{Markup, is_forbidden, turns_direction};
use super::section::{
    Context, added, apart, budget, declared, error_path, form, headline, lede, left, measured,
    observable, residual_after, residual_before, scores, views, warnings,
};
use super::slug::slug;
use super::summary::Summary;

const STYLE: &str = include_str!("style.css");
const SORT: &str = include_str!("sort.js");
const ZOOM: &str = include_str!("zoom.js");
const FILTER: &str = include_str!("filter.js");

/// What a page may load: nothing but what it holds.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Marks around the part of a page that an index repeats.
///
/// Comments cannot come from a user's text, where every `<` is escaped.
pub(crate) const CASE_MARKS: (&str, &str) = ("<!--truing:case-->", "<!--/truing:case-->");
/// Marks around the summary of a page.
pub(crate) const SUMMARY_MARKS: (&str, &str) =
    ("<script type=\"application/json\" class=\"truing-summary\">", "</script>");

/// Renders a case as one self-contained HTML page.
///
/// The page needs no network and no JavaScript, is escaped throughout, and is also well-formed
/// XML. Values that are not finite appear as «–» and are left out of plots; plots of more
/// readings than can be told apart are thinned and say so, so that a page stays below 2 MB.
#[must_use]
pub fn render(input: &ReportInput) -> String {
    let context = Context::new(input);
    let mut body = Markup::new();
    body.constant(CASE_MARKS.0);
    body.open("article", &[("class", &"case")]);
    header(&mut body, &context);
    let sections = SECTIONS.map(|(write, place)| {
        let mut content = Markup::new();
        write(&mut content, &context);
        Section { content: content.into_string(), place }
    });
    let sections: Vec<Section> =
        sections.into_iter().filter(|section| !section.content.is_empty()).collect();
    contents(&mut body, &sections);
    for section in &sections {
        section.write(&mut body);
    }
    body.close("article");
    body.constant(CASE_MARKS.1);
    body.constant("\n");
    body.constant(SUMMARY_MARKS.0);
    body.own_output(&summary_json(&Summary::of(&context)));
    body.constant(SUMMARY_MARKS.1);
    document(input.title, "page", &body)
}

/// Where a section stands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// In sight.
    Open,
    /// Folded under its heading, unfolded on paper.
    Folded,
}

/// Writes one section of a page.
type WriteSection = fn(&mut Markup, &Context);

/// In reading order: the answer, its pictures, what is left open; then what it rests on.
const SECTIONS: [(WriteSection, Place); 15] = [
    (headline, Place::Open),
    (views, Place::Open),
    (form, Place::Open),
    (added, Place::Open),
    (left, Place::Open),
    (warnings, Place::Open),
    (apart, Place::Open),
    (residual_before, Place::Open),
    (residual_after, Place::Open),
    (measured, Place::Folded),
    (declared, Place::Folded),
    (budget, Place::Folded),
    (scores, Place::Folded),
    (error_path, Place::Folded),
    (observable, Place::Folded),
];

/// A section as written: its heading, and what stands under it.
struct Section {
    content: String,
    place: Place,
}

impl Section {
    /// The heading with its tags, and the rest.
    fn parts(&self) -> (&str, &str) {
        let end = self.content.find(HEADING.1).map_or(0, |at| at + HEADING.1.len());
        self.content.split_at(end)
    }

    fn heading(&self) -> &str {
        let (heading, _) = self.parts();
        heading.trim_start_matches(HEADING.0).trim_end_matches(HEADING.1)
    }

    /// Address of the section within the page.
    fn anchor(&self) -> String {
        slug(self.heading())
    }

    fn write(&self, out: &mut Markup) {
        let (heading, rest) = self.parts();
        let anchor = self.anchor();
        if self.place == Place::Open {
            out.open("section", &[("id", &anchor)]);
            out.own_output(&self.content);
        } else {
            out.open("section", &[]);
            out.open("details", &[]);
            out.open("summary", &[]);
            out.own_output(heading);
            out.close("summary");
            // Within, so that whoever follows a link to it finds it unfolded.
            out.open("div", &[("id", &anchor)]);
            out.own_output(rest);
            out.close("div");
            out.close("details");
        }
        out.close("section");
    }
}

/// Tags of a section's heading.
const HEADING: (&str, &str) = ("<h2>", "</h2>");

/// Links to every section, folded: they would fill the first screen.
fn contents(out: &mut Markup, sections: &[Section]) {
    out.open("nav", &[("aria-label", &"Contents")]);
    out.open("details", &[]);
    out.element("summary", &[], "Contents");
    for section in sections {
        out.open("a", &[("href", &format!("#{}", section.anchor()))]);
        out.own_output(section.heading());
        out.close("a");
    }
    out.close("details");
    out.close("nav");
}

fn header(out: &mut Markup, context: &Context) {
    out.open("header", &[]);
    out.element("p", &[("class", &"kind")], context.input.kind);
    out.open("h1", &[]);
    out.name(context.input.title);
    out.close("h1");
    lede(out, context);
    if let Some(story) = context.input.story {
        told(out, story);
    }
    out.close("header");
}

/// What the owner of the data asks, and knows from elsewhere.
fn told(out: &mut Markup, story: &Story) {
    out.open("div", &[("class", &"story")]);
    let lines = [
        ("Question", &story.question),
        ("Independent calculation", &story.independent),
        ("What stays open", &story.open),
    ];
    for (name, text) in lines {
        if let Some(text) = text {
            out.open("p", &[]);
            out.element("strong", &[], name);
            out.text(": ");
            out.named_prose(text);
            out.close("p");
        }
    }
    out.close("div");
}

/// JSON that can stand inside a script element of a well-formed document: what markup gives a
/// meaning, what XML forbids and what turns the direction of text is written as `\u…`.
fn summary_json(summary: &Summary) -> String {
    let json = serde_json::to_string(summary).expect("plain strings and finite numbers");
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        if matches!(c, '&' | '<' | '>') || is_forbidden(c) || turns_direction(c) {
            // Every such character lies in the basic plane: one code unit.
            write!(safe, "\\u{:04x}", u32::from(c)).expect("a String takes any text");
        } else {
            safe.push(c);
        }
    }
    safe
}

/// Class of a page over many cases.
pub(crate) const INDEX: &str = "index";

/// Wraps a body into a document with its style.
pub(crate) fn document(title: &str, class: &str, body: &Markup) -> String {
    let mut page = Markup::new();
    page.constant("<!DOCTYPE html>\n");
    page.open("html", &[("lang", &"en")]);
    page.open("head", &[]);
    page.leaf("meta", &[("charset", &"utf-8")]);
    page.leaf("meta", &[("http-equiv", &"Content-Security-Policy"), ("content", &POLICY)]);
    let viewport = "width=device-width, initial-scale=1";
    page.leaf("meta", &[("name", &"viewport"), ("content", &viewport)]);
    page.leaf("meta", &[("name", &"color-scheme"), ("content", &"light dark")]);
    page.leaf("meta", &[("name", &"generator"), ("content", &GENERATOR)]);
    page.element("title", &[], title);
    page.open("style", &[]);
    page.constant(STYLE);
    page.close("style");
    page.close("head");
    page.open("body", &[]);
    page.open("main", &[("class", &class)]);
    page.append(body);
    page.close("main");
    page.open("footer", &[]);
    let note = format!("{GENERATOR}. Every ± is an expanded uncertainty, k\u{a0}=\u{a0}2.");
    page.element("p", &[], &note);
    page.close("footer");
    page.open("script", &[]);
    page.constant(SORT);
    if class == INDEX {
        page.constant(FILTER);
    } else {
        page.constant(ZOOM);
    }
    page.close("script");
    page.close("body");
    page.close("html");
    page.constant("\n");
    page.into_string()
}

const GENERATOR: &str = concat!("Truing ", env!("CARGO_PKG_VERSION"));
