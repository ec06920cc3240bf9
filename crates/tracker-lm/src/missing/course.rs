//! How a stand moves with time: steadily, or until it comes to rest.
//!
//! A stand that was carried to where it stands settles: `1 − exp(−t/τ)`, or a part of it soon and the
//! rest later, as feet and floor do. Which of these it is, the residual of the declared model says; the
//! catalogue holds one drift for each station, by the course that shows, so that no station's drift
//! competes with itself.

use std::collections::HashMap;

use crate::count::count;
use crate::missing::looked_through::{LookedThrough, Moving, Seen};

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

/// How far the stand of a station has come at every reading since its first one, before which nobody
/// saw it; zero at the others' readings.
pub(crate) fn of_station(readings: &[Seen], station: usize, course: &Course) -> Vec<f64> {
    let first = first(readings.iter().filter(|seen| seen.station == station));
    let come = |seen: &Seen| {
        if seen.station == station { course.at(seen.time, first) } else { 0.0 }
    };
    readings.iter().map(come).collect()
}

/// Words for a stand that moves so, by its law where it comes to rest.
pub(crate) fn words(name: &str, law: Option<String>) -> String {
    match law {
        None => format!("station {name} moves steadily; its place is given at its first reading"),
        Some(law) => format!(
            "station {name} moves and comes to rest; its place is given at its first reading: {law}"
        ),
    }
}

/// How far the machine has come that moves steadily since the first reading.
pub(crate) fn of_machine(readings: &[Seen]) -> Vec<f64> {
    let first = first(readings.iter());
    readings.iter().map(|seen| seen.time - first).collect()
}

/// How far all stands have come at every reading, from the mean of those of its station on: where a
/// station is in the middle of its readings is the station's own place, and says nothing of how far
/// it moves.
pub(crate) fn of_all(readings: &[Seen], course: &Course) -> Vec<f64> {
    let come = of_readings(readings, course);
    let mut sums: HashMap<usize, (f64, f64)> = HashMap::new();
    for (seen, come) in readings.iter().zip(&come) {
        let (sum, n) = sums.entry(seen.station).or_default();
        *sum += come;
        *n += 1.0;
    }
    let since = |(seen, come): (&Seen, &f64)| {
        let (sum, n) = sums[&seen.station];
        come - sum / n
    };
    readings.iter().zip(&come).map(since).collect()
}

fn first<'s>(readings: impl Iterator<Item = &'s Seen>) -> f64 {
    readings.map(|seen| seen.time).fold(f64::INFINITY, f64::min)
}

/// Share of a motion, squared, from which on that of one station is all of it.
const ALL_OF_IT: f64 = 0.9;

/// Whether one station sees nearly all of a motion: one that has come to rest before the next station
/// is manned is the first one's own.
fn is_of_one(readings: &[Seen], share: &[f64]) -> bool {
    let mut of_station: HashMap<usize, f64> = HashMap::new();
    for (seen, share) in readings.iter().zip(share) {
        *of_station.entry(seen.station).or_default() += share * share;
    }
    let most = of_station.values().copied().fold(0.0, f64::max);
    most > ALL_OF_IT * share.iter().map(|share| share * share).sum::<f64>()
}

/// How far what drifts alike at every reading has come since the first one.
pub(crate) fn of_readings(readings: &[Seen], course: &Course) -> Vec<f64> {
    let first = first(readings.iter());
    readings.iter().map(|seen| course.at(seen.time, first)).collect()
}

/// The course that readings show which drift alike, wherever they are taken.
pub(crate) fn clearest_of_readings(through: &LookedThrough<'_>) -> Course {
    clearest(through, |course| of_readings(through.readings, course))
}

/// The course that the stand of a station shows.
pub(crate) fn clearest_of_station(through: &LookedThrough<'_>, station: usize) -> Course {
    clearest(through, |course| of_station(through.readings, station, course))
}

/// The course that all stands show together.
pub(crate) fn clearest_of_all(through: &LookedThrough<'_>) -> Course {
    clearest(through, |course| {
        let share = of_all(through.readings, course);
        if is_of_one(through.readings, &share) { vec![0.0; share.len()] } else { share }
    })
}

/// A steady course, unless one that comes to rest takes so much more of the residual away that a
/// steady drift shows it once in a hundred surveys.
fn clearest(through: &LookedThrough<'_>, share: impl Fn(&Course) -> Vec<f64>) -> Course {
    let steady = share(&Course::STEADY);
    let moved = || through.readings.iter().zip(&steady).filter(|(_, share)| **share != 0.0);
    let times = || moved().map(|(seen, _)| seen.time);
    let span = times().fold(f64::NEG_INFINITY, f64::max) - times().fold(f64::INFINITY, f64::min);
    let taken = |share: Vec<f64>| through.taken(Moving::Stations, &[share]);
    let Some((by_steady, width)) = taken(steady.clone()) else { return Course::STEADY };
    if !(span > 0.0 && span.is_finite()) {
        return Course::STEADY;
    }
    let of = |course: Course| Some((taken(share(&course))?.0, course));
    let most_of = |tried: &mut dyn Iterator<Item = Course>| {
        tried.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let one = |constant: f64| Course::settling(constant);
    let Some(mut best) = most_of(&mut SHARES.iter().map(|share| one(share * span))) else {
        return Course::STEADY;
    };
    let chance = |(most, course): &(f64, Course), more: usize, before: f64| {
        through.p_value([before, *most], [width, width + more]) * count(course.searched)
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::missing::looked_through::Fit;

    /// A stand that settles soon, and by as much again later: what chance may do is multiplied by how many
    /// courses were looked at, and by no fewer.
    #[test]
    fn a_course_of_two_counts_all_that_were_looked_at() {
        const READINGS: usize = 240;
        let readings: Vec<Seen> = (0..READINGS)
            .map(|i| Seen { station: 0, step: i, time: count(i) / count(READINGS - 1) })
            .collect();
        let noise = |i: usize| 1e-3 * (12.9 * count(i * i + 1)).sin();
        let settled = |time: f64, constant: f64| -(-time / constant).exp_m1();
        let data = DVector::from_fn(READINGS, |i, _| {
            let time = readings[i].time;
            settled(time, 0.05) + settled(time, 0.7) + noise(i)
        });
        let basis = DMatrix::from_element(READINGS, 1, count(READINGS).sqrt().recip());
        let residual = &data - &basis * basis.tr_mul(&data);
        let looked_at = Cell::new(0);
        let values = |_: Moving, share: &[f64]| {
            looked_at.set(looked_at.get() + 1);
            let column = DMatrix::from_column_slice(share.len(), 1, share);
            let whole = column.norm();
            (column, vec![whole])
        };
        let fit = Fit::of_rows(&basis, &residual);
        let through = LookedThrough { readings: &readings, fit: &fit, values: &values };
        let found = clearest_of_station(&through, 0);
        assert!(found.slower.is_some(), "{found:?}");
        assert!(found.searched >= looked_at.get(), "{found:?} {}", looked_at.get());
    }
}
