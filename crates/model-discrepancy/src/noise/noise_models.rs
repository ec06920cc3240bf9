//! Noise models that the noise of a system may have, and the system under each.

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::algebra::f_tail::f_tail;
use crate::algebra::linearised::Linearised;
use crate::algebra::linearised::groups_are_runs;
use crate::algebra::raw_observations::RawObservations;
use crate::algebra::reading::Reading;
use crate::count::count;
use crate::levels::MIN_CLUSTERS;
use crate::noise::whitening::Whitening;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of a model's parameter that are compared, zero included: finer than any data set can
/// tell.
pub(crate) const STEPS: usize = 20;

/// Largest fractional: at one half the noise is 1/f and no longer stationary.
const MAX_FRACTION: f64 = 0.45;

/// Longest series for which more than neighbours is tried: the cost grows with the square of the
/// length and faster.
const MAX_LENGTH: usize = 512;

/// A system's columns under each model that its noise may have: the same for every candidate
/// beside it, and found when first asked for.
#[derive(Default)]
pub(crate) struct NoiseModels {
    readings: OnceLock<Option<RawObservations>>,
    neighbours: OnceLock<Family>,
    fractional: OnceLock<Option<Family>>,
    neighbours_in_readings: OnceLock<Option<Family>>,
    fractional_in_readings: OnceLock<Option<Family>>,
    position: OnceLock<Option<Family>>,
    free: OnceLock<Vec<(Reading, f64)>>,
}

impl NoiseModels {
    /// What the rows are combinations of, where they are.
    pub(crate) fn readings(&self, lin: &Linearised<'_>) -> Option<&RawObservations> {
        self.readings.get_or_init(|| RawObservations::of(lin)).as_ref()
    }

    /// Readings of which the system leaves anything, and the square of what it leaves, of one.
    pub(crate) fn free_readings(&self, lin: &Linearised<'_>) -> &[(Reading, f64)] {
        let of = |reading: Reading| {
            let left = reading.left_by(&lin.basis);
            (left > 0.0).then_some((reading, left))
        };
        self.free.get_or_init(|| lin.readings().into_iter().filter_map(of).collect())
    }

    /// Noise of which neighbours agree.
    pub(crate) fn neighbours(&self, lin: &Linearised<'_>) -> &Family {
        self.neighbours.get_or_init(|| Family::of_rows(lin, Kind::Neighbours))
    }

    /// The same in the readings behind the rows.
    pub(crate) fn neighbours_in_readings(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || Some(Family::of_readings(lin, self.readings(lin)?, Kind::Neighbours));
        self.neighbours_in_readings.get_or_init(of).as_ref()
    }

    /// Noise of long memory; `None` where it is not tried.
    ///
    /// Where groups are runs of readings it is not: from the readings of a run it would tell how
    /// far runs agree, which the scatter between runs tells better. Unless there are too few runs
    /// to tell, or the model says that its records run on through several groups: what wanders more
    /// slowly than a group lasts is in no scatter between groups.
    pub(crate) fn fractional(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || {
            let is_long = longest(&lin.series) > MAX_LENGTH;
            let runs_tell = groups_are_runs(lin) && lin.clusters.len() >= MIN_CLUSTERS;
            let is_tried = !is_long && (!runs_tell || lin.runs_on);
            is_tried.then(|| Family::of_rows(lin, Kind::Fractional))
        };
        self.fractional.get_or_init(of).as_ref()
    }

    /// The same in the readings behind the rows.
    pub(crate) fn fractional_in_readings(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || {
            self.fractional(lin)?;
            Some(Family::of_readings(lin, self.readings(lin)?, Kind::Fractional))
        };
        self.fractional_in_readings.get_or_init(of).as_ref()
    }

    /// Noise of the machine's position, of which neighbours agree; `None` where readings are not
    /// along a direction each.
    pub(crate) fn position(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || {
            let ([one], Some(all)) = (&lin.series[..], &lin.directions) else { return None };
            let directions = || one.iter().map(|&i| all[i]).collect();
            let is_short = one.len() <= MAX_LENGTH;
            is_short.then(|| Family::of_rows(lin, Kind::Position(directions())))
        };
        self.position.get_or_init(of).as_ref()
    }
}

/// Noise models of one kind, from white to the strongest, each found when first asked for.
pub(crate) struct Family {
    kind: Kind,
    base: DMatrix<f64>,
    pub(crate) series: Vec<Vec<usize>>,
    models: [OnceLock<Option<UnderModel>>; STEPS],
}

/// How successive values depend on each other.
enum Kind {
    Neighbours,
    Fractional,
    /// Along which direction each value reads a position.
    Position(Vec<Vector3<f64>>),
}

impl Family {
    fn of_rows(lin: &Linearised<'_>, kind: Kind) -> Self {
        let (base, series) = (lin.basis.matrix(), lin.series.clone());
        Self { kind, base, series, models: Default::default() }
    }

    fn of_readings(lin: &Linearised<'_>, readings: &RawObservations, kind: Kind) -> Self {
        let (base, series) = (readings.lift_base(&lin.basis.matrix()), readings.series.clone());
        Self { kind, base, series, models: Default::default() }
    }

    /// The base under each model, white first; without those under which it has no information.
    pub(crate) fn models(&self) -> impl Iterator<Item = &UnderModel> {
        let of = |step: usize| {
            let whitening = self.whitening(count(step) / count(STEPS - 1));
            UnderModel::new(&self.series, &self.base, whitening)
        };
        let models = self.models.iter().enumerate();
        models.filter_map(move |(step, model)| model.get_or_init(|| of(step)).as_ref())
    }

    fn whitening(&self, share: f64) -> Whitening {
        match &self.kind {
            Kind::Neighbours => Whitening::Neighbours(MAX_PHI * share),
            Kind::Fractional => Whitening::fractional(MAX_FRACTION * share, longest(&self.series)),
            Kind::Position(directions) => Whitening::read_along(MAX_PHI * share, directions),
        }
    }
}

fn longest(series: &[Vec<usize>]) -> usize {
    series.iter().map(Vec::len).max().unwrap_or(0)
}

/// A system's columns under one model of the noise.
pub(crate) struct UnderModel {
    whitening: Whitening,
    /// The whitened columns.
    base: DMatrix<f64>,
    /// Cholesky factor of their information.
    factor: DMatrix<f64>,
    /// Logarithm of the determinants of the noise and of the columns' information.
    log_determinant: f64,
}

/// A candidate under one model of the noise.
pub(crate) struct UnderNoise {
    /// Minus twice the restricted log likelihood, up to a constant.
    pub(crate) deviance: f64,
    /// Of the F test of what is tested.
    pub(crate) p_value: f64,
}

impl UnderModel {
    fn new(series: &[Vec<usize>], base: &DMatrix<f64>, whitening: Whitening) -> Option<Self> {
        let base = whitening.apply(series, base);
        let factor = (base.transpose() * &base).cholesky()?.unpack();
        let information: f64 = factor.diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        let log_determinant = whitening.log_determinant(series) + information;
        Some(Self { whitening, base, factor, log_determinant })
    }

    pub(crate) fn judge(
        &self,
        series: &[Vec<usize>],
        columns: &DMatrix<f64>,
        along: &DVector<f64>,
    ) -> Option<UnderNoise> {
        let white = self.whitening.apply(series, columns);
        let shared = self.factor.solve_lower_triangular(&self.base.tr_mul(&white))?;
        let products = white.transpose() * &white - shared.transpose() * &shared;
        let (n, m) = (columns.ncols() - 1, along.len());
        let dof = count(columns.nrows().saturating_sub(self.base.ncols() + n));
        let factor = products.cholesky()?.unpack();
        let square = factor[(n, n)].powi(2);
        let log_determinant: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        // The row of the data, with what the tested columns explained put back.
        let own = factor.view((n - m, n - m), (m, m)).tr_mul(along);
        let explained = (own + factor.view((n, n - m), (1, m)).transpose()).norm_squared();
        let p_value = f_tail(explained / count(m) / (square / dof), count(m), dof);
        Some(UnderNoise {
            deviance: dof * square.ln() + log_determinant + self.log_determinant,
            p_value,
        })
    }
}
