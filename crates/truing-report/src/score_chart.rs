//! How the candidates of one pass scored: significance, and error on unseen data if added.

use super::axis::{Range, Scale, ticks};
use super::markup::{Markup, shorten, text_width};
use super::number::{power_of_ten, real};
use super::svg::{FONT, label, line, open_sign, open_svg, rectangle};

/// Candidates of one pass, side by side in two charts that share their rows.
#[derive(Clone, Debug)]
pub(crate) struct ScoreChart {
    pub(crate) rows: Vec<ScoreRow>,
    /// Error on unseen data without any of them, in the unit shown.
    pub(crate) without: Option<f64>,
    /// Title of the second chart.
    pub(crate) error_title: String,
    pub(crate) alternative: String,
}

/// One candidate.
#[derive(Clone, Debug)]
pub(crate) struct ScoreRow {
    pub(crate) name: String,
    pub(crate) p_value: f64,
    /// Error on unseen data with it, in the unit shown.
    pub(crate) held_out: f64,
    /// Class that gives the bar its look.
    pub(crate) class: &'static str,
}

/// Powers of ten at which bars end: beyond them p says nothing more.
const MOST_DECADES: f64 = 16.0;
/// Powers of ten shown at least, so that noise looks like noise.
const LEAST_DECADES: f64 = 4.0;
/// Errors beyond this multiple of the error without the candidate are drawn at the edge.
const FAR: f64 = 2.0;

/// Where things go; narrow drawings have the name above its bar.
struct Grid {
    top: f64,
    row: f64,
    bar_below: f64,
    name_width: f64,
    bars: Scale,
    errors: Scale,
    bottom: f64,
}

impl ScoreChart {
    pub(crate) fn draw(&self, width: f64, class: &str) -> Markup {
        let grid = self.grid(width);
        let mut svg = open_svg((width, grid.bottom + 24.0), class, &self.alternative);
        draw_axes(&mut svg, &grid, self, width);
        for (i, row) in self.rows.iter().enumerate() {
            draw_row(&mut svg, &grid, row, grid.top + grid.row * real(i));
        }
        svg.close("svg");
        svg
    }

    fn grid(&self, width: f64) -> Grid {
        let wide = width > 600.0;
        let (row, bar_below) = if wide { (24.0, 5.0) } else { (38.0, 18.0) };
        let bars_from = if wide { 0.27 * width } else { 8.0 };
        let gap = if wide { 44.0 } else { 26.0 };
        let bars_to = bars_from + 0.58 * (width - bars_from) - gap;
        let top = if wide { 28.0 } else { 46.0 };
        Grid {
            top,
            row,
            bar_below,
            name_width: if wide { bars_from - 14.0 } else { width - 12.0 },
            bars: Scale { range: self.decades(), from_px: bars_from, to_px: bars_to },
            errors: Scale { range: self.errors(), from_px: bars_to + gap, to_px: width - 18.0 },
            bottom: top + row * real(self.rows.len()) + 4.0,
        }
    }

    fn decades(&self) -> Range {
        let most = self.rows.iter().map(|r| decades(r.p_value)).fold(LEAST_DECADES, f64::max);
        Range { low: 0.0, high: most.ceil() }
    }

    fn errors(&self) -> Range {
        let far = self.without.map_or(f64::INFINITY, |w| FAR * w);
        let shown = self.rows.iter().map(|r| r.held_out.min(far));
        let range = Range::of(shown.chain(self.without));
        range.unwrap_or(Range { low: 0.0, high: 1.0 }).padded(0.08)
    }
}

/// A bar of one look on its own, for a legend.
pub(crate) fn bar_sign(class: &str) -> Markup {
    let mut svg = open_sign(22.0);
    rectangle(&mut svg, &format!("bar {class}"), (1.0, 2.0), (21.0, 12.0));
    svg.close("svg");
    svg
}

/// Length of a bar: −log10 p, cut; zero where there is no p.
fn decades(p_value: f64) -> f64 {
    if p_value.is_nan() { 0.0 } else { (-p_value.log10()).clamp(0.0, MOST_DECADES) }
}

fn draw_axes(svg: &mut Markup, grid: &Grid, chart: &ScoreChart, width: f64) {
    let (bars, errors) = (&grid.bars, &grid.errors);
    let (top, bottom) = (grid.top - 4.0, grid.bottom);
    for tick in ticks(bars.range, if width > 600.0 { 8 } else { 4 }) {
        let x = bars.px(tick.at);
        line(svg, "grid", (x, top), (x, bottom));
        #[expect(clippy::cast_possible_truncation, reason = "clamped to 0..=16")]
        let exponent = -tick.at.round() as i32;
        // Steps of half a decade have no round label.
        if (tick.at - tick.at.round()).abs() < 1e-9 {
            label(svg, "middle", (x, bottom + 16.0), &power_of_ten(exponent));
        }
    }
    line(svg, "axis", (bars.from_px, top), (bars.from_px, bottom));
    for tick in ticks(errors.range, if width > 600.0 { 4 } else { 2 }) {
        let x = errors.px(tick.at);
        line(svg, "grid", (x, top), (x, bottom));
        let half = 0.5 * text_width(&tick.label, FONT);
        label(svg, "middle", (x.min(width - half - 1.0), bottom + 16.0), &tick.label);
    }
    if let Some(without) = chart.without {
        let x = errors.px(without);
        line(svg, "reference", (x, top), (x, bottom));
    }
    draw_titles(svg, grid, chart, width);
}

/// Titles; in narrow drawings the second is one line below the first.
fn draw_titles(svg: &mut Markup, grid: &Grid, chart: &ScoreChart, width: f64) {
    let wide = width > 600.0;
    let title = "significance p (longer bar: less likely chance)";
    let first = if wide { grid.bars.from_px } else { 2.0 };
    let room = if wide { grid.bars.to_px - first + 40.0 } else { width - 4.0 };
    label(svg, "start title", (first, 13.0), &shorten(title, room, FONT));
    if wide {
        let room = width - grid.errors.from_px - 2.0;
        let fitting = shorten(&chart.error_title, room, FONT);
        label(svg, "start title", (grid.errors.from_px, 13.0), &fitting);
    } else {
        let fitting = shorten(&chart.error_title, width - 4.0, FONT);
        label(svg, "end title", (width - 2.0, 31.0), &fitting);
    }
}

fn draw_row(svg: &mut Markup, grid: &Grid, row: &ScoreRow, top: f64) {
    let bar = top + grid.bar_below;
    let middle = bar + 7.0;
    let name = shorten(&row.name, grid.name_width, FONT);
    if grid.bar_below < 10.0 {
        label(svg, "end", (grid.bars.from_px - 8.0, middle + 4.0), &name);
    } else {
        label(svg, "start", (grid.bars.from_px + 4.0, bar - 5.0), &name);
    }
    if row.p_value.is_nan() {
        label(svg, "start faint", (grid.bars.from_px + 6.0, middle + 4.0), "cannot be seen");
    } else {
        let end = grid.bars.px(decades(row.p_value)).max(grid.bars.from_px + 1.5);
        let class = format!("bar {}", row.class);
        rectangle(svg, &class, (grid.bars.from_px, bar), (end, bar + 14.0));
    }
    if row.held_out.is_finite() {
        let x = grid.errors.px(row.held_out);
        let beyond = !grid.errors.range.contains(row.held_out);
        rectangle(svg, &format!("tag {}", row.class), (x - 4.0, bar + 3.0), (x + 4.0, bar + 11.0));
        if beyond {
            label(svg, "start", (x + 5.0, middle + 4.0), "›");
        }
    }
}
