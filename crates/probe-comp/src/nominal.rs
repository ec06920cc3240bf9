use std::sync::Arc;

use geometry::{DeviationAlong, Foot, FormedSurface, GeometryError, HeightGrid, Sphere, Surface};
use nalgebra::{Point3, Unit, Vector3};

/// Side of the surface on which the ball is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// That to which the surface's own normal points: +z for a graph over xy, outside of a sphere.
    #[default]
    Along,
    /// The other one.
    Against,
}

impl Side {
    /// +1 or −1.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Along => 1.0,
            Self::Against => -1.0,
        }
    }
}

/// The part as drawn, in the workpiece frame, seen from the side of the ball.
///
/// Normals point from the part to the ball, distances are positive there, and curvatures are
/// positive where the part is hollow.
#[derive(Clone, Debug)]
pub struct Nominal {
    surface: Arc<dyn Surface>,
    side: Side,
    pub(crate) form: FormFrame,
}

/// In which coordinates the part's errors of form are spoken of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FormFrame {
    /// By direction from a centre.
    Around { center_mm: Point3<f64> },
    /// By place in the xy plane.
    Over,
}

/// Nominal point under a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalFoot {
    /// Closest point of the surface.
    pub point_mm: Point3<f64>,
    /// Unit normal there, towards the ball.
    pub normal: Unit<Vector3<f64>>,
    /// Distance of the query, positive on the ball's side.
    pub distance_mm: f64,
    /// Whether the foot is within the aperture of a surface that has one.
    pub inside_aperture: bool,
}

impl Nominal {
    /// Any surface, touched from one side.
    #[must_use]
    pub fn new(surface: Arc<dyn Surface>, side: Side) -> Self {
        Self { surface, side, form: FormFrame::Over }
    }

    /// A sphere, touched from outside or, as a seat or a ring, from inside ([`Side::Against`]).
    #[must_use]
    pub fn sphere(sphere: Sphere, side: Side) -> Self {
        let form = FormFrame::Around { center_mm: sphere.center_mm() };
        Self { surface: Arc::new(sphere), side, form }
    }

    /// The part with the deviations that were measured of it, over its own x and y: the sum of two
    /// surfaces, along the surface's own normal whichever side is touched.
    #[must_use]
    pub fn with_form_map(self, map_mm: HeightGrid, along: DeviationAlong) -> Self {
        Self { surface: Arc::new(FormedSurface::new(self.surface, map_mm, along)), ..self }
    }

    /// The same part touched from the other side.
    #[must_use]
    pub fn from_side(mut self, side: Side) -> Self {
        self.side = side;
        self
    }

    /// Side on which the ball is.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// The closest point of the surface, seen from the ball.
    ///
    /// # Errors
    ///
    /// As [`Surface::closest_point`].
    pub fn foot(&self, query_mm: &Point3<f64>) -> Result<NominalFoot, GeometryError> {
        let Foot { point_mm, normal, signed_distance_mm, inside_aperture } =
            self.surface.closest_point(query_mm)?;
        let sign = self.side.sign();
        Ok(NominalFoot {
            point_mm,
            normal: Unit::new_unchecked(normal.into_inner() * sign),
            distance_mm: signed_distance_mm * sign,
            inside_aperture,
        })
    }

    /// Whether it is made of flat faces, so that no curvature says how large a ball may be.
    pub(crate) fn is_faceted(&self) -> bool {
        self.surface.is_faceted()
    }

    /// Principal curvatures at a point, the larger first; positive where the part is hollow.
    ///
    /// # Errors
    ///
    /// As [`Surface::curvature`].
    pub fn curvatures_per_mm(&self, point_mm: &Point3<f64>) -> Result<[f64; 2], GeometryError> {
        let curvature = self.surface.curvature(point_mm)?;
        Ok(match self.side {
            Side::Along => [curvature.major_per_mm, curvature.minor_per_mm],
            Side::Against => [-curvature.minor_per_mm, -curvature.major_per_mm],
        })
    }
}
