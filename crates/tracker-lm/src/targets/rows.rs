//! All rows at a solution, with what belongs to a unit alone taken out of it: the six errors of
//! an angle, or the place of a reflector.

use std::collections::HashSet;

use model_discrepancy::Projected;
use nalgebra::DMatrix;

use super::HoldOut;
use super::bundle::Bundle;
use super::sight::Sight;
use crate::missing::reduce::{Reduced, reduce};
use crate::{AxisModel, TrackerError};

/// Reduced rows of all units, one after the other; in mm, not whitened.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    units: Vec<Unit>,
    /// Reading and component that each row is tied to.
    pub(super) tied_to: Vec<(usize, usize)>,
    /// Standard uncertainty of each row.
    pub(super) sigma_mm: Vec<f64>,
}

/// Rows of one unit.
#[derive(Clone, Debug)]
struct Unit {
    /// Reading and component of each row before reduction.
    of: Vec<(usize, usize)>,
    /// Standard uncertainties of these.
    sigma_mm: Vec<f64>,
    /// `None` at an angle that has no errors of its own: the first, or any of a perfect axis.
    reduced: Option<Reduced>,
}

impl Rows {
    /// Rows are tied to the components `tied`, where given and where these leave the rest determined.
    pub(super) fn new(
        bundle: &Bundle<'_>,
        sights: &[Sight],
        hold_out: HoldOut,
        tied: Option<&HashSet<(usize, usize)>>,
    ) -> Result<Self, TrackerError> {
        let mut rows = Self { units: Vec::new(), tied_to: Vec::new(), sigma_mm: Vec::new() };
        match hold_out {
            HoldOut::Step => {
                for (k, angle) in bundle.angles.iter().enumerate() {
                    let visits = visits(bundle, &angle.steps, |_| true);
                    let is_free = bundle.axis_model == AxisModel::Free && k > 0;
                    let own = is_free.then_some(|n: usize| {
                        DMatrix::from_fn(3, 6, |i, j| sights[n].by_error[(i, j)])
                    });
                    let free = || TrackerError::UndeterminedAngle {
                        angle_deg: angle.angle_rad.to_degrees(),
                        free: bundle.survey.axis.letter.error_names().to_vec(),
                    };
                    rows.add(bundle, &visits, own, tied).ok_or_else(free)?;
                }
            }
            HoldOut::Mount => {
                let steps: Vec<usize> = (0..bundle.survey.steps.len()).collect();
                for mount in 0..bundle.survey.mounts.len() {
                    let visits =
                        visits(bundle, &steps, |n| bundle.survey.targets[n].mount == mount);
                    let own =
                        Some(|n: usize| DMatrix::from_fn(3, 3, |i, j| sights[n].by_mount[(i, j)]));
                    rows.add(bundle, &visits, own, tied).ok_or(TrackerError::NotFinite)?;
                }
            }
        }
        Ok(rows)
    }

    /// Adds a unit of visits with the derivative of a reading by what belongs to it alone.
    fn add(
        &mut self,
        bundle: &Bundle<'_>,
        visits: &[Vec<usize>],
        own: Option<impl Fn(usize) -> DMatrix<f64>>,
        tied: Option<&HashSet<(usize, usize)>>,
    ) -> Option<()> {
        let of: Vec<(usize, usize)> =
            visits.iter().flatten().flat_map(|&n| (0..3).map(move |c| (n, c))).collect();
        let sigma_mm: Vec<f64> = of.iter().map(|&(n, c)| bundle.weights[n].sigma_mm[c]).collect();
        let reduced = match own {
            None => None,
            Some(own) => {
                let blocks: Vec<_> = visits.iter().flatten().map(|&n| own(n)).collect();
                let width = blocks.first()?.ncols();
                let design = DMatrix::from_fn(of.len(), width, |i, j| {
                    blocks[i / 3][(i % 3, j)] / sigma_mm[i]
                });
                let counts: Vec<usize> = visits.iter().map(|v| 3 * v.len()).collect();
                let is_free = |i: &usize| tied.is_some_and(|tied| !tied.contains(&of[*i]));
                let free: Vec<usize> = (0..of.len()).filter(is_free).collect();
                Some(reduce(&design, &counts, &free)?)
            }
        };
        let tied: Vec<usize> =
            reduced.as_ref().map_or_else(|| (0..of.len()).collect(), |r| r.tied_to.clone());
        self.tied_to.extend(tied.iter().map(|&i| of[i]));
        self.sigma_mm.extend(tied.iter().map(|&i| sigma_mm[i]));
        self.units.push(Unit { of, sigma_mm, reduced });
        Some(())
    }

    pub(super) fn len(&self) -> usize {
        self.tied_to.len()
    }

    /// Of what components of readings the rows of every unit are combinations, each over its standard
    /// uncertainty: a reading far off is one there, and among the rows it is spread over several.
    pub(super) fn projected(&self) -> Vec<Projected> {
        let mut first_row = 0;
        let mut all = Vec::new();
        for unit in &self.units {
            let Some(reduced) = &unit.reduced else {
                first_row += unit.of.len();
                continue;
            };
            let combination = reduced.transformation.clone();
            let n_rows = combination.nrows();
            all.push(Projected { first_row, readings: unit.of.clone(), combination });
            first_row += n_rows;
        }
        all
    }

    /// Length of a column of three components per reading before anything is taken out of it, each
    /// over its standard uncertainty.
    pub(super) fn whitened_norm(&self, column: &[f64]) -> f64 {
        let of_unit = |unit: &Unit| -> f64 {
            let pairs = unit.of.iter().zip(&unit.sigma_mm);
            pairs.map(|(&(n, c), sigma)| (column[3 * n + c] / sigma).powi(2)).sum()
        };
        self.units.iter().map(of_unit).sum::<f64>().sqrt()
    }

    /// Columns given for every component of every reading, as columns of the reduced rows.
    pub(super) fn columns(
        &self,
        width: usize,
        value: impl Fn(usize, usize, usize) -> f64,
    ) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.len(), width);
        let mut start = 0;
        for unit in &self.units {
            let whitened = DMatrix::from_fn(unit.of.len(), width, |i, column| {
                let (target, component) = unit.of[i];
                value(target, component, column) / unit.sigma_mm[i]
            });
            let mut own = match &unit.reduced {
                Some(reduced) => &reduced.transformation * whitened,
                None => whitened,
            };
            for (i, mut row) in own.row_iter_mut().enumerate() {
                row *= self.sigma_mm[start + i];
            }
            out.rows_mut(start, own.nrows()).copy_from(&own);
            start += own.nrows();
        }
        out
    }
}

/// Readings of each of the steps, in order; steps without any are left out.
fn visits(
    bundle: &Bundle<'_>,
    steps: &[usize],
    is_wanted: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let of = |&step: &usize| {
        let angle = bundle.angle_of_step[step];
        let at_step = bundle.targets_of[angle].iter().copied();
        at_step.filter(|&n| bundle.survey.targets[n].step == step && is_wanted(n)).collect()
    };
    steps.iter().map(of).filter(|v: &Vec<usize>| !v.is_empty()).collect()
}
