use std::sync::Arc;

use geometry::{AsphereShape, GeometryError, Polynomial};
use nalgebra::Point2;
use pose_icp::{Holes, MeshSurface, Part};
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Document, Finite, Folder, Positive, Problem, quote};
use crate::shape::{Shape, read_shape};

/// `[surface]`; which keys are needed depends on the shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceSettings {
    shape: Spanned<ShapeName>,
    radius_mm: Option<Finite>,
    conic: Option<Finite>,
    coefficients: Option<Vec<Finite>>,
    diameter_mm: Option<Positive>,
    aperture_center_mm: Option<[Finite; 2]>,
    unit_mm: Option<Positive>,
    terms: Option<Vec<(u8, u8, Finite)>>,
    file: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Asphere,
    Polynomial,
    Mesh,
}

/// The part, and how to speak of it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) part: Part,
    pub(super) words: String,
    /// Whether a rotation about z may show.
    pub(super) shows_gamma: bool,
}

impl SurfaceSettings {
    pub(super) fn read(
        &self,
        folder: &Folder,
        document: &Document,
        warnings: &mut Vec<String>,
    ) -> Result<Surface, Error> {
        let of_asphere = [
            ("radius_mm", self.radius_mm.is_some()),
            ("conic", self.conic.is_some()),
            ("coefficients", self.coefficients.is_some()),
            ("diameter_mm", self.diameter_mm.is_some()),
            ("aperture_center_mm", self.aperture_center_mm.is_some()),
        ];
        let of_polynomial = [("unit_mm", self.unit_mm.is_some()), ("terms", self.terms.is_some())];
        let of_mesh = [("file", self.file.is_some())];
        let mut unused = |keys: &[(&str, bool)], shape: &str| {
            let set = keys.iter().filter(|(_, is_set)| *is_set);
            warnings.extend(
                set.map(|(key, _)| format!("`[surface] {key}` is not used with shape `{shape}`")),
            );
        };
        match self.shape.get_ref() {
            ShapeName::Asphere => {
                unused(&of_polynomial, "asphere");
                unused(&of_mesh, "asphere");
                self.asphere(document)
            }
            ShapeName::Polynomial => {
                unused(&of_asphere, "polynomial");
                unused(&of_mesh, "polynomial");
                self.polynomial(document)
            }
            ShapeName::Mesh => {
                unused(&of_asphere, "mesh");
                unused(&of_polynomial, "mesh");
                self.mesh(folder, document)
            }
        }
    }

    fn missing(&self, document: &Document, key: &str, purpose: &'static str) -> Error {
        let key = format!("[surface] {key}");
        Error::case(document.at(&self.shape.span()), Problem::MissingKey { key, purpose })
    }

    fn no_surface(&self, document: &Document, source: GeometryError) -> Error {
        let message = format!("[surface]: {source}");
        Error::case(document.at(&self.shape.span()), Problem::WrongValue { message })
    }

    fn mesh(&self, folder: &Folder, document: &Document) -> Result<Surface, Error> {
        let file = self.file.as_deref().ok_or_else(|| {
            self.missing(document, "file", "the mesh, a .stl, .ply or .obj beside `case.toml`")
        })?;
        let path = folder.location(file).file;
        let Shape::Mesh(mesh) = read_shape(&path)? else {
            let message = format!("[surface] file: {} holds points, not triangles", quote(file));
            let at = document.at(&self.shape.span());
            return Err(Error::case(at, Problem::WrongValue { message }));
        };
        let words = format!("mesh of {} triangles", mesh.faces.len());
        let surface = MeshSurface::new(&mesh, Holes::Refuse)
            .map_err(|source| Error::Register { path, source: Box::new(source) })?;
        Ok(Surface { part: Part::mesh(surface), words, shows_gamma: true })
    }

    fn polynomial(&self, document: &Document) -> Result<Surface, Error> {
        let Positive(unit_mm) = self.unit_mm.ok_or_else(|| {
            self.missing(document, "unit_mm", "the length by which x and y are divided")
        })?;
        let terms = self.terms.as_deref().filter(|terms| !terms.is_empty()).ok_or_else(|| {
            self.missing(document, "terms", "the terms, `[[i, j, a], …]`, a in mm")
        })?;
        let terms = terms.iter().map(|(i, j, Finite(a))| (usize::from(*i), usize::from(*j), *a));
        let words = format!("polynomial of {} terms in units of {unit_mm} mm", terms.len());
        let surface = Polynomial::new(unit_mm, terms).map_err(|e| self.no_surface(document, e))?;
        Ok(Surface { part: Part::freeform(Arc::new(surface)), words, shows_gamma: true })
    }

    fn asphere(&self, document: &Document) -> Result<Surface, Error> {
        let Finite(radius_mm) = self.radius_mm.ok_or_else(|| {
            self.missing(document, "radius_mm", "the vertex radius, positive for a bowl")
        })?;
        let Positive(diameter_mm) = self
            .diameter_mm
            .ok_or_else(|| self.missing(document, "diameter_mm", "the part's diameter"))?;
        let Finite(conic) = self.conic.unwrap_or(Finite(0.0));
        let coefficients: Vec<f64> =
            self.coefficients.iter().flatten().map(|Finite(a)| *a).collect();
        let [Finite(x), Finite(y)] = self.aperture_center_mm.unwrap_or([Finite(0.0), Finite(0.0)]);
        let words = format!(
            "asphere, R = {radius_mm} mm, k = {conic}, diameter {diameter_mm} mm{}",
            if coefficients.is_empty() { "" } else { ", with even terms" }
        );
        let shape = AsphereShape {
            radius_mm,
            conic,
            coefficients,
            diameter_mm,
            aperture_center_mm: Point2::new(x, y),
        };
        let part = Part::asphere(shape).map_err(|e| self.no_surface(document, e))?;
        Ok(Surface { part, words, shows_gamma: false })
    }
}
