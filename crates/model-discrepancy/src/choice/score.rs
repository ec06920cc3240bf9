//! Scores of all candidates in one pass.

use crate::choice::blocks::passing::One;
use crate::choice::context::Context;
use crate::levels::CLEAR_GAIN;
use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::{Candidate, Estimability, catalogue, classes, estimabilities};
use crate::choice::one_observation::{LocalEstimability, full_candidate, local_effects};
use crate::choice::tail::{is_one_tail, may_be_a_tail};
use crate::count::count;
use crate::levels::CHOICE_FOLDS;
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test};
use crate::tests::hold_out::{Comparison, HeldOut, compare, folds, leave_out};
use crate::tests::left_out::LeftOut;
use crate::tests::significance::{Asked, Reach, significance_beside};

/// Change of an error on groups left out, whitened and squared or as a share, that is round-off: an
/// error that stays the same by construction differs by some 1e-13.
const NO_CHANGE: f64 = 1e-9;

/// A candidate with its scores.
#[derive(Clone, Debug)]
pub(crate) struct Scored {
    pub(crate) candidate: Candidate,
    /// What it stands beside, where that is more than the system.
    pub(crate) base: Option<Basis>,
    pub(crate) class: usize,
    pub(crate) test: Significance,
    /// What the test had to show.
    pub(crate) asked: Asked,
    /// Number of things that were looked at.
    pub(crate) trials: f64,
    /// p-value times that number.
    pub(crate) adjusted: f64,
    /// Whether no test is left that could raise the p-value.
    pub(crate) is_confirmed: bool,
    /// Whether the reported error on groups left out must fall with it.
    pub(crate) is_reported: bool,
    /// Error on groups left out; `None` where the candidate was out of the question already.
    pub(crate) held_out: Option<HeldOut>,
    pub(crate) comparison: Option<Comparison>,
    /// Bayesian information criterion relative to nothing added; lower is better.
    pub(crate) criterion: f64,
}

impl Scored {
    /// Whether it makes unseen groups better predicted.
    ///
    /// A group that cannot be predicted with it, because without the group too few are left for
    /// its amplitudes, says nothing; where there are such, the others, at least as many, must gain
    /// clearly. One bad reading, which is not judged itself, says nothing of the other groups where
    /// the model has no parameter that it could have pulled.
    pub(crate) fn generalises(&self) -> bool {
        let better = |c: &Comparison| {
            let gain = if c.lost == 0 { 0.0 } else { CLEAR_GAIN * c.std };
            let falls = c.reported[1] < c.reported[0] * (1.0 - NO_CHANGE) || !self.is_reported;
            c.lost <= c.judged && c.difference < -gain - NO_CHANGE && falls
        };
        let same = |c: &Comparison| {
            let is_one = self.candidate.home.is_some() && c.lost == 0;
            let stays = c.reported[1] <= c.reported[0] * (1.0 + NO_CHANGE) || !self.is_reported;
            is_one && c.difference <= NO_CHANGE && stays
        };
        self.comparison.is_some_and(|c| better(&c) || same(&c))
    }
}

/// How candidates are judged in one pass.
pub(crate) struct Scoring<'a> {
    pub(crate) lin: &'a Linear<'a>,
    /// Fold of each cluster.
    pub(crate) folds: Vec<usize>,
    /// Clusters that are not judged.
    pub(crate) skip: Vec<bool>,
    /// Residual without what the system explains.
    pub(crate) clean: DVector<f64>,
    /// The present system with folds left out, and its error on them.
    left_out: OnceCell<LeftOut>,
    present: OnceCell<HeldOut>,
    /// Significance asked of an adjusted p-value.
    pub(crate) alpha: f64,
    /// Effects that are out of the question.
    pub(crate) banned: &'a [usize],
    /// Whether to score hopeless candidates too.
    pub(crate) thorough: bool,
}

impl<'a> Scoring<'a> {
    /// Judges beside `system` as fitted at `at` and linearised in `lin`.
    pub(crate) fn new(
        context: &Context<'a>,
        system: &System<'_>,
        at: &Estimate,
        lin: &'a Linear<'a>,
        alpha: f64,
    ) -> Self {
        let folds = folds(lin.clusters.len(), CHOICE_FOLDS);
        let skip = excluded(context, system, at, lin);
        let thorough = context.thorough;
        Self {
            lin,
            folds,
            skip,
            clean: lin.clean_residual(),
            left_out: OnceCell::new(),
            present: OnceCell::new(),
            alpha,
            banned: context.banned,
            thorough,
        }
    }

    /// Error of the present system on left-out groups.
    pub(crate) fn present(&self) -> &HeldOut {
        self.present.get_or_init(|| self.left_out().errors(self.lin, &self.lin.basis))
    }

    fn left_out(&self) -> &LeftOut {
        self.left_out.get_or_init(|| LeftOut::of(self.lin, &self.folds, &self.skip))
    }

    /// Error on left-out groups of the system with a candidate, whose own cluster is not judged.
    fn with(&self, base: &Basis, candidate: &Candidate) -> (HeldOut, Vec<bool>) {
        let (lin, full) = (self.lin, base.with(&candidate.tangent, NEW_DIRECTION));
        let mut skip = self.skip.clone();
        let Some(home) = candidate.home else {
            // A base begins with the system's columns.
            return (self.left_out().errors(lin, &full), skip);
        };
        skip[home] = true;
        (leave_out(lin, &full, &self.folds, &skip), skip)
    }
}

/// One pass over the catalogue.
pub(crate) struct ScorePass {
    /// All candidates: confirmed where scoring is thorough, otherwise screened.
    pub(crate) judged: Vec<Scored>,
    pub(crate) candidates: Candidates,
    /// Effects the design cannot see, with the share absorbed.
    pub(crate) not_estimable: Vec<(usize, f64)>,
    /// Significance asked of one p-value.
    pub(crate) alpha_single: f64,
}

/// Clusters whose only reading was named bad: they stay in the fit and are not judged.
pub(crate) fn excluded(
    context: &Context<'_>,
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
) -> Vec<bool> {
    let mut excluded = vec![false; lin.clusters.len()];
    for active in &system.active {
        if let Some(only) = home_of_bad(context, at, lin, active.effect) {
            excluded[only] = true;
        }
    }
    excluded
}

/// The one cluster that an effect with a subject moves: one bad reading, which says nothing of others.
pub(crate) fn home_of_bad(
    context: &Context<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
    effect: usize,
) -> Option<usize> {
    context.model.declared().effects[effect].subject.as_ref()?;
    let tangent = lin.tangent(&whole_tangent(context.model, &at.state, effect));
    let moved =
        |&c: &usize| lin.clusters[c].iter().any(|&i| tangent.row(i).iter().any(|&v| v != 0.0));
    let mut touched = (0..lin.clusters.len()).filter(moved);
    touched.next().filter(|_| touched.next().is_none())
}

/// Scores every effect of the catalogue that is not in the system.
pub(crate) fn score_catalogue(
    system: &System<'_>,
    at: &Estimate,
    scoring: &Scoring<'_>,
) -> ScorePass {
    let lin = scoring.lin;
    let mut candidates = Vec::new();
    let mut not_estimable = Vec::new();
    let effects = &system.model.declared().effects;
    let is_open =
        |effect: usize| !scoring.banned.contains(&effect) && !effects[effect].only_instead;
    for (effect, sight) in catalogue(system, at, lin).into_iter().filter(|(e, _)| is_open(*e)) {
        match sight {
            Estimability::Estimable(candidate) => candidates.push(*candidate),
            Estimability::NotEstimable(absorbed) => not_estimable.push((effect, absorbed)),
        }
    }
    let mut locals = Families::default();
    for (effect, sight) in local_effects(system, at, lin).filter(|(e, _)| is_open(*e)) {
        match sight {
            LocalEstimability::Estimable(local) => {
                locals.push(&effects[effect].id, effect, local.test.p_value);
            }
            LocalEstimability::NotEstimable(absorbed) => not_estimable.push((effect, absorbed)),
        }
    }
    for effect in locals.worth_scoring(scoring) {
        if let Estimability::Estimable(candidate) = full_candidate(system, at, lin, effect) {
            candidates.push(*candidate);
        }
    }
    let class = classes(&candidates);
    let trials = trials(&candidates, &class, &locals);
    let alpha_single = scoring.alpha / trials.tests.max(1.0);
    let candidates = Candidates { all: candidates, class, trials };
    let judged = |i| {
        if scoring.thorough {
            candidates.judged(scoring, i)
        } else {
            candidates.screened(scoring, i)
        }
    };
    let judged = (0..candidates.all.len()).filter_map(judged).collect();
    ScorePass { judged, candidates, not_estimable, alpha_single }
}

/// The pass over effects of which alone the F test lets any pass, screened.
pub(crate) fn score_passing(
    system: &System<'_>,
    at: &Estimate,
    scoring: &Scoring<'_>,
    passing: &[One],
) -> Vec<Scored> {
    let base = (&scoring.lin.basis, &scoring.clean);
    let effects = passing.iter().map(|one| one.effect).collect();
    let seen = estimabilities(system, at, scoring.lin, effects).into_iter();
    let one = |(one, (_, seen)): (&One, (usize, Estimability))| {
        screened(scoring, base, seen.candidate()?, one.class, one.trials)
    };
    passing.iter().zip(seen).filter_map(one).collect()
}

/// What a pass judges, and beside how much else.
#[derive(Clone)]
pub(crate) struct Candidates {
    pub(crate) all: Vec<Candidate>,
    /// Class of each.
    class: Vec<usize>,
    trials: Trials,
}

impl Candidates {
    /// The same, and one more.
    pub(crate) fn with(&self, candidate: Candidate) -> Self {
        let mut more = self.clone();
        more.class.push(more.all.len());
        more.all.push(candidate);
        more
    }

    /// The one at a place in the list.
    pub(crate) fn judged(&self, scoring: &Scoring<'_>, i: usize) -> Option<Scored> {
        let base = (&scoring.lin.basis, &scoring.clean);
        confirmed(scoring, base, self.screened(scoring, i)?)
    }

    /// The same by the F test alone, which further tests could only contradict.
    fn screened(&self, scoring: &Scoring<'_>, i: usize) -> Option<Scored> {
        let base = (&scoring.lin.basis, &scoring.clean);
        screened(scoring, base, self.all[i].clone(), self.class[i], self.trials_of(&self.all[i]))
    }

    /// By how much the p-value of one counts more for how much else is judged.
    pub(crate) fn trials_of(&self, candidate: &Candidate) -> f64 {
        self.trials.tests * self.trials.family(candidate)
    }
}

/// Candidates that move one observation each, by id: effect and p-value on its own.
#[derive(Default)]
struct Families(Vec<(String, Vec<(usize, f64)>)>);

impl Families {
    fn push(&mut self, id: &str, effect: usize, p_value: f64) {
        match self.0.iter_mut().find(|(known, _)| known == id) {
            Some((_, members)) => members.push((effect, p_value)),
            None => self.0.push((id.to_owned(), vec![(effect, p_value)])),
        }
    }

    /// Those that may be significant, and for the report the strongest of each family.
    fn worth_scoring(&self, scoring: &Scoring<'_>) -> Vec<usize> {
        let mut worth = Vec::new();
        for (_, members) in &self.0 {
            let level = scoring.alpha / count(members.len());
            let strongest = members.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let shown = strongest.filter(|_| scoring.thorough).map(|(effect, _)| *effect);
            let heard = |m: &&(usize, f64)| m.1 <= level || Some(m.0) == shown;
            worth.extend(members.iter().filter(heard).map(|(effect, _)| *effect));
        }
        worth
    }
}

/// How many independent things a pass looks at.
#[derive(Clone)]
struct Trials {
    tests: f64,
    /// Id and size of each family of candidates that live in one group each.
    families: Vec<(String, usize)>,
}

impl Trials {
    /// Members of a family of candidates of which each lives in one group.
    fn family(&self, candidate: &Candidate) -> f64 {
        if candidate.reach == Reach::Many {
            return 1.0;
        }
        self.families.iter().find(|(id, _)| *id == candidate.id).map_or(1.0, |(_, n)| count(*n))
    }
}

fn trials(candidates: &[Candidate], class: &[usize], locals: &Families) -> Trials {
    let mut families: Vec<(String, usize)> =
        locals.0.iter().map(|(id, members)| (id.clone(), members.len())).collect();
    let mut tests = families.len();
    for (i, candidate) in candidates.iter().enumerate() {
        if locals.0.iter().any(|(id, _)| *id == candidate.id) {
            continue;
        }
        if candidate.reach == Reach::Many {
            tests += usize::from(class[i] == i);
        } else if let Some((_, n)) = families.iter_mut().find(|(id, _)| *id == candidate.id) {
            *n += 1;
        } else {
            tests += 1;
            families.push((candidate.id.clone(), 1));
        }
    }
    Trials { tests: count(tests), families }
}

/// Judges beside a base that begins with the system's columns, by the F test alone.
pub(crate) fn screened_beside(
    scoring: &Scoring<'_>,
    base: Basis,
    candidate: Candidate,
    trials: f64,
) -> Option<Scored> {
    let residual = base.reject(&scoring.clean);
    let scored = screened(scoring, (&base, &residual), candidate, 0, trials)?;
    Some(Scored { base: Some(base), ..scored })
}

/// Judges beside a base and what this leaves of the data, by the F test alone.
pub(crate) fn screened(
    scoring: &Scoring<'_>,
    (base, residual): (&Basis, &DVector<f64>),
    candidate: Candidate,
    class: usize,
    trials: f64,
) -> Option<Scored> {
    let lin = scoring.lin;
    let level = scoring.alpha / trials;
    let asked = Asked { reach: candidate.reach, searched: candidate.searched, level };
    let added = Basis::of(&candidate.beside, NEW_DIRECTION.sqrt());
    let test = asked.searched_for(f_test(residual, base.dim(), &added)?);
    Some(Scored {
        base: None,
        class,
        asked,
        trials,
        adjusted: (test.p_value * trials).min(1.0),
        is_confirmed: false,
        is_reported: is_reported(lin, &candidate.beside),
        held_out: None,
        comparison: None,
        criterion: criterion(lin.rows.len(), &test, candidate.searched),
        candidate,
        test,
    })
}

impl Scored {
    /// Makes all tests that are left; what cannot be tested counts for nothing.
    pub(crate) fn confirm(&mut self, scoring: &Scoring<'_>) {
        if self.is_confirmed {
            return;
        }
        let confirmed = match &self.base {
            Some(base) => confirmed(scoring, (base, &base.reject(&scoring.clean)), self.clone()),
            None => confirmed(scoring, (&scoring.lin.basis, &scoring.clean), self.clone()),
        };
        if let Some(confirmed) = confirmed {
            *self = confirmed;
        } else {
            (self.is_confirmed, self.adjusted) = (true, f64::INFINITY);
        }
    }
}

/// What was screened with all tests that could raise its p-value, and its error on groups left out;
/// `None` where they cannot be made.
fn confirmed(
    scoring: &Scoring<'_>,
    (base, residual): (&Basis, &DVector<f64>),
    mut judged: Scored,
) -> Option<Scored> {
    let lin = scoring.lin;
    let candidate = &judged.candidate;
    if judged.test.p_value <= judged.asked.level {
        judged.test = significance_beside(lin, base, residual, &candidate.beside, judged.asked)?;
    }
    judged.is_confirmed = true;
    judged.adjusted = (judged.test.p_value * judged.trials).min(1.0);
    if judged.adjusted <= scoring.alpha
        && (may_be_a_tail(lin, base, &[candidate]) || is_one_tail(lin, base, residual, candidate))
    {
        judged.adjusted = 1.0;
    }
    if scoring.thorough || judged.adjusted <= scoring.alpha {
        let (held_out, skip) = scoring.with(base, candidate);
        judged.comparison = Some(compare(scoring.present(), &held_out, &skip));
        judged.held_out = Some(held_out);
    }
    Some(judged)
}

/// Bayesian information criterion of so many rows, relative to nothing added; of what is the best of
/// so many looked at, each is as likely beforehand as its share.
pub(crate) fn criterion(rows: usize, test: &Significance, searched: f64) -> f64 {
    let n = count(rows);
    let rss_after = test.variance * count(test.dof);
    let ratio = (rss_after / (rss_after + test.explained)).max(f64::MIN_POSITIVE);
    n * ratio.ln() + count(test.directions) * n.ln() + 2.0 * searched.ln()
}

/// Whether half of what a candidate adds to judged readings, in units of their noise, is in rows
/// that are reported: the reported error says nothing of an effect on moments beside forces.
fn is_reported(lin: &Linear<'_>, beside: &DMatrix<f64>) -> bool {
    let (mut reported, mut all) = (0.0, 0.0);
    for &row in lin.clusters.iter().flatten() {
        let square = beside.row(row).norm_squared();
        all += square;
        if lin.layout.rows[lin.rows[row]].reported {
            reported += square;
        }
    }
    2.0 * reported >= all
}
