//! A single reading far off: a mistake, or the tail of the noise?

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::reading::{Reading, left_by};
use crate::count::count;
use crate::levels::{
    HEAVY_TAILS, IN_TAILS, IN_TAILS_UNDECLARED, REACHED, REACHED_UNDECLARED, STAY,
};
use crate::noise::linear::Linear;
use crate::tests::law::{FREEDOMS, Law, Seen, alike};

/// Scales of each law, from a quarter of the root mean square to half as much again, in equal
/// ratios: heavy tails make the root mean square larger than the scale, never much smaller.
const SCALES: usize = 24;
const SMALLEST: f64 = 0.25;
const LARGEST: f64 = 1.5;

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
    let least = if lin.is_as_declared { IN_TAILS } else { IN_TAILS_UNDECLARED };
    far_off(lin, beside, observation).is_none_or(|(_, chance)| chance > least)
}

/// The reading that lies farthest off, in its own standard uncertainties, where the noise of all others hardly ever puts
/// one there: too seldom to say nothing of it, however often a mistake has to be rarer.
pub(crate) fn stands_out(lin: &Linear<'_>) -> Option<FarOff> {
    let readings = lin.noise.all_readings(lin);
    let all: Vec<&Reading> = readings.iter().collect();
    let size = |(reading, seen): (&&Reading, Seen)| (seen.z.abs(), reading.observation);
    let of_each = each_studentized(lin, &lin.basis, &all).map(size);
    let (_, observation) = of_each.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (z, chance) = far_off(lin, &beside(lin, &lin.basis, observation), observation)?;
    (chance <= STAY).then_some(FarOff { observation, z, chance })
}

/// The span of a basis and of the readings of an observation, each by itself.
pub(crate) fn beside(lin: &Linear<'_>, base: &Basis, observation: usize) -> Basis {
    let readings = lin.noise.all_readings(lin).iter();
    let own = readings.filter(|reading| reading.observation == observation);
    let columns: Vec<_> = own.map(|reading| reading.column(lin.rows.len())).collect();
    base.with(&DMatrix::from_columns(&columns), NEW_DIRECTION)
}

/// A reading that lies far off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarOff {
    pub(crate) observation: usize,
    /// Standard uncertainties, all components together.
    pub(crate) z: f64,
    /// That the noise puts any reading there.
    pub(crate) chance: f64,
}

/// How far off a reading is, and the chance that the noise puts any there, as [`is_in_tails`] has it; nought where the
/// others are too few to tell, and `None` where the fit follows it wherever it goes.
fn far_off(lin: &Linear<'_>, beside: &Basis, observation: usize) -> Option<(f64, f64)> {
    let (own, others): (Vec<&Reading>, Vec<&Reading>) =
        lin.noise.all_readings(lin).iter().partition(|r| r.observation == observation);
    let components = studentized(lin, &lin.basis, &own);
    if components.is_empty() {
        return None;
    }
    let z = components.iter().map(|seen| seen.z * seen.z).sum::<f64>().sqrt();
    let left = components.iter().map(|seen| seen.left).sum::<f64>() / count(components.len());
    let farthest = Seen { z, left };
    let rest = studentized(lin, beside, &others);
    if rest.len() < MIN_ROWS {
        return Some((z, 0.0));
    }
    let laws = weighed(&rest, z, lin.is_as_declared);
    let n = count(own.len() + others.len()) / count(own.len());
    Some((z, any_beyond(&laws, (farthest, components.len()), n)))
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
    any_beyond(&laws, (Seen { z: farthest, left: 1.0 }, 1), n) > least
}

/// Chance that noise of the law which these residuals show puts any of as many as far off as `farthest_residual`, one beside
/// them in their unit: the normal law, or Student's t of any freedom, by its likelihood. Nought where they are too few to tell.
#[must_use]
pub fn chance_as_far(residuals: &[f64], farthest_residual: f64) -> f64 {
    let seen = |z: &f64| Seen { z: *z, left: 1.0 };
    let rows: Vec<Seen> = residuals.iter().map(seen).collect();
    let far = farthest_residual.abs();
    if rows.len() < MIN_ROWS || residuals.iter().all(|z| *z == 0.0) {
        return 0.0;
    }
    any_beyond(&weighed(&rows, far, false), (seen(&far), 1), count(rows.len()))
}

/// Chance that any of `n` readings of so many components lies beyond `farthest`.
fn any_beyond(laws: &[(Law, f64)], (farthest, components): (Seen, usize), n: f64) -> f64 {
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
    let normal: f64 = laws.iter().filter(|(l, _)| l.freedom().is_none()).map(|(_, w)| w).sum();
    let inverse = laws.iter().filter_map(|(l, w)| l.freedom().map(|f| w / f)).sum::<f64>();
    (normal <= HEAVY_TAILS).then(|| (1.0 - normal) / inverse)
}

/// Laws with their probabilities; the normal law is as likely beforehand as all others together.
/// Mistakes lie anywhere up to the farthest row, or to `farthest` where that is farther. Where rows are in
/// units of a declared uncertainty the law's standard deviation is about one.
fn weighed(rows: &[Seen], farthest: f64, is_declared: bool) -> Vec<(Law, f64)> {
    let rms = (rows.iter().map(|seen| seen.z * seen.z).sum::<f64>() / count(rows.len())).sqrt();
    let end = rows.iter().map(|seen| seen.z.abs()).fold(farthest, f64::max);
    let ratio = (LARGEST / SMALLEST).powf(1.0 / count(SCALES - 1));
    let scales = (0..SCALES).map(|i| rms * SMALLEST * ratio.powf(count(i)));
    let freedoms = (0..FREEDOMS.len()).map(|of| (Some(of), 1.0 / count(FREEDOMS.len())));
    let families: Vec<(Option<usize>, f64)> = freedoms.chain([(None, 1.0)]).collect();
    let rows = alike(rows, rms);
    let mut laws: Vec<(Law, f64)> = Vec::with_capacity(families.len() * SCALES);
    for scale in scales {
        for &(of, prior) in &families {
            let law = Law::new(of, scale);
            let [none, some] = law.log_likelihoods(&rows, end);
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
fn studentized(lin: &Linear<'_>, beside: &Basis, readings: &[&Reading]) -> Vec<Seen> {
    each_studentized(lin, beside, readings).map(|(_, seen)| seen).collect()
}

fn each_studentized<'r, 'a>(
    lin: &Linear<'_>,
    beside: &Basis,
    readings: &'r [&'a Reading],
) -> impl Iterator<Item = (&'r &'a Reading, Seen)> {
    let residual: DVector<f64> = beside.reject(&lin.residual);
    let seen = move |(reading, left): (&'r &'a Reading, f64)| {
        let seen = Seen { z: reading.of(&residual) / left.sqrt(), left };
        (left > 1.0 - FOLLOWED).then_some((reading, seen))
    };
    readings.iter().zip(left_by(beside, readings)).filter_map(seen)
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

    use super::*;

    /// Quantiles of a law at evenly spaced probabilities: data without chance.
    fn quantiles(inverse: impl Fn(f64) -> f64, n: usize) -> Vec<Seen> {
        let z = |i| inverse((count(i) + 0.5) / count(n));
        (0..n).map(|i| Seen { z: z(i), left: 1.0 }).collect()
    }

    fn weight_of_normal(rows: &[Seen]) -> f64 {
        weighed(rows, 0.0, false)
            .iter()
            .filter(|(law, _)| law.freedom().is_none())
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
            weighed(&rows, far, is_declared)
                .iter()
                .map(|(law, w)| w * law.outside(Seen { z: far, left: 1.0 }, 1))
                .sum()
        };
        let undeclared = beyond(1.0, false);
        assert!(beyond(1.0, true) < undeclared, "{} {undeclared}", beyond(1.0, true));
        assert!(beyond(0.7, true) > undeclared, "{} {undeclared}", beyond(0.7, true));
    }

    #[test]
    fn weights_are_probabilities_at_any_scale() {
        for scale in [1e-9, 1.0, 1e6] {
            let rows = quantiles(|p| scale * Normal::standard().inverse_cdf(p), 60);
            let sum: f64 = weighed(&rows, 0.0, false).iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            let far = 9.0 * scale;
            let beyond = |(law, w): &(Law, f64)| w * law.outside(Seen { z: far, left: 1.0 }, 1);
            let chance: f64 = weighed(&rows, 0.0, false).iter().map(beyond).sum();
            assert!(chance < 1e-3, "{chance}");
        }
    }
}
