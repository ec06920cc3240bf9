//! Steps at which something may have changed for good: where a beam was lost or a reflector slipped.
//!
//! A lock has as many possible jumps as steps, and testing all of them in the loop would cost
//! every other effect its significance. So the catalogue holds, for each dead path and each
//! reflector, a change in the middle of the run; one after every gap in the readings, where a beam
//! was broken; and one wherever the residual of the declared model shows a change so clearly that
//! chance does it nowhere in a hundred surveys.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::effects::Change;
use crate::network::Network;
use crate::reduction::Reduction;
use crate::sights::Sight;

/// Chance that a survey without any change shows one.
const FALSE_ALARM: f64 = 0.01;
/// Changes found in the residual that are offered at most, the clearest.
const MOST_FOUND: usize = 6;
/// Gaps of one dead path that are offered at most, the first.
const MOST_GAPS: usize = 4;

/// The declared model at its solution, whitened.
pub(crate) struct Fitted<'a> {
    pub(crate) network: &'a Network<'a>,
    pub(crate) sights: &'a [Sight],
    pub(crate) reduction: &'a Reduction,
    /// Orthonormal basis of the shared parameters' columns; prior rows come last.
    pub(crate) basis: &'a DMatrix<f64>,
    /// Residual without what the basis explains.
    pub(crate) residual: &'a DVector<f64>,
    pub(crate) sigma_mm: f64,
}

/// What may change, and the steps at which it was measured.
struct Thing {
    /// Station and mount of a dead path; a mount alone.
    of: Change,
    /// Ranges that it touches, by step.
    ranges: Vec<(usize, Vec<usize>)>,
}

/// Changes for the catalogue, in the order of things and steps.
pub(crate) fn changes(fitted: &Fitted<'_>) -> Vec<Change> {
    let things = things(fitted.network);
    let mut found: Vec<Change> = Vec::new();
    for thing in &things {
        let steps: Vec<usize> = thing.ranges.iter().map(|(step, _)| *step).collect();
        if steps.len() >= 2 {
            found.push(thing.of.at(steps[steps.len() / 2]));
        }
        if matches!(thing.of, Change::DeadPath { .. }) {
            let gaps = steps.windows(2).filter(|w| w[1] > w[0] + 1).take(MOST_GAPS);
            found.extend(gaps.map(|w| thing.of.at(w[1])));
        }
    }
    let trials: usize = things.iter().map(|t| t.ranges.len().saturating_sub(1)).sum();
    let mut clear: Vec<(f64, Change)> = (things.iter())
        .filter_map(|thing| clearest(fitted, thing))
        .filter(|(p_value, _)| *p_value * count(trials) <= FALSE_ALARM)
        .collect();
    clear.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.extend(clear.into_iter().take(MOST_FOUND).map(|(_, change)| change));
    found.sort_by_key(|c| c.key());
    found.dedup();
    found
}

impl Change {
    fn at(self, at: usize) -> Self {
        match self {
            Self::DeadPath { station, mount, .. } => Self::DeadPath { station, mount, step: at },
            Self::Mount { mount, .. } => Self::Mount { mount, step: at },
        }
    }

    fn key(self) -> (usize, usize, usize, usize) {
        match self {
            Self::DeadPath { station, mount, step } => (0, station, mount.unwrap_or(0), step),
            Self::Mount { mount, step } => (1, mount, 0, step),
        }
    }

    /// What one unit of it does to the residual of a range, mm.
    fn column(self, sight: &Sight) -> Vec<f64> {
        match self {
            Self::DeadPath { .. } => vec![-1.0],
            Self::Mount { .. } => sight.by_mount.iter().copied().collect(),
        }
    }
}

fn things(network: &Network<'_>) -> Vec<Thing> {
    let survey = network.survey;
    let paths = network.dead_paths.iter().map(|&(station, mount)| Change::DeadPath {
        station,
        mount,
        step: 0,
    });
    let mounts = (0..survey.mounts.len()).map(|mount| Change::Mount { mount, step: 0 });
    paths
        .chain(mounts)
        .map(|of| {
            let touched = |step: usize| {
                let ranges = network.ranges_of_step[step].iter().copied();
                let own: Vec<_> = ranges.filter(|&r| of.touches(survey, r)).collect();
                (!own.is_empty()).then_some((step, own))
            };
            Thing { of, ranges: (0..survey.steps.len()).filter_map(touched).collect() }
        })
        .collect()
}

/// The step at which a change of a thing takes most of the residual away, and its p-value.
fn clearest(fitted: &Fitted<'_>, thing: &Thing) -> Option<(f64, Change)> {
    let width = thing.of.column(fitted.sights.first()?).len();
    let rows = fitted.residual.len();
    let mut tangent = DMatrix::zeros(rows, width);
    let mut along = DMatrix::zeros(fitted.basis.ncols(), width);
    let mut best: Option<(f64, usize)> = None;
    // From the last step backwards, so that each change is the one before and one step more.
    for (step, ranges) in thing.ranges.iter().skip(1).rev() {
        let columns: Vec<_> = (ranges.iter())
            .map(|&r| {
                (
                    r,
                    thing
                        .of
                        .column(&fitted.sights[r])
                        .iter()
                        .map(|v| v / fitted.sigma_mm)
                        .collect(),
                )
            })
            .collect();
        let (start, added) =
            fitted.reduction.impulse(fitted.network.angle_of_step[*step], &columns);
        along += fitted.basis.rows(start, added.nrows()).tr_mul(&added);
        let mut touched = tangent.rows_mut(start, added.nrows());
        touched += added;
        let normal = tangent.tr_mul(&tangent) - along.tr_mul(&along);
        let score = tangent.tr_mul(fitted.residual);
        let Some(explained) = normal.cholesky().map(|f| score.dot(&f.solve(&score))) else {
            continue;
        };
        if best.is_none_or(|(most, _)| explained > most) {
            best = Some((explained, *step));
        }
    }
    let (explained, step) = best?;
    let dof = rows.checked_sub(fitted.basis.ncols() + width).filter(|&d| d > 0)?;
    let left = (fitted.residual.norm_squared() - explained).max(0.0);
    let f = explained / count(width) / (left / count(dof));
    let law = FisherSnedecor::new(count(width), count(dof)).ok()?;
    let p_value = if f.is_nan() { 1.0 } else { law.sf(f) };
    Some((p_value, thing.of.at(step)))
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}
