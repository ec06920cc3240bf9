//! Scores of shapes along covariates.

use std::borrow::Cow;
use std::cell::OnceCell;

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::system::Empirical;
use crate::choice::candidate::{Candidate, Source, estimable_columns};
use crate::choice::context::Context;
use crate::choice::interruption::{interrupted, strongest as strongest_break};
use crate::choice::score::{Scored, Scoring, screened_beside};
use crate::choice::screening::Screening;
use crate::choice::shape::{Shape, correction};
use crate::choice::shapes::Shapes;
use crate::levels::MIN_SHAPE_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::Significance;
use crate::tests::significance::Reach;
use crate::{Covariate, Origin};

/// The shapes along every covariate that may be significant, screened.
pub(crate) fn score_covariates(context: &Context<'_>, scoring: &Scoring<'_>) -> Vec<Scored> {
    let screening = Screening::new(scoring.lin, &scoring.clean);
    let families: Vec<_> =
        context.along().map(|(c, shapes)| (c, strongest_shapes(&screening, c, shapes))).collect();
    // That a shape is the best of many is in the number of trials.
    let trials = families.iter().flat_map(|(_, found)| found).map(|(shape, _)| shape.tried).sum();
    let mut judged = Vec::new();
    for (covariate, found) in &families {
        // The further tests could only raise it.
        let may_be = found
            .iter()
            .filter(|(_, test)| test.is_some_and(|test| test.p_value * trials <= scoring.alpha));
        for (shape, _) in may_be {
            let candidate = empirical_candidate(scoring.lin, &scoring.lin.basis, covariate, shape);
            judged
                .extend(candidate.and_then(|(c, base)| screened_beside(scoring, base, c, trials)));
        }
    }
    judged
}

/// The shapes along one covariate; of its periods, of its levels apart and of its interruptions the
/// one each that takes away most.
pub(crate) fn strongest_shapes<'a>(
    screening: &Screening,
    covariate: &Covariate,
    shapes: &'a Shapes,
) -> Vec<(Cow<'a, Shape>, Option<Significance>)> {
    let power = |test: &Option<Significance>| test.map_or(0.0, |test| test.explained);
    let screened =
        |shapes: &'a [Shape]| shapes.iter().map(Cow::Borrowed).zip(screening.screened(shapes));
    let anew = |shape: Shape| {
        let test = screening.screened(std::slice::from_ref(&shape)).pop()?;
        Some((Cow::Owned(shape), test))
    };
    let mut found: Vec<_> = screened(&shapes.single).collect();
    let period = shapes.periods.as_ref().and_then(|periods| {
        let powers = screening.of_periods(covariate, periods).into_iter().map(|t| power(&t));
        let all = periods.parts.iter().zip(powers);
        let (&part, _) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
        anew(periods.shape(covariate, part))
    });
    found.extend(period);
    found.extend(screened(&shapes.apart).max_by(|a, b| power(&a.1).total_cmp(&power(&b.1))));
    let breaks = &shapes.breaks;
    let course = OnceCell::new();
    let at = strongest_break(breaks, |some| {
        let course = course.get_or_init(|| screening.course(covariate));
        screening.of_breaks(course, some).iter().map(power).collect()
    });
    found.extend(at.and_then(|at| anew(interrupted(covariate, at, breaks))));
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
    let mut kept = estimable_columns(&shape_columns, &left, MIN_SHAPE_KEPT);
    if kept.is_empty() {
        return None;
    }
    let (tested, beside) = (tangent.select_columns(&kept), left.select_columns(&kept));
    let constant_columns = tangent.select_columns(&constants);
    let left = base.with(&tested, NEW_DIRECTION).reject_columns(&constant_columns);
    let new_constants = estimable_columns(&constant_columns, &left, MIN_SHAPE_KEPT);
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
pub(crate) fn recorded(context: &Context<'_>, column: &str) -> bool {
    context.covariates.iter().any(|c| c.name == column && c.origin == Origin::Recorded)
}

/// A recorded shape anew, beside another base.
pub(crate) fn shape_again(
    context: &Context<'_>,
    lin: &Linear<'_>,
    base: &Basis,
    covariate: &str,
    shape: &str,
) -> Option<(Candidate, Basis)> {
    let (covariate, shapes) = context.along().find(|(c, _)| c.name == covariate)?;
    empirical_candidate(lin, base, covariate, &shapes.named(covariate, shape)?)
}
