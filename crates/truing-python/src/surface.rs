//! Nominal surfaces.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use pyo3::prelude::*;
use truing::geometry::{self, AsphereShape, GeometryError, Plane, Polynomial};
use truing::pose_icp::Part;
use truing::probe_comp::{Nominal, Side};

use crate::refusal::Refusal;

/// A surface as drawn, in the workpiece frame.
#[pyclass(frozen, module = "truing", name = "Surface")]
#[derive(Debug)]
pub(crate) struct Surface {
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Asphere(AsphereShape),
    Sphere(geometry::Sphere),
    Plane(Plane),
    Polynomial(Polynomial),
}

impl Surface {
    /// For touches that a pose is fitted to.
    pub(crate) fn part(&self) -> Result<Part, Refusal> {
        Ok(match &self.shape {
            Shape::Asphere(shape) => Part::asphere(shape.clone())?,
            Shape::Sphere(sphere) => Part::freeform(Arc::new(*sphere)),
            Shape::Plane(plane) => Part::freeform(Arc::new(*plane)),
            Shape::Polynomial(polynomial) => Part::freeform(Arc::new(polynomial.clone())),
        })
    }

    /// For touches that are compensated.
    pub(crate) fn nominal(&self, side: Side) -> Result<Nominal, Refusal> {
        Ok(match &self.shape {
            Shape::Asphere(shape) => {
                Nominal::new(Arc::new(geometry::Asphere::new(shape.clone())?), side)
            }
            Shape::Sphere(sphere) => Nominal::sphere(*sphere, side),
            Shape::Plane(plane) => Nominal::new(Arc::new(*plane), side),
            Shape::Polynomial(polynomial) => Nominal::new(Arc::new(polynomial.clone()), side),
        })
    }
}

#[pymethods]
impl Surface {
    /// `z = r²/(R(1 + √(1 − (1 + k) r²/R²))) + A4 r⁴ + A6 r⁶ + …`, vertex at the origin.
    #[staticmethod]
    #[pyo3(signature = (radius_mm, conic=0.0, coefficients=vec![], *, diameter_mm))]
    fn asphere(
        radius_mm: f64,
        conic: f64,
        coefficients: Vec<f64>,
        diameter_mm: f64,
    ) -> Result<Self, Refusal> {
        let shape = AsphereShape::on_axis(radius_mm, conic, coefficients, diameter_mm);
        geometry::Asphere::new(shape.clone())?;
        Ok(Self { shape: Shape::Asphere(shape) })
    }

    /// A sphere; its own side is the outside.
    #[staticmethod]
    #[pyo3(signature = (radius_mm, center_mm=[0.0; 3]))]
    fn sphere(radius_mm: f64, center_mm: [f64; 3]) -> Result<Self, Refusal> {
        let sphere = geometry::Sphere::new(Point3::from(center_mm), radius_mm)?;
        Ok(Self { shape: Shape::Sphere(sphere) })
    }

    /// A plane; its own side is the one that its normal points to.
    #[staticmethod]
    #[pyo3(signature = (point_mm=[0.0; 3], normal=[0.0, 0.0, 1.0]))]
    fn plane(point_mm: [f64; 3], normal: [f64; 3]) -> Result<Self, Refusal> {
        let plane = Plane::new(Point3::from(point_mm), Vector3::from(normal))?;
        Ok(Self { shape: Shape::Plane(plane) })
    }

    /// `z = Σ a (x/unit)^i (y/unit)^j` of terms `(i, j, a)`, a in mm.
    #[staticmethod]
    fn polynomial(unit_mm: f64, terms: Vec<(usize, usize, f64)>) -> Result<Self, Refusal> {
        Ok(Self { shape: Shape::Polynomial(Polynomial::new(unit_mm, terms)?) })
    }

    fn __repr__(&self) -> String {
        format!("{:?}", self.shape)
    }
}

impl From<GeometryError> for Refusal {
    fn from(error: GeometryError) -> Self {
        Self::of(error.to_string())
    }
}
