//! Where a ball touched.

use nalgebra::{Point2, Point3, Unit, Vector3};
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::probe_comp::{self, BallTouch, Contact, NormalSource, Side};

use crate::arrays::{Table, column, rows, rows_of, std_of_each, table, vectors};
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
    let approach = approach.map(|a| rows_of::<3>("approach", &a, n)).transpose()?;
    let guide_mm = guide_mm.map(|g| rows_of::<2>("guide_mm", &g, n)).transpose()?;
    let mut touches: Vec<BallTouch> = (centers.into_iter().zip(std_mm))
        .map(|(at, sigma_mm)| BallTouch::new(Point3::from(at), sigma_mm))
        .collect();
    for (i, touch) in touches.iter_mut().enumerate() {
        touch.approach = approach.as_ref().map(|a| direction(i, a[i])).transpose()?;
        touch.guide_mm = guide_mm.as_ref().map(|g| Point2::from(g[i]));
    }
    let contacts = py.detach(|| probe_comp::compensate(&nominal, tip_radius_mm, &touches, source));
    answer(py, &contacts.map_err(Refusal::from)?)
}

fn direction(index: usize, approach: [f64; 3]) -> Result<Unit<Vector3<f64>>, Refusal> {
    let direction = Unit::try_new(Vector3::from(approach), 0.0);
    direction
        .filter(|d| d.iter().all(|v| v.is_finite()))
        .ok_or_else(|| Refusal::of(format!("approach of touch {} has no direction", index + 1)))
}

fn answer<'py>(py: Python<'py>, contacts: &[Contact]) -> PyResult<Bound<'py, PyDict>> {
    let all = || contacts.iter();
    let found = PyDict::new(py);
    found.set_item("points_mm", vectors(py, all().map(|c| &c.point_mm.coords)))?;
    found.set_item("normals", vectors(py, all().map(|c| c.normal.as_ref())))?;
    found.set_item("deviation_mm", column(py, all().map(|c| c.deviation_mm).collect()))?;
    let std = all().map(Contact::sigma_deviation_mm).collect();
    found.set_item("deviation_std_mm", column(py, std))?;
    let inside: Vec<bool> = all().map(|c| c.inside_aperture).collect();
    found.set_item("inside_aperture", numpy::PyArray1::from_vec(py, inside))?;
    let planned = contacts.iter().all(|c| c.planned.is_some());
    let error = |c: &Contact| c.planned.map_or([f64::NAN; 3], |p| p.error_mm.into());
    found.set_item("error_mm", planned.then(|| table(py, all().map(error))))?;
    Ok(found)
}
