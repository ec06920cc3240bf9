//! Axes of a map.

use super::axis::Range;
use super::layer::Layer;
use super::markup::Markup;
use super::panel::{Axis, Panel};

/// Axes on which a millimetre is as long one way as the other.
pub(crate) struct EvenAxes {
    pub(crate) x: Range,
    pub(crate) y: Range,
    /// Width and height of the drawing.
    size: (f64, f64),
}

impl EvenAxes {
    /// Around a field, with `margin` left free at every side and `above` more at the top, in a drawing
    /// of the given width.
    pub(crate) fn around(field: (Range, Range), (margin, above): (f64, f64), width: f64) -> Self {
        let widen = |r: Range, top: f64| Range { low: r.low - margin, high: r.high + margin + top };
        let (x, y) = (widen(field.0, 0.0), widen(field.1, above));
        // About what the frame takes from the drawing: tick labels, titles.
        let (plot_width, frame) = (width - 60.0, 58.0);
        let plot_height = (plot_width * y.span() / x.span()).clamp(0.4 * width, 1.1 * width);
        let per_px = (x.span() / plot_width).max(y.span() / plot_height);
        let centred = |r: Range, px: f64| {
            let half = 0.5 * px * per_px;
            Range { low: r.middle() - half, high: r.middle() + half }
        };
        let size = (width, plot_height + frame);
        Self { x: centred(x, plot_width), y: centred(y, plot_height), size }
    }

    /// Draws layers between the axes.
    pub(crate) fn draw(
        self,
        (x_title, y_title): (&str, &str),
        layers: Vec<Layer>,
        alternative: String,
    ) -> Markup {
        let panel = Panel {
            size: self.size,
            x: Axis::new(self.x, x_title),
            y: Axis { baseline: false, ..Axis::new(self.y, y_title) },
            layers,
            alternative,
        };
        panel.draw("plot")
    }
}
