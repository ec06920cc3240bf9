//! What a panel draws between its axes.

use super::axis::{Scale, drawable};
use super::input::Facet;
use super::markup::{Markup, Path, Px};
use super::svg::{colour, label, leaf_path, open_sign, rectangle, shaded_dot};

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
    /// Dots of a colour that is the deeper the more there is to show, from 0 to 1.
    Shaded { points: Vec<[f64; 2]>, colour: usize, depth: f64, size: f64 },
    /// Names that show when pointed at.
    Names { points: Vec<([f64; 2], String)> },
    /// Lines from place to place with a head at the end.
    Arrows { lines: Vec<[[f64; 2]; 2]>, colour: usize },
    /// A surface, piece by piece, one over the other.
    Facets { facets: Vec<Facet> },
    /// A note that starts at a point.
    Note { at: [f64; 2], text: String },
}

/// How marks look beside their colour.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MarkStyle {
    /// For data that was not fitted.
    pub(crate) hollow: bool,
    /// Smaller, where there are many.
    pub(crate) many: bool,
}

/// Where a panel draws.
pub(crate) struct Area {
    pub(crate) x: Scale,
    pub(crate) y: Scale,
}

pub(crate) fn draw_layer(svg: &mut Markup, area: &Area, layer: &Layer) {
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
        Layer::Shaded { points, colour, depth, size } => {
            let path = mark_path(area, points, "h0");
            shaded_dot(svg, &path, (*colour, *depth), *size);
        }
        Layer::Names { points } => names(svg, area, points),
        Layer::Arrows { lines, colour: index } => arrows(svg, area, lines, *index),
        Layer::Facets { facets } => draw_facets(svg, area, facets),
        Layer::Note { at, text } => {
            label(svg, "start", (area.x.px(at[0]), area.y.px(at[1]) + 4.0), text);
        }
    }
}

/// Opacity of a facet in full light, and how much more one has in full shade.
const FACET_OPACITY: [f64; 2] = [0.05, 0.75];

fn draw_facets(svg: &mut Markup, area: &Area, facets: &[Facet]) {
    for facet in facets.iter().filter(|f| f.corners.iter().all(|c| visible(area, *c))) {
        let mut outline = Path::default();
        for (index, [x, y]) in facet.corners.into_iter().enumerate() {
            let (x, y) = (area.x.px(x), area.y.px(y));
            if index == 0 {
                outline.move_to(x, y);
            } else {
                outline.line_to(x, y);
            }
        }
        outline.constant("Z");
        let shade = if facet.shade.is_finite() { facet.shade.clamp(0.0, 1.0) } else { 0.0 };
        let opacity = format!("{:.2}", FACET_OPACITY[0] + FACET_OPACITY[1] * shade);
        svg.leaf("path", &[("class", &"paper"), ("d", &outline)]);
        svg.leaf("path", &[("class", &"facet"), ("d", &outline), ("fill-opacity", &opacity)]);
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
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
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
        if path.is_empty() {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    leaf_path(svg, &format!("band {}", colour(index)), &path);
}

/// One path for all marks of a kind: a zero-length segment with a round or square cap is a dot
/// at a quarter of the bytes of a circle element.
fn marks(svg: &mut Markup, area: &Area, points: &[[f64; 2]], index: usize, style: MarkStyle) {
    let shape = SHAPES[index % SHAPES.len()];
    let path = mark_path(area, points, shape.commands);
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

/// The same mark at every point.
fn mark_path(area: &Area, points: &[[f64; 2]], commands: &'static str) -> Path {
    let mut path = Path::default();
    for point in points.iter().filter(|p| visible(area, **p)) {
        path.move_to(area.x.px(point[0]), area.y.px(point[1]));
        path.constant(commands);
    }
    path
}

/// How marks of one colour look.
#[derive(Clone, Copy)]
struct Shape {
    class: &'static str,
    commands: &'static str,
}

const SHAPES: [Shape; 6] = [
    Shape { class: "dot", commands: "h0" },
    // A printer to PDF leaves out square caps of what has no length at all.
    Shape { class: "square", commands: "h.01" },
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

/// Background: drawn before the grid.
pub(crate) fn stretch(svg: &mut Markup, area: &Area, from: f64, to: f64) {
    let (left, right) = (area.x.px(from), area.x.px(to));
    rectangle(svg, "stretch", (left, area.y.to_px), (right, area.y.from_px));
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
