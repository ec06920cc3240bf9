//! How a stand moves with time: steadily, or until it comes to rest.
//!
//! A stand that was carried to where it stands settles: `1 − exp(−t/τ)`. Which of the two it is, the
//! residual of the declared model says; the catalogue holds one drift for each station, by the course
//! that shows, so that no station's drift competes with itself.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::Survey;
use crate::count::count;
use crate::missing::change::Change;
use crate::missing::changes::Fitted;
use crate::missing::moves::Part;

/// Chance that a steady drift shows a time constant.
const FALSE_ALARM: f64 = 0.01;
/// The same below which a time constant is refined.
const IN_SIGHT: f64 = 0.2;
/// Time constants that are tried, as shares of the time that a drift is seen.
const SHARES: [f64; 6] = [0.05, 0.1, 0.2, 0.35, 0.6, 1.0];
/// Steps of the time constant once one is found, either way.
const REFINED: [f64; 6] = [1.3, 1.15, 1.07, 1.03, 1.015, 1.007];

/// How far a stand has come, per unit of its amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    /// Of a stand that comes to rest, in the unit of time; `None` of one that moves steadily.
    pub(crate) time_constant: Option<f64>,
    /// How many courses were looked at to find it.
    pub(crate) searched: usize,
}

impl Course {
    /// What is taken where nothing else shows.
    pub(crate) const STEADY: Self = Self { time_constant: None, searched: 1 };

    fn settling(time_constant: f64) -> Self {
        // As it is printed.
        let rounded = format!("{time_constant:.2e}").parse().unwrap_or(time_constant);
        Self { time_constant: Some(rounded), searched: 1 + SHARES.len() }
    }

    /// At a time of the run, for what was first seen at another.
    fn at(&self, time: f64, first: f64) -> f64 {
        match self.time_constant {
            None => time,
            Some(constant) => -(-(time - first) / constant).exp_m1(),
        }
    }
}

/// Of every stand alone, and of all alike.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Courses {
    pub(crate) of_station: Vec<Course>,
    pub(crate) of_all: Course,
}

/// How far the stand of a station has come at every range, from its first reading on where it
/// settles; zero at the others' ranges.
pub(crate) fn of_station(
    survey: &Survey,
    time: &[f64],
    station: usize,
    course: &Course,
) -> Vec<f64> {
    let is_own = |r: usize| survey.ranges[r].station == station;
    let own = (0..time.len()).filter(|&r| is_own(r));
    let first = own.map(|r| time[r]).fold(f64::INFINITY, f64::min);
    (0..time.len()).map(|r| if is_own(r) { course.at(time[r], first) } else { 0.0 }).collect()
}

/// How far all stands have come at every range, from the mean of those of its station on: where a
/// station is in the middle of its readings is the station's own place, and says nothing of how far
/// it moves.
pub(crate) fn of_all(survey: &Survey, time: &[f64], course: &Course) -> Vec<f64> {
    let first = time.iter().copied().fold(f64::INFINITY, f64::min);
    let come: Vec<f64> = time.iter().map(|time| course.at(*time, first)).collect();
    let mut sums = vec![(0.0, 0.0); survey.stations.len()];
    for (range, come) in survey.ranges.iter().zip(&come) {
        let (sum, n) = &mut sums[range.station];
        *sum += come;
        *n += 1.0;
    }
    let since = |(range, come): (&crate::Range, &f64)| {
        let (sum, n) = sums[range.station];
        come - sum / n
    };
    survey.ranges.iter().zip(&come).map(since).collect()
}

/// The course that each drift shows, by itself or else beside a change that the residual shows.
pub(crate) fn courses(fitted: &Fitted<'_>, time: &[f64], beside: Option<Change>) -> Courses {
    let survey = fitted.network.survey;
    let beside = beside.map(|change| fitted.beside(change));
    let of = |share: &dyn Fn(&Course) -> Vec<f64>| match (clearest(fitted, time, share), &beside) {
        (Course::STEADY, Some((basis, residual))) => {
            clearest(&Fitted { basis, residual, ..*fitted }, time, share)
        }
        (alone, _) => alone,
    };
    let of_station = (0..survey.stations.len())
        .map(|k| of(&|course| of_station(survey, time, k, course)))
        .collect();
    Courses { of_station, of_all: of(&|course| of_all(survey, time, course)) }
}

/// A steady course, unless one that comes to rest takes so much more of the residual away that a
/// steady drift shows it once in a hundred surveys.
fn clearest(fitted: &Fitted<'_>, time: &[f64], share: impl Fn(&Course) -> Vec<f64>) -> Course {
    let steady = share(&Course::STEADY);
    let seen = |r: &usize| steady[*r] != 0.0;
    let times = || (0..time.len()).filter(seen).map(|r| time[r]);
    let span = times().fold(f64::NEG_INFINITY, f64::max) - times().fold(f64::INFINITY, f64::min);
    let Some(by_steady) = explained(fitted, &steady) else { return Course::STEADY };
    if !(span > 0.0 && span.is_finite()) {
        return Course::STEADY;
    }
    let of = |constant: f64| {
        let course = Course::settling(constant);
        Some((explained(fitted, &share(&course))?, constant))
    };
    let tried = SHARES.iter().filter_map(|share| of(share * span));
    let Some(mut best) = tried.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Course::STEADY };
    let chance = |most: f64| {
        let left = fitted.residual.norm_squared() - most;
        let parameters = fitted.basis.ncols() + WIDTH + 1;
        let dof = count(fitted.residual.len().saturating_sub(parameters));
        let f = (most - by_steady) / (left / dof);
        let p_value = FisherSnedecor::new(1.0, dof).map_or(1.0, |law| law.sf(f.max(0.0)));
        p_value * count(Course::settling(1.0).searched)
    };
    // A finer search does not make clear what was not in sight.
    if chance(best.0) > IN_SIGHT {
        return Course::STEADY;
    }
    for step in REFINED {
        for factor in [1.0 / step, step] {
            best = of(best.1 * factor).filter(|moved| moved.0 > best.0).unwrap_or(best);
        }
    }
    let (most, constant) = best;
    if chance(most) <= FALSE_ALARM { Course::settling(constant) } else { Course::STEADY }
}

/// Amplitudes of a stand that moves.
const WIDTH: usize = 3;

/// What a stand that moves so takes of the sum of squares; `None` where it does not show.
fn explained(fitted: &Fitted<'_>, share: &[f64]) -> Option<f64> {
    let column = |(sight, share): (&crate::missing::sights::Sight, &f64)| {
        let slopes = Part::Station.slopes(sight);
        slopes.iter().map(|slope| share * slope / fitted.sigma_mm).collect()
    };
    let columns: Vec<Vec<f64>> = fitted.sights.iter().zip(share).map(column).collect();
    let tangent = fitted.rows(&columns);
    let left = fitted.left_of(tangent);
    let along = left.tr_mul(fitted.residual);
    let solved = left.tr_mul(&left).cholesky()?.solve(&along);
    Some(along.dot(&solved))
}
