//! Angles, stations and reflectors that could be measured next.

use nalgebra::{Point3, Vector3, Vector6};
use tracker_lm::{
    Approach, AxisError, DeadPathEstimate, ErrorOrder, MountEstimate, RotaryAxis, StationPose, Step,
};

use super::plan_settings::TracerPlanSettings;
use super::settings::{MOUNTS, STATIONS};
use super::tables::PLACE;
use crate::case::{Finite, Positive};
use crate::kinds::touching::{Place, PlanSettings, shuffled};
use crate::kinds::{Beside, Cells, Offer, Offered};

/// Places of stations along the diagonal of the region where no spacing is declared.
const ACROSS: f64 = 3.0;
/// Nearest that a tracer stands to a reflector.
const NEAREST_MM: f64 = 100.0;
/// Parts of a degree that angles are typed to.
const DIGITS: f64 = 1e9;
/// Angles nearer than this are one.
const SAME_DEG: f64 = 1e-6;

/// What the survey has and what was found of it, to predict a reading by.
pub(super) struct Surveyed<'c> {
    /// Table of the readings.
    pub(super) table: &'static str,
    pub(super) axis: &'c RotaryAxis,
    pub(super) steps: &'c [Step],
    /// Names of the stations, and where they are.
    pub(super) stations: Vec<(&'c str, Point3<f64>)>,
    pub(super) mounts: &'c [MountEstimate],
    /// Names of the reflectors.
    pub(super) mount_names: Vec<&'c str>,
    pub(super) errors: &'c [AxisError],
    /// Pairs of station and reflector of every reading.
    pub(super) seen: Vec<(usize, usize)>,
    pub(super) sight: Sight<'c>,
    /// From the machine's zero to that of the survey.
    pub(super) away_mm: Vector3<f64>,
    pub(super) has_direction: bool,
    pub(super) order: ErrorOrder,
}

/// What one reading tells.
pub(super) enum Sight<'c> {
    /// A displacement from the beam's zero, with the dead paths found.
    Range(&'c [DeadPathEstimate]),
    /// A point in the frame of the station, with the poses found.
    Point(&'c [StationPose]),
}

/// Angles seen from all stations; stations and reflectors where `[plan]` says where they can be.
pub(super) fn offer(settings: &TracerPlanSettings, of: &Surveyed<'_>) -> Offer {
    let mut offered = Vec::new();
    let ways: &[Option<Approach>] = if of.has_direction {
        &[Some(Approach::Positive), Some(Approach::Negative)]
    } else {
        &[None]
    };
    for angle_deg in settings.angles(of.steps) {
        offered.extend(ways.iter().map(|way| of.angle(angle_deg, *way)));
    }
    offered.extend(settings.stations(of).iter().map(|at| of.station(at)));
    for [x, y, z] in settings.mounts_mm.iter().flatten() {
        offered.push(of.mount(&Point3::new(x.0, y.0, z.0)));
    }
    Offer {
        table: of.table,
        readings: match of.sight {
            Sight::Range(_) => vec!["displacement_mm"],
            Sight::Point(_) => PLACE.to_vec(),
        },
        columns: Vec::new(),
        offered: shuffled(&offered),
        noun: "run",
        is_record: false,
        made: Some(of.steps.len()),
        minutes: settings.minutes_per_measurement.map(|Positive(minutes)| minutes),
        reach: None,
    }
}

/// The number that was typed: the way through radians leaves round-off in the last digits.
fn as_typed(angle_deg: f64) -> f64 {
    (angle_deg * DIGITS).round() / DIGITS
}

impl TracerPlanSettings {
    /// Those declared, or those that there were and the middles between them.
    fn angles(&self, steps: &[Step]) -> Vec<f64> {
        if let Some(angles) = &self.angles_deg {
            return angles.iter().map(|Finite(angle)| *angle).collect();
        }
        let mut all: Vec<f64> = steps.iter().map(|s| s.angle_rad.to_degrees()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() < SAME_DEG);
        let middles: Vec<f64> = all.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        [all, middles].concat()
    }

    /// Places in the declared region, apart from the reflectors; none without a region.
    fn stations(&self, of: &Surveyed<'_>) -> Vec<Point3<f64>> {
        if self.x_mm.is_none() && self.y_mm.is_none() && self.z_mm.is_none() {
            return Vec::new();
        }
        let region = PlanSettings::of_region([self.x_mm, self.y_mm, self.z_mm], self.spacing_mm);
        let there = of.stations.iter().map(|(_, at)| at + of.away_mm);
        let there: Vec<Point3<f64>> = there.collect();
        let targets: Vec<Point3<f64>> = (of.mounts.iter())
            .flat_map(|mount| of.steps.iter().map(move |step| (mount, step.angle_rad)))
            .map(|(mount, angle)| of.target(&mount.position_mm, angle))
            .collect();
        let free = |at: &Point3<f64>| {
            let near = *at - of.away_mm;
            let apart = targets.iter().all(|target| (target - near).norm() > NEAREST_MM);
            apart.then_some(Place { contact_mm: *at, normal: Vector3::z_axis() })
        };
        let places = region.places(&there, ACROSS, free).unwrap_or_default();
        places.iter().map(|place| place.contact_mm).collect()
    }
}

impl Surveyed<'_> {
    /// Where the declared model has a reflector at an angle, with the errors found next to it.
    fn target(&self, mount_mm: &Point3<f64>, angle_rad: f64) -> Point3<f64> {
        let axis = self.axis;
        let arm = axis.rotation(angle_rad) * mount_mm.coords;
        let away = |error: &&AxisError| (error.angle_rad - angle_rad).abs();
        let nearest = self.errors.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let errors: Vector6<f64> = nearest.map_or_else(Vector6::zeros, |e| e.error);
        let [mut shift, mut turn] = [0, 3].map(|first| errors.fixed_rows::<3>(first).into_owned());
        if self.order == ErrorOrder::Rotating {
            [shift, turn] = [shift, turn].map(|v| axis.rotation(angle_rad) * v);
        }
        axis.origin_mm + arm + shift + turn.cross(&arm)
    }

    fn row(&self, station: &str, mount: &str, step: usize) -> Cells {
        let step = &self.steps[step];
        let mut cells = vec![
            ("station", station.to_owned()),
            ("mount", mount.to_owned()),
            ("step", step.name.clone()),
        ];
        cells.extend(self.turned(step.angle_rad.to_degrees(), step.approach));
        cells
    }

    fn turned(&self, angle_deg: f64, way: Option<Approach>) -> Cells {
        let mut cells = vec![("angle_deg", format!("{}", as_typed(angle_deg)))];
        if self.has_direction {
            let word = match way {
                Some(Approach::Positive) => "+1",
                Some(Approach::Negative) => "-1",
                None => "",
            };
            cells.push(("direction", word.to_owned()));
        }
        cells
    }

    /// One more step, seen by every station on every reflector that it saw.
    fn angle(&self, angle_deg: f64, way: Option<Approach>) -> Offered {
        let mut rows = Vec::new();
        for (station, mount) in self.pairs() {
            let target = self.target(&self.mounts[mount].position_mm, angle_deg.to_radians());
            let (name, at) = &self.stations[station];
            let mut cells = vec![
                ("station", (*name).to_owned()),
                ("mount", self.mount_names[mount].to_owned()),
            ];
            cells.extend(match self.sight {
                Sight::Range(found) => {
                    displacement((target - at).norm() - dead_path_mm(found, (station, mount)))
                }
                Sight::Point(poses) => {
                    point(&poses[station].machine_from_station.inverse_transform_point(&target))
                }
            });
            cells.extend(self.turned(angle_deg, way));
            rows.push(cells);
        }
        Offered { names: "step", rows, beside: Vec::new(), told: Vec::new(), touch: None }
    }

    /// Pairs of station and reflector that were measured.
    fn pairs(&self) -> Vec<(usize, usize)> {
        let mut pairs = self.seen.clone();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// One more station, which sees every reflector at every step there was; a tracker's own frame is
    /// taken to lie as the machine's.
    fn station(&self, at: &Point3<f64>) -> Offered {
        let near = at - self.away_mm;
        let rows = self.mount_names.iter().zip(self.mounts).flat_map(|(name, mount)| {
            let target = |step: usize| self.target(&mount.position_mm, self.steps[step].angle_rad);
            let range_mm = move |step: usize| (target(step) - near).norm();
            (0..self.steps.len()).map(move |step| {
                let mut cells = self.row("", name, step);
                cells.retain(|(column, _)| *column != "station");
                cells.extend(match self.sight {
                    Sight::Range(_) => displacement(range_mm(step) - range_mm(0)),
                    Sight::Point(_) => point(&Point3::from(target(step) - near)),
                });
                cells
            })
        });
        Self::placed("station", (STATIONS, at), rows.collect())
    }

    /// One more reflector, seen by every station at every step there was.
    fn mount(&self, at: &Point3<f64>) -> Offered {
        let target = |step: usize| self.target(at, self.steps[step].angle_rad);
        let mut rows = Vec::new();
        for (station, (name, from)) in self.stations.iter().enumerate() {
            let range_mm = |step: usize| (target(step) - from).norm();
            for step in 0..self.steps.len() {
                let mut cells = self.row(name, "", step);
                cells.retain(|(column, _)| *column != "mount");
                cells.extend(match self.sight {
                    Sight::Range(_) => displacement(range_mm(step) - range_mm(0)),
                    Sight::Point(poses) => {
                        let there = poses[station].machine_from_station;
                        point(&there.inverse_transform_point(&target(step)))
                    }
                });
                rows.push(cells);
            }
        }
        Self::placed("mount", (MOUNTS, at), rows)
    }

    fn placed(
        names: &'static str,
        (table, at): (&'static str, &Point3<f64>),
        rows: Vec<Cells>,
    ) -> Offered {
        let place = PLACE.into_iter().zip(at.iter());
        let cells = place.clone().map(|(name, v)| (name, format!("{v:.6}"))).collect();
        let told = place.map(|(name, v)| (name, *v)).collect();
        let beside = vec![Beside { table, rows: vec![cells], are_readings: false }];
        Offered { names, rows, beside, told, touch: None }
    }
}

fn dead_path_mm(found: &[DeadPathEstimate], (station, mount): (usize, usize)) -> f64 {
    let is_it =
        |d: &&DeadPathEstimate| d.station == station && d.mount.is_none_or(|own| own == mount);
    found.iter().find(is_it).map_or(0.0, |d| d.length_mm)
}

fn displacement(mm: f64) -> Cells {
    vec![("displacement_mm", format!("{mm:.7}"))]
}

fn point(at_mm: &Point3<f64>) -> Cells {
    PLACE.into_iter().zip(at_mm.iter()).map(|(name, v)| (name, format!("{v:.7}"))).collect()
}
