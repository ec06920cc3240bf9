//! Marks stand where their values are, before and after on one scale.

use model_discrepancy::Outcome;
use roxmltree::{Document, Node};

use super::sample::{Sample, four_displacements, photogrammetry};
use super::{has_class, parse, section, text_of};
use crate::{DeviationMap, ExtraPlot, render};

/// Positions are written with one decimal, and so are the ticks they are read against.
const ROUNDING_PX: f64 = 0.11;

const BEFORE: &str = "Residual of the declared model";
const AFTER: &str = "Residual with the added effects";

fn number(node: Node, attribute: &str) -> f64 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

/// Labels of the vertical axis: value and height on the drawing.
fn vertical_ticks(svg: Node) -> Vec<(f64, f64)> {
    let label = |n: Node| {
        let value = text_of(n).replace('−', "-").parse().ok()?;
        // Labels stand 4 units below their line.
        Some((value, number(n, "y") - 4.0))
    };
    let texts = svg.children().filter(|n| n.has_tag_name("text") && has_class(*n, "end"));
    texts.filter_map(label).collect()
}

/// Drawings of a section as a wide page shows them, without those folded away.
fn wide_drawings<'a, 'i>(document: &'a Document<'i>, heading: &str) -> Vec<Node<'a, 'i>> {
    // A section may be folded as a whole, under its heading.
    let has_heading = |n: &Node| n.children().any(|c| c.has_tag_name("h2"));
    let within = |a: &Node| a.has_tag_name("details") && !a.children().any(|s| has_heading(&s));
    let open = |n: &Node| !n.ancestors().any(|a| within(&a));
    let node = section(document, heading);
    node.descendants().filter(|n| has_class(*n, "wide") && open(n)).collect()
}

/// Heights of the filled and hollow marks of a drawing, from left to right.
fn mark_heights(svg: Node) -> Vec<f64> {
    let is_mark = |n: &Node| {
        let shape = ["dot", "square", "drawn"].iter().any(|s| has_class(*n, s));
        n.has_tag_name("path") && shape && !has_class(*n, "hole")
    };
    let mut places: Vec<(f64, f64)> = Vec::new();
    for path in svg.children().filter(is_mark) {
        for start in path.attribute("d").unwrap().split('M').skip(1) {
            let end = start.find(['h', 'm']).unwrap();
            let (x, y) = start[..end].split_once(' ').unwrap();
            places.push((x.parse().unwrap(), y.parse().unwrap()));
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.into_iter().map(|(_, y)| y).collect()
}

/// Reads marks back against the ticks and compares them with the residual of one component.
fn assert_drawn(svg: Node, residuals: &[f64], component: usize, components: usize) {
    let ticks = vertical_ticks(svg);
    let ((low, low_px), (high, high_px)) = (ticks[0], ticks[ticks.len() - 1]);
    let px_per_unit = (high_px - low_px) / (high - low);
    let heights = mark_heights(svg);
    let expected: Vec<f64> =
        residuals.iter().skip(component).step_by(components).copied().collect();
    assert_eq!(heights.len(), expected.len());
    for (height, value) in heights.iter().zip(&expected) {
        let predicted = low_px + px_per_unit * (value - low);
        assert!((height - predicted).abs() < 2.0 * ROUNDING_PX, "{value} at {height}");
    }
}

#[test]
fn marks_stand_at_their_values_before_and_after() {
    let sample = photogrammetry();
    let page = render(&sample.closed());
    let document = parse(&page);
    for (heading, residuals) in
        [(BEFORE, &sample.closure.residuals_before), (AFTER, &sample.closure.residuals_after)]
    {
        let drawings = wide_drawings(&document, heading);
        assert_eq!(drawings.len(), 3, "one strip per component");
        for (component, svg) in drawings.iter().enumerate() {
            assert_drawn(*svg, residuals, component, 3);
        }
    }
}

#[test]
fn before_and_after_share_one_scale() {
    let shares = |sample: &Sample| {
        let page = render(&sample.closed());
        let document = parse(&page);
        let ticks = |heading| {
            let drawings = wide_drawings(&document, heading);
            drawings.into_iter().map(vertical_ticks).collect::<Vec<_>>()
        };
        let (before, after) = (ticks(BEFORE), ticks(AFTER));
        assert!(before.iter().all(|t| t.len() >= 2), "{before:?}");
        assert_eq!(before, after);
    };
    shares(&photogrammetry());
    shares(&four_displacements());
    // Also where it is the residual after that is larger.
    let mut worse = four_displacements();
    std::mem::swap(&mut worse.closure.residuals_before, &mut worse.closure.residuals_after);
    shares(&worse);
}

#[test]
fn bars_grow_with_significance_and_the_added_one_is_marked() {
    let page = render(&photogrammetry().closed());
    let document = parse(&page);
    let first = wide_drawings(&document, "How each candidate effect scored")[0];
    let bars: Vec<Node> = first.children().filter(|n| has_class(*n, "bar")).collect();
    // Seven of the nine candidates can be seen; they are sorted by significance.
    assert_eq!(bars.len(), 7);
    assert!(has_class(bars[0], "added"));
    let decades = |p: f64| (-p.log10()).min(16.0);
    let width = |bar: &Node| number(*bar, "width");
    // p of the fourth candidate of the sample, against the first, which is cut at 16 decades.
    let ratio = width(&bars[3]) / width(&bars[0]);
    assert!((ratio - decades(0.031) / 16.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn a_pass_is_compared_with_the_error_that_it_started_from() {
    let mut sample = four_displacements();
    // Both effects come in as a pair; then comes another pass.
    let passes = &mut sample.closure.passes;
    passes[0].scores[3].outcome = Outcome::Added;
    passes[1].scores[0].outcome = Outcome::NotSignificant;
    passes[1].scores[0].label = "drift".into();
    passes[1].scores[0].held_out_rms = 0.0659;
    let heading = "How each candidate effect scored";
    let page = render(&sample.closed());
    // A pass that added nothing has no picture.
    assert_eq!(wide_drawings(&parse(&page), heading).len(), 1);
    sample.closure.passes[1].scores[0].outcome = Outcome::Added;
    let page = render(&sample.closed());
    let document = parse(&page);
    let drawings = wide_drawings(&document, heading);
    let place = |svg: &Node, class: &str, attribute: &str| {
        number(svg.children().find(|n| has_class(*n, class)).unwrap(), attribute)
    };
    // Its error is the one of the last step: the square stands on the line.
    let centre = place(&drawings[1], "tag", "x") + 0.5 * place(&drawings[1], "tag", "width");
    let line = place(&drawings[1], "reference", "x1");
    assert!((centre - line).abs() < 2.0 * ROUNDING_PX, "{centre} against {line}");
}

/// A printer to PDF leaves out a square cap on a line of no length.
#[test]
fn square_marks_have_a_length() {
    let page = render(&photogrammetry().closed());
    let document = parse(&page);
    let is_square = |n: &Node| n.has_tag_name("path") && has_class(*n, "square");
    let squares: Vec<Node> = document.descendants().filter(is_square).collect();
    assert!(!squares.is_empty());
    for square in squares {
        let lines = square.attribute("d").unwrap().split('M').skip(1);
        for line in lines {
            let (_, length) = line.split_once('h').unwrap();
            assert!(length.parse::<f64>().unwrap() > 0.0, "{line}");
        }
    }
}

#[test]
fn the_heat_map_is_as_dark_as_the_candidates_are_alike() {
    let sample = photogrammetry();
    let page = render(&sample.closed());
    let document = parse(&page);
    let heading = "What cannot be told apart, and which measurement would";
    let drawing = wide_drawings(&document, heading)[0];
    let n = sample.closure.confusable_ids.len();
    let cells: Vec<f64> = drawing
        .children()
        .filter(|n| has_class(*n, "heat"))
        .map(|n| number(n, "fill-opacity"))
        .take(n * n)
        .collect();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let alike = sample.closure.confusability[(i, j)].abs();
        // Rounded to two decimals.
        assert!((cells[i * n + j] - (0.05 + 0.95 * alike)).abs() <= 0.0051, "{i} {j}");
    }
}

#[test]
fn deviations_have_the_shade_of_their_size_and_the_colour_of_their_sign() {
    let before = vec![-4e-3, -1e-3, 0.0, 1e-3, 1e-3, 4e-3, f64::NAN];
    let mut sample = four_displacements();
    sample.plots = vec![ExtraPlot::Deviations(DeviationMap {
        title: "Deviations".into(),
        caption: String::new(),
        x_title: "x, mm".into(),
        y_title: "y, mm".into(),
        unit: "mm".into(),
        at: (0..7).map(|i| [f64::from(i), f64::from(i % 3)]).collect(),
        names: (0..7).map(|i| format!("P{i}")).collect(),
        after: before.iter().map(|v| 0.25 * v).collect(),
        before,
    })];
    let page = render(&sample.closed());
    let document = parse(&page);
    let drawing = |name: &str| {
        let is_it = |n: &Node| n.attribute("aria-label").is_some_and(|a| a.contains(name));
        document.descendants().find(is_it).unwrap()
    };
    let dots = |svg: Node, class: &str, opacity: &str| -> usize {
        let of_shade = |n: &Node| {
            has_class(*n, "shaded")
                && has_class(*n, class)
                && n.attribute("stroke-opacity") == Some(opacity)
        };
        let paths = svg.children().filter(of_shade);
        paths.map(|n| n.attribute("d").unwrap().matches('M').count()).sum()
    };
    // The scale ends at 4 µm, of which 1 µm is a quarter.
    let before = drawing("Deviations, declared model");
    let counts = [("c0", "1.00"), ("c0", "0.25"), ("c1", "0.25"), ("c1", "1.00"), ("bare", "1.00")];
    assert_eq!(counts.map(|(class, opacity)| dots(before, class, opacity)), [1, 1, 2, 1, 6]);
    let after = drawing("Deviations, with the added effects");
    assert_eq!(counts.map(|(class, opacity)| dots(after, class, opacity)), [0, 1, 1, 0, 6]);
    let key = drawing("Colours from");
    assert!(text_of(key).contains("≥ 4 µm"), "{}", text_of(key));
}

#[test]
fn nothing_is_drawn_outside_its_drawing() {
    /// Half of the widest mark.
    const OVERHANG_PX: f64 = 5.0;
    for sample in [photogrammetry(), four_displacements()] {
        let page = render(&sample.closed());
        let document = parse(&page);
        for svg in document.descendants().filter(|n| n.has_tag_name("svg")) {
            let (width, height) = (number(svg, "width"), number(svg, "height"));
            for node in svg.children().filter(|n| n.has_tag_name("text")) {
                let (x, y) = (number(node, "x"), number(node, "y"));
                assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y));
            }
            for node in svg.children().filter(|n| n.has_tag_name("circle")) {
                let (x, y) = (number(node, "cx"), number(node, "cy"));
                assert!((-OVERHANG_PX..=width + OVERHANG_PX).contains(&x));
                assert!((-OVERHANG_PX..=height + OVERHANG_PX).contains(&y));
            }
        }
    }
}
