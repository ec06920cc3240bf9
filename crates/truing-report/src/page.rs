//! The page around the sections.

use std::fmt::Write;

use super::input::{ReportInput, Story};
use super::markup::{Markup, is_forbidden, turns_direction};
use super::section::{
    Context, added, apart, declared, error_path, headline, lede, left, measured, observable,
    residual_after, residual_before, scores, views, warnings,
};
use super::summary::Summary;

const STYLE: &str = include_str!("style.css");
const SORT: &str = include_str!("sort.js");
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
    for section in SECTIONS {
        let mut content = Markup::new();
        section(&mut content, &context);
        if !content.as_str().is_empty() {
            body.open("section", &[]);
            body.append(&content);
            body.close("section");
        }
    }
    body.close("article");
    body.constant(CASE_MARKS.1);
    body.constant("\n");
    body.constant(SUMMARY_MARKS.0);
    body.own_output(&summary_json(&Summary::of(&context)));
    body.constant(SUMMARY_MARKS.1);
    document(input.title, "page", &body)
}

/// In reading order.
const SECTIONS: [fn(&mut Markup, &Context); 13] = [
    measured,
    declared,
    headline,
    residual_before,
    scores,
    added,
    residual_after,
    error_path,
    views,
    apart,
    observable,
    left,
    warnings,
];

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
    }
    page.close("script");
    page.close("body");
    page.close("html");
    page.constant("\n");
    page.into_string()
}

const GENERATOR: &str = concat!("Truing ", env!("CARGO_PKG_VERSION"));
