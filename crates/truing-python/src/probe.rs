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
    let some = |which: Range<usize>| -> Result<Columns, Refusal> {
        let touches: Vec<BallTouch> = which.map(touch).collect();
        let contacts = probe_comp::compensate(&nominal, tip_radius_mm, &touches, source)?;
        Ok(Columns::of(&contacts))
    };
    let stretches: Result<_, Refusal> = py.detach(|| {
        // A surface through all touches needs all of them.
        if source == NormalSource::SurfaceFit {
            return Ok(vec![some(0..n)?]);
        }
        let starts = (0..n.max(1)).into_par_iter().step_by(STRETCH);
        let each: Result<Vec<Columns>, Refusal> =
            starts.map(|start| some(start..n.min(start + STRETCH))).collect();
        // An error counts touches from the first one on.
        each.or_else(|_| Ok(vec![some(0..n)?]))
    });
    answer(py, &stretches?)
}

/// Touches whose records and contacts, some 400 bytes a touch, stay near to a core until they are columns.
const STRETCH: usize = 4096;

fn direction(index: usize, approach: [f64; 3]) -> Result<Unit<Vector3<f64>>, Refusal> {
    let direction = Unit::try_new(Vector3::from(approach), 0.0);
    direction
        .filter(|d| d.iter().all(|v| v.is_finite()))
        .ok_or_else(|| Refusal::of(format!("approach of touch {} has no direction", index + 1)))
}

/// What is told of some contacts.
#[derive(Debug)]
struct Columns {
    points_mm: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    deviation_mm: Vec<f64>,
    deviation_std_mm: Vec<f64>,
    inside_aperture: Vec<bool>,
    error_mm: Option<Vec<[f64; 3]>>,
}

impl Columns {
    fn of(contacts: &[Contact]) -> Self {
        let all = || contacts.iter();
        Self {
            points_mm: all().map(|c| c.point_mm.into()).collect(),
            normals: all().map(|c| c.normal.into_inner().into()).collect(),
            deviation_mm: all().map(|c| c.deviation_mm).collect(),
            deviation_std_mm: all().map(Contact::sigma_deviation_mm).collect(),
            inside_aperture: all().map(|c| c.inside_aperture).collect(),
            error_mm: all().map(|c| c.planned.map(|p| p.error_mm.into())).collect(),
        }
    }
}

fn answer<'py>(py: Python<'py>, stretches: &[Columns]) -> PyResult<Bound<'py, PyDict>> {
    fn joined<T: Copy>(stretches: &[Columns], of: impl Fn(&Columns) -> &[T]) -> Vec<T> {
        stretches.iter().map(of).collect::<Vec<_>>().concat()
    }
    let found = PyDict::new(py);
    found.set_item("points_mm", table(py, joined(stretches, |s| &s.points_mm)))?;
    found.set_item("normals", table(py, joined(stretches, |s| &s.normals)))?;
    found.set_item("deviation_mm", column(py, joined(stretches, |s| &s.deviation_mm)))?;
    found.set_item("deviation_std_mm", column(py, joined(stretches, |s| &s.deviation_std_mm)))?;
    let inside = joined(stretches, |s| &s.inside_aperture);
    found.set_item("inside_aperture", PyArray1::from_vec(py, inside))?;
    let planned: Option<Vec<_>> = stretches.iter().map(|s| s.error_mm.as_deref()).collect();
    found.set_item("error_mm", planned.map(|rows| table(py, rows.concat())))?;
    Ok(found)
}
