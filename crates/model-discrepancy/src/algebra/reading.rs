//! Readings, as directions of the rows that hold them.

use std::collections::BTreeMap;

use nalgebra::DVector;

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

    /// Square of what a basis leaves of the reading, of one.
    pub(crate) fn left_by(&self, basis: &Basis) -> f64 {
        let whole: f64 = self.terms.iter().map(|(_, share)| share * share).sum();
        (whole - basis.square_along(&self.terms)).max(0.0)
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
