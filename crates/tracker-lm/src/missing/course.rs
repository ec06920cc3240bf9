//! How a stand moves with time: steadily, or until it comes to rest.
//!
//! A stand that was carried to where it stands settles: `1 − exp(−t/τ)`, or a part of it soon and the
//! rest later, as feet and floor do. Which of these it is, the residual of the declared model says; the catalogue holds one drift for each station, by the course
//! that shows, so that no station's drift competes with itself.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::Survey;
use crate::count::count;
use crate::missing::change::Change;
use crate::missing::changes::Fitted;
use crate::missing::moves::Part;
use crate::missing::session::{LookedThrough, Seen, Session, movable, sessions};
use crate::missing::sights::Sight;

/// Chance that a steady drift shows a time constant.
const FALSE_ALARM: f64 = 0.01;
/// The same below which a time constant is refined.
const IN_SIGHT: f64 = 0.2;
/// Time constants that are tried, as shares of the time that a drift is seen.
const SHARES: [f64; 6] = [0.05, 0.1, 0.2, 0.35, 0.6, 1.0];
/// Steps of the time constant once one is found, either way.
const REFINED: [f64; 6] = [1.3, 1.15, 1.07, 1.03, 1.015, 1.007];

/// Time constants of the slower of two courses beyond those, as shares of the same.
const SLOWER: [f64; 2] = [1.5, 2.5];
/// Times by which it is slower, at least: closer ones are one.
const APART: f64 = 2.5;
/// Shares of the whole that it may have, from which the search begins.
const PARTS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Share of the whole that either of two has, at least.
const LEAST: f64 = 0.1;

/// How far a stand has come, per unit of its amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    /// Of a stand that comes to rest, in the unit of time; `None` of one that moves steadily.
    pub(crate) time_constant: Option<f64>,
    /// What comes to rest later.
    slower: Option<Slower>,
    /// How many courses were looked at to find it.
    pub(crate) searched: usize,
}

/// The slower of two courses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slower {
    time_constant: f64,
    /// Of the whole, 0 to 1.
    share: f64,
}

impl Course {
    /// What is taken where nothing else shows.
    pub(crate) const STEADY: Self = Self { time_constant: None, slower: None, searched: 1 };

    fn settling(time_constant: f64) -> Self {
        let time_constant = Some(three_digits(time_constant));
        Self { time_constant, slower: None, searched: 1 + SHARES.len() }
    }

    fn settling_twice(time_constant: f64, slower: f64, share: f64) -> Self {
        let share = three_digits(share.clamp(LEAST, 1.0 - LEAST));
        let slower = Slower { time_constant: three_digits(slower), share };
        let searched = 1 + SHARES.len() * (1 + PARTS.len() * (SHARES.len() + SLOWER.len()));
        Self { slower: Some(slower), searched, ..Self::settling(time_constant) }
    }

    /// Its law, with the unit of its time constants; `None` of one that moves steadily.
    pub(crate) fn law(&self, unit: &str) -> Option<String> {
        let slower = self.slower.map_or_else(String::new, |Slower { time_constant, share }| {
            format!(", and {:.1} % of it with τ = {time_constant} {unit}", 100.0 * share)
        });
        let constant = self.time_constant?;
        Some(format!("1 − exp(−t/τ), τ = {constant} {unit}{slower}"))
    }

    /// At a time of the run, for what was first seen at another.
    fn at(&self, time: f64, first: f64) -> f64 {
        let since = time - first;
        let come = |constant: f64| -(-since / constant).exp_m1();
        let Some(constant) = self.time_constant else { return since };
        let slow = self.slower.map_or(0.0, |s| s.share * (come(s.time_constant) - come(constant)));
        come(constant) + slow
    }
}

/// Rounded as it is printed.
fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Of every stand alone, and of all alike; and sessions that no column says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Courses {
    pub(crate) of_station: Vec<Course>,
    pub(crate) of_all: Course,
    pub(crate) sessions: Vec<Session>,
}

/// How far the stand of a station has come at every range since its first reading, before which nobody
/// saw it; zero at the others' ranges.
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

/// Share of a motion, squared, from which on that of one station is all of it.
const ALL_OF_IT: f64 = 0.9;

/// Whether one station sees nearly all of a motion: one that has come to rest before the next station
/// is manned is the first one's own.
fn is_of_one(survey: &Survey, share: &[f64]) -> bool {
    let mut of_station = vec![0.0; survey.stations.len()];
    for (range, share) in survey.ranges.iter().zip(share) {
        of_station[range.station] += share * share;
    }
    let most = of_station.iter().copied().fold(0.0, f64::max);
    most > ALL_OF_IT * of_station.iter().sum::<f64>()
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
    let of_all = of(&|course| {
        let share = of_all(survey, time, course);
        if is_of_one(survey, &share) { vec![0.0; share.len()] } else { share }
    });
    Courses { of_station, of_all, sessions: sessions_of(fitted, time) }
}

fn sessions_of(fitted: &Fitted<'_>, time: &[f64]) -> Vec<Session> {
    let survey = fitted.network.survey;
    let (basis, residual) = (fitted.basis, fitted.residual);
    let through = LookedThrough { readings: seen(survey, time), basis, residual };
    let rows = |station: Option<usize>, share: &[f64]| {
        let part = moved(station);
        let column = |(sight, share): (&Sight, &f64)| -> Vec<f64> {
            part.slopes(sight).iter().map(|slope| share * slope / fitted.sigma_mm).collect()
        };
        let columns: Vec<Vec<f64>> = fitted.sights.iter().zip(share).map(column).collect();
        let width = columns.first().map_or(0, Vec::len);
        let whole = |k: usize| columns.iter().map(|c| c[k] * c[k]).sum::<f64>().sqrt();
        (fitted.rows(&columns), (0..width).map(whole).collect())
    };
    // Of two axes one turns about the place where the other one stands.
    let is_one_axis = survey.second.is_none();
    let movable = movable(survey.stations.len()).filter(|of| of.is_some() || is_one_axis);
    sessions(&through, movable, &rows)
}

/// What a session moves: the axis against all stations, or one of these.
pub(crate) fn moved(station: Option<usize>) -> Part {
    if station.is_some() { Part::Station } else { Part::Error }
}

/// By which station and when every range was read.
pub(crate) fn seen(survey: &Survey, time: &[f64]) -> Vec<Seen> {
    let of = |(range, time): (&crate::Range, &f64)| {
        let (station, step) = (range.station, range.step);
        Seen { station, step, time: *time }
    };
    survey.ranges.iter().zip(time).map(of).collect()
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
    let of = |course: Course| Some((explained(fitted, &share(&course))?, course));
    let most_of = |tried: &mut dyn Iterator<Item = Course>| {
        tried.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let one = |constant: f64| Course::settling(constant);
    let Some(mut best) = most_of(&mut SHARES.iter().map(|share| one(share * span))) else {
        return Course::STEADY;
    };
    let chance = |(most, course): &(f64, Course), more: usize, before: f64| {
        p_value_of_more(fitted, more, *most, before) * count(course.searched)
    };
    // A finer search does not make clear what was not in sight.
    if chance(&best, 1, by_steady) > IN_SIGHT {
        return Course::STEADY;
    }
    for factor in REFINED.into_iter().flat_map(|step| [1.0 / step, step]) {
        let constant = best.1.time_constant.unwrap_or(span) * factor;
        best = of(one(constant)).filter(|moved| moved.0 > best.0).unwrap_or(best);
    }
    if chance(&best, 1, by_steady) > FALSE_ALARM {
        return Course::STEADY;
    }
    let constants = SHARES.iter().chain(&SLOWER).map(|share| share * span);
    let Some(mut two) = most_of(&mut pairs(&constants.collect::<Vec<_>>())) else { return best.1 };
    for step in REFINED {
        for number in 0..3 {
            for factor in [1.0 / step, step] {
                let moved = two.1.moved(number, factor).and_then(of);
                two = moved.filter(|moved| moved.0 > two.0).unwrap_or(two);
            }
        }
    }
    // A second time constant and a share.
    if chance(&two, 2, best.0) <= FALSE_ALARM { two.1 } else { best.1 }
}

/// Two courses with time constants of these, the slower one's in each share.
fn pairs(constants: &[f64]) -> impl Iterator<Item = Course> {
    let slower = |fast: f64| constants.iter().copied().filter(move |slow| *slow >= APART * fast);
    let both = move |fast: f64| slower(fast).map(move |slow| (fast, slow));
    constants.iter().copied().flat_map(both).flat_map(|(fast, slow)| {
        PARTS.into_iter().map(move |share| Course::settling_twice(fast, slow, share))
    })
}

impl Course {
    /// One of the three numbers of two courses changed by a factor; `None` where they are then one.
    fn moved(&self, number: usize, factor: f64) -> Option<Self> {
        let (fast, slower) = (self.time_constant?, self.slower?);
        let mut numbers = [fast, slower.time_constant, slower.share];
        numbers[number] *= factor;
        let [fast, slow, share] = numbers;
        (slow >= APART * fast).then(|| Self::settling_twice(fast, slow, share))
    }
}

/// That so many further parameters take `most` by chance where `before` was taken without them.
fn p_value_of_more(fitted: &Fitted<'_>, more: usize, most: f64, before: f64) -> f64 {
    let left = fitted.residual.norm_squared() - most;
    let parameters = fitted.basis.ncols() + WIDTH + more;
    let dof = count(fitted.residual.len().saturating_sub(parameters));
    let f = (most - before) / count(more) / (left / dof);
    FisherSnedecor::new(count(more), dof).map_or(1.0, |law| law.sf(f.max(0.0)))
}

/// Amplitudes of a stand that moves.
const WIDTH: usize = 3;

/// What a stand that moves so takes of the sum of squares; `None` where it does not show.
fn explained(fitted: &Fitted<'_>, share: &[f64]) -> Option<f64> {
    let column = |(sight, share): (&Sight, &f64)| {
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
