use std::sync::Arc;

use geometry::{Asphere, Surface};
use probe_comp::{Nominal, Side};

use crate::Error;
use crate::case::{Document, Folder};
use crate::kinds::surface::{Drawn, DrawnShape, SurfaceSettings};

/// The part, and how to speak of it.
#[derive(Clone, Debug)]
pub(super) struct PartSurface {
    pub(super) nominal: Nominal,
    pub(super) words: String,
    /// Whether `[surface]` itself says on which side the ball is.
    pub(super) has_own_side: bool,
    /// Tables that hold the shape.
    pub(super) tables: Vec<&'static str>,
}

pub(super) fn read_surface(
    settings: &SurfaceSettings,
    folder: &Folder,
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<PartSurface, Error> {
    let drawn = settings.read(folder, document, warnings)?;
    let Drawn { shape, words, form, tables, .. } = drawn;
    let surface: Arc<dyn Surface> = match shape {
        DrawnShape::Sphere { sphere, inside } => {
            let side = if inside { Side::Against } else { Side::Along };
            let nominal = Nominal::sphere(sphere, side);
            return Ok(PartSurface { nominal, words, has_own_side: true, tables });
        }
        DrawnShape::Asphere(shape) => {
            Arc::new(Asphere::new(shape).map_err(|e| settings.no_surface(document, e))?)
        }
        DrawnShape::Polynomial(surface) => Arc::new(surface),
        DrawnShape::Mesh(surface) => Arc::new(*surface),
        DrawnShape::Grid(surface) => Arc::new(surface),
        DrawnShape::Nurbs(surface) => surface,
        DrawnShape::Plane(surface) => Arc::new(surface),
    };
    let nominal = Nominal::new(surface, Side::Along);
    let nominal = match form {
        Some(form) => nominal.with_form_map(form.map_mm, form.along),
        None => nominal,
    };
    Ok(PartSurface { nominal, words, has_own_side: false, tables })
}
