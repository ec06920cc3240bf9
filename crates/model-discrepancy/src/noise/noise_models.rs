//! Noise models that the noise of a system may have, and the system under each.

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::algebra::f_tail::f_tail;
use crate::algebra::leverage::Leverage;
use crate::algebra::linearised::Linearised;
use crate::algebra::linearised::groups_are_runs;
use crate::algebra::product::{gram, tr_times};
use crate::algebra::raw_observations::RawObservations;
use crate::algebra::reading::{Reading, left_by};
use crate::count::count;
use crate::levels::MIN_CLUSTERS;
use crate::noise::neighbours::Autoregression;
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
    all: OnceLock<Vec<Reading>>,
    free: OnceLock<Vec<(usize, f64)>>,
    leverages: OnceLock<Vec<Option<Leverage>>>,
}

impl NoiseModels {
    /// What the rows are combinations of, where they are.
    pub(crate) fn readings(&self, lin: &Linearised<'_>) -> Option<&RawObservations> {
        self.readings.get_or_init(|| RawObservations::of(lin)).as_ref()
    }

    /// The readings behind all rows that are reported.
    pub(crate) fn all_readings(&self, lin: &Linearised<'_>) -> &[Reading] {
        self.all.get_or_init(|| lin.readings())
    }

    /// Which of [`Self::all_readings`] the system leaves anything of, and the square of what it leaves, of
    /// one.
    pub(crate) fn free_readings(&self, lin: &Linearised<'_>) -> &[(usize, f64)] {
        let of = || {
            let all: Vec<&Reading> = self.all_readings(lin).iter().collect();
            let left = left_by(&lin.basis, &all).into_iter().enumerate();
            left.filter(|(_, left)| *left > 0.0).collect()
        };
        self.free.get_or_init(of)
    }

    /// What the system takes of each group; `None` where eigenvectors are not found.
    pub(crate) fn leverages(&self, lin: &Linearised<'_>) -> &[Option<Leverage>] {
        let all = || lin.clusters.iter().map(|rows| Leverage::of(&lin.basis, rows)).collect();
        self.leverages.get_or_init(all)
    }

    /// Noise of which neighbours agree.
    pub(crate) fn neighbours(&self, lin: &Linearised<'_>) -> &Family {
        self.neighbours.get_or_init(|| Family::neighbours(&lin.series, lin.basis.matrix()))
    }

    /// The same in the readings behind the rows.
    pub(crate) fn neighbours_in_readings(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || {
            let readings = self.readings(lin)?;
            let base = readings.lift_base(&lin.basis.matrix());
            Some(Family::neighbours(&readings.series, base))
        };
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
            is_tried.then(|| Family::new(Kind::Fractional(lin.basis.matrix()), &lin.series))
        };
        self.fractional.get_or_init(of).as_ref()
    }

    /// The same in the readings behind the rows.
    pub(crate) fn fractional_in_readings(&self, lin: &Linearised<'_>) -> Option<&Family> {
        let of = || {
            self.fractional(lin)?;
            let readings = self.readings(lin)?;
            let base = readings.lift_base(&lin.basis.matrix());
            Some(Family::new(Kind::Fractional(base), &readings.series))
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
            is_short
                .then(|| Family::new(Kind::Position(lin.basis.matrix(), directions()), &lin.series))
        };
        self.position.get_or_init(of).as_ref()
    }
}

/// Noise models of one kind, from white to the strongest, each found when first asked for.
pub(crate) struct Family {
    kind: Kind,
    series: Vec<Vec<usize>>,
    models: [OnceLock<Option<UnderModel>>; STEPS],
}

/// How successive values depend on each other.
enum Kind {
    Neighbours(Autoregression),
    /// With long memory: a system's columns.
    Fractional(DMatrix<f64>),
    /// As a position, with along which direction each value reads it.
    Position(DMatrix<f64>, Vec<Vector3<f64>>),
}

impl Family {
    fn new(kind: Kind, series: &[Vec<usize>]) -> Self {
        Self { kind, series: series.to_vec(), models: Default::default() }
    }

    fn neighbours(series: &[Vec<usize>], base: DMatrix<f64>) -> Self {
        Self::new(Kind::Neighbours(Autoregression::new(series, base)), series)
    }

    /// A candidate under each model, white first, where the system has information under it:
    /// `columns` beside those of the system, what is left of the data last, `along` the share of the
    /// data in the last ones before that.
    pub(crate) fn judged<'a>(
        &'a self,
        columns: &'a DMatrix<f64>,
        along: &'a DVector<f64>,
    ) -> impl Iterator<Item = UnderNoise> + 'a {
        let products = match &self.kind {
            Kind::Neighbours(noise) => Some(noise.with(&self.series, columns)),
            Kind::Fractional(_) | Kind::Position(..) => None,
        };
        (0..STEPS).filter_map(move |step| {
            let strength = count(step) / count(STEPS - 1);
            let model =
                self.models[step].get_or_init(|| UnderModel::new(self, strength)).as_ref()?;
            let [across, own] = match (&products, &self.kind) {
                (Some(products), _) => products.each_ref().map(|p| p.at(MAX_PHI * strength)),
                (None, Kind::Neighbours(_)) => return None,
                (None, Kind::Fractional(base) | Kind::Position(base, _)) => {
                    match &model.whitening {
                        Some(whitening) => {
                            let white = whitening.apply(&self.series, columns);
                            [
                                tr_times(base, &whitening.transposed(&self.series, &white)),
                                gram(&white),
                            ]
                        }
                        None => [tr_times(base, columns), gram(columns)],
                    }
                }
            };
            model.judge((&across, &own), along, columns.nrows())
        })
    }
}

fn longest(series: &[Vec<usize>]) -> usize {
    series.iter().map(Vec::len).max().unwrap_or(0)
}

/// A system's columns under one model of the noise.
struct UnderModel {
    /// What turns the noise white, where it is not; of neighbours products are enough.
    whitening: Option<Whitening>,
    /// Cholesky factor of the columns' information.
    factor: DMatrix<f64>,
    /// Logarithm of the determinants of the noise and of the columns' information.
    log_determinant: f64,
}

/// A candidate under one model of the noise.
pub(crate) struct UnderNoise {
    /// Square of what is left, whitened, and its degrees of freedom.
    pub(crate) square: f64,
    pub(crate) dof: f64,
    /// Logarithm of the determinants of the noise and of the information of all columns.
    log_determinant: f64,
    /// Square of what is tested explains, and in how many directions.
    explained: f64,
    tested: f64,
}

/// Where the variance of the noise is from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Variance {
    /// Declared: this is what the rows were whitened by, over that.
    Declared(f64),
    /// From what is left.
    Found,
}

impl UnderNoise {
    /// Minus twice the restricted log likelihood, up to a constant.
    pub(crate) fn deviance(&self, variance: Variance) -> f64 {
        self.log_determinant
            + match variance {
                Variance::Declared(over) => over * self.square,
                Variance::Found => self.dof * self.square.ln(),
            }
    }

    /// Of the test of what is tested: χ² where the variance is declared, and else F.
    pub(crate) fn p_value(&self, variance: Variance) -> f64 {
        match variance {
            Variance::Declared(over) => {
                ChiSquared::new(self.tested).map_or(1.0, |law| law.sf(over * self.explained))
            }
            Variance::Found => {
                let f = self.explained / self.tested / (self.square / self.dof);
                f_tail(f, self.tested, self.dof)
            }
        }
    }
}

impl UnderModel {
    /// `strength` is 0 for white noise, 1 for the longest memory.
    fn new(family: &Family, strength: f64) -> Option<Self> {
        let series = &family.series;
        let is_white = strength <= 0.0;
        let (base, whitening) = match &family.kind {
            Kind::Neighbours(noise) => {
                let phi = MAX_PHI * strength;
                return Self::of(&noise.own().at(phi), noise.log_determinant(phi), None);
            }
            Kind::Fractional(base) | Kind::Position(base, _) if is_white => (base, None),
            Kind::Fractional(base) => {
                (base, Some(Whitening::fractional(MAX_FRACTION * strength, longest(series))))
            }
            Kind::Position(base, directions) => {
                (base, Some(Whitening::read_along(MAX_PHI * strength, directions)))
            }
        };
        let of_noise = whitening.as_ref().map_or(0.0, |white| white.log_determinant(series));
        let information =
            whitening.as_ref().map_or_else(|| gram(base), |white| gram(&white.apply(series, base)));
        Self::of(&information, of_noise, whitening)
    }

    fn of(information: &DMatrix<f64>, of_noise: f64, whitening: Option<Whitening>) -> Option<Self> {
        let factor = information.clone().cholesky()?.unpack();
        let of_columns: f64 = factor.diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        Some(Self { whitening, factor, log_determinant: of_noise + of_columns })
    }

    /// From the products, whitened, of the system's columns with the candidate's, and of these.
    fn judge(
        &self,
        (across, own): (&DMatrix<f64>, &DMatrix<f64>),
        along: &DVector<f64>,
        rows: usize,
    ) -> Option<UnderNoise> {
        let shared = self.factor.solve_lower_triangular(across)?;
        let products = own - shared.transpose() * &shared;
        let (n, m) = (own.ncols() - 1, along.len());
        let dof = count(rows.saturating_sub(self.factor.ncols() + n));
        let factor = products.cholesky()?.unpack();
        let square = factor[(n, n)].powi(2);
        let log_determinant: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        // The row of the data, with what the tested columns explained put back.
        let own = factor.view((n - m, n - m), (m, m)).tr_mul(along);
        let explained = (own + factor.view((n, n - m), (1, m)).transpose()).norm_squared();
        let log_determinant = log_determinant + self.log_determinant;
        Some(UnderNoise { square, dof, log_determinant, explained, tested: count(m) })
    }
}
