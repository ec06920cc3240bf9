//! Readings from which on a reflector may sit elsewhere, and readings that may be wrong.
//!
//! There are as many of either as readings, and testing all in the loop would cost every other
//! effect its significance. So the catalogue holds, for each reflector, a slip in the middle of
//! the run, and those faults that the residual shows so clearly that chance does it nowhere in a
//! hundred surveys: another session of the machine or of one station, too. Where reflectors are held
//! out, nothing is known of one's slip.

use model_discrepancy::chance_to_explain;
use nalgebra::{DMatrix, DVector, Vector3};

use super::rows::Rows;
use super::sight::Sight;
use super::{HoldOut, TargetSurvey};
use crate::Target;
use crate::count::count;
use crate::missing::course::{Course, clearest_of_station};
use crate::missing::looked_through::{Fit, LookedThrough, Moving, Seen};
use crate::missing::session::{Session, movable, sessions};

/// Chance that a survey without any fault shows one.
const FALSE_ALARM: f64 = 0.01;
/// Faults of a kind that are offered at most, the clearest.
const MOST_FOUND: usize = 6;
/// Slips of a reflector that are tried: more stops than this are tried at even distances.
const MOST_TRIED: usize = 48;

/// What may be wrong, by the reading at which it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The reflector sits elsewhere from this reading on.
    Slip(usize),
    /// This reading alone.
    BadPoint(usize),
    /// The machine against all stations, or one station, from a reading on.
    Session(Session),
}

/// What the residual of the declared model shows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) faults: Vec<Fault>,
    /// How every station moves.
    pub(super) courses: Vec<Course>,
}

/// The declared model at its solution, whitened.
pub(super) struct Fitted<'a> {
    pub(super) survey: &'a TargetSurvey,
    pub(super) sights: &'a [Sight],
    pub(super) rows: &'a Rows,
    /// Orthonormal basis of the base parameters' columns.
    pub(super) basis: &'a DMatrix<f64>,
    /// Residual without what the basis explains.
    pub(super) residual: &'a DVector<f64>,
    pub(super) hold_out: HoldOut,
    /// Of every reading.
    pub(super) time: &'a [f64],
}

impl Fault {
    pub(super) fn reading(self) -> usize {
        match self {
            Self::Slip(reading) | Self::BadPoint(reading) => reading,
            Self::Session(session) => session.first,
        }
    }

    /// What coordinate `c` of it does to a reading; of a session, while it lasts.
    pub(super) fn column(
        self,
        survey: &TargetSurvey,
        sights: &[Sight],
        target: usize,
        c: usize,
    ) -> Vector3<f64> {
        match self {
            Self::Session(session) => by_motion(&sights[target], session.moving(), c),
            Self::Slip(from) => {
                let is_own = survey.targets[target].mount == survey.targets[from].mount;
                sights[target].by_mount.column(c) * f64::from(u8::from(is_own && target >= from))
            }
            Self::BadPoint(reading) if target == reading => sights[target].by_reading(c),
            Self::BadPoint(_) => Vector3::zeros(),
        }
    }
}

/// What a motion of the axis, or of the reading's station, does to a reading.
fn by_motion(sight: &Sight, moving: Moving, c: usize) -> Vector3<f64> {
    match moving {
        Moving::Machine => sight.by_axis_motion(c),
        Moving::Stations => sight.by_station_motion(c),
    }
}

/// By which station and when every reading was taken.
pub(super) fn seen(survey: &TargetSurvey, time: &[f64]) -> Vec<Seen> {
    let of = |(target, time): (&Target, &f64)| {
        let (station, step) = (target.station, target.step);
        Seen { station, step, time: *time }
    };
    survey.targets.iter().zip(time).map(of).collect()
}

/// Coordinates of a motion.
const MOTION: usize = 6;

/// The course of every station, and sessions beside these.
fn motions(fitted: &Fitted<'_>) -> (Vec<Course>, Vec<Session>) {
    let Fitted { survey, sights, basis, residual, .. } = *fitted;
    let values = |moving: Moving, share: &[f64]| {
        let value = |n: usize, c: usize, k: usize| {
            share[n] * if share[n] == 0.0 { 0.0 } else { by_motion(&sights[n], moving, k)[c] }
        };
        let mut tangent = fitted.rows.columns(MOTION, value);
        for (mut row, sigma) in tangent.row_iter_mut().zip(&fitted.rows.sigma_mm) {
            row /= *sigma;
        }
        let column = |k: usize| -> Vec<f64> {
            (0..3 * sights.len()).map(|i| value(i / 3, i % 3, k)).collect()
        };
        let whole = (0..MOTION).map(|k| fitted.rows.whitened_norm(&column(k))).collect();
        (tangent, whole)
    };
    let readings = seen(survey, fitted.time);
    let fit = Fit::of_rows(basis, residual);
    let through = LookedThrough { readings: &readings, fit: &fit, values: &values };
    let stations = 0..survey.stations.len();
    let courses: Vec<Course> = stations.map(|k| clearest_of_station(&through, k)).collect();
    let sessions = sessions(&through, movable(survey.stations.len()), &courses);
    (courses, sessions)
}

/// Faults and courses for the catalogue.
pub(super) fn found(fitted: &Fitted<'_>) -> Found {
    let survey = fitted.survey;
    let readings = |mount: usize| -> Vec<usize> {
        (0..survey.targets.len()).filter(|&n| survey.targets[n].mount == mount).collect()
    };
    let mut found = Vec::new();
    let mut slips = Vec::new();
    let n_slipping = match fitted.hold_out {
        HoldOut::Step => survey.mounts.len(),
        HoldOut::Mount => 0,
    };
    for mount in 0..n_slipping {
        let own = readings(mount);
        if own.len() >= 2 {
            found.push(Fault::Slip(own[own.len() / 2]));
        }
        let stride = own.len().div_ceil(MOST_TRIED).max(1);
        slips.extend(own.into_iter().skip(1).step_by(stride).map(Fault::Slip));
    }
    let points: Vec<Fault> = (0..survey.targets.len()).map(Fault::BadPoint).collect();
    for kind in [slips, points] {
        let trials = count(kind.len());
        let mut clear: Vec<(f64, Fault)> = (kind.into_iter())
            .filter_map(|fault| Some((p_value(fitted, fault)?, fault)))
            .filter(|(p_value, _)| p_value * trials <= FALSE_ALARM)
            .collect();
        clear.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.extend(clear.into_iter().take(MOST_FOUND).map(|(_, fault)| fault));
    }
    let (courses, sessions) = motions(fitted);
    found.extend(sessions.into_iter().map(Fault::Session));
    let mut seen = Vec::new();
    found.retain(|fault| {
        let is_new = !seen.contains(fault);
        seen.push(*fault);
        is_new
    });
    Found { faults: found, courses }
}

/// Of a fault beside the declared model (F test).
fn p_value(fitted: &Fitted<'_>, fault: Fault) -> Option<f64> {
    let value = |target: usize, component: usize, c: usize| {
        fault.column(fitted.survey, fitted.sights, target, c)[component]
    };
    let mut tangent = fitted.rows.columns(3, value);
    for (mut row, sigma) in tangent.row_iter_mut().zip(&fitted.rows.sigma_mm) {
        row /= *sigma;
    }
    let along = fitted.basis.tr_mul(&tangent);
    tangent -= fitted.basis * along;
    let score = tangent.tr_mul(fitted.residual);
    let explained = score.dot(&tangent.tr_mul(&tangent).cholesky()?.solve(&score));
    let dof = tangent.nrows().saturating_sub(fitted.basis.ncols() + 3);
    let left = (fitted.residual.norm_squared() - explained).max(0.0);
    Some(chance_to_explain(explained / left, 3, dof))
}
