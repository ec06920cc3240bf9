//! Does one of the two frames mirror the other?

use nalgebra::DVector;

use crate::motion::Moved;
use crate::problem::FitProblem;
use crate::refine::refine;
use crate::spread::check_spread;
use crate::statistics::ratio;
use crate::{FrameMap, Handedness, Noise, Options, PointPair, Transform, closed_form};

/// Likelihood ratio of 1000, beyond which a verdict is given: that of a fair coin falling the
/// same way ten times.
const DECISIVE_LOG_RATIO: f64 = 6.907_755;

/// Evidence for and against a mirrored frame.
///
/// Families below the rigid one are judged as rigid, affine maps as similarities, so that the
/// two sides differ in nothing but handedness.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reflection {
    /// What the data say.
    pub verdict: ReflectionVerdict,
    /// Root-mean-square distance left by the best proper map.
    pub proper_rms_mm: f64,
    /// Root-mean-square distance left by the best improper map.
    pub improper_rms_mm: f64,
    /// Log-likelihood of the improper map over that of the proper one.
    pub log_likelihood_ratio: f64,
}

impl Reflection {
    /// Whether the data speak decisively for a map of the other handedness.
    #[must_use]
    pub fn speaks_against(&self, handedness: Handedness) -> bool {
        match handedness {
            Handedness::Proper => self.verdict == ReflectionVerdict::Improper,
            Handedness::Improper => self.verdict == ReflectionVerdict::Proper,
        }
    }

    /// Root-mean-square distance left by the best map of a handedness.
    #[must_use]
    pub fn rms_mm(&self, handedness: Handedness) -> f64 {
        match handedness {
            Handedness::Proper => self.proper_rms_mm,
            Handedness::Improper => self.improper_rms_mm,
        }
    }
}

/// What the data say about a mirrored frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum ReflectionVerdict {
    /// A proper map fits decisively better.
    Proper,
    /// An improper map fits decisively better: one frame is mirrored.
    Improper,
    /// Both fit about equally well: the points lie in a plane (planar: on a line), or the noise
    /// hides it.
    Undecided,
}

/// `None` where the points do not determine either map.
pub(crate) fn judge<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
) -> Option<Reflection> {
    let transform = options.transform.clamp(Transform::Rigid, Transform::Similarity);
    let options = Options { transform, ..*options };
    if pairs.len() < transform.minimum_points(D) || check_spread(pairs, transform).is_err() {
        return None;
    }
    let [proper, improper] = [Handedness::Proper, Handedness::Improper]
        .map(|handedness| Misfit::of(pairs, &Options { handedness, ..options }));
    let dof = ratio(D * pairs.len() - transform.parameter_count(D));
    let log_likelihood_ratio = match options.noise {
        Noise::Estimated => 0.5 * dof * (proper.chi2 / improper.chi2).ln(),
        Noise::Declared => {
            // Where neither map fits, the declared noise is not the measure of their difference.
            let variance_factor = (proper.chi2.min(improper.chi2) / dof.max(1.0)).max(1.0);
            0.5 * (proper.chi2 - improper.chi2) / variance_factor
        }
    };
    let verdict = if log_likelihood_ratio > DECISIVE_LOG_RATIO {
        ReflectionVerdict::Improper
    } else if log_likelihood_ratio < -DECISIVE_LOG_RATIO {
        ReflectionVerdict::Proper
    } else {
        ReflectionVerdict::Undecided
    };
    Some(Reflection {
        verdict,
        proper_rms_mm: proper.rms_mm,
        improper_rms_mm: improper.rms_mm,
        log_likelihood_ratio,
    })
}

struct Misfit {
    rms_mm: f64,
    /// Weighted sum of squares; what rounding alone leaves, where it is less.
    chi2: f64,
}

impl Misfit {
    fn of<const D: usize>(pairs: &[PointPair<D>], options: &Options) -> Self {
        let start = closed_form::estimate(pairs, options.transform, options.handedness).map;
        let problem = FitProblem::new(pairs, options.transform, &start);
        let exact = options.loss.is_none() && pairs.iter().all(|p| p.uncertainty.is_isotropic());
        let best = if exact {
            Moved::still()
        } else {
            // The closed form is still a fair witness where the iteration fails.
            refine(&problem, options).map_or(Moved::still(), |solution| solution.point)
        };
        let whitened = problem.whitened(&best);
        let chi2 = match options.loss {
            None => whitened.norm_squared(),
            // Outliers weigh on both maps; the better half of the points decides.
            Some(_) => median_norm_squared::<D>(&whitened) * ratio(pairs.len()),
        };
        let rms_mm = rms_mm(pairs, &problem.map(&best));
        Self { rms_mm, chi2: chi2.max(problem.round_off_chi2) }
    }
}

fn median_norm_squared<const D: usize>(whitened: &DVector<f64>) -> f64 {
    let mut squares: Vec<f64> =
        whitened.as_slice().chunks(D).map(|r| r.iter().map(|v| v * v).sum()).collect();
    squares.sort_by(f64::total_cmp);
    squares[squares.len() / 2]
}

fn rms_mm<const D: usize>(pairs: &[PointPair<D>], map: &FrameMap<D>) -> f64 {
    let residuals = pairs.iter().map(|p| (p.target_mm - map.apply(&p.source_mm)).norm_squared());
    (residuals.sum::<f64>() / ratio(pairs.len())).sqrt()
}
