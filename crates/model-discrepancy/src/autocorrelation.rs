//! Correlation of successive observations, the commonest colour of noise.

use std::iter;
use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::basis::Basis;
use crate::colour::Whitening;
use crate::linear::Linear;
use crate::readings::Readings;
use crate::significance::{MIN_CLUSTERS, count, f_tail};
use crate::whiteness::groups_are_runs;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of a colour's parameter that are compared, zero included: finer than any data set can
/// tell.
const STEPS: usize = 20;

/// Largest memory: at one half the noise is 1/f and no longer stationary.
const MAX_MEMORY: f64 = 0.45;

/// Longest series for which more than neighbours is tried: the cost grows with the square of the
/// length and faster.
const MAX_LENGTH: usize = 512;

/// Colours less likely than this, beside the likeliest, are left out.
const NEGLIGIBLE: f64 = 1e-4;

/// A system's columns under each colour that its noise may have: the same for every candidate
/// beside it, and found when first asked for.
#[derive(Default)]
pub(crate) struct Colours {
    readings: OnceLock<Option<Readings>>,
    neighbours: OnceLock<Family>,
    memory: OnceLock<Option<Family>>,
    neighbouring_readings: OnceLock<Option<Family>>,
    memory_of_readings: OnceLock<Option<Family>>,
    position: OnceLock<Option<Family>>,
}

impl Colours {
    /// What the rows are combinations of, where they are.
    fn readings(&self, lin: &Linear<'_>) -> Option<&Readings> {
        self.readings.get_or_init(|| Readings::of(lin)).as_ref()
    }

    /// Noise of which neighbours agree.
    fn neighbours(&self, lin: &Linear<'_>) -> &Family {
        self.neighbours.get_or_init(|| Family::of_rows(lin, Kind::Neighbours))
    }

    /// The same in the readings behind the rows.
    fn neighbouring_readings(&self, lin: &Linear<'_>) -> Option<&Family> {
        let of = || Some(Family::of_readings(lin, self.readings(lin)?, Kind::Neighbours));
        self.neighbouring_readings.get_or_init(of).as_ref()
    }

    /// Noise of long memory; `None` where it is not tried.
    ///
    /// Where groups are runs of readings it is not: from the readings of a run it would tell how
    /// far runs agree, which the scatter between runs tells better. Unless there are too few runs
    /// to tell, or the model says that its records run on through several groups: what wanders more
    /// slowly than a group lasts is in no scatter between groups.
    fn memory(&self, lin: &Linear<'_>) -> Option<&Family> {
        let of = || {
            let is_long = longest(&lin.series) > MAX_LENGTH;
            let runs_tell = groups_are_runs(lin) && lin.clusters.len() >= MIN_CLUSTERS;
            let is_tried = !is_long && (!runs_tell || lin.runs_on);
            is_tried.then(|| Family::of_rows(lin, Kind::Memory))
        };
        self.memory.get_or_init(of).as_ref()
    }

    /// The same in the readings behind the rows.
    fn memory_of_readings(&self, lin: &Linear<'_>) -> Option<&Family> {
        let of = || Some(Family::of_readings(lin, self.readings(lin)?, Kind::Memory));
        self.memory_of_readings.get_or_init(of).as_ref()
    }

    /// Noise of the machine's position, of which neighbours agree; `None` where readings are not
    /// along a direction each.
    fn position(&self, lin: &Linear<'_>) -> Option<&Family> {
        let of = || {
            let ([one], Some(all)) = (&lin.series[..], &lin.directions) else { return None };
            let directions = || one.iter().map(|&i| all[i]).collect();
            let is_short = one.len() <= MAX_LENGTH;
            is_short.then(|| Family::of_rows(lin, Kind::Position(directions())))
        };
        self.position.get_or_init(of).as_ref()
    }
}

/// Colours of one kind, from white to the strongest, each found when first asked for.
struct Family {
    kind: Kind,
    base: DMatrix<f64>,
    series: Vec<Vec<usize>>,
    colours: [OnceLock<Option<Coloured>>; STEPS],
}

/// How successive values depend on each other.
enum Kind {
    Neighbours,
    Memory,
    /// Along which direction each value reads a position.
    Position(Vec<Vector3<f64>>),
}

impl Family {
    fn of_rows(lin: &Linear<'_>, kind: Kind) -> Self {
        let (base, series) = (lin.basis.matrix(), lin.series.clone());
        Self { kind, base, series, colours: Default::default() }
    }

    fn of_readings(lin: &Linear<'_>, readings: &Readings, kind: Kind) -> Self {
        let (base, series) = (readings.lift_base(&lin.basis.matrix()), readings.series.clone());
        Self { kind, base, series, colours: Default::default() }
    }

    /// The base under each colour, white first; without those under which it has no information.
    fn colours(&self) -> impl Iterator<Item = &Coloured> {
        let of = |step: usize| {
            let whitening = self.whitening(count(step) / count(STEPS - 1))?;
            Coloured::new(&self.series, &self.base, whitening)
        };
        let colours = self.colours.iter().enumerate();
        colours.filter_map(move |(step, colour)| colour.get_or_init(|| of(step)).as_ref())
    }

    fn whitening(&self, share: f64) -> Option<Whitening> {
        match &self.kind {
            Kind::Neighbours => Some(Whitening::Neighbours(MAX_PHI * share)),
            Kind::Memory => Some(Whitening::memory(MAX_MEMORY * share, longest(&self.series))),
            Kind::Position(directions) => Whitening::read_along(MAX_PHI * share, directions),
        }
    }
}

fn longest(series: &[Vec<usize>]) -> usize {
    series.iter().map(Vec::len).max().unwrap_or(0)
}

/// What is tested, beside everything it is tested beside.
pub(crate) struct Tested<'a> {
    lin: &'a Linear<'a>,
    /// Columns beside `lin.basis`, the tested ones last, then what they all leave of the data.
    columns: DMatrix<f64>,
    /// Share of the data in each tested column.
    along: DVector<f64>,
}

impl<'a> Tested<'a> {
    /// The last `n_tested` columns of `full`, which begins with the columns of `lin.basis`;
    /// `residual` is what the columns before them leave of the data.
    pub(crate) fn new(
        lin: &'a Linear<'a>,
        full: &Basis,
        n_tested: usize,
        residual: &DVector<f64>,
    ) -> Self {
        let columns = full.columns_from(lin.basis.dim());
        let beside = columns.ncols();
        let tested = columns.columns(beside - n_tested, n_tested);
        let along = tested.tr_mul(residual);
        // Without what the tested columns explain, so that no digits are lost in the products.
        let rest = residual - tested * &along;
        let mut columns = columns.insert_column(beside, 0.0);
        columns.set_column(beside, &rest);
        Self { lin, columns, along }
    }

    /// p-values with coloured noise along the measured order, where white is not the likeliest:
    /// noise of which neighbours agree, of long memory, and of the machine's position. Each is found
    /// when it is asked for.
    pub(crate) fn p_values(&self) -> impl Iterator<Item = f64> {
        let (lin, colours) = (self.lin, &self.lin.colours);
        let of = |family| self.p_value(&self.columns, family);
        let neighbours = iter::once_with(move || of(colours.neighbours(lin)));
        let memory = iter::once_with(move || of(colours.memory(lin)?));
        let position = iter::once_with(move || of(colours.position(lin)?));
        neighbours.chain(memory).chain(position).flatten()
    }

    /// The same with the noise in the readings behind the rows, where there are such.
    pub(crate) fn p_values_of_readings(&self) -> impl Iterator<Item = f64> {
        let (lin, colours) = (self.lin, &self.lin.colours);
        let of = |family| self.p_value(&colours.readings(lin)?.lift(&self.columns), family);
        let neighbours = iter::once_with(move || of(colours.neighbouring_readings(lin)?));
        let memory = iter::once_with(move || of(colours.memory_of_readings(lin)?));
        neighbours.chain(memory).flatten()
    }

    /// The colour is not known, and the variance of a slow effect depends on it: the mean over
    /// the colours, each as likely as the data make it; before them, that the noise is white is as
    /// likely as that it has any memory. Restricted likelihood (Patterson and
    /// Thompson 1971): unlike the plain lag-one correlation it is not pulled towards zero by what
    /// the fit has taken out.
    fn p_value(&self, columns: &DMatrix<f64>, family: &Family) -> Option<f64> {
        let mut judged: Vec<Judged> = Vec::with_capacity(STEPS);
        let mut best = f64::INFINITY;
        let judge = |c: &Coloured| c.judge(&family.series, columns, &self.along);
        for colour in family.colours().filter_map(judge) {
            best = best.min(colour.deviance);
            // Stronger ones are less likely still.
            let is_negligible = colour.deviance - best > 2.0 * NEGLIGIBLE.recip().ln();
            judged.push(colour);
            if is_negligible {
                break;
            }
        }
        // White is the first.
        let (white, others) = judged.split_first().filter(|(white, _)| white.deviance > best)?;
        let share = |c: &Judged| (0.5 * (best - c.deviance)).exp();
        let of_white = (count(STEPS - 1) * share(white), white.p_value);
        let shares = others.iter().map(|c| (share(c), c.p_value)).chain([of_white]);
        let likely: Vec<_> = shares.filter(|(share, _)| *share > NEGLIGIBLE).collect();
        let sum: f64 = likely.iter().map(|(share, _)| share).sum();
        Some(likely.iter().map(|(share, p_value)| share * p_value).sum::<f64>() / sum)
    }
}

/// A system's columns under one colour of the noise.
struct Coloured {
    whitening: Whitening,
    /// The whitened columns.
    base: DMatrix<f64>,
    /// Cholesky factor of their information.
    factor: DMatrix<f64>,
    /// Logarithm of the determinants of the noise and of the columns' information.
    volume: f64,
}

/// A candidate under one colour of the noise.
struct Judged {
    /// Minus twice the restricted log likelihood, up to a constant.
    deviance: f64,
    /// Of the F test of what is tested.
    p_value: f64,
}

impl Coloured {
    fn new(series: &[Vec<usize>], base: &DMatrix<f64>, whitening: Whitening) -> Option<Self> {
        let base = whitening.apply(series, base);
        let factor = (base.transpose() * &base).cholesky()?.unpack();
        let information: f64 = factor.diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        let volume = whitening.volume(series) + information;
        Some(Self { whitening, base, factor, volume })
    }

    fn judge(
        &self,
        series: &[Vec<usize>],
        columns: &DMatrix<f64>,
        along: &DVector<f64>,
    ) -> Option<Judged> {
        let white = self.whitening.apply(series, columns);
        let shared = self.factor.solve_lower_triangular(&self.base.tr_mul(&white))?;
        let products = white.transpose() * &white - shared.transpose() * &shared;
        let (n, m) = (columns.ncols() - 1, along.len());
        let dof = count(columns.nrows().saturating_sub(self.base.ncols() + n));
        let factor = products.cholesky()?.unpack();
        let square = factor[(n, n)].powi(2);
        let volume: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        // The row of the data, with what the tested columns explained put back.
        let own = factor.view((n - m, n - m), (m, m)).tr_mul(along);
        let explained = (own + factor.view((n, n - m), (1, m)).transpose()).norm_squared();
        let p_value = f_tail(explained / count(m) / (square / dof), count(m), dof);
        Some(Judged { deviance: dof * square.ln() + volume + self.volume, p_value })
    }
}

/// Significance of the lag-one correlation (normal approximation, one-sided for `φ > 0`).
pub(crate) fn lag_one_z(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> f64 {
    let (raw, expected, pairs) = lag_one_terms(lin, q, residual);
    (raw - expected) * pairs.sqrt()
}

fn lag_one_terms(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> (f64, f64, f64) {
    let (mut lagged, mut square, mut leaked, mut free, mut pairs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for one in &lin.series {
        for &i in one {
            square += residual[i] * residual[i];
            free += 1.0 - q.row(i).norm_squared();
        }
        for pair in one.windows(2) {
            lagged += residual[pair[0]] * residual[pair[1]];
            leaked -= q.row(pair[0]).dot(&q.row(pair[1]));
            pairs += 1.0;
        }
    }
    if square <= 0.0 || free <= 0.0 {
        return (0.0, 0.0, pairs);
    }
    (lagged / square, leaked / free, pairs)
}
