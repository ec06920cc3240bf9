//! One pair of axes and what is drawn in it.

use super::axis::{Range, Scale, Tick, ticks};
use super::layer::{Area, Layer, draw_layer, stretch};
use super::markup::{Markup, shorten, text_width};
use super::svg::{FONT, label, line, open_svg};

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
