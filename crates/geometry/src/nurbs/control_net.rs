//! Knots and control points of a surface.

use nalgebra::Vector4;

use super::knots::Knots;

/// What a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ControlNet {
    pub(super) knots: [Knots; 2],
    /// Control points times weight, and weight; u running fastest.
    pub(super) points: Vec<Vector4<f64>>,
}

impl ControlNet {
    /// A control point of a span, `a` and `b` from its first.
    pub(super) fn control(&self, spans: [usize; 2], a: usize, b: usize) -> &Vector4<f64> {
        let i = spans[0] - self.knots[0].degree + a;
        let j = spans[1] - self.knots[1].degree + b;
        &self.points[i + j * self.knots[0].count()]
    }
}
