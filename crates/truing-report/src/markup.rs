//! Writes HTML and SVG; whatever is not a tag name or a constant is escaped here.

use std::fmt::{Display, Write};

/// Attributes of one element.
pub(crate) type Attributes<'a> = &'a [(&'a str, &'a dyn Display)];

/// Markup under construction; also valid as XML.
#[derive(Clone, Debug, Default)]
pub(crate) struct Markup {
    out: String,
}

impl Markup {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn open(&mut self, tag: &'static str, attributes: Attributes) {
        self.start(tag, attributes);
        self.out.push('>');
    }

    pub(crate) fn close(&mut self, tag: &'static str) {
        self.out.push_str("</");
        self.out.push_str(tag);
        self.out.push('>');
        if BLOCKS.contains(&tag) {
            self.out.push('\n');
        }
    }

    /// An element without content.
    pub(crate) fn leaf(&mut self, tag: &'static str, attributes: Attributes) {
        self.start(tag, attributes);
        self.out.push_str("/>");
    }

    /// An element that holds only text.
    pub(crate) fn element(&mut self, tag: &'static str, attributes: Attributes, text: &str) {
        self.open(tag, attributes);
        self.text(text);
        self.close(tag);
    }

    pub(crate) fn text(&mut self, text: &str) {
        escape(text, &mut self.out);
    }

    /// A name out of a user's file: kept from changing the direction of what surrounds it.
    pub(crate) fn name(&mut self, text: &str) {
        self.element("bdi", &[], text);
    }

    /// Sentences in which a pair of backticks encloses code.
    pub(crate) fn prose(&mut self, text: &str) {
        let mut rest = text;
        while let Some((before, code, after)) = split_code(rest) {
            self.text(before);
            self.element("code", &[], code);
            rest = after;
        }
        self.text(rest);
    }

    /// Prose that may be, or hold, a name out of a user's file.
    pub(crate) fn named_prose(&mut self, text: &str) {
        self.open("bdi", &[]);
        self.prose(text);
        self.close("bdi");
    }

    pub(crate) fn append(&mut self, other: &Self) {
        self.out.push_str(&other.out);
    }

    /// A constant of this crate, as it stands.
    pub(crate) fn constant(&mut self, markup: &'static str) {
        self.out.push_str(markup);
    }

    /// Markup that an earlier run of this crate wrote, as it stands.
    pub(crate) fn own_output(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    pub(crate) fn into_string(self) -> String {
        self.out
    }

    fn start(&mut self, tag: &'static str, attributes: Attributes) {
        self.out.push('<');
        self.out.push_str(tag);
        for (name, value) in attributes {
            self.out.push(' ');
            self.out.push_str(name);
            self.out.push_str("=\"");
            escape(&value.to_string(), &mut self.out);
            self.out.push('"');
        }
    }
}

/// What stands before, within and after the first pair of backticks.
fn split_code(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once('`')?;
    let (code, after) = rest.split_once('`')?;
    Some((before, code, after))
}

/// Elements after which a new line keeps the page readable as text.
const BLOCKS: &[&str] = &["p", "h1", "h2", "h3", "tr", "table", "figure", "section", "div", "svg"];

/// Escapes text for content and for quoted attributes.
///
/// Characters that XML forbids become U+FFFD, and so do those that turn the direction of text
/// until they are undone: a name must not reorder the sentence around it.
fn escape(text: &str, out: &mut String) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            _ if is_forbidden(c) || turns_direction(c) => out.push('\u{fffd}'),
            _ => out.push(c),
        }
    }
}

/// Control characters, and what is no character.
pub(crate) fn is_forbidden(c: char) -> bool {
    c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')
}

/// Explicit embeddings, overrides and isolates of the bidirectional algorithm.
pub(crate) fn turns_direction(c: char) -> bool {
    matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A length in SVG units, written with one decimal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Px(pub(crate) f64);

impl Display for Px {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tenths = (self.0 * 10.0).round();
        // Positions come from finite data; a value that overflowed lands on the edge.
        let tenths = if tenths.is_finite() { tenths + 0.0 } else { 0.0 };
        if tenths % 10.0 == 0.0 {
            write!(f, "{:.0}", tenths / 10.0 + 0.0)
        } else {
            write!(f, "{:.1}", tenths / 10.0)
        }
    }
}

/// Path data under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    out: String,
}

impl Path {
    pub(crate) fn move_to(&mut self, x: f64, y: f64) {
        self.push('M', x, y);
    }

    pub(crate) fn line_to(&mut self, x: f64, y: f64) {
        self.push('L', x, y);
    }

    /// Path commands that do not depend on the data.
    pub(crate) fn constant(&mut self, commands: &'static str) {
        self.out.push_str(commands);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.out.is_empty()
    }

    fn push(&mut self, command: char, x: f64, y: f64) {
        write!(self.out, "{command}{} {}", Px(x), Px(y)).expect("a String takes any text");
    }
}

impl Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.out)
    }
}

/// Cuts a label to what a width in SVG units can hold.
///
/// The middle goes: what tells `bad-point [P17]` from `bad-point [P18]` stands at the end.
pub(crate) fn shorten(text: &str, width: f64, font_size: f64) -> String {
    /// Share of the room that the beginning gets.
    const HEAD: f64 = 0.6;
    let limit = width / font_size;
    if em_width(text) <= limit {
        return text.to_string();
    }
    let room = limit - em_width("…");
    let head = fitting(text.chars(), HEAD * room);
    let tail = fitting(text.chars().rev(), (1.0 - HEAD) * room);
    head.into_iter().chain(['…']).chain(tail.into_iter().rev()).collect()
}

/// The first characters that fit.
fn fitting(characters: impl Iterator<Item = char>, room: f64) -> Vec<char> {
    let mut used = 0.0;
    let fits = |c: &char| {
        used += em(*c);
        used <= room
    };
    characters.take_while(fits).collect()
}

/// Width of text in SVG units, on the wide side.
pub(crate) fn text_width(text: &str, font_size: f64) -> f64 {
    em_width(text) * font_size
}

fn em_width(text: &str) -> f64 {
    text.chars().map(em).sum()
}

/// Advance of one character in em for a sans-serif face, on the wide side.
fn em(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '|' | '\'' | ' ' | '\u{2009}' | '\u{202f}' => {
            0.34
        }
        'm' | 'w' | 'M' | 'W' | '−' | '×' | '±' => 0.9,
        // Combining marks and the like are rare enough to count in full.
        '\u{2e80}'.. => 1.05,
        'A'..='Z' => 0.72,
        _ => 0.61,
    }
}
