//! The residual of the declared model, in which motions by time are looked for.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::count::count;

/// Share of a column's length that must be left beside the model: rows are linear to no more.
const NOTHING_LEFT: f64 = 1e-3;

/// By which station, at which step and when a reading was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) station: usize,
    pub(crate) step: usize,
    pub(crate) time: f64,
}

/// What moves against the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moving {
    /// The machine, against all stations.
    Machine,
    /// The station of each reading.
    Stations,
}

/// Whitened rows of what a motion does that has come so far at every reading, and the length of each
/// column before anything was taken out of its rows.
pub(crate) type Rows<'a> = dyn Fn(Moving, &[f64]) -> (DMatrix<f64>, Vec<f64>) + 'a;

/// A residual in which motions are looked for.
#[derive(Clone, Copy)]
pub(crate) struct LookedThrough<'a> {
    pub(crate) readings: &'a [Seen],
    /// Orthonormal basis of the fitted parameters' whitened columns, and the residual beside it.
    pub(crate) basis: &'a DMatrix<f64>,
    pub(crate) residual: &'a DVector<f64>,
    pub(crate) rows: &'a Rows<'a>,
}

impl LookedThrough<'_> {
    /// What motions with these courses take together of the sum of squares, and the directions that
    /// they show; `None` where they show none.
    pub(crate) fn taken(&self, moving: Moving, shares: &[Vec<f64>]) -> Option<(f64, usize)> {
        let mut shown: Vec<DVector<f64>> = Vec::new();
        for share in shares {
            let (tangent, whole) = (self.rows)(moving, share);
            let left = &tangent - self.basis * self.basis.tr_mul(&tangent);
            for (column, whole) in left.column_iter().zip(&whole) {
                let mut rest = column.into_owned();
                // Twice: what is left may be a thousandth.
                for _ in 0..2 {
                    for known in &shown {
                        let along = known.dot(&rest);
                        rest.axpy(-along, known, 1.0);
                    }
                }
                let length = rest.norm();
                if length > NOTHING_LEFT * whole {
                    rest.unscale_mut(length);
                    shown.push(rest);
                }
            }
        }
        let taken = shown.iter().map(|way| way.dot(self.residual).powi(2)).sum();
        (!shown.is_empty()).then_some((taken, shown.len()))
    }

    /// That what is taken rises so by chance with so many parameters, from before to after.
    pub(crate) fn p_value(&self, taken: [f64; 2], parameters: [usize; 2]) -> f64 {
        let more = parameters[1].saturating_sub(parameters[0]);
        let fitted = self.basis.ncols() + parameters[1];
        let dof = self.residual.len().checked_sub(fitted).filter(|dof| *dof > 0 && more > 0);
        let Some(dof) = dof else { return 1.0 };
        let left = (self.residual.norm_squared() - taken[1]).max(f64::MIN_POSITIVE);
        let f = (taken[1] - taken[0]).max(0.0) / count(more) / (left / count(dof));
        FisherSnedecor::new(count(more), count(dof)).map_or(1.0, |law| law.sf(f))
    }
}
