//! Elements of a drawing.

use super::markup::{Markup, Path, Px};

/// Height of the letters in a drawing, SVG units.
pub(crate) const FONT: f64 = 12.0;

/// Class of the n-th colour; marks of the n-th colour have the n-th shape.
pub(crate) const COLOURS: [&str; 6] = ["c0", "c1", "c2", "c3", "c4", "c5"];

pub(crate) fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
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

/// Dots of a shade, `(colour, depth from 0 to 1)`, with a rim that shows also the palest.
pub(crate) fn shaded_dot(svg: &mut Markup, path: &Path, look: (usize, f64), size: f64) {
    if path.is_empty() {
        return;
    }
    let dots = |svg: &mut Markup, class: &str, width: f64, opacity: f64| {
        let opacity = format!("{opacity:.2}");
        svg.leaf(
            "path",
            &[
                ("class", &class),
                ("d", path),
                ("stroke-width", &Px(width)),
                ("stroke-opacity", &opacity),
            ],
        );
    };
    dots(svg, "shaded rim", size, 1.0);
    dots(svg, "shaded bare", size - 1.2, 1.0);
    if look.1 > 0.0 {
        dots(svg, &format!("shaded {}", colour(look.0)), size - 1.2, look.1);
    }
}

pub(crate) fn leaf_path(svg: &mut Markup, class: &str, path: &Path) {
    if !path.is_empty() {
        svg.leaf("path", &[("class", &class), ("d", path)]);
    }
}
