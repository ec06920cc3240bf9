//! Errors of several models on one line each, with the spread of each.

use super::axis::{Range, Scale, ticks};
use super::markup::{Markup, Path, Px, shorten, text_width};
use super::svg::{FONT, colour, label, line, open_svg};

/// Errors of several models over one axis that starts at zero.
#[derive(Clone, Debug)]
pub(crate) struct IntervalChart {
    pub(crate) rows: Vec<IntervalRow>,
    /// Title of the axis.
    pub(crate) title: String,
    /// A value to compare with, and its name.
    pub(crate) reference: Option<(f64, String)>,
    pub(crate) alternative: String,
}

/// One model.
#[derive(Clone, Debug)]
pub(crate) struct IntervalRow {
    pub(crate) name: String,
    /// Error on data the fit never saw.
    pub(crate) held_out: f64,
    /// Expanded uncertainty of it.
    pub(crate) expanded: f64,
    /// Error on the data fitted.
    pub(crate) fitted: f64,
    pub(crate) colour: usize,
}

const ROW: f64 = 46.0;
const MARGIN: f64 = 16.0;

impl IntervalChart {
    pub(crate) fn draw(&self, width: f64, class: &str) -> Markup {
        let top = if self.reference.is_some() { 34.0 } else { 16.0 };
        let bottom = top + ROW * super::number::real(self.rows.len());
        let mut svg = open_svg((width, bottom + 38.0), class, &self.alternative);
        let scale = Scale { range: self.range(), from_px: MARGIN, to_px: width - MARGIN - 8.0 };
        self.draw_axis(&mut svg, &scale, top, bottom);
        if let Some((value, name)) = &self.reference {
            draw_reference(&mut svg, scale.px(*value), (22.0, bottom), name, width);
        }
        let mut y = top;
        for row in &self.rows {
            draw_row(&mut svg, &scale, row, y, width);
            y += ROW;
        }
        svg.close("svg");
        svg
    }

    fn range(&self) -> Range {
        let ends = self.rows.iter().flat_map(|r| [r.held_out, r.held_out + r.expanded, r.fitted]);
        let reference = self.reference.iter().map(|(value, _)| *value);
        let found = Range::of(ends.chain(reference).chain([0.0]));
        let range = found.unwrap_or(Range { low: 0.0, high: 1.0 });
        Range { low: 0.0, high: range.high + 0.04 * range.span() }
    }

    fn draw_axis(&self, svg: &mut Markup, scale: &Scale, top: f64, bottom: f64) {
        let most = if scale.to_px < 500.0 { 4 } else { 8 };
        for tick in ticks(scale.range, most) {
            let x = scale.px(tick.at);
            line(svg, "grid", (x, top), (x, bottom));
            let half = 0.5 * text_width(&tick.label, FONT);
            label(svg, "middle", (x.max(half), bottom + 16.0), &tick.label);
        }
        line(svg, "axis", (scale.from_px, bottom), (scale.to_px, bottom));
        label(svg, "end title", (scale.to_px + 8.0, bottom + 32.0), &self.title);
    }
}

fn draw_reference(svg: &mut Markup, x: f64, (top, bottom): (f64, f64), name: &str, width: f64) {
    line(svg, "reference", (x, top), (x, bottom));
    let fitting = shorten(name, width - 8.0, FONT);
    let half = 0.5 * text_width(&fitting, FONT);
    label(svg, "middle", (x.min(width - half - 2.0).max(half + 2.0), top - 8.0), &fitting);
}

fn draw_row(svg: &mut Markup, scale: &Scale, row: &IntervalRow, top: f64, width: f64) {
    let middle = top + 30.0;
    label(svg, "start", (scale.from_px + 4.0, top + 14.0), &shorten(&row.name, width - 40.0, FONT));
    let class = format!("interval {}", colour(row.colour));
    if row.held_out.is_finite() && row.expanded.is_finite() {
        let low = (row.held_out - row.expanded).max(0.0);
        let from = (scale.px(low), middle);
        line(svg, &class, from, (scale.px(row.held_out + row.expanded), middle));
    }
    if row.held_out.is_finite() {
        let at = (scale.px(row.held_out), middle);
        mark(svg, &format!("big-dot {}", colour(row.colour)), at);
    }
    if row.fitted.is_finite() {
        circle(svg, &format!("ring {}", colour(row.colour)), (scale.px(row.fitted), middle));
    }
}

fn mark(svg: &mut Markup, class: &str, at: (f64, f64)) {
    let mut path = Path::default();
    path.move_to(at.0, at.1);
    path.constant("h0");
    svg.leaf("path", &[("class", &class), ("d", &path)]);
}

fn circle(svg: &mut Markup, class: &str, at: (f64, f64)) {
    svg.leaf("circle", &[("class", &class), ("cx", &Px(at.0)), ("cy", &Px(at.1)), ("r", &"4.5")]);
}
