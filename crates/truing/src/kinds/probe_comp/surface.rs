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
    /// Whether a table holds its heights.
    pub(super) is_grid: bool,
}

pub(super) fn read_surface(
    settings: &SurfaceSettings,
    folder: &Folder,
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<PartSurface, Error> {
    let Drawn { shape, words, .. } = settings.read(folder, document, warnings)?;
    let is_grid = matches!(shape, DrawnShape::Grid(_));
    let surface: Arc<dyn Surface> = match shape {
        DrawnShape::Sphere { sphere, inside } => {
            let side = if inside { Side::Against } else { Side::Along };
            let nominal = Nominal::sphere(sphere, side);
            return Ok(PartSurface { nominal, words, has_own_side: true, is_grid });
        }
        DrawnShape::Asphere(shape) => {
            Arc::new(Asphere::new(shape).map_err(|e| settings.no_surface(document, e))?)
        }
        DrawnShape::Polynomial(surface) => Arc::new(surface),
        DrawnShape::Mesh(surface) => Arc::new(*surface),
        DrawnShape::Grid(surface) => Arc::new(surface),
        DrawnShape::Plane(surface) => Arc::new(surface),
    };
    let nominal = Nominal::new(surface, Side::Along);
    Ok(PartSurface { nominal, words, has_own_side: false, is_grid })
}
