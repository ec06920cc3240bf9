//! What a machine is to be set to, as a page.

use super::fact::Fact;
use super::markup::Markup;
use super::number::{NONE, percent, significant};
use super::page::document;
use super::region::Region;
use super::section::{Cell, Kind, facts, table};

/// Everything that a design card shows.
#[derive(Clone, Debug)]
pub struct DesignCard<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// The answer in one sentence.
    pub lede: &'a str,
    /// Heading and lines of what is set and given.
    pub facts: (&'a str, &'a [Fact]),
    /// The picture.
    pub region: RegionFigure<'a>,
    /// The figures behind it.
    pub figures: FigureTable<'a>,
}

/// A region of stability with what is said about it.
#[derive(Clone, Debug)]
pub struct RegionFigure<'a> {
    /// Heading.
    pub heading: &'a str,
    /// What the picture shows and what its dashed line is.
    pub caption: &'a str,
    /// The picture.
    pub region: &'a Region,
    /// What comfortable, stable and unstable mean.
    pub legend: [&'a str; 3],
}

/// A table of figures.
#[derive(Clone, Debug)]
pub struct FigureTable<'a> {
    /// Heading.
    pub heading: &'a str,
    /// What the table holds.
    pub caption: &'a str,
    /// Titles of the columns with their units.
    pub columns: &'a [&'a str],
    /// One figure per column.
    pub rows: &'a [Vec<Figure>],
}

/// One cell of a table of figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Figure {
    /// A short word.
    Word(&'static str),
    /// A number in the unit of its column.
    Number(Option<f64>),
    /// A share of one, shown in percent.
    Share(Option<f64>),
}

/// Widths of the picture on a wide and on a narrow page; the style sheet shows one of the two.
const WIDTHS: [(f64, &str); 2] = [(900.0, "plot wide"), (352.0, "plot narrow")];

/// Renders a design card as one self-contained HTML page.
#[must_use]
pub fn render_design(card: &DesignCard) -> String {
    let mut body = Markup::new();
    body.open("header", &[]);
    body.element("h1", &[], card.title);
    body.element("p", &[("class", &"lede")], card.lede);
    body.close("header");
    body.open("section", &[]);
    let (heading, lines) = card.facts;
    body.element("h2", &[], heading);
    facts(&mut body, lines.iter().map(|fact| (fact.name.clone(), fact.value.clone())));
    body.close("section");
    body.open("section", &[]);
    body.element("h2", &[], card.region.heading);
    body.element("p", &[], card.region.caption);
    legend(&mut body, card.region.legend);
    for (width, class) in WIDTHS {
        body.append(&card.region.region.draw(width, class));
    }
    card.region.region.data().link(&mut body, card.region.heading);
    body.close("section");
    body.open("section", &[]);
    body.element("h2", &[], card.figures.heading);
    figures(&mut body, &card.figures);
    body.close("section");
    document(card.title, "page", &body)
}

fn legend(out: &mut Markup, [comfortable, stable, unstable]: [&str; 3]) {
    out.open("p", &[("class", &"legend")]);
    for (class, text) in [("comfortable", comfortable), ("stable", stable)] {
        out.open("span", &[]);
        let mut sign = super::svg::open_sign(22.0);
        super::svg::rectangle(&mut sign, &format!("region {class}"), (1.0, 2.0), (21.0, 12.0));
        sign.close("svg");
        out.append(&sign);
        out.text(" ");
        out.text(text);
        out.close("span");
    }
    out.element("span", &[], &format!("empty: {unstable}"));
    out.close("p");
}

fn figures(out: &mut Markup, of: &FigureTable) {
    let kind = |column: usize| match of.rows.first().and_then(|row| row.get(column)) {
        Some(Figure::Word(_)) => Kind::Unit,
        _ => Kind::Number,
    };
    let columns: Vec<(&str, Kind)> =
        of.columns.iter().enumerate().map(|(i, title)| (*title, kind(i))).collect();
    let cell = |figure: &Figure| match *figure {
        Figure::Word(word) => Cell::new(word),
        Figure::Number(Some(value)) => Cell::number(significant(value, 3), value),
        Figure::Share(Some(value)) => Cell::number(percent(value), value),
        Figure::Number(None) | Figure::Share(None) => Cell::new(NONE),
    };
    let rows = of.rows.iter().map(|row| row.iter().map(cell).collect());
    table(out, of.caption, &columns, rows);
}
