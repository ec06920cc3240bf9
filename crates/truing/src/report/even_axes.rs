//! Axes of a map.

use super::axis::Range;

/// Axes on which a millimetre is as long one way as the other, and the drawing's height.
///
/// `margin` is left free around the field, `above` more at its top.
pub(crate) fn even_axes(
    field: (Range, Range),
    (margin, above): (f64, f64),
    width: f64,
) -> (Range, Range, f64) {
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
    (centred(x, plot_width), centred(y, plot_height), plot_height + frame)
}
