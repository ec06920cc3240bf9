//! Readings at which something may have changed for good: where a beam was lost or a reflector slipped; and
//! readings that are off by themselves.
//!
//! A lock has as many possible jumps as readings, and testing all of them in the loop would cost
//! every other effect its significance. So the catalogue holds, for each dead path, each station and
//! each reflector, a change in the middle of the run; one after every gap in a lock's readings,
//! where a beam was broken; and one wherever the residual of the declared model shows a change so
//! clearly that white noise does it nowhere in a hundred surveys; single readings only of that sort. Such a change says among how many
//! it was found: noise of another colour looks like one far more often, and only the loop knows
//! the colour.

use model_discrepancy::chance_to_explain;
use nalgebra::{DMatrix, DVector};

use crate::count::count;
use crate::missing::change::{Change, Offered};
use crate::missing::looked_through::Fit;
use crate::missing::reduction::{Reduction, of_ranges};
use crate::missing::sights::Sight;
use crate::network::Network;

/// Chance that a survey without any change shows one.
const FALSE_ALARM: f64 = 0.01;
/// Changes found in the residual that are offered at most, the clearest.
const MOST_FOUND: usize = 6;
/// Single readings found in the residual that are offered at most, the clearest.
const MOST_READINGS: usize = 3;
/// Gaps of one dead path that are offered at most, the first.
const MOST_GAPS: usize = 4;

/// Share of a reading's column that the declared model must leave before its error is looked at.
const MIN_SEEN: f64 = 0.02;

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

/// What may change, and the visits at which it was measured.
struct Thing {
    /// Dead path of a station and mount, or a mount; from the first range on.
    of: Change,
    /// In the order measured.
    visits: Vec<Visit>,
}

/// Successive ranges of one thing at one step.
struct Visit {
    step: usize,
    ranges: Vec<usize>,
}

/// Changes for the catalogue, in the order of things and readings, and the clearest that the residual
/// shows.
pub(crate) fn changes(fitted: &Fitted<'_>) -> (Vec<Offered>, Option<Change>) {
    let things = things(fitted.network);
    let mut found: Vec<Change> = Vec::new();
    for Thing { of, visits } in &things {
        if visits.len() >= 2 {
            found.push(of.at(visits[visits.len() / 2].ranges[0]));
        }
        if matches!(of, Change::DeadPath { .. }) {
            let gaps = visits.windows(2).filter(|w| w[1].step.abs_diff(w[0].step) > 1);
            found.extend(gaps.take(MOST_GAPS).map(|w| of.at(w[1].ranges[0])));
        }
    }
    let trials: usize = things.iter().map(|t| t.visits.len().saturating_sub(1)).sum();
    let mut clear: Vec<(f64, Change)> = (things.iter())
        .filter_map(|thing| clearest(fitted, thing))
        .filter(|(p_value, _)| *p_value * count(trials) <= FALSE_ALARM)
        .collect();
    clear.sort_by(|a, b| a.0.total_cmp(&b.0));
    let clearest = clear.first().map(|(_, change)| *change);
    let by_run = found.into_iter().map(|change| Offered { change, searched: 1 });
    let seen = clear.into_iter().take(MOST_FOUND);
    let seen = seen.map(|(_, change)| Offered { change, searched: trials });
    let n_ranges = fitted.network.survey.ranges.len();
    let mut off: Vec<(f64, Change)> = (0..n_ranges)
        .filter_map(|range| alone(fitted, range))
        .filter(|(p_value, _)| *p_value * count(n_ranges) <= FALSE_ALARM)
        .collect();
    off.sort_by(|a, b| a.0.total_cmp(&b.0));
    let off = off.into_iter().take(MOST_READINGS);
    let off = off.map(|(_, change)| Offered { change, searched: n_ranges });
    let mut offered: Vec<_> = by_run.chain(seen).chain(off).collect();
    // What the run alone offers goes first, and is not searched for again.
    offered.sort_by_key(|o| (o.change.key(), o.searched));
    offered.dedup_by_key(|o| o.change);
    (offered, clearest)
}

impl Fitted<'_> {
    /// Basis and residual with a change fitted as well.
    pub(crate) fn beside(&self, change: Change) -> (DMatrix<f64>, DVector<f64>) {
        let added = self.left_of(self.tangent(change)).qr().q();
        let residual = self.residual - &added * added.tr_mul(self.residual);
        let known = self.basis.ncols();
        let mut basis = self.basis.clone().resize_horizontally(known + added.ncols(), 0.0);
        basis.columns_mut(known, added.ncols()).copy_from(&added);
        (basis, residual)
    }

    /// Chance that so many amplitudes explain so much of the sum of squares.
    fn p_value(&self, explained: f64, width: usize) -> f64 {
        let dof = self.residual.len().saturating_sub(self.basis.ncols() + width);
        let left = (self.residual.norm_squared() - explained).max(0.0);
        chance_to_explain(explained / left, width, dof)
    }

    /// What the shared parameters leave of whitened columns.
    pub(crate) fn left_of(&self, tangent: DMatrix<f64>) -> DMatrix<f64> {
        let taken = self.basis * self.basis.tr_mul(&tangent);
        tangent - taken
    }

    /// What a change does to the rows, whitened.
    fn tangent(&self, change: Change) -> DMatrix<f64> {
        let survey = self.network.survey;
        let width = self.sights.first().map_or(0, |sight| change.column(sight).len());
        let columns = of_ranges(self.sights.len(), width, |r| {
            let touched = if change.touches(survey, r) { 1.0 / self.sigma_mm } else { 0.0 };
            change.column(&self.sights[r]).iter().map(|v| v * touched).collect()
        });
        // Prior rows come last, and are of no range.
        self.reduction.columns(&columns).resize_vertically(self.residual.len(), 0.0)
    }

    /// A fit with this basis and residual, as it sees the ranges.
    pub(crate) fn of_ranges(&self, basis: &DMatrix<f64>, residual: &DVector<f64>) -> Fit {
        let residual_alone = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
        Fit {
            shared: self.reduction.of_ranges(basis).transpose(),
            own: self.reduction.taken_out(self.sights),
            residual: self.reduction.of_ranges(&residual_alone).column(0).into_owned(),
            square: residual.norm_squared(),
            dof: residual.len().saturating_sub(basis.ncols()),
        }
    }
}

impl Change {
    fn at(self, from: usize) -> Self {
        match self {
            Self::DeadPath { station, mount, .. } => Self::DeadPath { station, mount, range: from },
            Self::Mount { mount, .. } => Self::Mount { mount, range: from },
            Self::Reading { .. } => Self::Reading { range: from },
        }
    }

    fn key(self) -> (usize, usize, usize, usize) {
        match self {
            Self::DeadPath { station, mount, range } => {
                (0, station, mount.map_or(0, |j| j + 1), range)
            }
            Self::Mount { mount, range } => (1, mount, 0, range),
            Self::Reading { range } => (2, 0, 0, range),
        }
    }

    /// What one unit of it does to the residual of a range, mm.
    fn column(self, sight: &Sight) -> Vec<f64> {
        match self {
            Self::DeadPath { .. } | Self::Reading { .. } => vec![-1.0],
            Self::Mount { .. } => sight.by_mount.iter().copied().collect(),
        }
    }
}

fn things(network: &Network<'_>) -> Vec<Thing> {
    let survey = network.survey;
    let paths = network.dead_paths.iter().map(|&(station, mount)| Change::DeadPath {
        station,
        mount,
        range: 0,
    });
    let mounts = (0..survey.mounts.len()).map(|mount| Change::Mount { mount, range: 0 });
    // All dead paths of a station at once: its tracer lost its count, or was knocked.
    let has_locks = network.dead_paths.iter().any(|(_, mount)| mount.is_some());
    let stations = (0..survey.stations.len())
        .filter(|_| has_locks)
        .map(|station| Change::DeadPath { station, mount: None, range: 0 });
    paths
        .chain(stations)
        .chain(mounts)
        .map(|of| {
            let mut visits: Vec<Visit> = Vec::new();
            for index in (0..survey.ranges.len()).filter(|&r| of.touches(survey, r)) {
                let step = survey.ranges[index].step;
                match visits.last_mut() {
                    Some(last) if last.step == step => last.ranges.push(index),
                    _ => visits.push(Visit { step, ranges: vec![index] }),
                }
            }
            Thing { of, visits }
        })
        .collect()
}

/// The reading from which on a change of a thing takes most of the residual away, and its p-value.
fn clearest(fitted: &Fitted<'_>, thing: &Thing) -> Option<(f64, Change)> {
    let width = thing.of.column(fitted.sights.first()?).len();
    let rows = fitted.residual.len();
    let mut tangent = DMatrix::zeros(rows, width);
    let mut along = DMatrix::zeros(fitted.basis.ncols(), width);
    let mut best: Option<(f64, usize)> = None;
    // From the last visit backwards, so that each change is the one before and one visit more.
    for Visit { step, ranges } in thing.visits.iter().skip(1).rev() {
        let whitened = |&r: &usize| {
            let column = thing.of.column(&fitted.sights[r]);
            (r, column.iter().map(|v| v / fitted.sigma_mm).collect())
        };
        let columns: Vec<_> = ranges.iter().map(whitened).collect();
        let angle = fitted.network.angle_of_step[*step];
        let (start, added) = fitted.reduction.impulse(angle, &columns);
        along += fitted.basis.rows(start, added.nrows()).tr_mul(&added);
        let mut touched = tangent.rows_mut(start, added.nrows());
        touched += added;
        let normal = tangent.tr_mul(&tangent) - along.tr_mul(&along);
        let score = tangent.tr_mul(fitted.residual);
        let Some(factor) = normal.cholesky() else { continue };
        let explained = score.dot(&factor.solve(&score));
        if best.is_none_or(|(most, _)| explained > most) {
            best = Some((explained, ranges[0]));
        }
    }
    let (explained, range) = best?;
    Some((fitted.p_value(explained, width), thing.of.at(range)))
}

/// One range with an error of its own, and its p-value.
fn alone(fitted: &Fitted<'_>, range: usize) -> Option<(f64, Change)> {
    let change = Change::Reading { range };
    let column = change.column(&fitted.sights[range]).iter().map(|v| v / fitted.sigma_mm).collect();
    let network = fitted.network;
    let angle = network.angle_of_step[network.survey.ranges[range].step];
    let (start, added) = fitted.reduction.impulse(angle, &[(range, column)]);
    let n = added.nrows();
    let along = fitted.basis.rows(start, n).tr_mul(&added);
    let left = added.norm_squared() - along.norm_squared();
    if left <= MIN_SEEN * added.norm_squared() {
        return None;
    }
    let explained = added.dot(&fitted.residual.rows(start, n)).powi(2) / left;
    Some((fitted.p_value(explained, 1), change))
}
