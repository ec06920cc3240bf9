//! One quantity as several sources have it, each on a line with its interval.

use super::axis::{Range, Scale, ticks};
use super::markup::{Markup, shorten, text_width};
use super::number::COVERAGE;
use super::svg::{FONT, colour, label, line, open_svg};

/// Values of one quantity over one axis.
#[derive(Clone, Debug)]
pub(crate) struct Forest<'a> {
    /// Name, value and standard uncertainty of each source; the last is what all of them give.
    pub(crate) rows: &'a [(String, f64, f64)],
    /// Title of the axis.
    pub(crate) title: &'a str,
    pub(crate) alternative: &'a str,
}

const ROW: f64 = 42.0;
const TOP: f64 = 12.0;
const MARGIN: f64 = 16.0;
/// Colour of a source, and of all together.
const OWN: usize = 0;
const ALL: usize = 2;

impl Forest<'_> {
    pub(crate) fn draw(&self, width: f64, class: &str) -> Markup {
        let bottom = TOP + ROW * super::number::real(self.rows.len());
        let mut svg = open_svg((width, bottom + 38.0), class, self.alternative);
        let scale = Scale { range: self.range(), from_px: MARGIN, to_px: width - MARGIN - 8.0 };
        let most = if width < 500.0 { 4 } else { 8 };
        for tick in ticks(scale.range, most) {
            let x = scale.px(tick.at);
            line(&mut svg, "grid", (x, TOP), (x, bottom));
            let half = 0.5 * text_width(&tick.label, FONT);
            label(&mut svg, "middle", (x.max(half), bottom + 16.0), &tick.label);
        }
        line(&mut svg, "axis", (scale.from_px, bottom), (scale.to_px, bottom));
        line(&mut svg, "reference", (scale.px(0.0), TOP), (scale.px(0.0), bottom));
        label(&mut svg, "end title", (scale.to_px + 8.0, bottom + 32.0), self.title);
        for (i, (name, value, std)) in self.rows.iter().enumerate() {
            let expanded = COVERAGE * std;
            let top = TOP + ROW * super::number::real(i);
            let chosen = colour(if i + 1 == self.rows.len() { ALL } else { OWN });
            let fitting = shorten(name, width - 40.0, FONT);
            label(&mut svg, "start", (scale.from_px + 4.0, top + 14.0), &fitting);
            if value.is_finite() && expanded.is_finite() {
                let [from, to] = [value - expanded, value + expanded].map(|v| scale.px(v));
                let class = format!("interval {chosen}");
                line(&mut svg, &class, (from, top + 28.0), (to, top + 28.0));
                let at = scale.px(*value);
                line(&mut svg, &format!("big-dot {chosen}"), (at, top + 28.0), (at, top + 28.0));
            }
        }
        svg.close("svg");
        svg
    }

    /// Of all intervals and zero.
    fn range(&self) -> Range {
        let ends = self.rows.iter().flat_map(|(_, value, std)| {
            let half = COVERAGE * std;
            [value - half, value + half].into_iter().filter(|end| end.is_finite())
        });
        let found = Range::of(ends.chain([0.0]));
        found.map_or(Range { low: -1.0, high: 1.0 }, |range| range.padded(0.04))
    }
}
