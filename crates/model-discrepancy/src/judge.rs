//! Scores of all candidates in one pass.

use std::cell::OnceCell;

use nalgebra::DVector;

use crate::basis::Basis;
use crate::candidate::{Candidate, Sight, Source, catalogue, classes, seen};
use crate::glance::Onlooker;
use crate::holdout::{Comparison, HeldOut, compare, folds, leave_out};
use crate::interruption::{breaks, interrupted, strongest as strongest_break};
use crate::linear::{Linear, NEW_DIRECTION};
use crate::local::{LocalSight, full_sight, local_effects};
use crate::model::whole_tangent;
use crate::select::CHOICE_FOLDS;
use crate::shape::{MIN_SHAPE_KEPT, Shape, correction, periods, shapes};
use crate::significance::{Asked, Reach, Significance, count, significance_beside};
use crate::system::{Empirical, Estimate, System};
use crate::{Covariate, Model, Options, Origin};

/// Standard errors by which groups must gain where others cannot be predicted any more.
const CLEARLY: f64 = 2.0;

/// What stays the same while effects are chosen.
pub(crate) struct Setting<'a> {
    pub(crate) model: &'a dyn Model,
    /// Recorded and coordinate covariates, and the measured order.
    pub(crate) covariates: &'a [Covariate],
    pub(crate) options: &'a Options,
    /// Components whose residual is zero throughout: not measured, and left out of inference.
    pub(crate) silent: &'a [bool],
    /// Whether to score hopeless candidates too, for the report.
    pub(crate) thorough: bool,
}

/// A candidate with its scores.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    pub(crate) candidate: Candidate,
    pub(crate) class: usize,
    pub(crate) test: Significance,
    /// What the test had to show.
    pub(crate) asked: Asked,
    /// p-value times the number of things that were looked at.
    pub(crate) adjusted: f64,
    /// Error on groups left out; `None` where the candidate was out of the question already.
    pub(crate) held_out: Option<HeldOut>,
    pub(crate) comparison: Option<Comparison>,
    /// Bayesian information criterion relative to nothing added; lower is better.
    pub(crate) criterion: f64,
}

impl Judged {
    /// Whether it makes unseen groups better predicted.
    ///
    /// A group that cannot be predicted with it, because without the group too few are left for
    /// its amplitudes, says nothing; where there are such, the others, at least as many, must gain
    /// clearly. One bad reading, which is not judged itself, says nothing of the other groups where
    /// the model has no parameter that it could have pulled.
    pub(crate) fn generalises(&self) -> bool {
        let better = |c: &Comparison| {
            let gain = if c.lost == 0 { 0.0 } else { CLEARLY * c.std };
            c.lost <= c.judged && c.difference < -gain && c.reported[1] < c.reported[0]
        };
        let same = |c: &Comparison| {
            let is_one = self.candidate.home.is_some() && c.lost == 0;
            is_one && c.difference <= 0.0 && c.reported[1] <= c.reported[0]
        };
        self.comparison.is_some_and(|c| better(&c) || same(&c))
    }
}

/// How candidates are judged in one pass.
pub(crate) struct Bench<'a> {
    pub(crate) lin: &'a Linear<'a>,
    /// Fold of each cluster.
    pub(crate) folds: Vec<usize>,
    /// Clusters that are not judged.
    pub(crate) skip: Vec<bool>,
    /// Residual without what the system explains.
    pub(crate) clean: DVector<f64>,
    /// Error of the present system on left-out groups.
    present: OnceCell<HeldOut>,
    /// Significance asked of an adjusted p-value.
    pub(crate) alpha: f64,
    /// Whether to score hopeless candidates too.
    pub(crate) thorough: bool,
}

impl<'a> Bench<'a> {
    /// Judges beside `system` as fitted at `at` and linearised in `lin`.
    pub(crate) fn new(
        setting: &Setting<'_>,
        system: &System<'_>,
        at: &Estimate,
        lin: &'a Linear<'a>,
        alpha: f64,
    ) -> Self {
        let folds = folds(lin.clusters.len(), CHOICE_FOLDS);
        let skip = excluded(setting, system, at, lin);
        let thorough = setting.thorough;
        Self {
            lin,
            folds,
            skip,
            clean: lin.clean_residual(),
            present: OnceCell::new(),
            alpha,
            thorough,
        }
    }

    /// Error of the present system on left-out groups.
    pub(crate) fn present(&self) -> &HeldOut {
        let of = || leave_out(self.lin, &self.lin.basis, &self.folds, &self.skip);
        self.present.get_or_init(of)
    }
}

/// One pass over the catalogue or over the covariates.
pub(crate) struct Hearing {
    pub(crate) judged: Vec<Judged>,
    /// Effects the design cannot see, with the share absorbed.
    pub(crate) unseen: Vec<(usize, f64)>,
    /// Significance asked of one p-value.
    pub(crate) alpha_single: f64,
}

/// Clusters whose only reading was named bad: they stay in the fit and are not judged.
pub(crate) fn excluded(
    setting: &Setting<'_>,
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
) -> Vec<bool> {
    let mut excluded = vec![false; lin.clusters.len()];
    let effects = &setting.model.declared().effects;
    for active in system.active.iter().filter(|a| effects[a.effect].subject.is_some()) {
        let tangent = lin.tangent(&whole_tangent(setting.model, &at.state, active.effect));
        let touched: Vec<_> = (0..lin.clusters.len())
            .filter(|&c| lin.clusters[c].iter().any(|&i| tangent.row(i).iter().any(|&v| v != 0.0)))
            .collect();
        if let [only] = touched[..] {
            excluded[only] = true;
        }
    }
    excluded
}

/// Scores every effect of the catalogue that is not in the system.
pub(crate) fn hear_catalogue(system: &System<'_>, at: &Estimate, bench: &Bench<'_>) -> Hearing {
    let lin = bench.lin;
    let mut candidates = Vec::new();
    let mut unseen = Vec::new();
    for (effect, sight) in catalogue(system, at, lin) {
        match sight {
            Sight::Seen(candidate) => candidates.push(*candidate),
            Sight::Unseen(absorbed) => unseen.push((effect, absorbed)),
        }
    }
    let mut locals = Families::default();
    for (effect, sight) in local_effects(system, at, lin) {
        match sight {
            LocalSight::Seen(local) => {
                locals.push(
                    &system.model.declared().effects[effect].id,
                    effect,
                    local.test.p_value,
                );
            }
            LocalSight::Unseen(absorbed) => unseen.push((effect, absorbed)),
        }
    }
    for effect in locals.worth_hearing(bench) {
        if let Sight::Seen(candidate) = full_sight(system, at, lin, effect) {
            candidates.push(*candidate);
        }
    }
    let class = classes(&candidates);
    let trials = trials(&candidates, &class, &locals);
    let judged = candidates
        .into_iter()
        .zip(class)
        .filter_map(|(candidate, class)| {
            let family = trials.family(&candidate);
            judge(bench, (&lin.basis, &bench.clean), candidate, class, trials.tests * family)
        })
        .collect();
    Hearing { judged, unseen, alpha_single: bench.alpha / trials.tests.max(1.0) }
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
    fn worth_hearing(&self, bench: &Bench<'_>) -> Vec<usize> {
        let mut worth = Vec::new();
        for (_, members) in &self.0 {
            let level = bench.alpha / count(members.len());
            let strongest = members.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let shown = strongest.filter(|_| bench.thorough).map(|(effect, _)| *effect);
            let heard = |m: &&(usize, f64)| m.1 <= level || Some(m.0) == shown;
            worth.extend(members.iter().filter(heard).map(|(effect, _)| *effect));
        }
        worth
    }
}

/// How many independent things a pass looks at.
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

/// Judges beside a base and what this leaves of the data.
fn judge(
    bench: &Bench<'_>,
    (base, residual): (&Basis, &DVector<f64>),
    candidate: Candidate,
    class: usize,
    trials: f64,
) -> Option<Judged> {
    let lin = bench.lin;
    let level = bench.alpha / trials;
    let asked = Asked { reach: candidate.reach, searched: candidate.searched, level };
    let test = significance_beside(lin, base, residual, &candidate.beside, asked)?;
    let adjusted = (test.p_value * trials).min(1.0);
    let n = count(lin.rows.len());
    let rss_after = test.variance * count(test.dof);
    let ratio = (rss_after / (rss_after + test.explained)).max(f64::MIN_POSITIVE);
    let criterion = n * ratio.ln() + count(test.directions) * n.ln();
    let mut judged = Judged {
        candidate,
        class,
        test,
        asked,
        adjusted,
        held_out: None,
        comparison: None,
        criterion,
    };
    if bench.thorough || adjusted <= bench.alpha {
        let mut skip = bench.skip.clone();
        if let Some(home) = judged.candidate.home {
            skip[home] = true;
        }
        let full = base.with(&judged.candidate.tangent, NEW_DIRECTION);
        let held_out = leave_out(lin, &full, &bench.folds, &skip);
        judged.comparison = Some(compare(bench.present(), &held_out, &skip));
        judged.held_out = Some(held_out);
    }
    Some(judged)
}

/// Scores the shapes along every covariate that may be significant.
pub(crate) fn hear_covariates(setting: &Setting<'_>, bench: &Bench<'_>) -> Vec<Judged> {
    let onlooker = Onlooker::new(bench.lin, &bench.clean);
    let families: Vec<_> =
        setting.covariates.iter().map(|c| (c, strongest_shapes(&onlooker, c))).collect();
    // That a shape is the best of many is in the number of trials.
    let trials = families.iter().flat_map(|(_, found)| found).map(|(shape, _)| shape.tried).sum();
    let mut judged = Vec::new();
    for (covariate, found) in &families {
        // The further tests could only raise it.
        let may_be = found
            .iter()
            .filter(|(_, glance)| glance.is_some_and(|test| test.p_value * trials <= bench.alpha));
        for (shape, _) in may_be {
            let candidate = empirical_candidate(bench.lin, &bench.lin.basis, covariate, shape);
            judged.extend(candidate.and_then(|(c, base)| {
                let residual = base.reject(&bench.clean);
                judge(bench, (&base, &residual), c, 0, trials)
            }));
        }
    }
    judged
}

/// The shapes along one covariate, of its periods and of its interruptions the one each that takes
/// away most.
fn strongest_shapes(
    onlooker: &Onlooker<'_>,
    covariate: &Covariate,
) -> Vec<(Shape, Option<Significance>)> {
    let layout = onlooker.lin.layout;
    let power = |glance: &Option<Significance>| glance.map_or(0.0, |test| test.explained);
    let seen = |shapes: Vec<Shape>| {
        let glances = onlooker.glances(&shapes);
        shapes.into_iter().zip(glances)
    };
    let mut found: Vec<_> = seen(shapes(layout, covariate)).collect();
    let periods = seen(periods(layout, covariate));
    found.extend(periods.max_by(|a, b| power(&a.1).total_cmp(&power(&b.1))));
    let breaks = breaks(layout, covariate);
    let at = strongest_break(&breaks, |some| {
        let broken: Vec<_> = some.iter().map(|&at| interrupted(covariate, at, &breaks)).collect();
        onlooker.glances(&broken).iter().map(power).collect()
    });
    found.extend(at.and_then(|at| seen(vec![interrupted(covariate, at, &breaks)]).next()));
    found
}

/// A shape as a candidate, limited to what the design sees, and the base to test it beside:
/// `base` with the constants that go along.
pub(crate) fn empirical_candidate(
    lin: &Linear<'_>,
    base: &Basis,
    covariate: &Covariate,
    shape: &Shape,
) -> Option<(Candidate, Basis)> {
    let all = correction(lin.layout, &covariate.name, shape);
    let tangent = lin.tangent(&all.columns);
    let functions = all.columns.ncols() - all.constants;
    let constants: Vec<_> = (functions..all.columns.ncols()).collect();
    let with_constants = base.with(&tangent.select_columns(&constants), MIN_SHAPE_KEPT);
    let shape_columns = tangent.columns(0, functions).into_owned();
    let left = with_constants.reject_columns(&shape_columns);
    let mut kept = seen(&shape_columns, &left, MIN_SHAPE_KEPT);
    if kept.is_empty() {
        return None;
    }
    let (tested, beside) = (tangent.select_columns(&kept), left.select_columns(&kept));
    let constant_columns = tangent.select_columns(&constants);
    let left = base.with(&tested, NEW_DIRECTION).reject_columns(&constant_columns);
    let new_constants = seen(&constant_columns, &left, MIN_SHAPE_KEPT);
    let n_constants = new_constants.len();
    kept.extend(new_constants.into_iter().map(|c| functions + c));
    let empirical = Empirical {
        coefficients: kept.iter().map(|&c| all.coefficients[c].clone()).collect(),
        columns: all.columns.select_columns(&kept),
        constants: n_constants,
        covariate: all.covariate,
        shape: all.shape,
    };
    let candidate = Candidate {
        id: format!("covariate:{}", covariate.name),
        subject: None,
        source: Source::Empirical(empirical),
        tangent: tested,
        beside,
        reach: Reach::Many,
        searched: 1.0,
        home: None,
    };
    Some((candidate, with_constants))
}

/// Whether the user recorded the column, rather than the model's input holding it.
pub(crate) fn recorded(setting: &Setting<'_>, column: &str) -> bool {
    setting.covariates.iter().any(|c| c.name == column && c.origin == Origin::Recorded)
}

/// A recorded shape anew, beside another base.
pub(crate) fn shape_again(
    setting: &Setting<'_>,
    lin: &Linear<'_>,
    base: &Basis,
    covariate: &str,
    shape: &str,
) -> Option<(Candidate, Basis)> {
    let covariate = setting.covariates.iter().find(|c| c.name == covariate)?;
    let breaks = breaks(lin.layout, covariate);
    let interruptions = breaks.iter().map(|&at| interrupted(covariate, at, &breaks));
    let smooth = shapes(lin.layout, covariate).into_iter();
    let mut all = smooth.chain(periods(lin.layout, covariate)).chain(interruptions);
    let shape = all.find(|s| s.name == shape)?;
    empirical_candidate(lin, base, covariate, &shape)
}
