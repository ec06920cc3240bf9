//! Two effects that hide each other: neither is significant alone, both are together.

use nalgebra::DMatrix;

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::choice::candidate::Candidate;
use crate::choice::score::{ScorePass, Scored, Scoring, criterion};
use crate::count::count;
use crate::levels::{CATALOGUE_SHARE, LEFT_BY_ANY, MAX_CLASSES, QUARTER, STAY};
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test};
use crate::tests::hold_out::{compare, leave_out};
use crate::tests::significance::{
    Asked, Reach, holds_in_readings, significance, significance_beside,
};

/// The best pair of effects, each needed beside the other, when its significance survives the
/// number of pairs tried.
pub(crate) fn find_pair(scoring: &Scoring<'_>, pass: &ScorePass) -> Option<[Scored; 2]> {
    let representatives: Vec<_> = (pass.judged.iter().enumerate())
        .filter(|(_, j)| j.candidate.reach == Reach::Many)
        .filter(|(i, j)| pass.judged.iter().position(|k| k.class == j.class) == Some(*i))
        .map(|(_, j)| j)
        .take(MAX_CLASSES)
        .collect();
    let n = representatives.len();
    let pairs = count(n * n.saturating_sub(1) / 2);
    let alpha = scoring.alpha * QUARTER / CATALOGUE_SHARE;
    let mut best: Option<([Scored; 2], f64)> = None;
    for (i, a) in representatives.iter().enumerate() {
        for b in &representatives[i + 1..] {
            let Some((pair, criterion)) = judge_pair(scoring, a, b, alpha / pairs) else {
                continue;
            };
            if best.as_ref().is_none_or(|(_, c)| criterion < *c) {
                best = Some((pair, criterion));
            }
        }
    }
    best.map(|(pair, _)| pair)
}

/// Both effects tested together, and each beside the other.
///
/// At group level a pair is as significant as the better of the two beside the other, which counts
/// twice: few groups know the scatter along one direction far better than along two.
pub(crate) fn judge_pair(
    scoring: &Scoring<'_>,
    a: &Scored,
    b: &Scored,
    level: f64,
) -> Option<([Scored; 2], f64)> {
    let lin = scoring.lin;
    let searched = a.candidate.searched * b.candidate.searched;
    let both = side_by_side(&a.candidate.beside, &b.candidate.beside);
    let together = Basis::of(&both, NEW_DIRECTION.sqrt());
    let square = scoring.clean.norm_squared();
    if square - together.explained(&scoring.clean) <= LEFT_BY_ANY * square {
        return None;
    }
    let plain = f_test(&scoring.clean, lin.basis.dim(), &together)?;
    let is_whole = plain.directions >= a.test.directions + b.test.directions;
    if plain.p_value * searched > level || !is_whole {
        return None;
    }
    let one_beside_other = |level: f64| {
        let a_beside_b = beside(lin, &a.candidate, &b.candidate, level)?;
        Some((a_beside_b, beside(lin, &b.candidate, &a.candidate, level)?))
    };
    let better = |of: &(Significance, Significance)| of.0.p_value.min(of.1.p_value);
    // Where both are above half the level they need not be asked further.
    if 2.0 * better(&one_beside_other(0.5 * level)?) > level {
        return None;
    }
    let both_beside = one_beside_other(STAY)?;
    let at_best = 2.0 * better(&both_beside);
    let (a_beside_b, b_beside_a) = both_beside;
    if a_beside_b.p_value > STAY || b_beside_a.p_value > STAY {
        return None;
    }
    let asked = Asked { reach: Reach::One, searched, level };
    let mut joint = significance_beside(lin, &lin.basis, &scoring.clean, &both, asked)?;
    joint.p_value = joint.p_value.max(at_best);
    if joint.p_value > level || !holds_in_readings(lin, &scoring.clean, &both, &joint, asked) {
        return None;
    }
    let full = lin.basis.with(&both, NEW_DIRECTION);
    let mut skip = scoring.skip.clone();
    for home in [a.candidate.home, b.candidate.home].into_iter().flatten() {
        skip[home] = true;
    }
    let held_out = leave_out(lin, &full, &scoring.folds, &skip);
    let comparison = Some(compare(scoring.present(), &held_out, &skip));
    let criterion = criterion(lin.rows.len(), &joint, searched);
    let member = |of: &Scored, test: Significance| Scored {
        test,
        adjusted: joint.p_value,
        held_out: Some(held_out.clone()),
        comparison,
        criterion,
        ..of.clone()
    };
    let pair = [member(a, a_beside_b), member(b, b_beside_a)];
    pair[0].generalises().then_some((pair, criterion))
}

fn side_by_side(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<_> = a.column_iter().chain(b.column_iter()).map(|c| c.clone_owned()).collect();
    DMatrix::from_columns(&columns)
}

fn beside(
    lin: &Linear<'_>,
    tested: &Candidate,
    other: &Candidate,
    level: f64,
) -> Option<Significance> {
    let base = lin.basis.with(&other.tangent, NEW_DIRECTION);
    significance(lin, &base, &tested.tangent, tested.reach, level)
}
