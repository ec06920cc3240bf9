//! Whether groups agree with each other on an effect of more directions than there are groups.

use crate::levels::MIN_AGREEING;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::algebra::basis::Basis;
use crate::count::count;
use crate::noise::linear::Linear;

/// Level of the test that the groups have the effect in common.
///
/// With more directions than groups the scores of the groups have no invertible covariance. What
/// is tested is whether a group's score points where those of the others point: without the effect
/// the cosine between a group's score and the sum of the others' (all at length one, the spatial
/// signs of Möttönen and Oja 1995) is zero on average, whatever the noise inside a group is.
/// The cosines share their terms: of `R` of them the scatter is too small by
/// `(R − 2)/(2(R − 1))` in the variance of their mean, which the statistic takes back.
pub(crate) fn agreement_p_value(lin: &Linear<'_>, residual: &DVector<f64>, added: &Basis) -> f64 {
    let sign = |cluster: &Vec<usize>| {
        let rows = added.rows(cluster);
        rows.tr_mul(&residual.select_rows(cluster)).try_normalize(f64::MIN_POSITIVE)
    };
    let signs: Vec<DVector<f64>> = lin.clusters.iter().filter_map(sign).collect();
    if signs.len() < MIN_AGREEING {
        return 1.0;
    }
    one_sided(&DMatrix::from_columns(&signs))
}

/// The test on the groups' directions, one column of length one each.
fn one_sided(signs: &DMatrix<f64>) -> f64 {
    let n = count(signs.ncols());
    let sum = signs.column_sum();
    let agreements: Vec<f64> = signs.column_iter().map(|s| s.dot(&sum) - 1.0).collect();
    let mean = agreements.iter().sum::<f64>() / n;
    let square: f64 = agreements.iter().map(|a| (a - mean).powi(2)).sum();
    let shared = (n - 2.0) / (2.0 * (n - 1.0));
    let t = mean / (square / (n - 1.0) / n / shared).sqrt();
    if t.is_nan() {
        return 1.0;
    }
    StudentsT::new(0.0, 1.0, n - 1.0).map_or(1.0, |law| law.sf(t))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    const TRIALS: usize = 4000;

    /// Share of trials below the level: six groups of forty directions, noise whose variance falls
    /// with the direction as that of slow noise does, and a common part of this size.
    fn share_below(level: f64, common: f64, n_groups: usize) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let below = (0..TRIALS).filter(|_| {
            let signs: Vec<DVector<f64>> = (0..n_groups)
                .map(|_| {
                    // Groups may be as loud as they like.
                    let loud: f64 = (0.5 * rng.sample::<f64, _>(StandardNormal)).exp();
                    let score = |i: usize| {
                        let noise: f64 = rng.sample(StandardNormal);
                        loud * (noise / count(i + 1).sqrt() + common)
                    };
                    DVector::from_iterator(40, (0..40).map(score)).normalize()
                })
                .collect();
            one_sided(&DMatrix::from_columns(&signs)) < level
        });
        count(below.count()) / count(TRIALS)
    }

    /// 5 % of 4000 have a standard deviation of 0.34 %, 1 % of 0.16 %; four of them, and the
    /// slow noise's own excess of a fifth.
    #[test]
    fn groups_without_a_common_effect_agree_as_often_as_they_may() {
        for n_groups in [6, 12] {
            let (five, one) = (share_below(0.05, 0.0, n_groups), share_below(0.01, 0.0, n_groups));
            assert!(five < 0.06 + 0.014, "{n_groups} groups: {five}");
            assert!(one < 0.012 + 0.007, "{n_groups} groups: {one}");
        }
    }

    #[test]
    fn a_common_effect_as_large_as_the_noise_is_found() {
        assert!(share_below(0.01, 0.5, 6) > 0.95);
    }
}
