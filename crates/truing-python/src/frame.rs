//! The transform between two frames.

use nalgebra::{Point, SMatrix};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::frame_fit::{
    self, FrameFit, Handedness, Noise, Options, PointPair, Transform, Uncertainty,
};
use truing::least_squares::Loss;

use crate::arrays::{Table, column, flat, matrix, rows, rows_of, small, table};
use crate::refusal::Refusal;

/// Fits the transform that takes one table of points to another.
#[pyfunction]
#[pyo3(signature = (from_mm, to_mm, std_mm, transform, handedness, estimate_noise, loss))]
pub(crate) fn fit_frame<'py>(
    py: Python<'py>,
    from_mm: Table<'py>,
    to_mm: Table<'py>,
    std_mm: PyReadonlyArrayDyn<'py, f64>,
    transform: &str,
    handedness: &str,
    estimate_noise: bool,
    loss: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let options = Options {
        transform: named_transform(transform)?,
        handedness: match handedness {
            "proper" => Handedness::Proper,
            "improper" => Handedness::Improper,
            found => return Err(Refusal::word("handedness", found, &["proper", "improper"]).into()),
        },
        noise: if estimate_noise { Noise::Estimated } else { Noise::Declared },
        loss: loss.map(named_loss).transpose()?,
    };
    match from_mm.shape()[1] {
        2 => fitted::<2>(py, &from_mm, &to_mm, &std_mm, &options),
        3 => fitted::<3>(py, &from_mm, &to_mm, &std_mm, &options),
        _ => Err(Refusal::shape("from_mm", "n × 2 or n × 3", from_mm.shape()).into()),
    }
}

fn named_transform(found: &str) -> Result<Transform, Refusal> {
    let all = Transform::ALL.map(|t| t.to_string());
    let named = all.iter().position(|name| name == found);
    let known = all.each_ref().map(String::as_str);
    named.map(|k| Transform::ALL[k]).ok_or_else(|| Refusal::word("transform", found, &known))
}

/// A robust loss by its name, at the scale that keeps 95 % of the efficiency of squares.
pub(crate) fn named_loss(found: &str) -> Result<Loss, Refusal> {
    match found {
        "huber" => Ok(Loss::huber_95()),
        "cauchy" => Ok(Loss::cauchy_95()),
        "tukey" => Ok(Loss::tukey_95()),
        _ => Err(Refusal::word("loss", found, &["huber", "cauchy", "tukey"])),
    }
}

fn fitted<'py, const D: usize>(
    py: Python<'py>,
    from_mm: &Table<'py>,
    to_mm: &Table<'py>,
    std_mm: &PyReadonlyArrayDyn<'py, f64>,
    options: &Options,
) -> PyResult<Bound<'py, PyDict>> {
    let from_mm = rows::<D>("from_mm", from_mm)?;
    let to_mm = rows_of::<D>("to_mm", to_mm, from_mm.len())?;
    // Written once, where the solver reads them.
    let pairs = pairs::<D>(&from_mm, &to_mm, std_mm)?;
    let fit = py.detach(|| frame_fit::fit_frame(&pairs, options));
    answer(py, fit.map_err(Refusal::from)?)
}

/// Points with one standard uncertainty for all, one each, one a coordinate, or a covariance each.
fn pairs<const D: usize>(
    from_mm: &[[f64; D]],
    to_mm: &[[f64; D]],
    std_mm: &PyReadonlyArrayDyn<'_, f64>,
) -> Result<Vec<PointPair<D>>, Refusal> {
    let (n, given) = (from_mm.len(), flat(std_mm));
    let isotropic = |sigma_mm: f64| Uncertainty::Isotropic { sigma_mm };
    match *std_mm.shape() {
        [] => Ok(paired(from_mm, to_mm, std::iter::repeat(isotropic(given[0])))),
        [len] if len == n => Ok(paired(from_mm, to_mm, given.iter().map(|s| isotropic(*s)))),
        [len, c] if len == n && c == D => {
            let per_axis = |sigma: &[f64; D]| Uncertainty::PerAxis { sigma_mm: (*sigma).into() };
            Ok(paired(from_mm, to_mm, given.as_chunks::<D>().0.iter().map(per_axis)))
        }
        [len, r, c] if len == n && r == D && c == D => {
            let full =
                |all: &[f64]| Uncertainty::Full { covariance_mm2: SMatrix::from_row_slice(all) };
            Ok(paired(from_mm, to_mm, given.chunks_exact(D * D).map(full)))
        }
        ref shape => {
            let needed = format!("() or {n} or {n} × {D}, or {n} × {D} × {D} for covariances");
            Err(Refusal::shape("std_mm", &needed, shape))
        }
    }
}

fn paired<const D: usize>(
    from_mm: &[[f64; D]],
    to_mm: &[[f64; D]],
    uncertainties: impl Iterator<Item = Uncertainty<D>>,
) -> Vec<PointPair<D>> {
    let points = from_mm.iter().zip(to_mm).zip(uncertainties);
    let pair = |((from, to), uncertainty): ((&[f64; D], &[f64; D]), _)| PointPair {
        target_mm: Point::from(*to),
        source_mm: Point::from(*from),
        uncertainty,
    };
    points.map(pair).collect()
}

fn answer<const D: usize>(py: Python<'_>, fit: FrameFit<D>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    let rows: Vec<Vec<f64>> = fit.target_from_source.homogeneous_rows();
    let homogeneous = nalgebra::DMatrix::from_fn(D + 1, D + 1, |r, c| rows[r][c]);
    let parameters = fit.parameters();
    let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
    let units: Vec<&str> = parameters.iter().map(|p| p.unit).collect();
    found.set_item("matrix", matrix(py, &homogeneous))?;
    found.set_item("linear", small(py, &fit.target_from_source.linear))?;
    let translation_mm = fit.target_from_source.translation_mm;
    found.set_item("translation_mm", column(py, translation_mm.iter().copied().collect()))?;
    found.set_item("pivot_mm", column(py, fit.pivot_mm.iter().copied().collect()))?;
    found.set_item("parameters", names)?;
    found.set_item("units", units)?;
    found.set_item("covariance", matrix(py, &fit.covariance))?;
    let std = fit.standard_uncertainties();
    found.set_item("std", std.map(|s| column(py, s.iter().copied().collect())))?;
    found.set_item("rms_mm", fit.rms_mm())?;
    found
        .set_item("residuals_mm", table(py, fit.residuals_mm.into_iter().map(<[f64; D]>::from)))?;
    found.set_item("degrees_of_freedom", fit.degrees_of_freedom)?;
    found.set_item("variance_factor", fit.variance_factor)?;
    found.set_item("weights", column(py, fit.weights))?;
    found.set_item("iterations", fit.report.iterations)?;
    Ok(found)
}
