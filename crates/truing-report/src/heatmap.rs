//! How alike the candidates look to this design.

use super::markup::{Markup, Px, shorten, text_width};
use super::number::{fixed, real};
use super::svg::{FONT, label, open_svg};

/// Similarities between things, 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Heatmap {
    pub(crate) names: Vec<String>,
    /// Rows of similarities; NaN where there is none.
    pub(crate) rows: Vec<Vec<f64>>,
    pub(crate) alternative: String,
}

/// Cells at least this wide hold their number.
const NUMBERED: f64 = 25.0;
const WIDEST_CELL: f64 = 38.0;
const TOP: f64 = 22.0;

impl Heatmap {
    pub(crate) fn draw(&self, width: f64, class: &str) -> Markup {
        let names = self.names.iter().enumerate().map(|(i, name)| format!("{}  {name}", i + 1));
        let names: Vec<String> = names.collect();
        let longest = names.iter().map(|n| text_width(n, FONT)).fold(0.0, f64::max);
        let left = (longest + 10.0).min(0.36 * width);
        let n = real(self.names.len().max(1));
        let cell = ((width - left - 4.0) / n).min(WIDEST_CELL);
        // Cells need not be square where names need the height.
        let height = cell.max(18.0);
        let size = (width, TOP + n * height + 34.0);
        let mut svg = open_svg(size, class, &self.alternative);
        for (i, name) in names.iter().enumerate() {
            let y = TOP + (real(i) + 0.5) * height + 4.0;
            label(&mut svg, "start", (2.0, y), &shorten(name, left - 8.0, FONT));
            let x = left + (real(i) + 0.5) * cell;
            // Every second number where the columns are too narrow for all.
            if cell >= 17.0 || i % 2 == 0 {
                label(&mut svg, "middle", (x, TOP - 7.0), &(i + 1).to_string());
            }
        }
        for (i, row) in self.rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let at = (left + real(j) * cell, TOP + real(i) * height);
                draw_cell(&mut svg, at, (cell, height), *value);
            }
        }
        draw_key(&mut svg, (left, TOP + n * height + 12.0), (width - left).min(220.0));
        svg.close("svg");
        svg
    }
}

fn draw_cell(svg: &mut Markup, at: (f64, f64), size: (f64, f64), value: f64) {
    let share = if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    shade(svg, at, (size.0 - 1.0, size.1 - 1.0), share);
    if size.0 < NUMBERED {
        return;
    }
    let centre = (at.0 + 0.5 * size.0 - 0.5, at.1 + 0.5 * size.1 + 3.5);
    let text = if value.is_finite() { short_share(share) } else { "–".to_string() };
    label(svg, if share > 0.55 { "cell on-dark" } else { "cell" }, centre, &text);
}

/// Two decimals without the zero before the point; «1» only for what is 1.
fn short_share(share: f64) -> String {
    match fixed(share, 2).as_str() {
        "1.00" if share < 1.0 - 1e-9 => ">.99".to_string(),
        "1.00" => "1".to_string(),
        "0.00" => "0".to_string(),
        text => text.trim_start_matches('0').to_string(),
    }
}

fn shade(svg: &mut Markup, at: (f64, f64), size: (f64, f64), share: f64) {
    let opacity = format!("{:.2}", 0.05 + 0.95 * share);
    svg.leaf(
        "rect",
        &[
            ("class", &"heat"),
            ("x", &Px(at.0)),
            ("y", &Px(at.1)),
            ("width", &Px(size.0.max(0.5))),
            ("height", &Px(size.1.max(0.5))),
            ("fill-opacity", &opacity),
        ],
    );
}

fn draw_key(svg: &mut Markup, at: (f64, f64), width: f64) {
    const STEPS: usize = 6;
    let step = 16.0;
    for i in 0..STEPS {
        let share = real(i) / real(STEPS - 1);
        shade(svg, (at.0 + 14.0 + real(i) * step, at.1), (step - 1.0, 10.0), share);
    }
    label(svg, "start", (at.0, at.1 + 10.0), "0");
    let end = at.0 + 14.0 + real(STEPS) * step + 4.0;
    label(svg, "start", (end, at.1 + 10.0), &shorten("1: the same", width, FONT));
}
