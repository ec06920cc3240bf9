//! How the stands of a survey of ranges move, and its sessions.

use crate::Survey;
use crate::missing::change::Change;
use crate::missing::changes::Fitted;
use crate::missing::course::{Course, clearest_of_all, clearest_of_readings, clearest_of_station};
use crate::missing::looked_through::{LookedThrough, Moving, Seen};
use crate::missing::moves::Part;
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
    let whitened = |slopes: &dyn Fn(usize) -> Vec<f64>, share: &[f64]| {
        let column = |(r, share): (usize, &f64)| -> Vec<f64> {
            slopes(r).iter().map(|slope| share * slope / fitted.sigma_mm).collect()
        };
        let columns: Vec<Vec<f64>> = share.iter().enumerate().map(column).collect();
        let width = columns.first().map_or(0, Vec::len);
        let whole = |k: usize| columns.iter().map(|c| c[k] * c[k]).sum::<f64>().sqrt();
        (fitted.rows(&columns), (0..width).map(whole).collect())
    };
    let rows = |moving: Moving, share: &[f64]| {
        whitened(&|r| part(moving).slopes(&fitted.sights[r]), share)
    };
    let scaled = |_: Moving, share: &[f64]| {
        whitened(&|r| ways_mm(survey, &fitted.sights[r], r).to_vec(), share)
    };
    let (basis, residual) = (fitted.basis, fitted.residual);
    let through = LookedThrough { readings: &readings, basis, residual, rows: &rows };
    let beside = beside.map(|change| fitted.beside(change));
    let by = |rows, clearest: &dyn Fn(&LookedThrough<'_>) -> Course| {
        let through = LookedThrough { rows, ..through };
        match (clearest(&through), &beside) {
            (Course::STEADY, Some((basis, residual))) => {
                clearest(&LookedThrough { basis, residual, ..through })
            }
            (alone, _) => alone,
        }
    };
    let of = |clearest: &dyn Fn(&LookedThrough<'_>) -> Course| by(&rows, clearest);
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
