//! Deviations as colours at their places.

use super::axis::{Range, drawable, round_step};
use super::even_axes::EvenAxes;
use super::input::DeviationMap;
use super::layer::Layer;
use super::markup::{Markup, Path, text_width};
use super::number::{counted, real, significant, trimmed};
use super::svg::{FONT, label, open_svg, shaded_dot};
use super::unit::Shown;

/// Colours of what is above and below the surface.
const ABOVE: usize = 1;
const BELOW: usize = 0;
/// Shades of either colour; a deviation has that of the nearest.
const SHADES: i32 = 4;
/// One deviation in so many may lie beyond the scale: a few far ones must not pale the others.
const ONE_BEYOND: usize = 50;
/// Share of the field that is left free around it.
const MARGIN: f64 = 0.06;
/// Width of a dot where there are few, and where there are many, SVG units.
const DOT: [f64; 2] = [11.0, 3.0];
/// Dots of the full width cover at most this share of a map that is as high as it is wide.
const COVERED: f64 = 0.35;
/// Points whose names show when pointed at: each is an element of its own.
const MOST_NAMES: usize = 600;

/// How the deviations of both maps of a case are coloured.
pub(crate) struct Colouring {
    /// Deviation of the deepest shade, in the map's unit.
    limit: f64,
    field: (Range, Range),
    shown: Shown,
}

impl Colouring {
    /// One scale for every deviation of the map; `None` where there is nothing to draw.
    pub(crate) fn of(map: &DeviationMap) -> Option<Self> {
        let values = map.before.iter().chain(&map.after);
        let mut sizes: Vec<f64> = values.map(|v| v.abs()).filter(|v| drawable(*v)).collect();
        sizes.sort_by(f64::total_cmp);
        let held = *sizes.iter().nth_back(sizes.len() / ONE_BEYOND)?;
        let limit = if held > 0.0 { rounded_up(held) } else { 1.0 };
        let field = |k: usize| Range::of(map.at.iter().map(move |at| at[k]));
        let shown = Shown::for_size(&map.unit, limit);
        Some(Self { limit, field: (field(0)?, field(1)?), shown })
    }

    /// Draws one set of deviations in a drawing of the given width.
    pub(crate) fn draw(
        &self,
        map: &DeviationMap,
        deviations: &[f64],
        name: &str,
        width: f64,
    ) -> Markup {
        let is_drawable = |at: &[f64; 2], v: f64| at.iter().all(|c| drawable(*c)) && drawable(v);
        let points: Vec<([f64; 2], f64, &str)> = (map.at.iter().zip(deviations).zip(&map.names))
            .filter(|((at, v), _)| is_drawable(at, **v))
            .map(|((at, v), name)| (*at, *v, name.as_str()))
            .collect();
        let margin = MARGIN * self.field.0.span().max(self.field.1.span());
        let axes = EvenAxes::around(self.field, (margin, 0.0), width);
        let size = (width * (COVERED / real(points.len().max(1))).sqrt()).clamp(DOT[1], DOT[0]);
        let mut layers: Vec<Layer> = (-SHADES..=SHADES)
            .map(|shade| {
                let of_shade = points.iter().filter(|(_, v, _)| self.shade(*v) == shade);
                let (colour, depth) = look(shade);
                Layer::Shaded { points: of_shade.map(|p| p.0).collect(), colour, depth, size }
            })
            .collect();
        let named = points.iter().take(MOST_NAMES);
        let names = named.map(|(at, v, name)| (*at, format!("{name}: {}", self.read(*v))));
        layers.push(Layer::Names { points: names.collect() });
        let largest = points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
        let alternative = format!(
            "{}, {name}: {}, the largest deviation {}",
            map.title,
            counted(points.len(), "point"),
            self.read(largest),
        );
        axes.draw((&map.x_title, &map.y_title), layers, alternative)
    }

    /// The shades with what they stand for.
    pub(crate) fn key(&self) -> Markup {
        let (step, radius) = (18.0, 0.5 * DOT[0]);
        let end_of_scale = |v: f64| self.with_unit(trimmed(v * self.shown.factor, 2));
        let low = format!("≤ {}", end_of_scale(-self.limit));
        let high = format!("≥ {}", end_of_scale(self.limit));
        let left = text_width(&low, FONT) + 8.0 + radius;
        let end = left + step * f64::from(2 * SHADES);
        let size = (end + radius + 8.0 + text_width(&high, FONT), 32.0);
        let mut svg = open_svg(size, "key", &format!("Colours from {low} to {high}"));
        for shade in -SHADES..=SHADES {
            let mut path = Path::default();
            path.move_to(left + step * f64::from(shade + SHADES), 12.0);
            path.constant("h0");
            let (colour, depth) = look(shade);
            shaded_dot(&mut svg, &path, (colour, depth), DOT[0]);
        }
        label(&mut svg, "start", (0.0, 16.0), &low);
        label(&mut svg, "middle", (0.5 * (left + end), 31.0), "0");
        label(&mut svg, "start", (end + radius + 8.0, 16.0), &high);
        svg.close("svg");
        svg
    }

    /// The nearest shade, below zero for what is below the surface.
    fn shade(&self, deviation: f64) -> i32 {
        let steps = f64::from(SHADES) * (deviation / self.limit).clamp(-1.0, 1.0);
        (-SHADES..=SHADES)
            .min_by(|a, b| (f64::from(*a) - steps).abs().total_cmp(&(f64::from(*b) - steps).abs()))
            .unwrap_or(0)
    }

    fn read(&self, deviation: f64) -> String {
        self.with_unit(significant(deviation * self.shown.factor, 3))
    }

    fn with_unit(&self, value: String) -> String {
        if self.shown.unit.is_empty() { value } else { format!("{value} {}", self.shown.unit) }
    }
}

/// The next round value, at most a quarter above.
fn rounded_up(value: f64) -> f64 {
    let step = 0.1 * round_step(value);
    // A value that is round already stays what it is, round-off or not.
    (value / step - 1e-9).ceil() * step
}

/// Colour of a shade, and how deep it is, 0 to 1.
fn look(shade: i32) -> (usize, f64) {
    (if shade < 0 { BELOW } else { ABOVE }, f64::from(shade.abs()) / f64::from(SHADES))
}
