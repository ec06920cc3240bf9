//! A single reading far off: a mistake, or the tail of the noise?

use nalgebra::DVector;
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use crate::algebra::basis::Basis;
use crate::algebra::reading::Reading;
use crate::count::count;
use crate::levels::HEAVY_TAILS;
use crate::noise::linear::Linear;

/// Degrees of freedom of Student's t that noise may have beside the normal law; beyond 20 the two
/// cannot be told apart by data that fit in a case.
const FREEDOMS: [f64; 7] = [2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0];

/// Scales of each law, from a quarter of the root mean square to half as much again, in equal
/// ratios: heavy tails make the root mean square larger than the scale, never much smaller.
const SCALES: usize = 24;
const SMALLEST: f64 = 0.25;
const LARGEST: f64 = 1.5;

/// Share of all readings that are mistakes, as a rule: they lie anywhere.
const MISTAKEN: f64 = 0.01;

/// Fewest readings that say anything of the tails.
const MIN_ROWS: usize = 12;

/// Likelihood of the declared sigma as the standard deviation of the noise, over that of any scale,
/// below which the readings refute it.
const REFUTED: f64 = 0.01;

/// Leverage beyond which a reading has no residual of its own.
const FOLLOWED: f64 = 0.95;

/// Chance that the noise alone puts any row as far off as the worst one of `observation`.
///
/// The law of the noise is unknown: the normal one, or Student's t of any freedom, weighed by the
/// likelihood of the other rows, of which one in a hundred may be a mistake as well. Where sigma was
/// declared it may be the standard deviation of that law, most of which is then made by its tails:
/// the larger of both chances counts, unless the other rows refute it. `beside` is the span of the model
/// with the observation's own effect.
///
/// Lange, Little and Taylor, «Robust statistical modeling using the t distribution», 1989.
pub(crate) fn chance_in_tails(lin: &Linear<'_>, beside: &Basis, observation: usize) -> f64 {
    let (own, others): (Vec<Reading>, Vec<Reading>) =
        lin.readings().into_iter().partition(|r| r.observation == observation);
    let farthest = studentized(lin, &lin.basis, &own).into_iter().map(f64::abs).fold(0.0, f64::max);
    let rest = studentized(lin, beside, &others);
    if rest.len() < MIN_ROWS {
        return 0.0;
    }
    let n = count(own.len() + others.len());
    // A common scatter that was fitted already holds the reading asked about.
    let as_declared = |(row, sigma): (&usize, &f64)| *sigma <= lin.layout.rows[*row].sigma;
    let is_declared = lin.layout.sigma_declared && lin.rows.iter().zip(&lin.sigma).all(as_declared);
    chance_beyond(&rest, farthest, n, is_declared)
}

/// Chance that the law of `rest` puts any of `n` readings beyond `farthest`; in units of the declared
/// sigma where one is declared.
fn chance_beyond(rest: &[f64], farthest: f64, n: f64, is_declared: bool) -> f64 {
    let any_beyond = |law: &Law| 1.0 - (1.0 - law.outside(farthest)).powf(n);
    let chance = |laws: &Laws| -> f64 {
        laws.weighed.iter().map(|(law, weight)| weight * any_beyond(law)).sum()
    };
    let free = Laws::of_any_scale(rest, farthest);
    let mut most = chance(&free);
    if is_declared {
        let declared = Laws::of_standard_deviation_one(rest, farthest);
        if declared.evidence >= free.evidence + REFUTED.ln() {
            most = most.max(chance(&declared));
        }
    }
    most.clamp(0.0, 1.0)
}

/// Degrees of freedom of Student's t that the residual shows, on the whole, where a normal law is
/// out of the question.
pub(crate) fn heavy_tails(lin: &Linear<'_>) -> Option<f64> {
    let rows = studentized(lin, &lin.basis, &lin.readings());
    if rows.len() < MIN_ROWS {
        return None;
    }
    let laws = Laws::of_any_scale(&rows, 0.0).weighed;
    let normal: f64 = laws.iter().filter(|(l, _)| l.freedom.is_none()).map(|(_, w)| w).sum();
    let inverse = laws.iter().filter_map(|(l, w)| l.freedom.map(|f| w / f)).sum::<f64>();
    (normal <= HEAVY_TAILS).then(|| (1.0 - normal) / inverse)
}

/// A law of the noise.
struct Law {
    /// Of Student's t; `None` for the normal law.
    freedom: Option<f64>,
    scale: f64,
    /// Density in the middle.
    peak: f64,
}

impl Law {
    fn new(freedom: Option<f64>, scale: f64) -> Self {
        let peak = match freedom {
            Some(freedom) => StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |t| t.pdf(0.0)),
            None => Normal::standard().pdf(0.0),
        };
        Self { freedom, scale, peak: peak / scale }
    }

    /// Probability beyond `z` on either side.
    fn outside(&self, z: f64) -> f64 {
        let z = z / self.scale;
        2.0 * match self.freedom {
            Some(freedom) => StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |t| t.sf(z)),
            None => Normal::standard().sf(z),
        }
    }

    fn density(&self, z: f64) -> f64 {
        let square = (z / self.scale).powi(2);
        self.peak
            * match self.freedom {
                Some(freedom) => (1.0 + square / freedom).powf(-0.5 * (freedom + 1.0)),
                None => (-0.5 * square).exp(),
            }
    }
}

/// Laws with their probabilities; the normal law is as likely beforehand as all others together.
struct Laws {
    weighed: Vec<(Law, f64)>,
    /// Logarithm of the mean likelihood of the rows.
    evidence: f64,
}

impl Laws {
    fn of_any_scale(rows: &[f64], farthest: f64) -> Self {
        let rms = (rows.iter().map(|z| z * z).sum::<f64>() / count(rows.len())).sqrt();
        let ratio = (LARGEST / SMALLEST).powf(1.0 / count(SCALES - 1));
        let scales = (0..SCALES).map(|i| rms * SMALLEST * ratio.powf(count(i)));
        let of_scale = |scale| families().map(move |(freedom, p)| (Law::new(freedom, scale), p));
        Self::of(rows, farthest, scales.flat_map(of_scale))
    }

    fn of_standard_deviation_one(rows: &[f64], farthest: f64) -> Self {
        let scale = |freedom: Option<f64>| freedom.map_or(1.0, |f| ((f - 2.0) / f).sqrt());
        let laws = families().map(|(freedom, p)| (Law::new(freedom, scale(freedom)), p));
        Self::of(rows, farthest, laws)
    }

    /// Mistakes lie anywhere up to the farthest row, or to `farthest` where that is farther.
    fn of(rows: &[f64], farthest: f64, laws: impl Iterator<Item = (Law, f64)>) -> Self {
        let end = rows.iter().map(|z| z.abs()).fold(farthest, f64::max);
        let mistaken = MISTAKEN / (2.0 * end);
        let mut all = 0.0;
        let mut weighed: Vec<(Law, f64)> = laws
            .map(|(law, probability)| {
                let density = |z: &f64| (1.0 - MISTAKEN) * law.density(*z) + mistaken;
                let likelihood: f64 = rows.iter().map(|z| density(z).ln()).sum();
                all += probability;
                (law, probability.ln() + likelihood)
            })
            .collect();
        let best = weighed.iter().map(|(_, l)| *l).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = weighed.iter().map(|(_, l)| (l - best).exp()).sum();
        for (_, weight) in &mut weighed {
            *weight = (*weight - best).exp() / total;
        }
        Self { weighed, evidence: best + (total / all).ln() }
    }
}

/// Degrees of freedom, `None` for the normal law, and what each law is worth beforehand.
fn families() -> impl Iterator<Item = (Option<f64>, f64)> {
    let freedoms = FREEDOMS.iter().map(|f| (Some(*f), 1.0 / count(FREEDOMS.len())));
    freedoms.chain([(None, 1.0)])
}

/// Residual over its own standard uncertainty of each reading that has one.
fn studentized(lin: &Linear<'_>, beside: &Basis, readings: &[Reading]) -> Vec<f64> {
    let residual: DVector<f64> = beside.reject(&lin.residual);
    let of_reading = |reading: &Reading| {
        let left = reading.left_by(beside);
        (left > 1.0 - FOLLOWED).then(|| reading.of(&residual) / left.sqrt())
    };
    readings.iter().filter_map(of_reading).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::IN_TAILS;

    /// Quantiles of a law at evenly spaced probabilities: data without chance.
    fn quantiles(inverse: impl Fn(f64) -> f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| inverse((count(i) + 0.5) / count(n))).collect()
    }

    fn weight_of_normal(rows: &[f64]) -> f64 {
        let laws = Laws::of_any_scale(rows, 0.0).weighed;
        laws.iter().filter(|(law, _)| law.freedom.is_none()).map(|(_, w)| w).sum()
    }

    #[test]
    fn normal_rows_make_the_normal_law_likely() {
        let rows = quantiles(|p| Normal::standard().inverse_cdf(p), 120);
        assert!(weight_of_normal(&rows) > 0.5, "{}", weight_of_normal(&rows));
    }

    /// A mistake among a hundred may be what a tail looks like: some probability is always left.
    #[test]
    fn rows_of_students_t_make_it_likely() {
        let law = StudentsT::new(0.0, 2.0, 3.0).expect("valid");
        let rows = quantiles(|p| law.inverse_cdf(p), 200);
        assert!(weight_of_normal(&rows) < HEAVY_TAILS, "{}", weight_of_normal(&rows));
    }

    #[test]
    fn weights_are_probabilities_at_any_scale() {
        for scale in [1e-9, 1.0, 1e6] {
            let rows = quantiles(|p| scale * Normal::standard().inverse_cdf(p), 60);
            let laws = Laws::of_any_scale(&rows, 0.0).weighed;
            let sum: f64 = laws.iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            let far = 9.0 * scale;
            let beyond = |(law, w): &(Law, f64)| w * law.outside(far);
            let chance: f64 = laws.iter().map(beyond).sum();
            assert!(chance < 1e-3, "{chance}");
        }
    }

    /// The middle of Student's t of few degrees of freedom: readings that look normal and scatter by six
    /// tenths of the standard deviation. Its tails put one of 40 beyond ten of these in a hundredth of such
    /// sets, a normal law with their own scatter never.
    #[test]
    fn a_declared_sigma_that_the_tails_make_is_believed() {
        let rows = quantiles(|p| 0.6 * Normal::standard().inverse_cdf(p), 40);
        let [declared, not] = [true, false].map(|known| chance_beyond(&rows, 10.0, 40.0, known));
        assert!(declared > IN_TAILS && not < 0.5 * IN_TAILS, "{declared} {not}");
    }

    #[test]
    fn a_reading_far_off_normal_noise_of_the_declared_size_is_a_mistake() {
        let rows = quantiles(|p| Normal::standard().inverse_cdf(p), 40);
        let chance = chance_beyond(&rows, 9.0, 40.0, true);
        assert!(chance < IN_TAILS, "{chance}");
    }

    #[test]
    fn a_sigma_declared_too_large_is_refuted_by_many_readings() {
        let rows = quantiles(|p| 0.4 * Normal::standard().inverse_cdf(p), 300);
        let chance = chance_beyond(&rows, 6.0, 300.0, true);
        assert!(chance < IN_TAILS, "{chance}");
    }
}
