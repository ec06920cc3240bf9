//! Readings, as directions of the rows that hold them.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::linearised::Linearised;

/// One reading of an observation: a row, or what several rows that are combinations of readings
/// hold of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) observation: usize,
    /// Positions in [`Linearised::rows`], and the share of the reading in each.
    terms: Vec<(usize, f64)>,
}

impl Reading {
    /// What a column of the rows, whitened, says along this reading.
    pub(crate) fn of(&self, column: &DVector<f64>) -> f64 {
        self.terms.iter().map(|&(row, share)| share * column[row]).sum()
    }

    fn square(&self) -> f64 {
        self.terms.iter().map(|(_, share)| share * share).sum()
    }

    /// As a column of `rows` rows.
    pub(crate) fn column(&self, rows: usize) -> DVector<f64> {
        let mut column = DVector::zeros(rows);
        for &(row, share) in &self.terms {
            column[row] = share;
        }
        column
    }
}

/// Readings of which what a basis holds is found together.
const TOGETHER: usize = 64;

/// Squares of what a basis leaves of each reading, of one.
pub(crate) fn left_by(basis: &Basis, readings: &[&Reading]) -> Vec<f64> {
    let mut left = Vec::with_capacity(readings.len());
    for some in readings.chunks(TOGETHER) {
        // Readings that follow each other are of the same rows, or of few.
        let mut rows: Vec<usize> =
            some.iter().flat_map(|reading| reading.terms.iter().map(|(row, _)| *row)).collect();
        rows.sort_unstable();
        rows.dedup();
        let mut shares = DMatrix::zeros(some.len(), rows.len());
        for (i, reading) in some.iter().enumerate() {
            for (row, share) in &reading.terms {
                shares[(i, rows.partition_point(|known| known < row))] = *share;
            }
        }
        let held = shares * basis.rows(&rows);
        let squares = held.row_iter().map(|held| held.norm_squared());
        left.extend(some.iter().zip(squares).map(|(r, held)| (r.square() - held).max(0.0)));
    }
    left
}

impl Linearised<'_> {
    /// The readings behind all rows that are reported.
    pub(crate) fn readings(&self) -> Vec<Reading> {
        let mut alone: BTreeMap<usize, usize> =
            self.rows.iter().enumerate().map(|(i, &row)| (row, i)).collect();
        let mut readings = Vec::new();
        for of in self.projected {
            let own = 0..of.combination.nrows();
            let kept: Vec<(usize, usize)> =
                own.filter_map(|i| Some((i, alone.remove(&(of.first_row + i))?))).collect();
            for (column, &(observation, _)) in of.readings.iter().enumerate() {
                let share = |&(i, row): &(usize, usize)| (row, of.combination[(i, column)]);
                let terms: Vec<_> = kept.iter().map(share).filter(|t| t.1 != 0.0).collect();
                if !terms.is_empty() {
                    readings.push(Reading { observation, terms });
                }
            }
        }
        let row = |&i: &usize| &self.layout.rows[self.rows[i]];
        readings.extend(alone.values().map(|i| {
            let observation = row(i).observation;
            Reading { observation, terms: vec![(*i, 1.0)] }
        }));
        readings.retain(|r| row(&r.terms[0].0).reported);
        readings
    }
}
