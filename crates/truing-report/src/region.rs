//! Where something is stable, over two quantities.

use super::axis::{Range, Scale, Tick};
use super::data_table::{DataTable, Datum};
use super::layer::Area;
use super::markup::Markup;
use super::number::{real, significant};
use super::svg::{label, line, open_svg, rectangle};

/// What is so at one place of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// Drawn empty.
    Unstable,
    /// Stable, with less than comfortable margins.
    Stable,
    /// Stable with margins.
    Comfortable,
}

/// A region of stability over two quantities, both in logarithm.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// What the picture shows, for whoever cannot see it.
    pub alternative: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Title of the vertical axis with its unit.
    pub y_title: String,
    /// Values of the columns, evenly in logarithm, ascending.
    pub x: Vec<f64>,
    /// Values of the rows, evenly in logarithm, descending.
    pub y: Vec<f64>,
    /// Row by row.
    pub cells: Vec<Vec<Stability>>,
    /// Where along the vertical axis a dashed line is drawn.
    pub chosen: f64,
}

const LEFT: f64 = 56.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 38.0;

impl Region {
    pub(crate) fn draw(&self, width: f64, class: &str) -> Markup {
        let height = (0.5 * width).clamp(260.0, 420.0);
        let mut svg = open_svg((width, height), class, &self.alternative);
        let area = Area {
            x: scale(&self.x, LEFT, width - RIGHT),
            y: scale(&self.y, height - BOTTOM, TOP),
        };
        let (step_x, step_y) = (
            (area.x.to_px - area.x.from_px) / real(self.x.len()),
            (area.y.from_px - area.y.to_px) / real(self.y.len()),
        );
        for (row, cells) in self.cells.iter().enumerate() {
            let top = TOP + real(row) * step_y;
            let mut from = 0;
            // One rectangle for each run of equal cells.
            for run in cells.chunk_by(|a, b| a == b) {
                let (left, right) = (LEFT + real(from) * step_x, real(run.len()) * step_x);
                from += run.len();
                let class = match run[0] {
                    Stability::Unstable => continue,
                    Stability::Stable => "region stable",
                    Stability::Comfortable => "region comfortable",
                };
                rectangle(&mut svg, class, (left, top), (left + right, top + step_y));
            }
        }
        axes(&mut svg, &area, (width, height), (&self.x_title, &self.y_title));
        let y = area.y.px(self.chosen.log10());
        line(&mut svg, "reference", (LEFT, y), (width - RIGHT, y));
        svg.close("svg");
        svg
    }
}

impl Region {
    /// What is so at every place.
    pub(crate) fn data(&self) -> DataTable {
        let mut data = DataTable::new([self.x_title.as_str(), self.y_title.as_str(), "stability"]);
        for (y, cells) in self.y.iter().zip(&self.cells) {
            for (x, cell) in self.x.iter().zip(cells) {
                let word = match cell {
                    Stability::Unstable => "unstable",
                    Stability::Stable => "stable",
                    Stability::Comfortable => "comfortable",
                };
                data.push([Datum::from(*x), Datum::from(*y), Datum::from(word)]);
            }
        }
        data
    }
}

/// Half a step beyond the outermost values, so that each has its cell.
fn scale(values: &[f64], from_px: f64, to_px: f64) -> Scale {
    let logarithms = values.iter().map(|v| v.log10());
    let range = Range::of(logarithms).unwrap_or(Range { low: 0.0, high: 1.0 });
    let share = 0.5 / real(values.len().saturating_sub(1).max(1));
    Scale { range: range.padded(share), from_px, to_px }
}

/// Powers of ten, and where there are fewer than three the numbers 2 and 5 between them.
fn decades(range: Range) -> Vec<Tick> {
    let ticks = |factors: &[f64]| -> Vec<Tick> {
        let powers = (-9..10).flat_map(|power| factors.iter().map(move |f| f * 10f64.powi(power)));
        powers
            .filter(|value| range.contains(value.log10()))
            .map(|value| Tick { at: value.log10(), label: significant(value, 1) })
            .collect()
    };
    let powers = ticks(&[1.0]);
    if powers.len() < 3 { ticks(&[1.0, 2.0, 5.0]) } else { powers }
}

fn axes(
    svg: &mut Markup,
    area: &Area,
    (width, height): (f64, f64),
    (x_title, y_title): (&str, &str),
) {
    let bottom = height - BOTTOM;
    for tick in decades(area.y.range) {
        let y = area.y.px(tick.at);
        line(svg, "grid", (LEFT, y), (width - RIGHT, y));
        label(svg, "end", (LEFT - 6.0, y + 4.0), &tick.label);
    }
    for tick in decades(area.x.range) {
        let x = area.x.px(tick.at);
        line(svg, "grid", (x, TOP), (x, bottom));
        label(svg, "middle", (x.min(width - 18.0), bottom + 16.0), &tick.label);
    }
    line(svg, "axis", (LEFT, bottom), (width - RIGHT, bottom));
    label(svg, "start title", (2.0, 13.0), y_title);
    let middle = 0.5 * (LEFT + width - RIGHT);
    label(svg, "middle title", (middle, bottom + 32.0), x_title);
}
