//! Raw observations behind rows that are combinations of them.
//!
//! Noise with memory runs through the readings of a record. Rows that are left of the readings of
//! one angle, say, once its own unknowns are taken out, mix the records, and at every angle
//! differently: their colours cannot be told row by row. So the rows are taken back to the
//! readings, with what was taken out of these as parameters: there the restricted likelihood is the
//! same, and the noise is plain.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::algebra::linearised::{Linearised, series};

/// Most readings for which this is worth its cost, which grows with their cube.
const MAX_READINGS: usize = 600;

/// An eigenvalue of a projector is zero or one.
const HALF: f64 = 0.5;

/// The readings of the rows of a [`Linearised`].
pub(crate) struct RawObservations {
    units: Vec<Unit>,
    total: usize,
    /// Of every reading's unknowns that the rows do not show any more, `readings × directions`.
    taken_out: DMatrix<f64>,
    /// Raw observations of each record, in measured order.
    pub(crate) series: Vec<Vec<usize>>,
}

/// Rows that are combinations of the same readings.
struct Unit {
    /// Positions in [`Linearised::rows`].
    rows: Vec<usize>,
    /// First of its readings, which follow each other.
    start: usize,
    /// `rows × readings`, orthonormal rows.
    combination: DMatrix<f64>,
}

impl RawObservations {
    /// `None` where every row is a reading, or where there are too many.
    pub(crate) fn of(lin: &Linearised<'_>) -> Option<Self> {
        let n: usize = lin.projected.iter().map(|c| c.readings.len()).sum();
        if lin.projected.is_empty() || n > MAX_READINGS {
            return None;
        }
        let mut alone: BTreeMap<usize, usize> =
            lin.rows.iter().enumerate().map(|(i, &row)| (row, i)).collect();
        let mut readings: Vec<(usize, usize)> = Vec::new();
        let mut units = Vec::new();
        for of in lin.projected {
            let own = 0..of.combination.nrows();
            let (kept, rows): (Vec<usize>, Vec<usize>) =
                own.filter_map(|i| Some((i, alone.remove(&(of.first_row + i))?))).unzip();
            if kept.is_empty() {
                continue;
            }
            let all = of.combination.select_rows(&kept);
            let used: Vec<usize> =
                (0..all.ncols()).filter(|&c| all.column(c).iter().any(|&v| v != 0.0)).collect();
            let combination = all.select_columns(&used);
            units.push(Unit { rows, start: readings.len(), combination });
            readings.extend(used.iter().map(|&c| of.readings[c]));
        }
        for &i in alone.values() {
            let start = readings.len();
            units.push(Unit { rows: vec![i], start, combination: DMatrix::identity(1, 1) });
            let row = &lin.layout.rows[lin.rows[i]];
            readings.push((row.observation, row.component));
        }
        let total = readings.len();
        let taken_out = taken_out(&units, total);
        let series = series(lin.layout, lin.records, readings.into_iter());
        Some(Self { units, total, taken_out, series })
    }

    /// Parameters' columns of the rows as those of the readings, with what was taken out of these.
    pub(crate) fn lift_base(&self, base: &DMatrix<f64>) -> DMatrix<f64> {
        let lifted = self.lift(base);
        let columns: Vec<_> = lifted.column_iter().chain(self.taken_out.column_iter()).collect();
        if columns.is_empty() { lifted } else { DMatrix::from_columns(&columns) }
    }

    /// Columns of the rows as columns of the readings.
    pub(crate) fn lift(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.total, columns.ncols());
        for unit in &self.units {
            let own = unit.combination.tr_mul(&columns.select_rows(&unit.rows));
            out.rows_mut(unit.start, own.nrows()).copy_from(&own);
        }
        out
    }
}

/// What the rows of each unit leave of its readings, orthonormal.
fn taken_out(units: &[Unit], total: usize) -> DMatrix<f64> {
    let mut columns = Vec::new();
    for unit in units {
        let n = unit.combination.ncols();
        let left = DMatrix::identity(n, n) - unit.combination.tr_mul(&unit.combination);
        let eigen = left.symmetric_eigen();
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > HALF {
                let mut column = DVector::zeros(total);
                column.rows_mut(unit.start, n).copy_from(&vector);
                columns.push(column);
            }
        }
    }
    if columns.is_empty() { DMatrix::zeros(total, 0) } else { DMatrix::from_columns(&columns) }
}
