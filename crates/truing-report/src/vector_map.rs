//! Error vectors at their places.

use super::axis::{Range, drawable, round_step};
use super::even_axes::EvenAxes;
use super::input::{Arrow, VectorMap};
use super::layer::Layer;
use super::markup::Markup;
use super::number::{counted, significant};
use super::thin;
use super::unit::Shown;

/// The longest arrow takes about this share of the field.
const LONGEST_SHARE: f64 = 0.14;
/// Colours of what is above and below a surface.
const ABOVE: usize = 1;
const BELOW: usize = 0;
/// Arrows in one map, at most.
pub(crate) const MOST_ARROWS: usize = 600;

/// How the arrows of both maps of a case are drawn.
pub(crate) struct Exaggeration {
    /// Length on the axes of an arrow of length 1.
    factor: f64,
    field: (Range, Range),
    /// Length of the arrow that shows the scale, in the map's unit.
    sample: f64,
    shown: Shown,
}

impl Exaggeration {
    /// One scale for every vector of the map; `None` where there is nothing to draw.
    pub(crate) fn of(map: &VectorMap) -> Option<Self> {
        let both = || map.before.iter().chain(&map.after).filter(|a| is_drawable(a));
        let seen = |k: usize| {
            let corners = map.facets.iter().flat_map(|f| &f.corners).map(move |c| c[k]);
            Range::of(both().map(move |a| a.at[k]).chain(corners.filter(|v| drawable(*v))))
        };
        let field = (seen(0)?, seen(1)?);
        let longest = both().map(|a| a.error[0].hypot(a.error[1])).fold(0.0, f64::max);
        let width = field.0.span().max(field.1.span());
        let factor = if longest > 0.0 { LONGEST_SHARE * width / longest } else { 1.0 };
        let sample = if longest > 0.0 { round_step(0.4 * longest) } else { 0.0 };
        let shown = Shown::for_size(&map.unit, longest);
        factor.is_finite().then_some(Self { factor, field, sample, shown })
    }

    /// Draws one set of vectors in a drawing of the given width.
    pub(crate) fn draw(
        &self,
        map: &VectorMap,
        arrows: &[Arrow],
        which: (&str, usize),
        width: f64,
    ) -> Markup {
        let kept: Vec<&Arrow> = arrows.iter().filter(|a| is_drawable(a)).collect();
        let stride = thin::stride(kept.len(), MOST_ARROWS);
        let kept: Vec<&Arrow> = kept.into_iter().step_by(stride).collect();
        // Room for arrows that point outwards, and for the sample arrow above.
        let margin = LONGEST_SHARE * self.field.0.span().max(self.field.1.span());
        let axes = EvenAxes::around(self.field, (margin, 0.6 * margin), width);
        let colour = which.1;
        let tip = |a: &&Arrow| {
            [a.at, [a.at[0] + self.factor * a.error[0], a.at[1] + self.factor * a.error[1]]]
        };
        let mut layers = Vec::new();
        if map.facets.is_empty() {
            layers.push(Layer::Arrows { lines: kept.iter().map(tip).collect(), colour });
        } else {
            layers.push(Layer::Facets { facets: map.facets.clone() });
            for (upwards, colour) in [(true, ABOVE), (false, BELOW)] {
                let lines = kept.iter().filter(|a| (a.error[1] >= 0.0) == upwards).map(tip);
                layers.push(Layer::Arrows { lines: lines.collect(), colour });
            }
        }
        let names = kept.iter().map(|a| (a.at, self.describe(a))).collect();
        layers.push(Layer::Names { points: names });
        layers.extend(self.sample_arrow((axes.x, axes.y)));
        let longest = kept.iter().map(|a| a.error[0].hypot(a.error[1])).fold(0.0, f64::max);
        let alternative = format!(
            "{}, {}: {}, the longest error {} {}",
            map.title,
            which.0,
            counted(kept.len(), "vector"),
            significant(longest * self.shown.factor, 3),
            self.shown.unit
        );
        axes.draw((&map.x_title, &map.y_title), layers, alternative)
    }

    fn sample_arrow(&self, (x, y): (Range, Range)) -> Vec<Layer> {
        if self.sample <= 0.0 {
            return Vec::new();
        }
        let from = [x.low + 0.03 * x.span(), y.high - 0.05 * y.span()];
        let to = [from[0] + self.factor * self.sample, from[1]];
        let text =
            format!("{} {}", significant(self.sample * self.shown.factor, 1), self.shown.unit);
        let at = [to[0] + 0.015 * x.span(), from[1]];
        vec![Layer::Arrows { lines: vec![[from, to]], colour: 5 }, Layer::Note { at, text }]
    }

    fn describe(&self, arrow: &Arrow) -> String {
        let shown = |v: f64| significant(v * self.shown.factor, 3);
        let [x, y] = arrow.error;
        format!("{}: {}, {} {}", arrow.name, shown(x), shown(y), self.shown.unit)
    }
}

fn is_drawable(arrow: &Arrow) -> bool {
    arrow.at.iter().chain(&arrow.error).all(|v| drawable(*v))
}
