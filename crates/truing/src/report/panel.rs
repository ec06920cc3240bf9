//! One pair of axes and what is drawn in it.

use super::axis::{Range, Scale, Tick, drawable, ticks};
use super::markup::{Markup, Path, Px, shorten, text_width};

/// Height of the letters in a drawing, SVG units.
pub(crate) const FONT: f64 = 12.0;

/// Room for tick labels and title below the plot area.
const BELOW: f64 = 36.0;
/// Room for the vertical axis' title above the plot area.
const ABOVE: f64 = 22.0;
/// Room right of the plot area: half of the last tick label.
const RIGHT: f64 = 14.0;

/// A plot in its own SVG element.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Width and height of the drawing.
    pub(crate) size: (f64, f64),
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Drawn in this order.
    pub(crate) layers: Vec<Layer>,
    /// What the picture shows, for those who cannot see it.
    pub(crate) alternative: String,
}

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) range: Range,
    pub(crate) title: String,
    /// Names in place of numbers.
    pub(crate) names: Option<Vec<Tick>>,
    /// Whether ticks are labelled; false where the plot below has the same axis.
    pub(crate) labelled: bool,
    /// Whether zero is where the data should be.
    pub(crate) baseline: bool,
}

impl Axis {
    pub(crate) fn new(range: Range, title: impl Into<String>) -> Self {
        Self { range, title: title.into(), names: None, labelled: true, baseline: true }
    }
}

/// Something drawn between the axes; what lies outside them is clipped to their edge or left out.
#[derive(Clone, Debug)]
pub(crate) enum Layer {
    /// A stretch of x, as background.
    Stretch { from: f64, to: f64 },
    /// A stretch of y.
    Strip { from: f64, to: f64 },
    /// Lines from zero to each point.
    Stems { points: Vec<[f64; 2]>, colour: usize },
    /// Points joined by a line; a trend is drawn heavier than a curve.
    Line { points: Vec<[f64; 2]>, colour: usize, trend: bool },
    /// A band between two values at each x.
    Band { points: Vec<[f64; 3]>, colour: usize },
    /// One mark per point.
    Marks { points: Vec<[f64; 2]>, colour: usize, style: MarkStyle },
    /// Names that show when pointed at.
    Names { points: Vec<([f64; 2], String)> },
    /// Lines from place to place with a head at the end.
    Arrows { lines: Vec<[[f64; 2]; 2]>, colour: usize },
    /// A note that starts at a point.
    Note { at: [f64; 2], text: String },
}

/// Class of the n-th colour; marks of the n-th colour have the n-th shape.
pub(crate) const COLOURS: [&str; 6] = ["c0", "c1", "c2", "c3", "c4", "c5"];

pub(crate) fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}

/// Where a panel draws.
pub(crate) struct Area {
    pub(crate) x: Scale,
    pub(crate) y: Scale,
}

impl Panel {
    pub(crate) fn draw(&self, class: &str) -> Markup {
        let mut svg = open_svg(self.size, class, &self.alternative);
        let y_ticks = ticks(self.y.range, self.y_tick_count());
        let area = self.area(&y_ticks);
        for layer in &self.layers {
            if let Layer::Stretch { from, to } = layer {
                stretch(&mut svg, &area, *from, *to);
            }
        }
        draw_y_axis(&mut svg, &area, &self.y, &y_ticks);
        draw_x_axis(&mut svg, &area, &self.x, self.size.0);
        for layer in &self.layers {
            draw_layer(&mut svg, &area, layer);
        }
        svg.close("svg");
        svg
    }

    fn area(&self, y_ticks: &[Tick]) -> Area {
        let widest = y_ticks.iter().map(|t| text_width(&t.label, FONT)).fold(0.0, f64::max);
        let left = (widest + 10.0).min(0.4 * self.size.0);
        let below = if self.x.labelled { BELOW } else { 8.0 };
        let above = if self.y.title.is_empty() { 8.0 } else { ABOVE };
        Area {
            x: Scale { range: self.x.range, from_px: left, to_px: self.size.0 - RIGHT },
            y: Scale { range: self.y.range, from_px: self.size.1 - below, to_px: above },
        }
    }

    fn y_tick_count(&self) -> usize {
        if self.size.1 < 150.0 { 4 } else { 6 }
    }
}

/// Opens an SVG element that says what it shows.
pub(crate) fn open_svg(size: (f64, f64), class: &str, alternative: &str) -> Markup {
    let mut svg = Markup::new();
    let view = format!("0 0 {} {}", Px(size.0), Px(size.1));
    svg.open(
        "svg",
        &[
            ("class", &class),
            ("viewBox", &view),
            ("width", &Px(size.0)),
            ("height", &Px(size.1)),
            ("role", &"img"),
            ("aria-label", &alternative),
        ],
    );
    svg
}

fn stretch(svg: &mut Markup, area: &Area, from: f64, to: f64) {
    let (left, right) = (area.x.px(from), area.x.px(to));
    rectangle(svg, "stretch", (left, area.y.to_px), (right, area.y.from_px));
}

pub(crate) fn rectangle(svg: &mut Markup, class: &str, top_left: (f64, f64), end: (f64, f64)) {
    let (width, height) = (end.0 - top_left.0, end.1 - top_left.1);
    svg.leaf(
        "rect",
        &[
            ("class", &class),
            ("x", &Px(top_left.0)),
            ("y", &Px(top_left.1)),
            ("width", &Px(width.max(0.0))),
            ("height", &Px(height.max(0.0))),
        ],
    );
}

pub(crate) fn line(svg: &mut Markup, class: &str, from: (f64, f64), to: (f64, f64)) {
    svg.leaf(
        "line",
        &[
            ("class", &class),
            ("x1", &Px(from.0)),
            ("y1", &Px(from.1)),
            ("x2", &Px(to.0)),
            ("y2", &Px(to.1)),
        ],
    );
}

/// Text in a drawing; `class` says how it is anchored: `start`, `middle`, `end`.
pub(crate) fn label(svg: &mut Markup, class: &str, at: (f64, f64), text: &str) {
    svg.element("text", &[("class", &class), ("x", &Px(at.0)), ("y", &Px(at.1))], text);
}

fn draw_y_axis(svg: &mut Markup, area: &Area, axis: &Axis, ticks: &[Tick]) {
    let (title, baseline) = (&axis.title, axis.baseline);
    let (left, right) = (area.x.from_px, area.x.to_px);
    for tick in ticks {
        let y = area.y.px(tick.at);
        let class = if tick.at == 0.0 && baseline { "zero" } else { "grid" };
        line(svg, class, (left, y), (right, y));
        label(svg, "end", (left - 6.0, y + 4.0), &tick.label);
    }
    if !title.is_empty() {
        let fitting = shorten(title, right - 2.0, FONT);
        label(svg, "start title", (2.0, 13.0), &fitting);
    }
}

fn draw_x_axis(svg: &mut Markup, area: &Area, axis: &Axis, width: f64) {
    let (bottom, left, right) = (area.y.from_px, area.x.from_px, area.x.to_px);
    line(svg, "axis", (left, bottom), (right, bottom));
    let ticks = axis.names.clone().unwrap_or_else(|| fitting_ticks(axis.range, right - left));
    for tick in &ticks {
        let x = area.x.px(tick.at);
        line(svg, "axis", (x, bottom), (x, bottom + 4.0));
        if axis.labelled {
            // A label at either end stays inside the drawing.
            let half = 0.5 * text_width(&tick.label, FONT);
            let x = x.min(width - half - 1.0).max(half + 1.0);
            label(svg, "middle", (x, bottom + 16.0), &tick.label);
        }
    }
    if axis.labelled && !axis.title.is_empty() {
        let fitting = shorten(&axis.title, width - 4.0, FONT);
        let half = 0.5 * text_width(&fitting, FONT);
        let x = (0.5 * (left + right)).min(width - half - 2.0);
        label(svg, "middle title", (x.max(half + 2.0), bottom + 31.0), &fitting);
    }
}

/// As many ticks as their labels leave room for.
fn fitting_ticks(range: Range, width: f64) -> Vec<Tick> {
    let fits = |found: &[Tick]| {
        let needed: f64 = found.iter().map(|t| text_width(&t.label, FONT) + 14.0).sum();
        needed <= width
    };
    let candidates = (2..=9).rev().map(|most| ticks(range, most));
    let found = candidates.clone().find(|found| fits(found));
    found.unwrap_or_else(|| {
        // Labels of many digits: the two ends say enough.
        let mut fewest = ticks(range, 2);
        if fewest.len() > 2 {
            fewest.drain(1..fewest.len() - 1);
        }
        fewest
    })
}

fn draw_layer(svg: &mut Markup, area: &Area, layer: &Layer) {
    match layer {
        Layer::Stretch { .. } => {}
        Layer::Strip { from, to } => {
            let (top, bottom) = (area.y.px(from.max(*to)), area.y.px(from.min(*to)));
            rectangle(svg, "strip", (area.x.from_px, top), (area.x.to_px, bottom));
        }
        Layer::Stems { points, colour: index } => stems(svg, area, points, *index),
        Layer::Line { points, colour: index, trend } => {
            if *trend {
                polyline(svg, area, "halo", points);
            }
            let class = format!("{} {}", if *trend { "trend" } else { "curve" }, colour(*index));
            polyline(svg, area, &class, points);
        }
        Layer::Band { points, colour: index } => band(svg, area, points, *index),
        Layer::Marks { points, colour: index, style } => marks(svg, area, points, *index, *style),
        Layer::Names { points } => names(svg, area, points),
        Layer::Arrows { lines, colour: index } => arrows(svg, area, lines, *index),
        Layer::Note { at, text } => {
            label(svg, "start", (area.x.px(at[0]), area.y.px(at[1]) + 4.0), text);
        }
    }
}

fn visible(area: &Area, point: [f64; 2]) -> bool {
    drawable(point[1]) && area.x.range.contains(point[0])
}

fn stems(svg: &mut Markup, area: &Area, points: &[[f64; 2]], index: usize) {
    let mut path = Path::default();
    for point in points.iter().filter(|p| visible(area, **p)) {
        let x = area.x.px(point[0]);
        path.move_to(x, area.y.px(0.0));
        path.line_to(x, area.y.px(point[1]));
    }
    leaf_path(svg, &format!("stem {}", colour(index)), &path);
}

fn polyline(svg: &mut Markup, area: &Area, class: &str, points: &[[f64; 2]]) {
    let mut path = Path::default();
    let mut broken = true;
    for point in points {
        if !visible(area, *point) {
            broken = true;
            continue;
        }
        let (x, y) = (area.x.px(point[0]), area.y.px(point[1]));
        if broken {
            path.move_to(x, y)
        } else {
            path.line_to(x, y)
        }
        broken = false;
    }
    leaf_path(svg, class, &path);
}

fn band(svg: &mut Markup, area: &Area, points: &[[f64; 3]], index: usize) {
    let inside = |p: &&[f64; 3]| visible(area, [p[0], p[1]]) && drawable(p[2]);
    let mut path = Path::default();
    let there = points.iter().filter(inside).map(|p| (p[0], p[1]));
    let back = points.iter().rev().filter(inside).map(|p| (p[0], p[2]));
    for (x, y) in there.chain(back) {
        let (x, y) = (area.x.px(x), area.y.px(y));
        if path.is_empty() { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    leaf_path(svg, &format!("band {}", colour(index)), &path);
}

/// One path for all marks of a kind: a zero-length segment with a round or square cap is a dot
/// at a quarter of the bytes of a circle element.
fn marks(svg: &mut Markup, area: &Area, points: &[[f64; 2]], index: usize, style: MarkStyle) {
    let mut path = Path::default();
    let shape = SHAPES[index % SHAPES.len()];
    for point in points.iter().filter(|p| visible(area, **p)) {
        let (x, y) = (area.x.px(point[0]), area.y.px(point[1]));
        path.move_to(x, y);
        path.constant(shape.commands);
    }
    let size = if style.many { " many" } else { "" };
    let class = format!("{}{size} {}", shape.class, colour(index));
    if style.hollow && shape.class == "drawn" {
        leaf_path(svg, &format!("{class} outline"), &path);
        return;
    }
    leaf_path(svg, &class, &path);
    if style.hollow {
        leaf_path(svg, &format!("{}{size} hole", shape.class), &path);
    }
}

/// How marks look beside their colour.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MarkStyle {
    /// For data that was not fitted.
    pub(crate) hollow: bool,
    /// Smaller, where there are many.
    pub(crate) many: bool,
}

/// How marks of one colour look.
#[derive(Clone, Copy)]
struct Shape {
    class: &'static str,
    commands: &'static str,
}

const SHAPES: [Shape; 6] = [
    Shape { class: "dot", commands: "h0" },
    Shape { class: "square", commands: "h0" },
    Shape { class: "drawn", commands: "m-3.8 3h7.6l-3.8-6.8z" },
    Shape { class: "drawn", commands: "m0-4.4l4.4 4.4l-4.4 4.4l-4.4-4.4z" },
    Shape { class: "drawn", commands: "m-3.8-3h7.6l-3.8 6.8z" },
    Shape { class: "cross", commands: "m-3-3l6 6m-6 0l6-6" },
];

fn names(svg: &mut Markup, area: &Area, points: &[([f64; 2], String)]) {
    for (point, name) in points.iter().filter(|(p, _)| visible(area, *p)) {
        let (x, y) = (area.x.px(point[0]), area.y.px(point[1]));
        svg.open("circle", &[("class", &"hit"), ("cx", &Px(x)), ("cy", &Px(y)), ("r", &"7")]);
        svg.element("title", &[], name);
        svg.close("circle");
    }
}

/// Length of an arrow's head, SVG units; shorter arrows have a shorter one.
const HEAD: f64 = 6.0;

fn arrows(svg: &mut Markup, area: &Area, lines: &[[[f64; 2]; 2]], index: usize) {
    let mut path = Path::default();
    let mut feet = Path::default();
    for [from, to] in lines.iter().filter(|l| visible(area, l[0]) && visible(area, l[1])) {
        let foot = (area.x.px(from[0]), area.y.px(from[1]));
        let tip = (area.x.px(to[0]), area.y.px(to[1]));
        feet.move_to(foot.0, foot.1);
        feet.constant("h0");
        path.move_to(foot.0, foot.1);
        path.line_to(tip.0, tip.1);
        let (dx, dy) = (tip.0 - foot.0, tip.1 - foot.1);
        let length = dx.hypot(dy);
        if length < 1.0 {
            continue;
        }
        let head = HEAD.min(0.5 * length) / length;
        for side in [-0.45, 0.45] {
            path.move_to(tip.0, tip.1);
            path.line_to(tip.0 - head * (dx - side * dy), tip.1 - head * (dy + side * dx));
        }
    }
    leaf_path(svg, "foot", &feet);
    leaf_path(svg, &format!("arrow {}", colour(index)), &path);
}

fn leaf_path(svg: &mut Markup, class: &str, path: &Path) {
    if !path.is_empty() {
        svg.leaf("path", &[("class", &class), ("d", path)]);
    }
}

/// The mark of the n-th colour on its own, for a legend.
pub(crate) fn mark_sign(index: usize) -> Markup {
    let shape = SHAPES[index % SHAPES.len()];
    let mut path = Path::default();
    path.move_to(7.0, 7.0);
    path.constant(shape.commands);
    let mut svg = open_sign(14.0);
    leaf_path(&mut svg, &format!("{} {}", shape.class, colour(index)), &path);
    svg.close("svg");
    svg
}

/// Opens a small drawing that stands in a line of text and says nothing that the text does not.
pub(crate) fn open_sign(width: f64) -> Markup {
    let mut svg = Markup::new();
    svg.open(
        "svg",
        &[
            ("class", &"sign"),
            ("viewBox", &format!("0 0 {} 14", Px(width))),
            ("width", &Px(width)),
            ("height", &Px(14.0)),
            ("aria-hidden", &"true"),
        ],
    );
    svg
}
