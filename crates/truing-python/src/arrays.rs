//! `NumPy` arrays in and out.

use nalgebra::{DMatrix, SMatrix, SVector};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::refusal::Refusal;

/// One number a row.
pub(crate) type Column<'py> = PyReadonlyArray1<'py, f64>;
/// Some numbers a row.
pub(crate) type Table<'py> = PyReadonlyArray2<'py, f64>;

/// The rows of a table of `D` columns, read once.
pub(crate) fn rows<const D: usize>(
    name: &str,
    table: &Table<'_>,
) -> Result<Vec<[f64; D]>, Refusal> {
    let view = table.as_array();
    if view.ncols() != D {
        return Err(Refusal::shape(name, &format!("n × {D}"), table.shape()));
    }
    Ok(match view.as_slice() {
        Some(all) => all.as_chunks::<D>().0.to_vec(),
        None => view.rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect(),
    })
}

/// The same, where there are to be `n` of them.
pub(crate) fn rows_of<const D: usize>(
    name: &str,
    table: &Table<'_>,
    n: usize,
) -> Result<Vec<[f64; D]>, Refusal> {
    let rows = rows::<D>(name, table)?;
    if rows.len() == n {
        Ok(rows)
    } else {
        Err(Refusal::shape(name, &format!("{n} × {D}"), table.shape()))
    }
}

/// The rows of a table of `D` columns where they lie; `n` of them where that is given.
pub(crate) fn each_row<'a, const D: usize>(
    name: &str,
    table: &'a Table<'_>,
    n: Option<usize>,
) -> Result<impl Iterator<Item = [f64; D]> + 'a, Refusal> {
    let view = table.as_array();
    if view.ncols() != D || n.is_some_and(|n| n != view.nrows()) {
        let n = n.map_or_else(|| "n".to_owned(), |n| n.to_string());
        return Err(Refusal::shape(name, &format!("{n} × {D}"), table.shape()));
    }
    Ok((0..view.nrows()).map(move |i| std::array::from_fn(|k| view[[i, k]])))
}

/// A contiguous column, where it lies.
pub(crate) fn slice<'a>(name: &str, column: &'a Column<'_>) -> Result<&'a [f64], Refusal> {
    column.as_slice().map_err(|_| Refusal::of(format!("{name}: an array without gaps is needed")))
}

/// Three numbers.
pub(crate) fn triple(name: &str, column: &Column<'_>) -> Result<[f64; 3], Refusal> {
    let view = column.as_array();
    if view.len() == 3 {
        Ok(std::array::from_fn(|k| view[k]))
    } else {
        Err(Refusal::shape(name, "3", column.shape()))
    }
}

/// One standard uncertainty for all of `n` readings, or one for each.
pub(crate) fn std_of_each(
    name: &str,
    std: &PyReadonlyArrayDyn<'_, f64>,
    n: usize,
) -> Result<Vec<f64>, Refusal> {
    let view = std.as_array();
    match view.shape() {
        [] => Ok(vec![view.first().copied().unwrap_or(f64::NAN); n]),
        [len] if *len == n => Ok(view.iter().copied().collect()),
        shape => Err(Refusal::shape(name, &format!("one number, or {n} of them"), shape)),
    }
}

/// An array of one row per item, handed over without a copy.
pub(crate) fn table<const D: usize>(
    py: Python<'_>,
    rows: impl Iterator<Item = [f64; D]>,
) -> Bound<'_, PyArray2<f64>> {
    let flat: Vec<f64> = rows.flatten().collect();
    let shape = (flat.len() / D, D);
    Array2::from_shape_vec(shape, flat).expect("whole rows were gathered").into_pyarray(py)
}

/// An array of vectors.
pub(crate) fn vectors<'py, 'a, const D: usize>(
    py: Python<'py>,
    vectors: impl Iterator<Item = &'a SVector<f64, D>>,
) -> Bound<'py, PyArray2<f64>> {
    table(py, vectors.map(|v| <[f64; D]>::from(*v)))
}

/// An array of numbers, handed over without a copy.
pub(crate) fn column(py: Python<'_>, numbers: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    numbers.into_pyarray(py)
}

/// A matrix of any size.
pub(crate) fn matrix<'py>(py: Python<'py>, of: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn(of.shape(), |at| of[at]).into_pyarray(py)
}

/// A matrix of known size.
pub(crate) fn small<'py, const R: usize, const C: usize>(
    py: Python<'py>,
    of: &SMatrix<f64, R, C>,
) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((R, C), |at| of[at]).into_pyarray(py)
}
