use std::sync::Arc;

use pose_icp::Part;

use crate::Error;
use crate::case::{Document, Folder};
use crate::kinds::surface::{Drawn, DrawnShape, SurfaceSettings};

/// The part, and how to speak of it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) part: Part,
    pub(super) words: String,
    /// Whether a rotation about z may show.
    pub(super) shows_gamma: bool,
    /// Tables that hold the shape.
    pub(super) tables: Vec<&'static str>,
}

pub(super) fn read_surface(
    settings: &SurfaceSettings,
    folder: &Folder,
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<Surface, Error> {
    let drawn = settings.read(folder, document, warnings)?;
    let Drawn { shape, words, reach_mm, form, tables } = drawn;

    let shows_gamma = !matches!(shape, DrawnShape::Asphere(_));
    let part = match shape {
        DrawnShape::Asphere(shape) => {
            Part::asphere(shape).map_err(|e| settings.no_surface(document, e))?
        }
        DrawnShape::Polynomial(surface) => Part::freeform(Arc::new(surface)),
        DrawnShape::Grid(surface) => Part::freeform(Arc::new(surface)),
        DrawnShape::Nurbs(surface) => Part::freeform(surface),
        DrawnShape::Mesh(surface) => Part::mesh(*surface),
        DrawnShape::Sphere { .. } | DrawnShape::Plane(_) => {
            let why = "looks the same from many sides and has no pose; take `asphere`, \
                       `polynomial`, `grid`, `nurbs` or `mesh`, or the kind `probe-comp`";
            return Err(settings.refused(document, why));
        }
    };
    let part = match reach_mm {
        Some(reach_mm) => part.with_form_radius_mm(reach_mm),
        None => part,
    };
    let part = match form {
        Some(form) => part.with_form_map(form.map_mm, form.along),
        None => part,
    };
    Ok(Surface { part, words, shows_gamma, tables })
}
