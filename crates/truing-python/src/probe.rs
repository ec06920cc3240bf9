//! Where a ball touched.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::{Point2, Point3, Unit, Vector3};
use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use truing::probe_comp::{self, BallTouch, Contact, NormalSource, Side};

use crate::arrays::{Table, column, rows, rows_of, std_of_each, table};
use crate::refusal::Refusal;
use crate::surface::Surface;

/// Contacts of a ball, one for each touch.
#[pyfunction]
#[pyo3(signature = (surface, centers_mm, std_mm, tip_radius_mm, against, normal, approach, guide_mm))]
pub(crate) fn compensate<'py>(
    py: Python<'py>,
    surface: PyRef<'py, Surface>,
    centers_mm: Table<'py>,
    std_mm: PyReadonlyArrayDyn<'py, f64>,
    tip_radius_mm: f64,
    against: bool,
    normal: &str,
    approach: Option<Table<'py>>,
    guide_mm: Option<Table<'py>>,
) -> PyResult<Bound<'py, PyDict>> {
    let nominal = surface.nominal(if against { Side::Against } else { Side::Along })?;
    let source = match normal {
        "nominal" => NormalSource::Nominal,
        "approach" => NormalSource::Approach,
        "surface-fit" => NormalSource::SurfaceFit,
        found => {
            let known = ["nominal", "approach", "surface-fit"];
            return Err(Refusal::word("normal", found, &known).into());
        }
    };
    let centers = rows::<3>("centers_mm", &centers_mm)?;
    let n = centers.len();
    let std_mm = std_of_each("std_mm", &std_mm, n)?;
    let approach = approach.as_ref().map(|a| rows_of::<3>("approach", a, n)).transpose()?;
    let guide_mm = guide_mm.as_ref().map(|g| rows_of::<2>("guide_mm", g, n)).transpose()?;
    let directions = |rows: Cow<'_, [[f64; 3]]>| -> Result<Vec<_>, Refusal> {
        rows.iter().enumerate().map(|(i, row)| direction(i, *row)).collect()
    };
    let approach = approach.map(directions).transpose()?;
    let touch = |i: usize| {
        let mut touch = BallTouch::new(Point3::from(centers[i]), std_mm.of(i));
        touch.approach = approach.as_ref().map(|a| a[i]);
        touch.guide_mm = guide_mm.as_ref().map(|g| Point2::from(g[i]));
        touch
    };
    let mut found = Columns::of(n, guide_mm.is_some());
    let some = |part: Part<'_>| -> Result<(), Refusal> {
        let touches: Vec<BallTouch> = part.touches.clone().map(touch).collect();
        part.fill(&probe_comp::compensate(&nominal, tip_radius_mm, &touches, source)?);
        Ok(())
    };
    let done: Result<(), Refusal> = py.detach(|| {
        // A surface through all touches needs all of them.
        if source == NormalSource::SurfaceFit {
            return found.parts(n).into_iter().try_for_each(some);
        }
        let each: Result<(), Refusal> = found.parts(STRETCH).into_par_iter().map(some).collect();
        // An error counts touches from the first one on.
        each.or_else(|_| found.parts(n).into_iter().try_for_each(some))
    });
    done?;
    found.into_answer(py)
}

/// Touches whose records and contacts, some 400 bytes a touch, stay near to a core until they are columns.
const STRETCH: usize = 256;

fn direction(index: usize, approach: [f64; 3]) -> Result<Unit<Vector3<f64>>, Refusal> {
    let direction = Unit::try_new(Vector3::from(approach), 0.0);
    direction
        .filter(|d| d.iter().all(|v| v.is_finite()))
        .ok_or_else(|| Refusal::of(format!("approach of touch {} has no direction", index + 1)))
}

/// What is told of all contacts.
#[derive(Debug)]
struct Columns {
    points_mm: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    deviation_mm: Vec<f64>,
    deviation_std_mm: Vec<f64>,
    inside_aperture: Vec<bool>,
    /// Empty where no point was planned.
    error_mm: Vec<[f64; 3]>,
    /// Whether points were planned, also where there is no touch.
    planned: bool,
}

/// The place in the columns of touches that follow one another.
#[derive(Debug)]
struct Part<'a> {
    touches: Range<usize>,
    points_mm: &'a mut [[f64; 3]],
    normals: &'a mut [[f64; 3]],
    deviation_mm: &'a mut [f64],
    deviation_std_mm: &'a mut [f64],
    inside_aperture: &'a mut [bool],
    error_mm: &'a mut [[f64; 3]],
}

impl Columns {
    /// Room for `n` contacts.
    fn of(n: usize, planned: bool) -> Self {
        Self {
            points_mm: vec![[0.0; 3]; n],
            normals: vec![[0.0; 3]; n],
            deviation_mm: vec![0.0; n],
            deviation_std_mm: vec![0.0; n],
            inside_aperture: vec![false; n],
            error_mm: vec![[0.0; 3]; if planned { n } else { 0 }],
            planned,
        }
    }

    /// All columns, cut after every `length` touches; one empty part where there are none.
    fn parts(&mut self, length: usize) -> Vec<Part<'_>> {
        let n = self.deviation_mm.len();
        let mut rest = Part {
            touches: 0..n,
            points_mm: &mut self.points_mm,
            normals: &mut self.normals,
            deviation_mm: &mut self.deviation_mm,
            deviation_std_mm: &mut self.deviation_std_mm,
            inside_aperture: &mut self.inside_aperture,
            error_mm: &mut self.error_mm,
        };
        let mut parts = Vec::with_capacity(n / length.max(1) + 1);
        while rest.touches.len() > length {
            let (first, others) = rest.split(length);
            parts.push(first);
            rest = others;
        }
        parts.push(rest);
        parts
    }

    fn into_answer(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let found = PyDict::new(py);
        found.set_item("points_mm", table(py, self.points_mm))?;
        found.set_item("normals", table(py, self.normals))?;
        found.set_item("deviation_mm", column(py, self.deviation_mm))?;
        found.set_item("deviation_std_mm", column(py, self.deviation_std_mm))?;
        found.set_item("inside_aperture", PyArray1::from_vec(py, self.inside_aperture))?;
        let error_mm = self.planned.then(|| table(py, self.error_mm));
        found.set_item("error_mm", error_mm)?;
        Ok(found)
    }
}

impl Part<'_> {
    /// The first `n` touches, and the others.
    fn split(self, n: usize) -> (Self, Self) {
        let at = self.touches.start + n;
        let (points_mm, points_after) = self.points_mm.split_at_mut(n);
        let (normals, normals_after) = self.normals.split_at_mut(n);
        let (deviation_mm, deviation_after) = self.deviation_mm.split_at_mut(n);
        let (deviation_std_mm, std_after) = self.deviation_std_mm.split_at_mut(n);
        let (inside_aperture, inside_after) = self.inside_aperture.split_at_mut(n);
        let (error_mm, error_after) = self.error_mm.split_at_mut(n.min(self.error_mm.len()));
        let first = Self {
            touches: self.touches.start..at,
            points_mm,
            normals,
            deviation_mm,
            deviation_std_mm,
            inside_aperture,
            error_mm,
        };
        let others = Self {
            touches: at..self.touches.end,
            points_mm: points_after,
            normals: normals_after,
            deviation_mm: deviation_after,
            deviation_std_mm: std_after,
            inside_aperture: inside_after,
            error_mm: error_after,
        };
        (first, others)
    }

    fn fill(self, contacts: &[Contact]) {
        for (i, contact) in contacts.iter().enumerate() {
            self.points_mm[i] = contact.point_mm.into();
            self.normals[i] = contact.normal.into_inner().into();
            self.deviation_mm[i] = contact.deviation_mm;
            self.deviation_std_mm[i] = contact.sigma_deviation_mm();
            self.inside_aperture[i] = contact.inside_aperture;
            if let (Some(error_mm), Some(planned)) = (self.error_mm.get_mut(i), &contact.planned) {
                *error_mm = planned.error_mm.into();
            }
        }
    }
}
