//! Whether each group shows the same amplitudes by itself.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::levels::MIN_GROUPS;
use crate::noise::linear::Linear;

/// Share of a direction's norm in a group that all that the model may have there must leave of it.
const KEPT: f64 = 0.05;

/// Level of the test that the amplitudes of `added`, each worked out from the readings of one group alone beside
/// all of `base` that shows there, are zero on average; 1 where the groups do not show them by themselves.
///
/// It asks no more than independent groups, few as they are and however their readings go together (Ibragimov and
/// Müller 2010): of one amplitude it is Student's t on the groups' values. Of several the scatter of the
/// values need not be alike in all directions, and the F statistic is judged with one and `G − 1` degrees of
/// freedom, the least that it can have (Box 1954).
pub(crate) fn within_groups(
    lin: &Linear<'_>,
    residual: &DVector<f64>,
    (base, added): (&Basis, &Basis),
) -> f64 {
    let of_group = |rows: &Vec<usize>| {
        of_one(&base.rows(rows), &added.rows(rows), &residual.select_rows(rows))
    };
    let groups: Option<Vec<(DMatrix<f64>, DVector<f64>)>> =
        lin.clusters.iter().map(of_group).collect();
    groups.map_or(1.0, |groups| common(&groups))
}

/// What a group's readings weigh each amplitude with, and the amplitudes; `None` where they do not tell them.
fn of_one(
    base: &DMatrix<f64>,
    added: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let there = Basis::of(base, KEPT);
    let beside = there.reject_columns(added);
    let is_told = beside
        .column_iter()
        .zip(added.column_iter())
        .all(|(left, whole)| left.norm() > KEPT * whole.norm());
    let weight = beside.tr_mul(&beside);
    let cholesky = weight.clone().cholesky().filter(|_| is_told)?;
    let (least, most) = {
        let l = cholesky.l_dirty().diagonal();
        (l.min(), l.max())
    };
    let amplitudes = cholesky.solve(&beside.tr_mul(&there.reject(residual)));
    (least > KEPT * most).then_some((weight, amplitudes))
}

fn common(groups: &[(DMatrix<f64>, DVector<f64>)]) -> f64 {
    let n = count(groups.len());
    let Some((first, _)) = groups.first().filter(|_| groups.len() >= MIN_GROUPS) else {
        return 1.0;
    };
    let weight = groups.iter().fold(first * 0.0, |sum, (w, _)| sum + w);
    let square = |v: &DVector<f64>| v.dot(&(&weight * v));
    let mean = groups.iter().fold(DVector::zeros(first.nrows()), |sum, (_, b)| sum + b) / n;
    let scatter: f64 = groups.iter().map(|(_, amplitudes)| square(&(amplitudes - &mean))).sum();
    f_tail(n * square(&mean) * (n - 1.0) / scatter, 1.0, n - 1.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    const TRIALS: usize = 4000;

    /// Share of trials below 1 %: groups of twenty readings whose noise is the same wave in all of a group, by
    /// chance up or down, beside a part of it that all have in common.
    fn share_below(common_part: f64, n_groups: usize, directions: usize) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let column = |i: usize, j: usize| (0.4 * count((i + 1) * (j + 2))).sin();
        let added = DMatrix::from_fn(20, directions, column);
        let base = DMatrix::from_element(20, 1, 1.0);
        let below = (0..TRIALS).filter(|_| {
            let one = |_| {
                let loud: f64 = (0.5 * rng.sample::<f64, _>(StandardNormal)).exp();
                let shared: f64 = rng.sample(StandardNormal);
                let residual = DVector::from_fn(20, |i, _| {
                    let white: f64 = rng.sample(StandardNormal);
                    column(i, 0) * (loud * shared + common_part) + 0.1 * white
                });
                of_one(&base, &added, &residual)
            };
            let groups: Vec<_> = (0..n_groups).filter_map(one).collect();
            common(&groups) < 0.01
        });
        count(below.count()) / count(TRIALS)
    }

    /// 1 % of 4000 has a standard deviation of 0.16 %; four of them.
    #[test]
    fn noise_that_a_group_has_in_common_is_no_effect() {
        for (n_groups, directions) in [(3, 1), (5, 1), (5, 3), (4, 6)] {
            let share = share_below(0.0, n_groups, directions);
            assert!(share < 0.0164, "{n_groups} groups, {directions} directions: {share}");
        }
    }

    #[test]
    fn what_all_groups_have_in_common_is_found() {
        assert!(share_below(20.0, 4, 1) > 0.95);
        assert!(share_below(20.0, 4, 6) > 0.95);
    }

    /// A group that goes one way only does not tell a reversal.
    #[test]
    fn groups_that_do_not_show_it_say_nothing() {
        let base = DMatrix::from_element(4, 1, 1.0);
        let one_way = DMatrix::from_element(4, 1, 1.0);
        assert!(of_one(&base, &one_way, &DVector::from_element(4, 2.0)).is_none());
    }
}
