//! Pictures that only this kind of case has.

use super::{Context, for_both, paragraph};
use crate::axis::Range;
use crate::data_table::{DataTable, Datum};
use crate::deviation_map::Colouring;
use crate::input::{Arrow, Curve, CurvePlot, DeviationMap, ExtraPlot, VectorMap};
use crate::layer::{Layer, MarkStyle, mark_sign};
use crate::markup::Markup;
use crate::number::{count, counted, significant, trimmed};
use crate::panel::{Axis, Panel};
use crate::thin;
use crate::unit::with_unit;
use crate::vector_map::Exaggeration;

/// Points of one curve.
const MOST_POINTS: usize = 1000;
/// Points of one curve that show their values when pointed at.
const MOST_VALUES: usize = 200;
/// Room for vectors at two maps side by side.
const MAP: f64 = 440.0;
/// What the two maps show.
const BEFORE: &str = "declared model";
const AFTER: &str = "with the added effects";

pub(crate) fn views(out: &mut Markup, context: &Context) {
    for plot in context.input.plots {
        match plot {
            ExtraPlot::Vectors(map) => vectors(out, map),
            ExtraPlot::Deviations(map) => deviations(out, map),
            ExtraPlot::Curves(plot) => curves(out, plot),
        }
    }
}

fn vectors(out: &mut Markup, map: &VectorMap) {
    heading(out, &map.title, &map.caption);
    let Some(exaggeration) = Exaggeration::of(map) else {
        paragraph(out, "quiet", "There is no vector to draw.");
        return;
    };
    let figure = |(arrows, name, colour): (&Vec<Arrow>, &str, usize)| {
        let drawn = || exaggeration.draw(map, arrows, (name, colour), MAP);
        (!arrows.is_empty()).then(|| (drawn(), vector_caption(name, arrows.len())))
    };
    side_by_side(out, [(&map.before, BEFORE, 0), (&map.after, AFTER, 2)].map(figure));
    let error = |of: &str, way: &str| with_unit(&format!("error {way}, {of}"), &map.unit);
    let columns = [BEFORE, AFTER].map(|of| [error(of, "horizontally"), error(of, "vertically")]);
    let mut data = DataTable::new(
        ["name".to_owned(), map.x_title.clone(), map.y_title.clone()]
            .into_iter()
            .chain(columns.into_iter().flatten()),
    );
    for (i, arrow) in map.before.iter().enumerate() {
        let after = map.after.get(i).map_or([f64::NAN; 2], |after| after.error);
        let numbers = [arrow.at, arrow.error, after].into_iter().flatten().map(Datum::from);
        data.push([Datum::from(arrow.name.as_str())].into_iter().chain(numbers));
    }
    data.link(out, &map.title);
}

fn deviations(out: &mut Markup, map: &DeviationMap) {
    heading(out, &map.title, &map.caption);
    let Some(colouring) = Colouring::of(map) else {
        paragraph(out, "quiet", "There is no deviation to draw.");
        return;
    };
    out.append(&colouring.key());
    let figure = |(values, name): (&Vec<f64>, &str)| {
        let caption = || format!("{name}: {}", counted(values.len(), "point"));
        (!values.is_empty()).then(|| (colouring.draw(map, values, name, MAP), caption()))
    };
    side_by_side(out, [(&map.before, BEFORE), (&map.after, AFTER)].map(figure));
    let [before, after] =
        [BEFORE, AFTER].map(|of| with_unit(&format!("deviation, {of}"), &map.unit));
    let mut data = DataTable::new(["name", &map.x_title, &map.y_title, &before, &after]);
    for (i, (name, [x, y])) in map.names.iter().zip(&map.at).enumerate() {
        let of = |values: &[f64]| values.get(i).copied().unwrap_or(f64::NAN);
        let numbers = [*x, *y, of(&map.before), of(&map.after)].map(Datum::from);
        data.push([Datum::from(name.as_str())].into_iter().chain(numbers));
    }
    data.link(out, &map.title);
}

fn heading(out: &mut Markup, title: &str, caption: &str) {
    out.element("h2", &[], title);
    if !caption.is_empty() {
        paragraph(out, "", caption);
    }
}

/// Drawings with their captions, those that there are.
fn side_by_side(out: &mut Markup, figures: [Option<(Markup, String)>; 2]) {
    out.open("div", &[("class", &"pair")]);
    for (drawing, caption) in figures.into_iter().flatten() {
        out.open("figure", &[]);
        out.append(&drawing);
        out.element("figcaption", &[], &caption);
        out.close("figure");
    }
    out.close("div");
}

fn vector_caption(name: &str, n: usize) -> String {
    let stride = thin::stride(n, crate::vector_map::MOST_ARROWS);
    if stride > 1 {
        format!("{name}: every {stride}th of {} vectors", count(n))
    } else {
        format!("{name}: {}", counted(n, "vector"))
    }
}

fn curves(out: &mut Markup, plot: &CurvePlot) {
    heading(out, &plot.title, &plot.caption);
    let Some((x, y)) = ranges(plot) else {
        paragraph(out, "quiet", "There is no curve to draw.");
        return;
    };
    if plot.curves.len() > 1 {
        out.open("p", &[("class", &"legend")]);
        for (i, curve) in plot.curves.iter().enumerate() {
            out.open("span", &[("class", &"key")]);
            out.append(&mark_sign(i));
            out.name(&curve.name);
            out.close("span");
        }
        out.close("p");
    }
    let layers: Vec<Layer> =
        plot.curves.iter().enumerate().flat_map(|(i, curve)| curve_layers(curve, i)).collect();
    out.open("figure", &[]);
    for_both(out, |width, class| {
        let panel = Panel {
            size: (width, 280.0),
            x: Axis::new(x, plot.x_title.clone()),
            y: Axis::new(y, plot.y_title.clone()),
            layers: layers.clone(),
            alternative: format!("{}: {} against {}", plot.title, plot.y_title, plot.x_title),
        };
        panel.draw(class)
    });
    if let Some(n) = plot.curves.iter().map(|c| c.points.len()).max().filter(|n| *n > MOST_POINTS) {
        let text = format!("Of up to {} points a curve, about {MOST_POINTS} are drawn.", count(n));
        out.element("figcaption", &[], &text);
    }
    out.close("figure");
    let mut data =
        DataTable::new(["curve", &plot.x_title, &plot.y_title, "half of a 95 % interval"]);
    for curve in &plot.curves {
        for (i, [x, y]) in curve.points.iter().enumerate() {
            let half_width = curve.half_widths.get(i).copied().unwrap_or(f64::NAN);
            data.push([curve.name.as_str().into(), (*x).into(), (*y).into(), half_width.into()]);
        }
    }
    data.link(out, &plot.title);
}

fn ranges(plot: &CurvePlot) -> Option<(Range, Range)> {
    let points = || plot.curves.iter().flat_map(|c| c.points.iter());
    let ends = plot
        .curves
        .iter()
        .flat_map(|c| c.points.iter().zip(&c.half_widths).flat_map(|(p, h)| [p[1] - h, p[1] + h]));
    let x = Range::of(points().map(|p| p[0]))?;
    let y = Range::of(points().map(|p| p[1]).chain(ends))?;
    Some((x.padded(0.02), y.padded(0.06)))
}

fn curve_layers(curve: &Curve, colour: usize) -> Vec<Layer> {
    let values: Vec<f64> = curve.points.iter().map(|p| p[1]).collect();
    let kept = thin::envelope(&values, MOST_POINTS);
    let points: Vec<[f64; 2]> = kept.iter().map(|i| curve.points[*i]).collect();
    let half = |i: &usize| Some((curve.points[*i], *curve.half_widths.get(*i)?));
    let band = kept.iter().filter_map(half).map(|(p, h)| [p[0], p[1] - h, p[1] + h]);
    let mut layers = vec![Layer::Band { points: band.collect(), colour }];
    if curve.joined {
        layers.push(Layer::Line { points: points.clone(), colour, trend: false });
    }
    if !curve.joined || curve.points.len() <= 60 {
        layers.push(Layer::Marks { points, colour, style: MarkStyle::default() });
    }
    if curve.points.len() <= MOST_VALUES {
        let value = |(i, p): (usize, &[f64; 2])| {
            let half = curve.half_widths.get(i).filter(|half| **half > 0.0);
            let half =
                half.map_or_else(String::new, |half| format!(" ± {}", significant(*half, 2)));
            (*p, format!("{}, {}: {}{half}", curve.name, trimmed(p[0], 5), significant(p[1], 3)))
        };
        layers.push(Layer::Names { points: curve.points.iter().enumerate().map(value).collect() });
    }
    layers
}
