//! Is a candidate's tangent in the residual by more than chance? Judged at group level.

use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::levels::CLEAR_BEYOND_DOUBT;
use crate::levels::MIN_CLUSTERS;
use crate::tests::f_test::{Significance, f_test};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::levels::MIN_AGREEING;
use crate::noise::linear::Linear;
use crate::tests::agreement::agreement_p_value;
use crate::tests::cluster_robust::cluster_robust;
use crate::tests::pooled_scatter::pooled_scatter;
use crate::tests::under_noise::Tested;
use crate::tests::vector_noise::vector_p_value;
use crate::tests::within_groups::within_groups;

/// Fewest degrees of freedom left for which a correlation between neighbours can be estimated.
const MIN_DOF_FOR_CORRELATION: usize = 8;

/// Whether the group level must confirm a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// The effect shows in many groups: the scatter between groups judges it.
    Many,
    /// The effect lives in one group: nothing but the other groups' noise can judge it.
    One,
}

/// What a test has to show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    pub(crate) reach: Reach,
    /// How many candidates were looked at in the same data to find this one.
    pub(crate) searched: f64,
    /// Above it, a test need not be asked further.
    pub(crate) level: f64,
}

impl Asked {
    /// The test of one that was found among others.
    pub(crate) fn searched_for(self, test: Significance) -> Significance {
        Significance { p_value: (test.p_value * self.searched).min(1.0), ..test }
    }
}

/// Tests `tangent` (whitened) beside everything in `base`.
///
/// Three tests, of which the least significant counts: the classical F test; the same after
/// taking out the correlation of successive observations, of neighbours (Prais and Winsten 1954)
/// and of long memory; and one at group level. Where a group is one vector, that is the F test with
/// the covariance of its components estimated; where it holds many readings, a Wald test on the
/// cluster-robust covariance CR2 with Hotelling's T² approximated as Zhang (2012) and Pustejovsky
/// and Tipton (2018) do, which asks no more than independent groups, or, where that cannot decide and
/// noise is all that is left, on their pooled scatter; with as many directions as groups, or
/// more, it is the agreement of the groups with each other.
/// Where one is above `level` the rest are not asked: they could only raise it.
pub(crate) fn significance(
    lin: &Linear<'_>,
    base: &Basis,
    tangent: &DMatrix<f64>,
    reach: Reach,
    level: f64,
) -> Option<Significance> {
    let residual = base.reject(&lin.residual);
    let asked = Asked { reach, searched: 1.0, level };
    let mut beside = base.reject_columns(tangent);
    for (mut left, whole) in beside.column_iter_mut().zip(tangent.column_iter()) {
        // Round-off of a column that the base holds is no direction.
        if left.norm() <= NEW_DIRECTION.sqrt() * whole.norm() {
            left.fill(0.0);
        }
    }
    significance_beside(lin, base, &residual, &beside, asked)
}

/// [`significance`] of a candidate of which `base` leaves `beside`; of the data it leaves
/// `residual`.
///
/// That the candidate was searched for counts under every colour of the noise. The group level
/// then has only to confirm it: its few groups could not tell chances so small apart.
pub(crate) fn significance_beside(
    lin: &Linear<'_>,
    base: &Basis,
    residual: &DVector<f64>,
    beside: &DMatrix<f64>,
    asked: Asked,
) -> Option<Significance> {
    let added = Basis::of(beside, NEW_DIRECTION.sqrt());
    let mut test = asked.searched_for(f_test(residual, base.dim(), &added)?);
    if test.p_value > asked.level {
        return Some(test);
    }
    let full = base.with(&added.matrix(), NEW_DIRECTION);
    if full.dim() < base.dim() + added.dim() {
        return None;
    }
    // The cheap ones first.
    if asked.reach == Reach::Many {
        let at_group_level =
            vector_p_value(lin, base, beside, (&added, &full)).unwrap_or_else(|| {
                group_p_value(lin, (&test, residual), (base, &added, &full), asked.level)
            });
        test.p_value = test.p_value.max(at_group_level);
    }
    if test.dof >= MIN_DOF_FOR_CORRELATION {
        let tested = Tested::new(lin, &full, added.dim(), residual);
        raise(&mut test.p_value, tested.p_values(), asked);
    }
    Some(test)
}

/// Whether what is significant by [`significance_beside`] stays so with the noise in the readings
/// behind the rows.
///
/// To be asked of what is about to be added: it costs more than all other tests.
pub(crate) fn holds_in_readings(
    lin: &Linear<'_>,
    residual: &DVector<f64>,
    beside: &DMatrix<f64>,
    test: &Significance,
    asked: Asked,
) -> bool {
    let is_clear = test.p_value <= CLEAR_BEYOND_DOUBT * asked.level;
    if lin.projected.is_empty() || is_clear || test.dof < MIN_DOF_FOR_CORRELATION {
        return true;
    }
    let added = Basis::of(beside, NEW_DIRECTION.sqrt());
    let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
    let tested = Tested::new(lin, &full, added.dim(), residual);
    let mut p_value = test.p_value;
    raise(&mut p_value, tested.p_values_of_readings(), asked);
    p_value <= asked.level
}

/// The largest of p-values, until one is above the level asked for.
fn raise(p_value: &mut f64, mut others: impl Iterator<Item = f64>, asked: Asked) {
    while *p_value <= asked.level
        && let Some(other) = others.next()
    {
        *p_value = p_value.max((other * asked.searched).min(1.0));
    }
}

fn group_p_value(
    lin: &Linear<'_>,
    (test, residual): (&Significance, &DVector<f64>),
    (base, added, full): (&Basis, &Basis, &Basis),
    level: f64,
) -> f64 {
    let clusters = lin.clusters.len();
    if clusters >= MIN_AGREEING && added.dim() >= clusters {
        return agreement_p_value(lin, residual, added);
    }
    // Many groups know their own scatter, which need not be alike: an effect of a few of them is judged
    // by theirs, unless declared noise says that all are alike.
    let is_pooled = lin.layout.sigma_declared || clusters < MIN_CLUSTERS;
    let of_scatter = || {
        let robust = cluster_robust(lin, added, full);
        let is_asked = is_pooled && robust > level;
        let pooled = if is_asked { pooled_scatter(lin, added, full) } else { None };
        pooled.unwrap_or(robust).min(robust)
    };
    if clusters >= MIN_CLUSTERS {
        return of_scatter();
    }
    let largest = lin.clusters.iter().map(Vec::len).max().unwrap_or(1);
    if largest == 1 {
        return 0.0;
    }
    // Too few groups to know their scatter well: count each as few readings as may be independent,
    // and let the scatter only object.
    let per_group = largest.min(3);
    let dof = (clusters * per_group).saturating_sub(full.dim()).min(test.dof) / per_group;
    let of_few = f_tail(test.f_statistic, count(test.directions), count(dof.max(1)));
    let of_few = of_few.min(of_few_declared(lin, test, count(per_group) / count(largest)));
    let has_scatter = clusters >= MIN_AGREEING;
    let p_value = if has_scatter { of_few.max(of_scatter()) } else { of_few };
    // Few groups that each show the same by themselves need not count as few readings.
    if p_value > level { p_value.min(within_groups(lin, residual, (base, added))) } else { p_value }
}

/// The same where the noise is declared, and few groups need not tell how large it is: a group that counts as so
/// many of its readings knows an amplitude by so much less.
fn of_few_declared(lin: &Linear<'_>, test: &Significance, counted: f64) -> f64 {
    let directions = count(test.directions);
    let law = ChiSquared::new(directions).ok().filter(|_| lin.is_as_declared);
    law.map_or(1.0, |law| law.sf(test.f_statistic * directions * counted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use crate::algebra::linearised::Linearised;

    /// Readings of one group each.
    const N: usize = 40;

    #[test]
    fn a_column_that_the_base_holds_is_no_direction() {
        let wave = |of: usize| move |i: usize, _: usize| (0.7 * count(i * of)).sin();
        let columns = DMatrix::from_columns(&[
            DVector::from_fn(N, wave(1)),
            DVector::from_fn(N, wave(2)),
            DVector::from_fn(N, wave(3)),
        ]);
        let basis = Basis::of(&columns, NEW_DIRECTION);
        let layout = Layout::default();
        let clusters: Vec<_> = (0..N).map(|i| vec![i]).collect();
        let residual = DVector::from_fn(N, wave(5)) + DVector::from_fn(N, wave(7));
        let lin = Linear::from(Linearised::of_parts(&layout, residual, basis, clusters));
        let held = &columns * DMatrix::from_column_slice(3, 1, &[1.0, -2.0, 0.5]);
        assert_eq!(significance(&lin, &lin.basis, &held, Reach::One, 1.0), None);
        let new =
            DMatrix::from_columns(&[held.column(0).into_owned(), DVector::from_fn(N, wave(5))]);
        let test = significance(&lin, &lin.basis, &new, Reach::One, 1.0).unwrap();
        assert_eq!(test.directions, 1);
    }
}
