//! A single reading far off: a mistake, or the tail of the noise?

use nalgebra::DVector;
use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

use crate::algebra::basis::Basis;
use crate::algebra::reading::{Reading, left_by};
use crate::count::count;
use crate::levels::{HEAVY_TAILS, IN_TAILS, IN_TAILS_UNDECLARED, REACHED, REACHED_UNDECLARED};
use crate::noise::linear::Linear;

/// Degrees of freedom of Student's t that noise may have beside the normal law; beyond 20 the two
/// cannot be told apart by data that fit in a case.
/// Beside each twice what is one more: the fourth root of `1 + z²/ν` to that power is what the density
/// falls by.
const FREEDOMS: [(f64, i32); 7] =
    [(2.5, 7), (3.0, 8), (4.0, 10), (5.0, 12), (7.0, 16), (10.0, 22), (20.0, 42)];

/// Scales of each law, from a quarter of the root mean square to half as much again, in equal
/// ratios: heavy tails make the root mean square larger than the scale, never much smaller.
const SCALES: usize = 24;
const SMALLEST: f64 = 0.25;
const LARGEST: f64 = 1.5;

/// Share of the other readings that are mistakes, where any are, which is as likely beforehand as that
/// none is: they lie anywhere. Without the one case a tail that is seen would pass for mistakes, without
/// the other two mistakes for a tail.
const MISTAKEN: f64 = 0.01;

/// Readings whose densities are multiplied before a logarithm is taken: sixteen of a mixture, each at
/// least some millionth of the largest, stay within the range of a number.
const MULTIPLIED: usize = 16;

/// Standard deviation of the logarithm of the noise's standard deviation over the declared one.
const DECLARED: f64 = 0.2;

/// Fewest readings that say anything of the tails.
const MIN_ROWS: usize = 12;

/// Leverage beyond which a reading has no residual of its own.
const FOLLOWED: f64 = 0.95;

/// Whether the noise alone may put a reading as far off as `observation`, all of its components together.
///
/// The law of the noise is unknown: the normal one, or Student's t of any freedom, weighed by the
/// likelihood of the other rows, none of which is a mistake or one in a hundred, and by how far their
/// standard deviation is from the declared one: what lies far off is part of that of a tail, not of
/// that of a mistake. A common scatter that the data showed is no declared one: the mistake is in it. `beside` is the span of the model with the observation's own effect.
///
/// Lange, Little and Taylor, «Robust statistical modeling using the t distribution», 1989.
pub(crate) fn is_in_tails(lin: &Linear<'_>, beside: &Basis, observation: usize) -> bool {
    let (own, others): (Vec<&Reading>, Vec<&Reading>) =
        lin.noise.all_readings(lin).iter().partition(|r| r.observation == observation);
    let components = studentized(lin, &lin.basis, &own);
    let farthest = components.iter().map(|z| z * z).sum::<f64>().sqrt();
    let rest = studentized(lin, beside, &others);
    if rest.len() < MIN_ROWS {
        return false;
    }
    let is_declared = lin.is_as_declared;
    let laws = weighed(&rest, farthest, is_declared);
    let n = count(own.len() + others.len()) / count(own.len());
    let least = if is_declared { IN_TAILS } else { IN_TAILS_UNDECLARED };
    any_beyond(&laws, (farthest, components.len()), n) > least
}

/// Whether the noise of the readings that were fitted may put the farthest of `n` others, so many standard uncertainties
/// off, where it is.
pub(crate) fn reaches(lin: &Linear<'_>, farthest: f64, n: f64) -> bool {
    let all: Vec<&Reading> = lin.noise.all_readings(lin).iter().collect();
    let rows = studentized(lin, &lin.basis, &all);
    if rows.len() < MIN_ROWS {
        return false;
    }
    let laws = weighed(&rows, farthest, lin.is_as_declared);
    let least = if lin.is_as_declared { REACHED } else { REACHED_UNDECLARED };
    any_beyond(&laws, (farthest, 1), n) > least
}

/// Chance that any of `n` readings of so many components lies beyond `farthest`.
fn any_beyond(laws: &[(Law, f64)], (farthest, components): (f64, usize), n: f64) -> f64 {
    let of_law = |law: &Law| 1.0 - (1.0 - law.outside(farthest, components)).powf(n);
    laws.iter().map(|(law, weight)| weight * of_law(law)).sum()
}

/// Least degrees of freedom for which the fourth moment is taken: below, it grows without bound, and with it how
/// well a sum of squares is known.
const LEAST_FREEDOM: f64 = 4.5;

/// Share of the degrees of freedom of a sum of squares that noise with such tails leaves: its variance is
/// `κ − 1` for each, 2 of a normal law, with `κ = 3 + 6/(ν − 4)`.
pub(crate) fn share_beside_tails(lin: &Linear<'_>) -> f64 {
    heavy_tails(lin).map_or(1.0, |freedom| {
        let kurtosis = 3.0 + 6.0 / (freedom.max(LEAST_FREEDOM) - 4.0);
        2.0 / (kurtosis - 1.0)
    })
}

/// Degrees of freedom of Student's t that the residual shows, on the whole, where a normal law is
/// out of the question.
pub(crate) fn heavy_tails(lin: &Linear<'_>) -> Option<f64> {
    let all: Vec<&Reading> = lin.noise.all_readings(lin).iter().collect();
    let rows = studentized(lin, &lin.basis, &all);
    if rows.len() < MIN_ROWS {
        return None;
    }
    let laws = weighed(&rows, 0.0, lin.is_as_declared);
    let normal: f64 = laws.iter().filter(|(l, _)| l.freedom.is_none()).map(|(_, w)| w).sum();
    let inverse = laws.iter().filter_map(|(l, w)| l.freedom.map(|f| w / f)).sum::<f64>();
    (normal <= HEAVY_TAILS).then(|| (1.0 - normal) / inverse)
}

/// A law of the noise.
struct Law {
    /// Of Student's t; `None` for the normal law.
    freedom: Option<f64>,
    /// See [`FREEDOMS`].
    quarters: i32,
    scale: f64,
    /// Density in the middle.
    peak: f64,
}

impl Law {
    fn new(of: Option<(f64, i32)>, scale: f64) -> Self {
        let (freedom, quarters) = of.map_or((None, 0), |(f, quarters)| (Some(f), quarters));
        let peak = match freedom {
            Some(freedom) => StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |t| t.pdf(0.0)),
            None => Normal::standard().pdf(0.0),
        };
        Self { freedom, quarters, scale, peak: peak / scale }
    }

    fn standard_deviation(&self) -> f64 {
        self.scale * self.freedom.map_or(1.0, |freedom| (freedom / (freedom - 2.0)).sqrt())
    }

    /// Probability that components together, root of their sum of squares, lie beyond `z`; of a law with heavy tails it
    /// is one of them that does.
    fn outside(&self, z: f64, components: usize) -> f64 {
        let z = z / self.scale;
        let n = count(components.max(1));
        match self.freedom {
            Some(freedom) => {
                let one = StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |t| 2.0 * t.sf(z));
                1.0 - (1.0 - one).powf(n)
            }
            None => ChiSquared::new(n).map_or(0.0, |square| square.sf(z * z)),
        }
    }

    /// Logarithms of the likelihood of rows: none of them a mistake, and some, up to `end`.
    fn log_likelihoods(&self, rows: &[f64], end: f64) -> [f64; 2] {
        let (anywhere, n) = (MISTAKEN / (2.0 * end), count(rows.len()));
        let (mut falls, mut mixed) = (0.0, 0.0);
        for some in rows.chunks(MULTIPLIED) {
            let (mut of_falls, mut of_mixed) = (1.0_f64, 1.0_f64);
            for z in some {
                let square = (z / self.scale).powi(2);
                let density = if let Some(freedom) = self.freedom {
                    let fall = 1.0 + square / freedom;
                    of_falls *= fall;
                    fall.sqrt().sqrt().powi(-self.quarters)
                } else {
                    falls += square;
                    (-0.5 * square).exp()
                };
                of_mixed *= (1.0 - MISTAKEN) * self.peak * density + anywhere;
            }
            falls += of_falls.ln();
            mixed += of_mixed.ln();
        }
        let power = self.freedom.map_or(0.5, |freedom| 0.5 * (freedom + 1.0));
        [n * self.peak.ln() - power * falls, mixed]
    }
}

/// Laws with their probabilities; the normal law is as likely beforehand as all others together.
/// Mistakes lie anywhere up to the farthest row, or to `farthest` where that is farther. Where rows are in
/// units of a declared uncertainty the law's standard deviation is about one.
fn weighed(rows: &[f64], farthest: f64, is_declared: bool) -> Vec<(Law, f64)> {
    let rms = (rows.iter().map(|z| z * z).sum::<f64>() / count(rows.len())).sqrt();
    let end = rows.iter().map(|z| z.abs()).fold(farthest, f64::max);
    let ratio = (LARGEST / SMALLEST).powf(1.0 / count(SCALES - 1));
    let scales = (0..SCALES).map(|i| rms * SMALLEST * ratio.powf(count(i)));
    let freedoms = FREEDOMS.iter().map(|f| (Some(*f), 1.0 / count(FREEDOMS.len())));
    let families: Vec<(Option<(f64, i32)>, f64)> = freedoms.chain([(None, 1.0)]).collect();
    let mut laws: Vec<(Law, f64)> = Vec::with_capacity(families.len() * SCALES);
    for scale in scales {
        for &(of, prior) in &families {
            let law = Law::new(of, scale);
            let [none, some] = law.log_likelihoods(rows, end);
            let more = none.max(some);
            let likelihood = more + ((none - more).exp() + (some - more).exp()).ln();
            let apart = if is_declared { law.standard_deviation().ln() / DECLARED } else { 0.0 };
            laws.push((law, prior.ln() + likelihood - 0.5 * apart.powi(2)));
        }
    }
    let best = laws.iter().map(|(_, l)| *l).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = laws.iter().map(|(_, l)| (l - best).exp()).sum();
    for (_, weight) in &mut laws {
        *weight = (*weight - best).exp() / total;
    }
    laws
}

/// Residual over its own standard uncertainty of each reading that has one.
fn studentized(lin: &Linear<'_>, beside: &Basis, readings: &[&Reading]) -> Vec<f64> {
    let residual: DVector<f64> = beside.reject(&lin.residual);
    let of_reading = |(reading, left): (&&Reading, f64)| {
        (left > 1.0 - FOLLOWED).then(|| reading.of(&residual) / left.sqrt())
    };
    readings.iter().zip(left_by(beside, readings)).filter_map(of_reading).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of a law at evenly spaced probabilities: data without chance.
    fn quantiles(inverse: impl Fn(f64) -> f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| inverse((count(i) + 0.5) / count(n))).collect()
    }

    fn weight_of_normal(rows: &[f64]) -> f64 {
        weighed(rows, 0.0, false)
            .iter()
            .filter(|(law, _)| law.freedom.is_none())
            .map(|(_, w)| w)
            .sum()
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

    /// Values that look normal and scatter by less than declared: what is far off may be what the
    /// declared uncertainty holds of a tail.
    #[test]
    fn a_declared_uncertainty_that_is_not_reached_speaks_for_a_tail() {
        let beyond = |scale: f64, is_declared| -> f64 {
            let rows = quantiles(|p| scale * Normal::standard().inverse_cdf(p), 60);
            let far = 8.0 * scale;
            weighed(&rows, far, is_declared).iter().map(|(law, w)| w * law.outside(far, 1)).sum()
        };
        let undeclared = beyond(1.0, false);
        assert!(beyond(1.0, true) < undeclared, "{} {undeclared}", beyond(1.0, true));
        assert!(beyond(0.7, true) > undeclared, "{} {undeclared}", beyond(0.7, true));
    }

    /// Row by row, and each law's density by its library.
    #[test]
    fn likelihoods_are_products_of_densities() {
        const ROUND_OFF: f64 = 1e-12;
        let rows = quantiles(|p| 1.4 * Normal::standard().inverse_cdf(p), 45);
        for of in FREEDOMS.map(Some).into_iter().chain([None]) {
            let (scale, end) = (0.7, 9.0);
            let law = Law::new(of, scale);
            let density = |z: &f64| match of {
                Some((freedom, _)) => StudentsT::new(0.0, scale, freedom).expect("valid").pdf(*z),
                None => Normal::new(0.0, scale).expect("valid").pdf(*z),
            };
            let by_hand = |share: f64| -> f64 {
                let mixed = |z| (1.0 - share) * density(z) + share / (2.0 * end);
                rows.iter().map(|z| mixed(z).ln()).sum()
            };
            let [none, some] = law.log_likelihoods(&rows, end);
            assert!((none / by_hand(0.0) - 1.0).abs() < ROUND_OFF, "{of:?}");
            assert!((some / by_hand(MISTAKEN) - 1.0).abs() < ROUND_OFF, "{of:?}");
        }
    }

    #[test]
    fn weights_are_probabilities_at_any_scale() {
        for scale in [1e-9, 1.0, 1e6] {
            let rows = quantiles(|p| scale * Normal::standard().inverse_cdf(p), 60);
            let sum: f64 = weighed(&rows, 0.0, false).iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            let far = 9.0 * scale;
            let beyond = |(law, w): &(Law, f64)| w * law.outside(far, 1);
            let chance: f64 = weighed(&rows, 0.0, false).iter().map(beyond).sum();
            assert!(chance < 1e-3, "{chance}");
        }
    }
}
