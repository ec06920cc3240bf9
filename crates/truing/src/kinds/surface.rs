//! `[surface]`: the part as drawn, for every kind that touches one.

mod even_places;
mod form_map;
mod grid;
mod mistakes;
mod nurbs;

use std::sync::Arc;

use geometry::{AsphereShape, GeometryError, HeightGrid, Nurbs, Plane, Polynomial, Sphere};
use nalgebra::{Point2, Point3, Vector3};
use pose_icp::{Holes, MeshSurface};
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Document, Finite, Folder, Positive, Problem, quote};
use crate::shape::{Format, Shape};

/// `[surface]`; which keys are needed depends on the shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceSettings {
    shape: Spanned<ShapeName>,
    radius_mm: Option<Finite>,
    conic: Option<Finite>,
    coefficients: Option<Vec<Finite>>,
    diameter_mm: Option<Positive>,
    aperture_center_mm: Option<[Finite; 2]>,
    unit_mm: Option<Positive>,
    terms: Option<Vec<(u8, u8, Finite)>>,
    file: Option<String>,
    degree: Option<Spanned<[u8; 2]>>,
    knots_u: Option<Spanned<Vec<Finite>>>,
    knots_v: Option<Spanned<Vec<Finite>>>,
    center_mm: Option<[Finite; 3]>,
    side: Option<SideName>,
    point_mm: Option<[Finite; 3]>,
    normal: Option<[Finite; 3]>,
    form: Option<Spanned<FormMapSettings>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Asphere,
    Polynomial,
    Mesh,
    Grid,
    Nurbs,
    Sphere,
    Plane,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SideName {
    Outside,
    Inside,
}

/// The part, and how to speak of it.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) shape: DrawnShape,
    pub(crate) words: String,
    /// How far from the z axis the drawing reaches, where it has no diameter.
    pub(crate) reach_mm: Option<f64>,
    /// What was measured of it, unless the shape holds it already.
    pub(crate) form: Option<FormMap>,
    /// Tables that hold shape and map.
    pub(crate) tables: Vec<&'static str>,
}

impl Drawn {
    /// A shape out of `case.toml` alone.
    fn of(shape: DrawnShape, words: String, reach_mm: Option<f64>) -> Self {
        Self { shape, words, reach_mm, form: None, tables: Vec::new() }
    }
}

/// What is drawn.
#[derive(Debug)]
pub(crate) enum DrawnShape {
    Asphere(AsphereShape),
    Polynomial(Polynomial),
    Mesh(Box<MeshSurface>),
    /// Heights in a table.
    Grid(HeightGrid),
    /// Control points in a table.
    Nurbs(Arc<Nurbs>),
    Sphere {
        sphere: Sphere,
        inside: bool,
    },
    Plane(Plane),
}

pub(crate) use form_map::FormMap;
use form_map::{FORM, FormMapSettings};
pub(crate) use mistakes::{
    TYPED, XYZ, mistakes_of_drawing, mistakes_of_points, mistakes_of_rows, yardstick_of,
};

/// z component of a plane's normal below which x and y are no coordinates of its places.
const LEAST_UPRIGHT: f64 = 0.1;

impl ShapeName {
    fn name(self) -> &'static str {
        match self {
            Self::Asphere => "asphere",
            Self::Polynomial => "polynomial",
            Self::Mesh => "mesh",
            Self::Grid => "grid",
            Self::Nurbs => "nurbs",
            Self::Sphere => "sphere",
            Self::Plane => "plane",
        }
    }

    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Asphere => {
                &["radius_mm", "conic", "coefficients", "diameter_mm", "aperture_center_mm"]
            }
            Self::Polynomial => &["unit_mm", "terms"],
            Self::Mesh => &["file", "unit_mm"],
            Self::Grid => &[],
            Self::Nurbs => &["degree", "knots_u", "knots_v"],
            Self::Sphere => &["radius_mm", "center_mm", "side"],
            Self::Plane => &["point_mm", "normal"],
        }
    }
}

impl SurfaceSettings {
    pub(crate) fn read(
        &self,
        folder: &Folder,
        document: &Document,
        warnings: &mut Vec<String>,
    ) -> Result<Drawn, Error> {
        let shape = *self.shape.get_ref();
        let unused = self.given().into_iter().filter(|key| !shape.keys().contains(key));
        warnings.extend(
            unused
                .map(|key| format!("`[surface] {key}` is not used with shape `{}`", shape.name())),
        );
        let form = self.form.as_ref().map(|form| form.get_ref().read(folder)).transpose()?;
        let mut drawn = match shape {
            ShapeName::Asphere => self.asphere(document)?,
            ShapeName::Polynomial => self.polynomial(document)?,
            ShapeName::Mesh => self.mesh(folder, document, form.as_ref())?,
            ShapeName::Grid => grid::grid(folder)?,
            ShapeName::Nurbs => self.nurbs(folder, document)?,
            ShapeName::Plane => self.plane(document)?,
            ShapeName::Sphere => self.sphere(document)?,
        };
        if let Some(form) = form {
            self.check_form(&drawn, document)?;
            drawn.words = format!("{}, with {}", drawn.words, form.words);
            drawn.tables.push(FORM);
            // A mesh is moved already.
            drawn.form = Some(form).filter(|_| shape != ShapeName::Mesh);
        }
        Ok(drawn)
    }

    /// Whether a map over x and y can belong to the shape.
    fn check_form(&self, drawn: &Drawn, document: &Document) -> Result<(), Error> {
        let why = match &drawn.shape {
            DrawnShape::Sphere { .. } => {
                "over x and y a sphere is there twice; draw the part as an asphere"
            }
            DrawnShape::Plane(plane) if plane.normal().z.abs() < LEAST_UPRIGHT => {
                "the plane stands upright, so that x and y hardly tell its places apart; turn the \
                 coordinates of the part"
            }
            _ => return Ok(()),
        };
        let at = self.form.as_ref().map_or(self.shape.span(), Spanned::span);
        let message = format!("[surface.form]: {why}");
        Err(Error::case(document.at(&at), Problem::WrongValue { message }))
    }

    /// The shape is not one for this kind of case.
    pub(crate) fn refused(&self, document: &Document, why: &str) -> Error {
        let message = format!("[surface] shape `{}`: {why}", self.shape.get_ref().name());
        Error::case(document.at(&self.shape.span()), Problem::WrongValue { message })
    }

    /// Keys that are there.
    fn given(&self) -> Vec<&'static str> {
        let keys = [
            ("radius_mm", self.radius_mm.is_some()),
            ("conic", self.conic.is_some()),
            ("coefficients", self.coefficients.is_some()),
            ("diameter_mm", self.diameter_mm.is_some()),
            ("aperture_center_mm", self.aperture_center_mm.is_some()),
            ("unit_mm", self.unit_mm.is_some()),
            ("terms", self.terms.is_some()),
            ("file", self.file.is_some()),
            ("degree", self.degree.is_some()),
            ("knots_u", self.knots_u.is_some()),
            ("knots_v", self.knots_v.is_some()),
            ("center_mm", self.center_mm.is_some()),
            ("side", self.side.is_some()),
            ("point_mm", self.point_mm.is_some()),
            ("normal", self.normal.is_some()),
        ];
        keys.into_iter().filter(|(_, is_given)| *is_given).map(|(key, _)| key).collect()
    }

    pub(super) fn missing(&self, document: &Document, key: &str, purpose: &'static str) -> Error {
        let key = format!("[surface] {key}");
        Error::case(document.at(&self.shape.span()), Problem::MissingKey { key, purpose })
    }

    /// The numbers given make no surface.
    pub(crate) fn no_surface(&self, document: &Document, source: GeometryError) -> Error {
        let message = format!("[surface]: {source}");
        Error::case(document.at(&self.shape.span()), Problem::WrongValue { message })
    }

    fn sphere(&self, document: &Document) -> Result<Drawn, Error> {
        let Finite(radius_mm) = self
            .radius_mm
            .ok_or_else(|| self.missing(document, "radius_mm", "the radius of the sphere"))?;
        let [x, y, z] = self.center_mm.unwrap_or([Finite(0.0); 3]).map(|Finite(v)| v);
        let sphere = Sphere::new(Point3::new(x, y, z), radius_mm)
            .map_err(|e| self.no_surface(document, e))?;
        let inside = self.side == Some(SideName::Inside);
        let side = if inside { "inside" } else { "outside" };
        let words = format!(
            "sphere of radius {radius_mm} mm about ({x}, {y}, {z}) mm, touched from {side}"
        );
        Ok(Drawn::of(DrawnShape::Sphere { sphere, inside }, words, None))
    }

    fn plane(&self, document: &Document) -> Result<Drawn, Error> {
        let [x, y, z] = self.point_mm.unwrap_or([Finite(0.0); 3]).map(|Finite(v)| v);
        let up = [Finite(0.0), Finite(0.0), Finite(1.0)];
        let [nx, ny, nz] = self.normal.unwrap_or(up).map(|Finite(v)| v);
        let plane = Plane::new(Point3::new(x, y, z), Vector3::new(nx, ny, nz))
            .map_err(|e| self.no_surface(document, e))?;
        let words = format!("plane through ({x}, {y}, {z}) mm, normal ({nx}, {ny}, {nz})");
        Ok(Drawn::of(DrawnShape::Plane(plane), words, None))
    }

    fn mesh(
        &self,
        folder: &Folder,
        document: &Document,
        form: Option<&FormMap>,
    ) -> Result<Drawn, Error> {
        let file = self.file.as_deref().ok_or_else(|| {
            self.missing(document, "file", "the mesh, a .stl, .ply or .obj beside `case.toml`")
        })?;
        let at = document.at(&self.shape.span());
        let path = folder.location(file).file;
        let fail = |problem| Error::Shape { path: path.clone(), problem };
        let format = Format::of(&path).map_err(fail)?;
        let bytes = folder.named(file, at.clone())?;
        let Shape::Mesh(mut mesh) = format.parse(&bytes).map_err(fail)? else {
            let message = format!("[surface] file: {} holds points, not triangles", quote(file));
            return Err(Error::case(at, Problem::WrongValue { message }));
        };
        // No mesh format says its unit.
        if let Some(Positive(unit_mm)) = self.unit_mm {
            mesh.vertices_mm.iter_mut().for_each(|vertex| vertex.coords *= unit_mm);
        }
        let words = format!("mesh of {} triangles", mesh.faces.len());
        let mesh = match form {
            Some(form) => form.on_mesh(&mesh).ok_or_else(|| {
                let message = "[surface.form]: its spacing divides the mesh into more than four \
                               million triangles; take a coarser map or a smaller mesh";
                let at = self.form.as_ref().map_or(self.shape.span(), Spanned::span);
                Error::case(document.at(&at), Problem::WrongValue { message: message.to_owned() })
            })?,
            None => mesh,
        };
        let surface = MeshSurface::new(&mesh, Holes::Refuse)
            .map_err(|source| Error::Register { path, source: Box::new(source) })?;
        let reach_mm = mesh.vertices_mm.iter().map(|v| v.coords.xy().norm()).reduce(f64::max);
        Ok(Drawn::of(DrawnShape::Mesh(Box::new(surface)), words, reach_mm))
    }

    fn polynomial(&self, document: &Document) -> Result<Drawn, Error> {
        let Positive(unit_mm) = self.unit_mm.ok_or_else(|| {
            self.missing(document, "unit_mm", "the length by which x and y are divided")
        })?;
        let terms = self.terms.as_deref().filter(|terms| !terms.is_empty()).ok_or_else(|| {
            self.missing(document, "terms", "the terms, `[[i, j, a], …]`, a in mm")
        })?;
        let terms = terms.iter().map(|(i, j, Finite(a))| (usize::from(*i), usize::from(*j), *a));
        let words = format!("polynomial of {} terms in units of {unit_mm} mm", terms.len());
        let surface = Polynomial::new(unit_mm, terms).map_err(|e| self.no_surface(document, e))?;
        Ok(Drawn::of(DrawnShape::Polynomial(surface), words, Some(unit_mm)))
    }

    fn asphere(&self, document: &Document) -> Result<Drawn, Error> {
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
        let aperture_center_mm = Point2::new(x, y);
        let shape =
            AsphereShape { radius_mm, conic, coefficients, diameter_mm, aperture_center_mm };
        Ok(Drawn::of(DrawnShape::Asphere(shape), words, None))
    }
}
