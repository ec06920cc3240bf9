//! `NumPy` arrays in and out.

use std::borrow::Cow;

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

/// The rows of a table of `D` columns, where they lie; gathered only where there are gaps between.
pub(crate) fn rows<'a, const D: usize>(
    name: &str,
    table: &'a Table<'_>,
) -> Result<Cow<'a, [[f64; D]]>, Refusal> {
    let view = table.as_array();
    if view.ncols() != D {
        return Err(Refusal::shape(name, &format!("n × {D}"), table.shape()));
    }
    Ok(match view.to_slice() {
        Some(all) => Cow::Borrowed(all.as_chunks::<D>().0),
        None => view.rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect(),
    })
}

/// The same, where there are to be `n` of them.
pub(crate) fn rows_of<'a, const D: usize>(
    name: &str,
    table: &'a Table<'_>,
    n: usize,
) -> Result<Cow<'a, [[f64; D]]>, Refusal> {
    let rows = rows::<D>(name, table)?;
    if rows.len() == n {
        Ok(rows)
    } else {
        Err(Refusal::shape(name, &format!("{n} × {D}"), table.shape()))
    }
}

/// Numbers of any shape in the order of their indices, the last of them running fastest.
pub(crate) fn flat<'a>(numbers: &'a PyReadonlyArrayDyn<'_, f64>) -> Cow<'a, [f64]> {
    let view = numbers.as_array();
    view.to_slice().map_or_else(|| view.iter().copied().collect(), Cow::Borrowed)
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
#[derive(Debug)]
pub(crate) struct StdOfEach<'a>(Cow<'a, [f64]>);

impl StdOfEach<'_> {
    /// That of one reading.
    pub(crate) fn of(&self, reading: usize) -> f64 {
        if let [same] = *self.0 { same } else { self.0[reading] }
    }
}

/// What was given for `n` readings.
pub(crate) fn std_of_each<'a>(
    name: &str,
    std: &'a PyReadonlyArrayDyn<'_, f64>,
    n: usize,
) -> Result<StdOfEach<'a>, Refusal> {
    match std.shape() {
        shape if shape.is_empty() || *shape == [n] => Ok(StdOfEach(flat(std))),
        shape => Err(Refusal::shape(name, &format!("one number, or {n} of them"), shape)),
    }
}

/// An array of one row per item, handed over without a copy.
pub(crate) fn table<const D: usize>(
    py: Python<'_>,
    rows: impl IntoIterator<Item = [f64; D]>,
) -> Bound<'_, PyArray2<f64>> {
    // Vectors that are given away become rows where they lie.
    let rows: Vec<[f64; D]> = rows.into_iter().collect();
    let (n, flat) = (rows.len(), rows.into_flattened());
    Array2::from_shape_vec((n, D), flat).expect("whole rows were gathered").into_pyarray(py)
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
