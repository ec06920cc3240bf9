use geometry::{GeometryError, Nurbs};
use nalgebra::Point3;

/// What a NURBS surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ControlPoints {
    pub(crate) degrees: [usize; 2],
    pub(crate) knots: [Vec<f64>; 2],
    /// In the order of the net, u running fastest.
    pub(crate) points_mm: Vec<Point3<f64>>,
    pub(crate) weights: Vec<f64>,
}

impl ControlPoints {
    /// The surface, its normal in the middle to +z.
    pub(crate) fn surface(&self) -> Result<Nurbs, GeometryError> {
        let surface = Nurbs::new(self.degrees, self.knots.clone(), &self.points_mm, &self.weights)?;
        Ok(if faces_down(&surface) { surface.flipped() } else { surface })
    }
}

/// Whether the normal in the middle points to −z.
pub(crate) fn faces_down(surface: &Nurbs) -> bool {
    let [u, v] = surface.domain().map(|[from, to]| 0.5 * (from + to));
    surface.normal(u, v).is_ok_and(|normal| normal.z < 0.0)
}
