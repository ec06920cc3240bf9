//! All rows of a joint bundle at its solution, with the errors of every angle taken out.

use std::collections::HashSet;

use least_squares::{BorderedPoint, BorderedProblem};
use model_discrepancy::Projected;
use nalgebra::{DMatrix, DVector, Vector6};

use crate::joint::Joint;
use crate::missing::reduce::{Reduced, reduce};
use crate::missing::sights::Sight;
use crate::network::Network;
use crate::spread::dense_block;
use crate::{AxisModel, TrackerError};

/// Reduced rows of all angles, one after the other; in mm, not whitened.
#[derive(Clone, Debug)]
pub(crate) struct Reduction {
    angles: Vec<AngleRows>,
    /// Range that each row is tied to.
    pub(crate) range_of_row: Vec<usize>,
}

/// Rows of one angle.
#[derive(Clone, Debug)]
struct AngleRows {
    /// Ranges of the angle, in the order of its rows before reduction.
    ranges: Vec<usize>,
    /// `None` at an angle that has no errors of its own: the first, or any of a perfect axis.
    reduced: Option<Reduced>,
    /// First reduced row among those of all angles.
    start: usize,
}

impl AngleRows {
    fn n_rows(&self) -> usize {
        self.reduced.as_ref().map_or(self.ranges.len(), |r| r.tied_to.len())
    }
}

impl Reduction {
    /// Rows are tied to the ranges `tied`, where given and where these leave the errors determined.
    pub(crate) fn new(
        joint: &Joint<'_>,
        sights: &[Sight],
        tied: Option<&HashSet<usize>>,
    ) -> Result<Self, TrackerError> {
        let network = joint.network;
        let mut angles = Vec::with_capacity(joint.ranges_of.len());
        let mut range_of_row = Vec::new();
        // Locks without a row at the angle before.
        let mut given_up: Vec<(usize, usize)> = Vec::new();
        for (k, ranges) in joint.ranges_of.iter().enumerate() {
            let ranges: Vec<usize> = ranges.iter().map(|&range| range as usize).collect();
            let visits: Vec<usize> = network.angles[k]
                .steps
                .iter()
                .map(|&s| network.ranges_of_step.at(s).len())
                .collect();
            let by_error = DMatrix::from_fn(ranges.len(), 6, |i, j| sights[ranges[i]].by_error[j]);
            let reduced = if k == 0 || network.axis_model != AxisModel::Free {
                None
            } else {
                let is_free = |&i: &usize| match tied {
                    Some(tied) => !tied.contains(&ranges[i]),
                    None => given_up.contains(&lock(network, ranges[i])),
                };
                let same: Vec<usize> = (0..visits[0]).filter(is_free).collect();
                Some(reduce(&by_error, &visits, &same).ok_or_else(|| undetermined(network, k))?)
            };
            let rows = AngleRows { ranges: ranges.clone(), reduced, start: range_of_row.len() };
            match &rows.reduced {
                Some(reduced) => {
                    range_of_row.extend(reduced.tied_to.iter().map(|&i| ranges[i]));
                    let is_free = |i: &usize| !reduced.tied_to.contains(i);
                    let free = (0..visits[0]).filter(is_free);
                    given_up = free.map(|i| lock(network, ranges[i])).collect();
                }
                None => range_of_row.extend(ranges),
            }
            angles.push(rows);
        }
        Ok(Self { angles, range_of_row })
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.range_of_row.len()
    }

    /// Of what ranges the rows of every angle with errors of its own are combinations.
    pub(crate) fn projected(&self) -> Vec<Projected> {
        let of = |angle: &AngleRows| {
            let combination = angle.reduced.as_ref()?.transformation.clone();
            let readings = angle.ranges.iter().map(|&range| (range, 0)).collect();
            Some(Projected { first_row: angle.start, readings, combination })
        };
        self.angles.iter().filter_map(of).collect()
    }

    /// Columns given for every range, as columns of the reduced rows.
    pub(crate) fn columns(&self, of_ranges: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.n_rows(), of_ranges.ncols());
        for angle in &self.angles {
            let own = of_ranges.select_rows(&angle.ranges);
            let own = match &angle.reduced {
                Some(reduced) => &reduced.transformation * own,
                None => own,
            };
            out.rows_mut(angle.start, angle.n_rows()).copy_from(&own);
        }
        out
    }

    /// Columns of the reduced rows, and of others that are of no range, as a range sees them: the products
    /// with columns given for the ranges are those with these reduced.
    pub(crate) fn of_ranges(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let n_ranges = self.angles.iter().map(|angle| angle.ranges.len()).sum();
        let mut out = DMatrix::zeros(n_ranges, rows.ncols());
        for angle in &self.angles {
            let own = rows.rows(angle.start, angle.n_rows());
            let own = match &angle.reduced {
                Some(reduced) => reduced.transformation.transpose() * own,
                None => own.into_owned(),
            };
            for (&range, row) in angle.ranges.iter().zip(own.row_iter()) {
                out.row_mut(range).copy_from(&row);
            }
        }
        out
    }

    /// Of every range, at which angle its errors are taken out, and along which of six orthonormal directions
    /// it is seen in them.
    pub(crate) fn taken_out(&self, sights: &[Sight]) -> Vec<Option<(usize, Vector6<f64>)>> {
        let mut taken = vec![None; sights.len()];
        for (k, angle) in self.angles.iter().enumerate() {
            if angle.reduced.is_none() {
                continue;
            }
            let mut by_error = of_ranges(angle.ranges.len(), 6, |i| {
                sights[angle.ranges[i]].by_error.data.0[0].to_vec()
            });
            for mut column in by_error.column_iter_mut() {
                column.normalize_mut();
            }
            for (&range, row) in angle.ranges.iter().zip(by_error.qr().q().row_iter()) {
                taken[range] = Some((k, Vector6::from_iterator(row.iter().copied())));
            }
        }
        taken
    }

    /// Derivative of the reduced rows by the shared parameters, mm per unit.
    pub(crate) fn by_shared(
        &self,
        joint: &Joint<'_>,
        at: &BorderedPoint,
        sigma_mm: f64,
    ) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.n_rows(), joint.shared_dim());
        for (k, angle) in self.angles.iter().enumerate() {
            let own = dense_block(joint, at, k).by_shared * sigma_mm;
            let own = match &angle.reduced {
                Some(reduced) => &reduced.transformation * own,
                None => own,
            };
            out.rows_mut(angle.start, angle.n_rows()).copy_from(&own);
        }
        out
    }

    /// What a few ranges of one angle add to its reduced rows: first row, and the rows.
    pub(crate) fn impulse(
        &self,
        angle: usize,
        of_ranges: &[(usize, Vec<f64>)],
    ) -> (usize, DMatrix<f64>) {
        let angle = &self.angles[angle];
        let width = of_ranges.first().map_or(0, |(_, v)| v.len());
        let mut out = DMatrix::zeros(angle.n_rows(), width);
        for (range, values) in of_ranges {
            let Some(row) = angle.ranges.iter().position(|r| r == range) else { continue };
            for (c, value) in values.iter().enumerate() {
                match &angle.reduced {
                    Some(reduced) => {
                        out.column_mut(c).axpy(*value, &reduced.transformation.column(row), 1.0);
                    }
                    None => out[(row, c)] += value,
                }
            }
        }
        (angle.start, out)
    }
}

/// Station and mount of a range.
fn lock(network: &Network<'_>, range: usize) -> (usize, usize) {
    let range = &network.survey.ranges[range];
    (range.station, range.mount)
}

/// Errors that the readings at an angle leave free.
fn undetermined(network: &Network<'_>, angle: usize) -> TrackerError {
    TrackerError::UndeterminedAngle {
        angle_deg: network.angles[angle].angle_rad.to_degrees(),
        free: network.axis(network.angles[angle].axis).letter.error_names().to_vec(),
    }
}

/// Columns of values given for every range.
pub(crate) fn of_ranges(
    n_ranges: usize,
    width: usize,
    values: impl Fn(usize) -> Vec<f64>,
) -> DMatrix<f64> {
    let mut columns = DMatrix::zeros(n_ranges, width);
    for (range, mut row) in columns.row_iter_mut().enumerate() {
        row.iter_mut().zip(values(range)).for_each(|(to, value)| *to = value);
    }
    columns
}

/// Least-squares answer of an angle's errors to changes of its ranges' residuals, `6 × ranges`.
pub(crate) fn answer(by_error: &[Vector6<f64>]) -> Option<DMatrix<f64>> {
    let design = DMatrix::from_fn(by_error.len(), 6, |i, j| by_error[i][j]);
    let scale = DVector::from_iterator(6, design.column_iter().map(|c| c.norm()));
    let mut scaled = design;
    for (mut column, s) in scaled.column_iter_mut().zip(scale.iter()) {
        column.unscale_mut(*s);
    }
    let qr = scaled.qr();
    let mut answer = -(qr.r().try_inverse()? * qr.q().transpose());
    for (mut row, s) in answer.row_iter_mut().zip(scale.iter()) {
        row.unscale_mut(*s);
    }
    Some(answer)
}
