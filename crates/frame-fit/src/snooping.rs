//! One bad point at a time: Baarda's data snooping.

use least_squares::Problem;
use nalgebra::{DMatrix, DVector, SVector};

use crate::decompose::dynamic;
use crate::motion::Moved;
use crate::problem::FitProblem;
use crate::statistics::{chi2_tail, f_tail, noncentrality, ratio};
use crate::{FrameFit, FrameFitError, Noise, Options, PointPair, fit_frame, input};

/// Share of a bias that has to show in the residual for a direction to count as controlled.
const SMALLEST_REDUNDANCY: f64 = 1e-6;

/// How sure data snooping has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SnoopingOptions {
    /// Probability that any of the good points is called bad; shared among the points by Šidák.
    pub family_significance: f64,
    /// Probability with which a bias of the detectable size is found.
    pub power: f64,
    /// Most points to set aside.
    pub max_removed: usize,
}

impl Default for SnoopingOptions {
    /// 5 % for the whole set, power 80 %, and as many removals as the redundancy allows.
    fn default() -> Self {
        Self { family_significance: 0.05, power: 0.8, max_removed: usize::MAX }
    }
}

/// How well one point is controlled by the others, and what they say of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reliability<const D: usize> {
    /// Share of a bias of each coordinate that shows in its residual: 0 is uncontrolled, 1 full.
    pub redundancy: SVector<f64, D>,
    /// Baarda's `w` of each coordinate, standard normal for a good point (Pope's τ where the
    /// noise is estimated); 0 where uncontrolled.
    pub w: SVector<f64, D>,
    /// Smallest bias of each coordinate alone with which the point is found with the chosen
    /// power; infinite where uncontrolled.
    pub detectable_mm: SVector<f64, D>,
    /// Best estimate of the bias of the point; `None` where the others do not determine it.
    pub bias_mm: Option<SVector<f64, D>>,
    /// Drop of the weighted sum of squares when the point is left out; 0 where uncontrolled.
    pub chi2_drop: f64,
    /// Probability of such a drop for a good point, before sharing among the points: χ² where
    /// the noise is declared, F against the other points where it is estimated.
    pub p_value: f64,
}

/// A point that was set aside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Suspect<const D: usize> {
    /// Position in the input slice.
    pub index: usize,
    /// Estimate of its bias, `target − T·source` with `T` from the points kept.
    pub bias_mm: SVector<f64, D>,
    /// Probability of such a contradiction for a good point, before sharing among the points.
    pub p_value: f64,
}

/// Outcome of data snooping.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Snooping<const D: usize> {
    /// Points set aside, in the order found.
    pub suspects: Vec<Suspect<D>>,
    /// Positions of the points kept, in input order.
    pub kept: Vec<usize>,
    /// Reliability of each point kept, in the order of `kept`.
    pub reliability: Vec<Reliability<D>>,
    /// Critical probability of a single test in the last round.
    pub critical_p: f64,
    /// Fit to the points kept.
    pub fit: FrameFit<D>,
}

/// Sets aside, one at a time, the point that the others contradict most.
///
/// A point that only some directions of the others control is never set aside. After each
/// removal everything is fitted and judged anew.
///
/// # Errors
///
/// As [`fit_frame`].
pub fn snoop<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
    snooping: &SnoopingOptions,
) -> Result<Snooping<D>, FrameFitError> {
    let mut kept: Vec<usize> = (0..pairs.len()).collect();
    let mut fit = fit_frame(pairs, options)?;
    let mut removed = Vec::new();
    loop {
        let used: Vec<_> = kept.iter().map(|&i| pairs[i]).collect();
        let reliability = reliability(&used, &fit, snooping)?;
        let critical_p = critical_p(snooping, kept.len());
        let worst = (0..kept.len())
            .filter(|&k| reliability[k].bias_mm.is_some() && reliability[k].p_value < critical_p)
            // Not by the probability, which underflows for gross errors.
            .max_by(|&a, &b| reliability[a].chi2_drop.total_cmp(&reliability[b].chi2_drop));
        if let Some(worst) = worst.filter(|_| removed.len() < snooping.max_removed) {
            let mut fewer = used;
            fewer.remove(worst);
            // Where the rest does not carry a fit, the point has to stay.
            if let Ok(refit) = fit_frame(&fewer, options) {
                removed.push((kept.remove(worst), reliability[worst].p_value));
                fit = refit;
                continue;
            }
        }
        let suspects = removed
            .into_iter()
            .map(|(index, p_value)| Suspect {
                index,
                bias_mm: fit.residual_mm(&pairs[index]),
                p_value,
            })
            .collect();
        return Ok(Snooping { suspects, kept, reliability, critical_p, fit });
    }
}

/// Šidák (1967): the level of one of `tests` so that all of them together keep the family's.
fn critical_p(snooping: &SnoopingOptions, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-snooping.family_significance) / ratio(tests))
}

/// Reliability of every point of `fit`, which is the fit of the same `pairs`, in input order.
///
/// Baarda (1968). Points are judged as a whole, in two or three coordinates at a time; a robust
/// loss of the fit is left aside.
///
/// # Errors
///
/// [`FrameFitError::InvalidPair`].
pub fn reliability<const D: usize>(
    pairs: &[PointPair<D>],
    fit: &FrameFit<D>,
    snooping: &SnoopingOptions,
) -> Result<Vec<Reliability<D>>, FrameFitError> {
    input::check_pairs(pairs)?;
    let map = &fit.target_from_source;
    let problem = FitProblem::new(pairs, fit.transform, map);
    let whitened = problem.whitened(&Moved::still());
    let mut jacobian = DMatrix::zeros(problem.residual_count(), problem.tangent_dim());
    problem.jacobian(&Moved::still(), &mut jacobian);
    let orthonormal = jacobian.qr().q();
    // What rounding leaves of an exact fit is no contradiction.
    let chi2 = whitened.norm_squared().max(problem.round_off_chi2);
    let dof = problem.residual_count().saturating_sub(problem.tangent_dim());
    let judge =
        Judge::new::<D>(fit.noise, chi2, dof, critical_p(snooping, pairs.len()), snooping.power);
    let of_point = |i: usize| {
        let rows = orthonormal.rows(D * i, D);
        let redundancy = DMatrix::identity(D, D) - rows * rows.transpose();
        let residual = whitened.rows(D * i, D).into_owned();
        judge.point(&pairs[i], &redundancy, &residual)
    };
    Ok((0..pairs.len()).map(of_point).collect())
}

/// What is common to all points of a fit.
struct Judge {
    noise: Noise,
    chi2: f64,
    dof: usize,
    /// Detectable size of a fully controlled bias, in standard deviations, by the number of
    /// directions that are controlled.
    detectable_sigmas: Vec<f64>,
}

/// The directions of a point that the others control, in whitened coordinates.
struct Controlled {
    /// Unit direction, and the share of a bias along it that shows in the residual.
    directions: Vec<(DVector<f64>, f64)>,
}

impl Controlled {
    /// `redundancy` is the whitened block of `I − QQᵀ` of the point.
    fn of(redundancy: &DMatrix<f64>) -> Self {
        let eigen = redundancy.clone().symmetric_eigen();
        let directions = (0..redundancy.nrows())
            .map(|k| (eigen.eigenvectors.column(k).into_owned(), eigen.eigenvalues[k]))
            .filter(|(_, share)| *share > SMALLEST_REDUNDANCY)
            .collect();
        Self { directions }
    }

    fn count(&self) -> usize {
        self.directions.len()
    }

    /// Drop of the weighted sum of squares when the point is left out.
    fn chi2_drop(&self, residual: &DVector<f64>) -> f64 {
        self.directions.iter().map(|(along, share)| along.dot(residual).powi(2) / share).sum()
    }

    /// Whitened bias that the residual points to.
    fn bias(&self, residual: &DVector<f64>) -> DVector<f64> {
        let zero = DVector::zeros(residual.len());
        self.directions
            .iter()
            .fold(zero, |sum, (along, share)| sum + along * (along.dot(residual) / share))
    }
}

impl Judge {
    fn new<const D: usize>(
        noise: Noise,
        chi2: f64,
        dof: usize,
        critical_p: f64,
        power: f64,
    ) -> Self {
        let mut judge = Self { noise, chi2, dof, detectable_sigmas: vec![f64::INFINITY] };
        for controlled in 1..=D {
            judge.detectable_sigmas.push(match judge.others(controlled) {
                Some(0) => f64::INFINITY,
                others => noncentrality(critical_p, power, controlled, others).sqrt(),
            });
        }
        judge
    }

    /// `redundancy` is `I − QQᵀ` and `residual` the residual of the point, both whitened.
    fn point<const D: usize>(
        &self,
        pair: &PointPair<D>,
        redundancy: &DMatrix<f64>,
        residual: &DVector<f64>,
    ) -> Reliability<D> {
        let whitening = dynamic(&pair.uncertainty.whitening_per_mm().expect("checked"));
        let controlled = Controlled::of(redundancy);
        let sigma = self.sigma();
        let detectable = self.detectable_sigmas[controlled.count()] * sigma;
        let mut reliability = Reliability {
            redundancy: SVector::zeros(),
            w: SVector::zeros(),
            detectable_mm: SVector::repeat(f64::INFINITY),
            bias_mm: None,
            chi2_drop: controlled.chi2_drop(residual),
            p_value: self.p_value(controlled.chi2_drop(residual), controlled.count()),
        };
        for axis in 0..D {
            // A bias of 1 mm along the axis, whitened, and what shows of it.
            let bias = whitening.column(axis);
            let shown = bias.dot(&(redundancy * bias));
            reliability.redundancy[axis] = shown / bias.norm_squared();
            if reliability.redundancy[axis] > SMALLEST_REDUNDANCY {
                reliability.w[axis] = bias.dot(residual) / (shown.sqrt() * sigma);
                reliability.detectable_mm[axis] = detectable / shown.sqrt();
            }
        }
        if controlled.count() == D {
            let bias = whitening.solve_lower_triangular(&controlled.bias(residual));
            reliability.bias_mm = bias.map(|b| SVector::from_column_slice(b.as_slice()));
        }
        reliability
    }

    /// Standard deviation of a whitened coordinate.
    fn sigma(&self) -> f64 {
        match self.noise {
            Noise::Declared => 1.0,
            Noise::Estimated => (self.chi2 / ratio(self.dof.max(1))).sqrt(),
        }
    }

    /// Degrees of freedom that the other points have left for the noise, where it is estimated.
    fn others(&self, controlled: usize) -> Option<usize> {
        (self.noise == Noise::Estimated).then(|| self.dof.saturating_sub(controlled))
    }

    fn p_value(&self, chi2_drop: f64, controlled: usize) -> f64 {
        match self.others(controlled) {
            _ if controlled == 0 => 1.0,
            None => chi2_tail(chi2_drop, controlled),
            Some(0) => 1.0,
            Some(others) => {
                let left = (self.chi2 - chi2_drop).max(f64::MIN_POSITIVE) / ratio(others);
                f_tail(chi2_drop / ratio(controlled) / left, controlled, others)
            }
        }
    }
}
