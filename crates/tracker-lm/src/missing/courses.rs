//! How the stands of a survey of ranges move, and its sessions.

use nalgebra::DMatrix;

use crate::Survey;
use crate::missing::change::Change;
use crate::missing::changes::Fitted;
use crate::missing::course::{Course, clearest_of_all, clearest_of_readings, clearest_of_station};
use crate::missing::looked_through::{LookedThrough, Moving, Seen};
use crate::missing::moves::Part;
use crate::missing::reduction::of_ranges;
use crate::missing::session::{Session, movable, sessions};
use crate::missing::sights::Sight;

/// Of every stand alone, of all alike, and of the scale of the readings; and sessions that no column says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Courses {
    pub(crate) of_station: Vec<Course>,
    pub(crate) of_all: Course,
    /// Of the proportion in which displacements read too long.
    pub(crate) of_scale: Course,
    pub(crate) sessions: Vec<Session>,
}

/// The course that each drift shows, by itself or else beside a change that the residual shows, and
/// the sessions beside these.
pub(crate) fn courses(fitted: &Fitted<'_>, time: &[f64], beside: Option<Change>) -> Courses {
    let survey = fitted.network.survey;
    let readings = seen(survey, time);
    let n = readings.len();
    let values = |width: usize, slopes: &dyn Fn(usize) -> Vec<f64>| {
        of_ranges(n, width, |r| slopes(r).iter().map(|slope| slope / fitted.sigma_mm).collect())
    };
    let moved = |slopes: &DMatrix<f64>, share: &[f64]| {
        let mut columns = slopes.clone();
        for mut column in columns.column_iter_mut() {
            column.iter_mut().zip(share).for_each(|(value, share)| *value *= share);
        }
        let whole = columns.column_iter().map(|c| c.norm()).collect();
        (columns, whole)
    };
    let slopes = |moving: Moving| move |r: usize| part(moving).slopes(&fitted.sights[r]);
    let of_machine = values(6, &slopes(Moving::Machine));
    let of_stations = values(3, &slopes(Moving::Stations));
    let of_scale = values(2, &|r| ways_mm(survey, &fitted.sights[r], r).to_vec());
    let motions = |moving: Moving, share: &[f64]| match moving {
        Moving::Machine => moved(&of_machine, share),
        Moving::Stations => moved(&of_stations, share),
    };
    let scaled = |_: Moving, share: &[f64]| moved(&of_scale, share);
    let fit = fitted.of_ranges(fitted.basis, fitted.residual);
    let through = LookedThrough { readings: &readings, fit: &fit, values: &motions };
    let beside = beside.map(|change| {
        let (basis, residual) = fitted.beside(change);
        fitted.of_ranges(&basis, &residual)
    });
    let by = |values, clearest: &dyn Fn(&LookedThrough<'_>) -> Course| {
        let through = LookedThrough { values, ..through };
        match (clearest(&through), &beside) {
            (Course::STEADY, Some(fit)) => clearest(&LookedThrough { fit, ..through }),
            (alone, _) => alone,
        }
    };
    let of = |clearest: &dyn Fn(&LookedThrough<'_>) -> Course| by(&motions, clearest);
    let stations = 0..survey.stations.len();
    let of_station: Vec<Course> =
        stations.map(|k| of(&|through| clearest_of_station(through, k))).collect();
    let of_all = of(&clearest_of_all);
    let of_scale = by(&scaled, &clearest_of_readings);
    // Of two axes one turns about the place where the other one stands.
    let is_one_axis = survey.second.is_none();
    let movable = movable(survey.stations.len()).filter(|of| of.is_some() || is_one_axis);
    let sessions = sessions(&through, movable, &of_station);
    Courses { of_station, of_all, of_scale, sessions }
}

/// The way of the light that was counted, and that which was not.
pub(crate) fn ways_mm(survey: &Survey, sight: &Sight, range: usize) -> [f64; 2] {
    let counted = survey.ranges[range].displacement_mm;
    [counted, sight.along_mm.norm() - counted]
}

/// The part of a range's geometry that moves.
pub(crate) fn part(moving: Moving) -> Part {
    match moving {
        Moving::Machine => Part::Error,
        Moving::Stations => Part::Station,
    }
}

/// By which station and when every range was read.
pub(crate) fn seen(survey: &Survey, time: &[f64]) -> Vec<Seen> {
    let of = |(range, time): (&crate::Range, &f64)| {
        let (station, step) = (range.station, range.step);
        Seen { station, step, time: *time }
    };
    survey.ranges.iter().zip(time).map(of).collect()
}
