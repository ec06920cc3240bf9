use std::sync::Arc;

use geometry::{
    Asphere, AsphereShape, DeviationAlong, Foot, FormedSurface, GeometryError, HeightGrid, Surface,
};

use crate::MeshSurface;

/// How far past the rim feet are sought during a search, as a share of the aperture.
///
/// The search may leave the aperture where tilt and decentre are hardly told apart; what it ends
/// with is checked against the aperture itself.
const SEARCH_RATIO: f64 = 2.0;
/// The search's own aperture stays this far inside the end of the conic.
const CONIC_SHARE: f64 = 0.95;

/// The part as drawn: its surface, in the workpiece frame.
#[derive(Clone, Debug)]
pub struct Part {
    surface: Arc<dyn Surface>,
    shape: Option<AsphereShape>,
    /// Point about which a rotation hardly changes the surface, on the z axis.
    pivot_mm: f64,
    /// Whether the surface has edges, where the distance has no derivative.
    has_edges: bool,
    /// Distance from the axis at which heights of errors of form count, where it is given.
    form_radius_mm: Option<f64>,
    /// Whether the surface is the drawn one with a measured map of its deviations.
    has_form_map: bool,
}

impl Part {
    /// A surface of revolution; its rotation γ is not visible and has to be held.
    ///
    /// # Errors
    ///
    /// As [`Asphere::new`].
    pub fn asphere(shape: AsphereShape) -> Result<Self, GeometryError> {
        let exact = Asphere::new(shape.clone())?;
        let pivot_mm = if flat(&shape) { 0.0 } else { shape.radius_mm };
        let surface: Arc<dyn Surface> = match Asphere::new(widened(&shape)) {
            Ok(wide) => Arc::new(wide),
            // The polynomial part overflows past the rim: the exact one has a margin of its own.
            Err(_) => Arc::new(exact),
        };
        Ok(Self { shape: Some(shape), pivot_mm, ..Self::freeform(surface) })
    }

    /// Any other smooth surface.
    #[must_use]
    pub fn freeform(surface: Arc<dyn Surface>) -> Self {
        Self {
            surface,
            shape: None,
            pivot_mm: 0.0,
            has_edges: false,
            form_radius_mm: None,
            has_form_map: false,
        }
    }

    /// The part with the deviations that were measured of it, over its own x and y: the sum of two
    /// surfaces. A mesh is moved corner by corner instead ([`TriangleMesh::formed`]).
    ///
    /// Errors of form that the loop looks for are then errors beside the map.
    ///
    /// [`TriangleMesh::formed`]: crate::TriangleMesh::formed
    #[must_use]
    pub fn with_form_map(self, map_mm: HeightGrid, along: DeviationAlong) -> Self {
        let surface = Arc::new(FormedSurface::new(self.surface.clone(), map_mm, along));
        Self { surface, has_form_map: true, ..self }
    }

    /// A mesh; the pose is good to what its facets leave.
    #[must_use]
    pub fn mesh(surface: MeshSurface) -> Self {
        Self { has_edges: true, ..Self::freeform(Arc::new(surface)) }
    }

    /// Heights of the loop's errors of form count at `radius_mm` from the axis, rather than at the
    /// outermost touch; an asphere has its rim for that.
    #[must_use]
    pub fn with_form_radius_mm(self, radius_mm: f64) -> Self {
        let form_radius_mm = Some(radius_mm).filter(|r| r.is_finite() && *r > 0.0);
        Self { form_radius_mm, ..self }
    }

    /// The asphere it was made from, if it was.
    #[must_use]
    pub fn shape(&self) -> Option<&AsphereShape> {
        self.shape.as_ref()
    }

    /// The surface, beyond the rim too.
    #[must_use]
    pub fn surface(&self) -> &dyn Surface {
        &*self.surface
    }

    /// Whether a foot is on the part itself, its rim included.
    pub(crate) fn contains(&self, foot: &Foot) -> bool {
        self.shape.as_ref().map_or(foot.inside_aperture, |shape| {
            let off_mm = (foot.point_mm.xy() - shape.aperture_center_mm).norm();
            off_mm <= 0.5 * shape.diameter_mm * (1.0 + RIM_SHARE) && !self.is_beside_map(foot)
        })
    }

    /// Whether a foot lies where the map of deviations was not measured.
    pub(crate) fn is_beside_map(&self, foot: &Foot) -> bool {
        // The aperture of the surface itself is wider than the part's.
        self.has_form_map && !foot.inside_aperture
    }

    /// Whether the surface is the drawn one with a measured map of its deviations.
    #[must_use]
    pub fn has_form_map(&self) -> bool {
        self.has_form_map
    }

    /// Whether a search may end where every step goes uphill although the derivative promises less.
    pub(crate) fn has_edges(&self) -> bool {
        self.has_edges
    }

    /// Radius by which surface forms are normalised: the part's own, the one given, or that of the
    /// contacts.
    pub(crate) fn form_radius_mm(&self, contacts: &[Foot]) -> f64 {
        let reach = |foot: &Foot| foot.point_mm.coords.xy().norm();
        match &self.shape {
            Some(shape) => shape.aperture_center_mm.coords.norm() + 0.5 * shape.diameter_mm,
            None => self
                .form_radius_mm
                .unwrap_or_else(|| contacts.iter().map(reach).fold(f64::MIN_POSITIVE, f64::max)),
        }
    }

    /// Height on the z axis of the point about which tilting hardly changes the surface.
    pub(crate) fn pivot_mm(&self) -> f64 {
        self.pivot_mm
    }
}

/// A touch on the rim is inside, whatever round-off does to it.
const RIM_SHARE: f64 = 1e-9;
/// Beyond this many diameters the vertex radius is no useful lever arm.
const FLAT_DIAMETERS: f64 = 1e4;

fn flat(shape: &AsphereShape) -> bool {
    shape.radius_mm.abs() > FLAT_DIAMETERS * shape.diameter_mm
}

fn widened(shape: &AsphereShape) -> AsphereShape {
    let off_mm = shape.aperture_center_mm.coords.norm();
    let curvature = shape.radius_mm.recip();
    let squeeze = (1.0 + shape.conic) * curvature * curvature;
    let limit_mm = if squeeze > 0.0 { squeeze.sqrt().recip() } else { f64::INFINITY };
    let room_mm = 2.0 * (CONIC_SHARE * limit_mm - off_mm);
    let diameter_mm = (SEARCH_RATIO * shape.diameter_mm).min(room_mm).max(shape.diameter_mm);
    AsphereShape { diameter_mm, ..shape.clone() }
}
