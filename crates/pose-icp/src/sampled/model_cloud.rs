//! The model as points.

use geometry::{Asphere, GeometryError};
use nalgebra::{Point2, Point3};

/// Where the ball's centre may be: points of the surface, or of the parallel one at the distance
/// of the tip.
#[derive(Clone, Debug)]
pub(super) struct ModelCloud {
    points_mm: Vec<Point3<f64>>,
}

/// Bytes of a point of the model.
pub(super) const POINT_BYTES: usize = size_of::<Point3<f64>>();

impl ModelCloud {
    /// The whole aperture on a square grid.
    pub(super) fn of_disc(
        surface: &Asphere,
        offset_mm: f64,
        spacing_mm: f64,
    ) -> Result<Self, GeometryError> {
        let shape = surface.shape();
        let center_mm = shape.aperture_center_mm;
        let mut cloud = Self { points_mm: Vec::new() };
        cloud.add_square(surface, offset_mm, &center_mm, shape.diameter_mm, spacing_mm)?;
        Ok(cloud)
    }

    /// Squares around the vertical images of points, as far as they lie in the aperture: the
    /// document's mapping along z.
    pub(super) fn around(
        surface: &Asphere,
        offset_mm: f64,
        points_mm: &[Point3<f64>],
        side_mm: f64,
        spacing_mm: f64,
    ) -> Result<Self, GeometryError> {
        let mut cloud = Self { points_mm: Vec::new() };
        for point in points_mm {
            let center_mm = below(surface, offset_mm, &point.xy());
            cloud.add_square(surface, offset_mm, &center_mm, side_mm, spacing_mm)?;
        }
        Ok(cloud)
    }

    /// Points at the middles of the cells into which a square is cut.
    fn add_square(
        &mut self,
        surface: &Asphere,
        offset_mm: f64,
        center_mm: &Point2<f64>,
        side_mm: f64,
        spacing_mm: f64,
    ) -> Result<(), GeometryError> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the caller has bounded the number of points"
        )]
        let cells = (side_mm / spacing_mm).round().max(1.0) as u32;
        let first = -0.5 * spacing_mm * f64::from(cells - 1);
        let along = |i: u32| first + spacing_mm * f64::from(i);
        for i in 0..cells {
            for j in 0..cells {
                let (x, y) = (center_mm.x + along(i), center_mm.y + along(j));
                if surface.contains(x, y) {
                    let on_surface = Point3::new(x, y, surface.sag_mm(x, y)?);
                    let normal = surface.normal(x, y)?;
                    self.points_mm.push(on_surface + normal.into_inner() * offset_mm);
                }
            }
        }
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.points_mm.len()
    }

    /// The nearest of all points, by going through all of them, as published; `None` of none.
    pub(super) fn nearest(&self, query_mm: &Point3<f64>) -> Option<Point3<f64>> {
        let mut best = (f64::INFINITY, None);
        for point in &self.points_mm {
            let square = (point - query_mm).norm_squared();
            if square < best.0 {
                best = (square, Some(*point));
            }
        }
        best.1
    }
}

/// Rounds of looking for the touched point; each gains the ratio of the ball's radius to that of
/// the surface, a digit at least.
const ROUNDS: usize = 6;

/// Where a ball touches whose centre is vertically over or below `center_mm`.
fn below(surface: &Asphere, offset_mm: f64, center_mm: &Point2<f64>) -> Point2<f64> {
    let mut touched = *center_mm;
    for _ in 0..ROUNDS {
        // Beside the aperture there is nothing to sample.
        let Ok(normal) = surface.normal(touched.x, touched.y) else { return touched };
        touched = center_mm - normal.xy() * offset_mm;
    }
    touched
}
