//! Live: wrenches beside a commanded path, and when the contact leaves it.

mod event;
mod row;

use ft_center::{ContactStatus, Monitor, MonitorOptions, Platform};
use geometry::PlanarMap;
use nalgebra::{Point2, Vector2};

use crate::{Case, Error};

pub use event::{PathEvent, PathSummary, What};
pub use row::{RowProblem, StreamRow, StreamTable};

/// What a live monitor is held to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathMonitorOptions {
    /// Distance of the contact from the commanded path at which it counts as left.
    pub tolerance_mm: f64,
    /// Time constant of the low pass of that distance: several turns of the spindle.
    pub filter_s: f64,
}

/// The contact is back once it is this share of the tolerance away, so that noise at the limit is
/// not told again and again.
const BACK: f64 = 0.8;
/// A gap in the stream longer than this starts the low pass afresh.
const MAX_GAP_S: f64 = 0.5;
/// Force under which a head that touched has lifted, over that from which it touches.
const LIFT: f64 = 0.8;
/// Least `|Fz|` of contact where the case names none, as the monitor of the crate has it.
const TOUCH_N: f64 = 5.0;

/// Where the sensor is, as a case of presses has it.
#[derive(Clone, Debug)]
pub(crate) struct LiveFrame {
    pub(crate) machine_from_sensor: PlanarMap,
    pub(crate) z0_mm: f64,
    pub(crate) min_fz_n: Option<f64>,
}

/// Follows the contact of a head beside its commanded path, row by row.
#[derive(Debug)]
pub struct PathMonitor {
    contact: Monitor,
    machine_from_sensor: PlanarMap,
    options: PathMonitorOptions,
    last_s: Option<f64>,
    /// Decayed sums of `Fz²`, and of `Fz²` times the distance.
    weight: f64,
    weighted_mm: Vector2<f64>,
    touching: bool,
    left: bool,
    summary: PathSummary,
}

impl PathMonitor {
    /// A monitor by the frame, contact height and force gate of a case of presses.
    ///
    /// # Errors
    ///
    /// [`Error::NothingToMonitor`] for other cases; as [`solve`](crate::solve) where the frame cannot
    /// be had; [`Error::FtCenter`] for options out of range.
    pub fn new(case: &Case, options: PathMonitorOptions) -> Result<Self, Error> {
        let live = case.measured.live()?.ok_or(Error::NothingToMonitor { kind: case.kind })?;
        let touch_fz_n = live.min_fz_n.unwrap_or(TOUCH_N);
        let of_contact = MonitorOptions {
            touch_fz_n,
            lift_fz_n: LIFT * touch_fz_n,
            filter_s: options.filter_s,
            max_gap_s: MAX_GAP_S,
        };
        let contact =
            Monitor::new(Platform::Plane { z0_mm: live.z0_mm }, of_contact).map_err(|source| {
                Error::FtCenter {
                    at: Box::new(crate::Location::file(&case.path)),
                    source: Box::new(source),
                }
            })?;
        Ok(Self {
            contact,
            machine_from_sensor: live.machine_from_sensor,
            options,
            last_s: None,
            weight: 0.0,
            weighted_mm: Vector2::zeros(),
            touching: false,
            left: false,
            summary: PathSummary::default(),
        })
    }

    /// Takes one row; what has changed with it, if anything.
    pub fn update(&mut self, row: &StreamRow) -> Option<PathEvent> {
        self.summary.rows += 1;
        let reading = self.contact.update(&row.sample);
        let time_s = row.sample.time_s;
        let place = reading.point_mm.map(|point| self.machine_from_sensor.apply(&point.xy()));
        let event = |what| Some(PathEvent { time_s, what, offset_mm: None });
        match reading.status {
            ContactStatus::InvalidSample => {
                self.summary.invalid += 1;
                return event(What::Invalid);
            }
            ContactStatus::NoContact => return None,
            ContactStatus::ContactLost => {
                (self.touching, self.left) = (false, false);
                return event(What::Lifted);
            }
            ContactStatus::OffWorkpiece | ContactStatus::Contact => {}
        }
        let offset_mm = self.offset(row, place?, reading.contact_time_s)?;
        if !self.touching {
            self.touching = true;
            self.summary.touches += 1;
            return Some(PathEvent {
                time_s,
                what: What::Touched,
                offset_mm: Some(offset_mm.into()),
            });
        }
        // Until the low pass has settled the distance is that of a few samples of an orbit.
        if reading.contact_time_s < self.options.filter_s {
            return None;
        }
        let distance_mm = offset_mm.norm();
        self.summary.farthest_mm = self.summary.farthest_mm.max(distance_mm);
        let limit_mm = self.options.tolerance_mm * if self.left { BACK } else { 1.0 };
        let is_out = distance_mm > limit_mm;
        if is_out == self.left {
            return None;
        }
        self.left = is_out;
        self.summary.departures += usize::from(is_out);
        let what = if is_out { What::Left } else { What::Back };
        Some(PathEvent { time_s, what, offset_mm: Some(offset_mm.into()) })
    }

    /// What there was.
    #[must_use]
    pub fn summary(&self) -> &PathSummary {
        &self.summary
    }

    /// Low pass of contact − commanded position, machine frame. The path is taken off before, so
    /// that the lag of the filter is none of the distance.
    fn offset(
        &mut self,
        row: &StreamRow,
        place_mm: Point2<f64>,
        contact_time_s: f64,
    ) -> Option<Vector2<f64>> {
        let time_s = row.sample.time_s;
        let step_s = self.last_s.map_or(f64::INFINITY, |last| time_s - last);
        self.last_s = Some(time_s);
        // The first sample after the head touched, or after a gap.
        let fresh = contact_time_s <= 0.0 || step_s > MAX_GAP_S;
        let keep = if fresh { 0.0 } else { (-step_s / self.options.filter_s).exp() };
        let weight = row.sample.wrench.force_n.z.powi(2);
        self.weight = keep * self.weight + weight;
        let off = place_mm - row.commanded_mm;
        self.weighted_mm = self.weighted_mm * keep + off * weight;
        (self.weight > 0.0).then(|| self.weighted_mm / self.weight)
    }
}
