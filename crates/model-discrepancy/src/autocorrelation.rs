//! Correlation of successive observations, the commonest colour of noise.

use std::iter;
use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::colour::Whitening;
use crate::linear::Linear;
use crate::significance::{MIN_CLUSTERS, count, f_tail};
use crate::whiteness::groups_are_runs;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of a colour's parameter that are compared, zero included: finer than any data set can
/// tell.
const STEPS: u32 = 20;

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
    neighbours: OnceLock<Vec<Coloured>>,
    memory: OnceLock<Vec<Coloured>>,
    position: OnceLock<Vec<Coloured>>,
}

impl Colours {
    /// Noise of which neighbours agree; white first.
    fn neighbours(&self, lin: &Linear<'_>) -> &[Coloured] {
        self.neighbours.get_or_init(|| grid(lin, MAX_PHI, |phi| Some(Whitening::Neighbours(phi))))
    }

    /// Noise of long memory; white first, and empty where it is not tried.
    ///
    /// Where groups are runs of readings it is not: from the readings of a run it would tell how
    /// far runs agree, which the scatter between runs tells better. Unless there are too few runs
    /// to tell, or the model says that its records run on through several groups: what wanders more
    /// slowly than a group lasts is in no scatter between groups.
    fn memory(&self, lin: &Linear<'_>) -> &[Coloured] {
        self.memory.get_or_init(|| {
            let longest = lin.series.iter().map(Vec::len).max().unwrap_or(0);
            let is_long = longest > MAX_LENGTH;
            let runs_tell = groups_are_runs(lin) && lin.clusters.len() >= MIN_CLUSTERS;
            if is_long || (runs_tell && !lin.runs_on) {
                return Vec::new();
            }
            grid(lin, MAX_MEMORY, |d| Some(Whitening::memory(d, longest)))
        })
    }

    /// Noise of the machine's position, of which neighbours agree; white first, and empty where
    /// readings are not along a direction each.
    fn position(&self, lin: &Linear<'_>) -> &[Coloured] {
        self.position.get_or_init(|| {
            let ([one], Some(all)) = (&lin.series[..], &lin.directions) else {
                return Vec::new();
            };
            if one.len() > MAX_LENGTH {
                return Vec::new();
            }
            let directions: Vec<_> = one.iter().map(|&i| all[i]).collect();
            grid(lin, MAX_PHI, |phi| Whitening::read_along(phi, &directions))
        })
    }
}

/// Colours from white to the strongest.
fn grid(lin: &Linear<'_>, strongest: f64, of: impl Fn(f64) -> Option<Whitening>) -> Vec<Coloured> {
    let base = lin.basis.matrix();
    (0..STEPS)
        .filter_map(|i| of(strongest * f64::from(i) / f64::from(STEPS - 1)))
        .filter_map(|whitening| Coloured::new(lin, &base, whitening))
        .collect()
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

    /// p-values with coloured noise along the measured order, of which white is not the likeliest:
    /// of which neighbours agree, of long memory, and of the machine's position. Each is found when
    /// it is asked for.
    pub(crate) fn p_values(&self) -> impl Iterator<Item = f64> {
        let (lin, colours) = (self.lin, &self.lin.colours);
        let neighbours = iter::once_with(|| self.p_value(colours.neighbours(lin)));
        let memory = iter::once_with(|| self.p_value(colours.memory(lin)));
        let position = iter::once_with(|| self.p_value(colours.position(lin)));
        neighbours.chain(memory).chain(position).flatten()
    }

    /// The colour is not known, and the variance of a slow effect depends on it: the mean over
    /// the colours, each as likely as the data make it; before them, that the noise is white is as
    /// likely as that it has any memory. Restricted likelihood (Patterson and
    /// Thompson 1971): unlike the plain lag-one correlation it is not pulled towards zero by what
    /// the fit has taken out.
    fn p_value(&self, colours: &[Coloured]) -> Option<f64> {
        let judged: Vec<Judged> = colours.iter().filter_map(|c| c.judge(self)).collect();
        let best = judged.iter().map(|c| c.deviance).fold(f64::INFINITY, f64::min);
        // White is the first.
        let (white, others) = judged.split_first().filter(|(white, _)| white.deviance > best)?;
        let share = |c: &Judged| (0.5 * (best - c.deviance)).exp();
        let of_white = (count(others.len()) * share(white), white.p_value);
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
    fn new(lin: &Linear<'_>, base: &DMatrix<f64>, whitening: Whitening) -> Option<Self> {
        let base = whitening.apply(&lin.series, base);
        let factor = (base.transpose() * &base).cholesky()?.unpack();
        let information: f64 = factor.diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        let volume = whitening.volume(&lin.series) + information;
        Some(Self { whitening, base, factor, volume })
    }

    fn judge(&self, tested: &Tested<'_>) -> Option<Judged> {
        let Tested { lin, columns, along } = tested;
        let white = self.whitening.apply(&lin.series, columns);
        let shared = self.factor.solve_lower_triangular(&self.base.tr_mul(&white))?;
        let products = white.transpose() * &white - shared.transpose() * &shared;
        let (n, m) = (columns.ncols() - 1, along.len());
        let dof = count(lin.rows.len().saturating_sub(self.base.ncols() + n));
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
