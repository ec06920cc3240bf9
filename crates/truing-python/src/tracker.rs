//! The six errors of a rotary axis.

use nalgebra::{Point3, Vector3};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::tracker_lm::{
    self, AxisLetter, DeadPath, ErrorOrder, Formulation, Gauge, Mount, Noise, Options, Range,
    RotaryAxis, Station, Step, Survey,
};

use crate::arrays::{Column, Table, column, rows, slice, small, table, triple};
use crate::refusal::Refusal;

/// Indices from 0.
type Indices<'py> = PyReadonlyArray1<'py, i64>;
/// Letter, origin and direction of the nominal axis.
type Axis<'py> = (String, Column<'py>, Column<'py>);
/// Station, mount and step of every reading, and what it reads.
type Ranges<'py> = (Indices<'py>, Indices<'py>, Indices<'py>, Column<'py>);

/// Finds stations, reflectors, dead paths, and the errors at every angle.
#[pyfunction]
#[pyo3(signature = (axis, stations_mm, mounts_mm, angles_rad, ranges, choices, noise))]
pub(crate) fn calibrate<'py>(
    py: Python<'py>,
    axis: Axis<'py>,
    stations_mm: Table<'py>,
    mounts_mm: Table<'py>,
    angles_rad: Column<'py>,
    ranges: Ranges<'py>,
    choices: [String; 4],
    noise: [Option<f64>; 3],
) -> PyResult<Bound<'py, PyDict>> {
    let letter = letter(&axis.0)?;
    let direction = Vector3::from(triple("direction", &axis.2)?);
    let origin_mm = Point3::from(triple("origin_mm", &axis.1)?);
    let axis = RotaryAxis::new(letter, origin_mm, direction).map_err(Refusal::from)?;
    let place = |(i, at): (usize, &[f64; 3])| (i.to_string(), Point3::from(*at));
    let survey = Survey {
        axis,
        second: None,
        stations: (rows("stations_mm", &stations_mm)?.iter().enumerate().map(place))
            .map(|(name, nominal_mm)| Station { name, nominal_mm })
            .collect(),
        mounts: (rows("mounts_mm", &mounts_mm)?.iter().enumerate().map(place))
            .map(|(name, nominal_mm)| Mount { name, nominal_mm })
            .collect(),
        steps: (angles_rad.as_array().iter().enumerate())
            .map(|(i, &angle_rad)| Step { name: i.to_string(), angle_rad, approach: None })
            .collect(),
        ranges: readings(&ranges)?,
    };
    let [displacement_mm, rigid_mm, station_mm] = noise;
    let noise = Noise { displacement_mm, rigid_mm, station_mm };
    let options = Options { noise, ..chosen(&choices)? };
    let found = py.detach(|| tracker_lm::calibrate(&survey, &options)).map_err(Refusal::from)?;
    answer(py, found, letter)
}

fn letter(found: &str) -> Result<AxisLetter, Refusal> {
    let all = [AxisLetter::A, AxisLetter::B, AxisLetter::C];
    let named = all.into_iter().find(|l| l.letter().to_string() == found);
    named.ok_or_else(|| Refusal::word("letter", found, &["A", "B", "C"]))
}

fn chosen([formulation, dead_path, gauge, order]: &[String; 4]) -> Result<Options, Refusal> {
    Ok(Options {
        formulation: one_of(
            "formulation",
            formulation,
            [("joint", Formulation::Joint), ("free-points", Formulation::FreePoints)],
        )?,
        dead_path: one_of(
            "dead_path",
            dead_path,
            [("lock", DeadPath::Lock), ("station", DeadPath::Station)],
        )?,
        gauge: one_of(
            "gauge",
            gauge,
            [("stations", Gauge::Stations), ("minimal", Gauge::Minimal), ("inner", Gauge::Inner)],
        )?,
        order: one_of(
            "order",
            order,
            [("fixed", ErrorOrder::Fixed), ("rotating", ErrorOrder::Rotating)],
        )?,
        ..Options::default()
    })
}

fn one_of<T: Copy, const N: usize>(
    name: &str,
    found: &str,
    known: [(&str, T); N],
) -> Result<T, Refusal> {
    let named = known.iter().find(|(word, _)| *word == found).map(|(_, choice)| *choice);
    named.ok_or_else(|| Refusal::word(name, found, &known.map(|(word, _)| word)))
}

fn readings((stations, mounts, steps, displacements): &Ranges<'_>) -> Result<Vec<Range>, Refusal> {
    let displacements_mm = slice("displacement_mm", displacements)?;
    let n = displacements_mm.len();
    let indices = |name: &str, of: &Indices<'_>| -> Result<Vec<usize>, Refusal> {
        if of.len() != n {
            return Err(Refusal::shape(name, &n.to_string(), of.shape()));
        }
        let whole = |(reading, &i): (usize, &i64)| {
            usize::try_from(i).map_err(|_| Refusal::below_zero(name, reading, i))
        };
        of.as_array().iter().enumerate().map(whole).collect()
    };
    let (stations, mounts) = (indices("station", stations)?, indices("mount", mounts)?);
    let steps = indices("step", steps)?;
    let of = |i: usize| Range {
        station: stations[i],
        mount: mounts[i],
        step: steps[i],
        displacement_mm: displacements_mm[i],
    };
    Ok((0..n).map(of).collect())
}

fn answer(
    py: Python<'_>,
    of: tracker_lm::Calibration,
    letter: AxisLetter,
) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    let six = |v: &nalgebra::Vector6<f64>| -> [f64; 6] { std::array::from_fn(|k| v[k]) };
    let sigma = |v: &nalgebra::Matrix3<f64>| [0, 1, 2].map(|k| v[(k, k)].max(0.0).sqrt());
    found.set_item("names", letter.error_names())?;
    let errors = || of.axis_errors.iter();
    found.set_item("angles_rad", column(py, errors().map(|e| e.angle_rad).collect()))?;
    found.set_item("errors", table(py, errors().map(|e| six(&e.error))))?;
    found.set_item("errors_std", table(py, errors().map(|e| six(&e.sigmas()))))?;
    let stations = || of.stations.iter();
    found.set_item("stations_mm", table(py, stations().map(|s| s.position_mm.into())))?;
    found.set_item("stations_std_mm", table(py, stations().map(|s| sigma(&s.covariance_mm2))))?;
    let mounts = || of.mounts.iter();
    found.set_item("mounts_mm", table(py, mounts().map(|m| m.position_mm.into())))?;
    found.set_item("mounts_std_mm", table(py, mounts().map(|m| sigma(&m.covariance_mm2))))?;
    let dead_paths = of.dead_paths.iter().map(|d| d.length_mm).collect();
    found.set_item("dead_paths_mm", column(py, dead_paths))?;
    let location = of.location.as_ref();
    let location_names = location.map(|_| letter.location_names());
    found.set_item("location_names", location_names)?;
    let errors = location.map(|l| column(py, l.errors.iter().copied().collect()));
    found.set_item("location", errors)?;
    found.set_item("location_covariance", location.map(|l| small(py, &l.covariance)))?;
    found.set_item("rms_mm", of.rms_mm())?;
    found.set_item("degrees_of_freedom", of.degrees_of_freedom)?;
    found.set_item("variance_factor", of.variance_factor)?;
    found.set_item("displacement_std_mm", of.displacement_mm)?;
    found.set_item("residuals_mm", column(py, of.residuals_mm))?;
    found.set_item("redundancy", column(py, of.redundancy))?;
    found.set_item("iterations", of.report.iterations)?;
    Ok(found)
}
