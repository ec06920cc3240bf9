//! Where a head presses, from wrenches.

use std::borrow::Cow;

use nalgebra::Point2;
use numpy::ndarray::Axis;
use numpy::{IntoPyArray, PyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::ft_center::{
    self, Contact, FtCenterError, LocateOptions, Noise, OrbitOptions, Press, PressRole, Sample,
    WrenchArrays, centers_into, locate, solve_batch, solve_presses,
};
use truing::geometry::Wrench;

use crate::arrays::{Column, Table, column, rows, small, table, vectors};
use crate::refusal::Refusal;

/// Forces and moments, one column each.
type Six<'a> = [Cow<'a, [f64]>; 6];

/// Columns where they lie; gathered where their numbers do not lie one behind the other.
fn six<'a>(wrenches: &'a Table<'_>) -> Result<Six<'a>, Refusal> {
    let view = wrenches.as_array();
    if view.ncols() != 6 {
        return Err(Refusal::shape("wrenches", "n × 6, six columns", wrenches.shape()));
    }
    Ok(std::array::from_fn(|k| {
        let column = view.index_axis_move(Axis(1), k);
        column.to_slice().map_or_else(|| column.iter().copied().collect(), Cow::Borrowed)
    }))
}

fn arrays<'a>([fx, fy, fz, mx, my, mz]: &'a Six<'_>) -> WrenchArrays<'a> {
    WrenchArrays { fx_n: fx, fy_n: fy, fz_n: fz, mx_nmm: mx, my_nmm: my, mz_nmm: mz }
}

/// The one centre of pressure of many wrenches, with its covariance.
#[pyfunction]
pub(crate) fn locate_contact<'py>(
    py: Python<'py>,
    wrenches: Table<'py>,
    z0_mm: f64,
    min_fz_n: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let columns = six(&wrenches)?;
    let arrays = arrays(&columns);
    let center = py.detach(|| solve_batch(&arrays, z0_mm, min_fz_n)).map_err(Refusal::from)?;
    let found = PyDict::new(py);
    found.set_item("center_mm", column(py, center.center_mm.iter().copied().collect()))?;
    found.set_item("covariance_mm2", small(py, &center.covariance_mm2))?;
    found.set_item("degrees_of_freedom", center.degrees_of_freedom)?;
    let wrench = center.mean_wrench.to_vector();
    found.set_item("mean_wrench", column(py, wrench.iter().copied().collect()))?;
    found.set_item("free_moment_nmm", center.free_moment_nmm)?;
    found.set_item("contact_samples", center.contact_samples)?;
    Ok(found)
}

/// Coordinates of every centre.
type Centers<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The centre of pressure of every wrench, x and y; NaN where nothing is touched.
#[pyfunction]
pub(crate) fn centers<'py>(
    py: Python<'py>,
    wrenches: Table<'py>,
    z0_mm: f64,
    min_fz_n: f64,
) -> PyResult<Centers<'py>> {
    let columns = six(&wrenches)?;
    let (arrays, n) = (arrays(&columns), columns[0].len());
    let (x_mm, y_mm) = py
        .detach(|| {
            let (mut x_mm, mut y_mm) = (vec![0.0; n], vec![0.0; n]);
            centers_into(&arrays, z0_mm, min_fz_n, &mut x_mm, &mut y_mm)?;
            Ok((x_mm, y_mm))
        })
        .map_err(|error: FtCenterError| Refusal::from(error))?;
    Ok((x_mm.into_pyarray(py), y_mm.into_pyarray(py)))
}

/// One press: name, role, machine position, times and wrenches.
type Recorded<'py> = (String, String, [f64; 2], Column<'py>, Table<'py>);

/// Places the sensor by presses at known positions, and every press in the machine.
#[pyfunction]
#[pyo3(signature = (presses, z0_mm, min_fz_n, noise, spin_hz))]
pub(crate) fn locate_presses<'py>(
    py: Python<'py>,
    presses: Vec<Recorded<'py>>,
    z0_mm: f64,
    min_fz_n: Option<f64>,
    noise: Option<[f64; 2]>,
    spin_hz: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let presses: Vec<Press> = presses.iter().map(press).collect::<Result<_, _>>()?;
    let contact = Contact { z0_mm, min_fz_n };
    let noise = noise.map(|[force_n, moment_nmm]| Noise { force_n, moment_nmm });
    let located = py.detach(|| {
        let solved = solve_presses(
            &presses,
            &contact,
            &OrbitOptions { spin_hz, ..OrbitOptions::default() },
        )?;
        locate(&solved, &contact, &LocateOptions { noise, handedness: None })
    });
    let located = located.map_err(Refusal::from)?;
    let found = PyDict::new(py);
    let frame = &located.frame;
    found.set_item("angle_rad", frame.angle_rad)?;
    found.set_item("translation_mm", column(py, frame.translation_mm.iter().copied().collect()))?;
    found.set_item("opposed", frame.handedness == ft_center::Handedness::Opposed)?;
    let centers = || located.centers.iter();
    found.set_item("names", centers().map(|c| c.press.as_str()).collect::<Vec<_>>())?;
    found.set_item("sensor_mm", vectors(py, centers().map(|c| &c.sensor_mm.coords)))?;
    found.set_item("machine_mm", vectors(py, centers().map(|c| &c.machine_mm.coords)))?;
    found.set_item("offset_mm", vectors(py, centers().map(|c| &c.offset_mm)))?;
    let std = |c: &ft_center::Center| [0, 1].map(|k| c.covariance_mm2[(k, k)].max(0.0).sqrt());
    found.set_item("std_mm", table(py, centers().map(std)))?;
    found.set_item("degrees_of_freedom", located.degrees_of_freedom)?;
    found.set_item("seat_mm", located.seat_mm)?;
    Ok(found)
}

fn press((name, role, machine_mm, time_s, wrench): &Recorded<'_>) -> Result<Press, Refusal> {
    let role = match role.as_str() {
        "frame" => PressRole::Frame,
        "check" => PressRole::Check,
        "locate" => PressRole::Locate,
        found => return Err(Refusal::word("use", found, &["frame", "check", "locate"])),
    };
    let wrenches = rows::<6>("wrench", wrench)?;
    if time_s.len() != wrenches.len() {
        let needed = wrenches.len().to_string();
        return Err(Refusal::shape("time_s", &needed, time_s.shape()));
    }
    let times = time_s.as_array();
    let record = (times.iter().zip(wrenches.iter()))
        .map(|(&time_s, wrench)| Sample { time_s, wrench: Wrench::from_vector(&(*wrench).into()) })
        .collect();
    Ok(Press { name: name.clone(), role, machine_mm: Point2::from(*machine_mm), record })
}
