use std::ops::ControlFlow;

use nalgebra::{Matrix2, Point3, Vector2};

use crate::error::finite;
use crate::graph::{self, Graph, Jet};
use crate::univariate::{MAX_DEGREE, Univariate};
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};

/// `z = Σ a (x/unit)^i (y/unit)^j`, without an aperture; its normal points to +z.
///
/// Closest points are those in whose valley the query's own projection along z lies: a surface
/// that folds within the query's distance may have a closer one elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    unit_mm: f64,
    terms: Vec<(usize, usize, f64)>,
    degree: usize,
}

impl Polynomial {
    /// Checks the terms `(i, j, a)`, `a` in mm.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InvalidRadius`] for a unit that is not positive,
    /// [`GeometryError::DegreeTooHigh`], [`GeometryError::NonFinite`].
    pub fn new(
        unit_mm: f64,
        terms: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self, GeometryError> {
        finite([&unit_mm], "unit of the polynomial")?;
        if unit_mm <= 0.0 {
            return Err(GeometryError::InvalidRadius { radius_mm: unit_mm });
        }
        let terms: Vec<_> = terms.into_iter().collect();
        finite(terms.iter().map(|(_, _, a)| a), "coefficient of the polynomial")?;
        let degree = terms.iter().map(|(i, j, _)| i.saturating_add(*j)).max().unwrap_or(0);
        if degree > MAX_DEGREE {
            return Err(GeometryError::DegreeTooHigh { degree, limit: MAX_DEGREE });
        }
        Ok(Self { unit_mm, terms, degree })
    }

    /// Height over the xy plane.
    #[must_use]
    pub fn sag_mm(&self, x_mm: f64, y_mm: f64) -> f64 {
        self.jet(x_mm, y_mm).z
    }

    /// `(∂z/∂x, ∂z/∂y)`.
    #[must_use]
    pub fn gradient(&self, x_mm: f64, y_mm: f64) -> Vector2<f64> {
        self.jet(x_mm, y_mm).gradient
    }

    /// Points at which the line meets the surface, ascending, in units of length along the line.
    fn meetings(&self, line: &Line) -> Result<Univariate, GeometryError> {
        finite(line.point_mm.iter(), "point of the line")?;
        let unit = self.unit_mm;
        let along = |k: usize| [line.point_mm[k] / unit, line.direction[k]];
        let (xs, ys) = (Univariate::powers(along(0)), Univariate::powers(along(1)));
        let mut gap = Univariate::linear([line.point_mm.z, line.direction.z * unit]);
        for &(i, j, a) in &self.terms {
            gap.subtract_product(&xs[i], &ys[j], a);
        }
        gap.trimmed(self.degree).ok_or(GeometryError::LineInSurface)
    }
}

impl Graph for Polynomial {
    fn jet(&self, x_mm: f64, y_mm: f64) -> Jet {
        let (xs, ys) = (powers(x_mm / self.unit_mm), powers(y_mm / self.unit_mm));
        let mut jet = Jet { z: 0.0, gradient: Vector2::zeros(), hessian: Matrix2::zeros() };
        for &(i, j, a) in &self.terms {
            let [x, dx, ddx] = derivatives(&xs, i);
            let [y, dy, ddy] = derivatives(&ys, j);
            jet.z += a * x * y;
            jet.gradient += Vector2::new(dx * y, x * dy) * a;
            jet.hessian += Matrix2::new(ddx * y, dx * dy, dx * dy, x * ddy) * a;
        }
        jet.gradient /= self.unit_mm;
        jet.hessian /= self.unit_mm * self.unit_mm;
        jet
    }

    fn contains(&self, _x: f64, _y: f64) -> bool {
        true
    }

    fn each_hit(
        &self,
        line: &Line,
        visit: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> Result<(), GeometryError> {
        let mut any = false;
        self.meetings(line)?.each_root(&mut |root| {
            any = true;
            visit(graph::hit(self, line, root * self.unit_mm))
        });
        if any { Ok(()) } else { Err(GeometryError::Misses) }
    }
}

impl Surface for Polynomial {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        finite([&query_mm.coords.norm_squared()], "query point")?;
        graph::foot(self, query_mm)
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        graph::curvature(self, point_mm)
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        graph::hits(self, line)
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        graph::first_hit(self, ray)
    }
}

fn powers(t: f64) -> [f64; MAX_DEGREE + 1] {
    let mut powers = [1.0; MAX_DEGREE + 1];
    for k in 1..=MAX_DEGREE {
        powers[k] = powers[k - 1] * t;
    }
    powers
}

/// `t^k` and its first two derivatives.
#[expect(clippy::cast_precision_loss, reason = "exponents are below 25")]
fn derivatives(powers: &[f64; MAX_DEGREE + 1], k: usize) -> [f64; 3] {
    let n = k as f64;
    let first = if k > 0 { n * powers[k - 1] } else { 0.0 };
    let second = if k > 1 { n * (n - 1.0) * powers[k - 2] } else { 0.0 };
    [powers[k], first, second]
}
