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
    /// The axis that rides on the first one and carries the reflectors, of a head with two.
    pub(super) carried: Option<Carried<'c>>,
}

/// The second axis of a head.
pub(super) struct Carried<'c> {
    pub(super) axis: &'c RotaryAxis,
    /// Its angle at every step.
    pub(super) angles_rad: &'c [f64],
    pub(super) errors: &'c [AxisError],
    /// Where each axis stands while the other one turns.
    pub(super) stand_rad: [f64; 2],
}

/// Angles of both axes; of one axis the second is zero.
type Pose = [f64; 2];

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
    let each: Vec<Offered> = (settings.poses(of).into_iter())
        .flat_map(|pose| ways.iter().map(move |way| of.angle(pose, *way)))
        .collect();
    for _ in 0..settings.cycles.unwrap_or(1) {
        offered.extend_from_slice(&each);
    }
    offered.extend(settings.stations(of).iter().map(|at| of.station(at)));
    for [x, y, z] in settings.mounts_mm.iter().flatten() {
        offered.push(of.mount(&Point3::new(x.0, y.0, z.0)));
    }
    let offered = shuffled(&offered);
    let controls = of.controls(&offered);
    Offer {
        table: of.table,
        readings: match of.sight {
            Sight::Range(_) => vec!["displacement_mm"],
            Sight::Point(_) => PLACE.to_vec(),
        },
        columns: Vec::new(),
        offered,
        noun: "run",
        is_record: false,
        is_new_session: false,
        controls,
        undeclared: settings.undeclared(of.carried.is_some()),
        made: Some(of.steps.len()),
        minutes: settings.minutes_per_measurement.map(|Positive(minutes)| minutes),
        reach: None,
    }
}

/// Angles declared, or those that there were and the middles between them, rad.
fn angles(declared: Option<&[Finite]>, measured: impl Iterator<Item = f64>) -> Vec<f64> {
    if let Some(declared) = declared {
        return declared.iter().map(|Finite(angle)| angle.to_radians()).collect();
    }
    let mut all: Vec<f64> = measured.map(f64::to_degrees).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_DEG);
    let middles: Vec<f64> = all.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    [all, middles].concat().into_iter().map(f64::to_radians).collect()
}

/// The number that was typed: the way through radians leaves round-off in the last digits.
fn as_typed(angle_deg: f64) -> f64 {
    (angle_deg * DIGITS).round() / DIGITS
}

impl TracerPlanSettings {
    /// Every angle of the axis; of a head every angle of each axis where the other one stands.
    fn poses(&self, of: &Surveyed<'_>) -> Vec<Pose> {
        let first = angles(self.angles_deg.as_deref(), of.steps.iter().map(|s| s.angle_rad));
        let Some(carried) = &of.carried else {
            return first.into_iter().map(|angle| [angle, 0.0]).collect();
        };
        let [stand, second_stand] = carried.stand_rad;
        let second = angles(self.second_angles_deg.as_deref(), carried.angles_rad.iter().copied());
        let elsewhere =
            second.into_iter().filter(|b| (b - second_stand).to_degrees().abs() >= SAME_DEG);
        let of_first = first.into_iter().map(|angle| [angle, second_stand]);
        of_first.chain(elsewhere.map(|angle| [stand, angle])).collect()
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
            .flat_map(|mount| (0..of.steps.len()).map(move |step| (mount, of.pose(step))))
            .map(|(mount, pose)| of.target(&mount.position_mm, pose))
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
    /// Angles of a step.
    fn pose(&self, step: usize) -> Pose {
        let second = self.carried.as_ref().map_or(0.0, |carried| carried.angles_rad[step]);
        [self.steps[step].angle_rad, second]
    }

    /// Where the declared model has a reflector, with the errors found next to the angle.
    fn target(&self, mount_mm: &Point3<f64>, [first_rad, second_rad]: Pose) -> Point3<f64> {
        let Some(carried) = &self.carried else {
            let arm = self.axis.rotation(first_rad) * mount_mm.coords;
            return self.turned_about(self.axis, self.errors, first_rad, &arm);
        };
        let on_second = carried.axis.rotation(second_rad) * mount_mm.coords;
        let [stand, second_stand] = carried.stand_rad;
        if (second_rad - second_stand).to_degrees().abs() >= SAME_DEG {
            return self.turned_about(carried.axis, carried.errors, second_rad, &on_second);
        }
        let arm = carried.axis.origin_mm - self.axis.origin_mm + on_second;
        let arm = self.axis.rotation(first_rad - stand) * arm;
        self.turned_about(self.axis, self.errors, first_rad, &arm)
    }

    /// The end of an arm from the origin of an axis, with its errors.
    fn turned_about(
        &self,
        axis: &RotaryAxis,
        errors: &[AxisError],
        angle_rad: f64,
        arm: &Vector3<f64>,
    ) -> Point3<f64> {
        let away = |error: &&AxisError| (error.angle_rad - angle_rad).abs();
        let nearest = errors.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let errors: Vector6<f64> = nearest.map_or_else(Vector6::zeros, |e| e.error);
        let [mut shift, mut turn] = [0, 3].map(|first| errors.fixed_rows::<3>(first).into_owned());
        if self.order == ErrorOrder::Rotating {
            [shift, turn] = [shift, turn].map(|v| axis.rotation(angle_rad) * v);
        }
        axis.origin_mm + arm + shift + turn.cross(arm)
    }

    /// Of an axis that came from one side only: its outermost angles from that side again. What comes from
    /// the other side afterwards may as well be another session, of which these would show the shift.
    fn controls(&self, offered: &[Offered]) -> Vec<usize> {
        let way = self.steps.first().and_then(|step| step.approach);
        if !self.has_direction || way.is_none() || self.steps.iter().any(|s| s.approach != way) {
            return Vec::new();
        }
        let by_angle = |a: &&Step, b: &&Step| a.angle_rad.total_cmp(&b.angle_rad);
        let ends = [self.steps.iter().min_by(by_angle), self.steps.iter().max_by(by_angle)];
        let again = |step: &Step| {
            let cells = self.turned([step.angle_rad, 0.0], way);
            offered.iter().position(|offered| {
                offered.names == "step"
                    && cells.iter().all(|cell| offered.common().any(|c| c == cell))
            })
        };
        ends.into_iter().flatten().filter_map(again).collect()
    }

    fn row(&self, station: &str, mount: &str, step: usize) -> Cells {
        let (pose, step) = (self.pose(step), &self.steps[step]);
        let mut cells = vec![
            ("station", station.to_owned()),
            ("mount", mount.to_owned()),
            ("step", step.name.clone()),
        ];
        cells.extend(self.turned(pose, step.approach));
        cells
    }

    fn turned(&self, pose: Pose, way: Option<Approach>) -> Cells {
        let [first, second] = pose.map(|angle| format!("{}", as_typed(angle.to_degrees())));
        let mut cells = vec![("angle_deg", first)];
        if self.carried.is_some() {
            cells.push(("second_angle_deg", second));
        }
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
    fn angle(&self, pose: Pose, way: Option<Approach>) -> Offered {
        let mut rows = Vec::new();
        for (station, mount) in self.pairs() {
            let target = self.target(&self.mounts[mount].position_mm, pose);
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
            cells.extend(self.turned(pose, way));
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
            let target = |step: usize| self.target(&mount.position_mm, self.pose(step));
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
        let target = |step: usize| self.target(at, self.pose(step));
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

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix6, Point3, Vector3, Vector6};
    use tracker_lm::{AxisError, AxisLetter, ErrorOrder, RotaryAxis, Step};

    use super::{Carried, Sight, Surveyed};

    /// C carries B: a reflector is where both rotations, one after the other, take it.
    #[test]
    fn a_head_is_turned_by_both_axes() {
        let [o1, o2] = [Point3::new(400.0, 400.0, 900.0), Point3::new(430.0, 380.0, 650.0)];
        let c = RotaryAxis::new(AxisLetter::C, o1, Vector3::z()).unwrap();
        let b = RotaryAxis::new(AxisLetter::B, o2, Vector3::y()).unwrap();
        let stand_rad = [-0.5, 0.2];
        let error = |angle_rad: f64, first: f64| AxisError {
            angle_rad,
            error: Vector6::new(first, 0.0, 0.0, 0.0, 0.0, 1e-4),
            covariance: Matrix6::zeros(),
        };
        let (of_first, of_second) = ([error(1.0, 0.01)], [error(-0.7, -0.02)]);
        let steps = [Step { name: "1".to_owned(), angle_rad: -0.5, approach: None }];
        let surveyed = Surveyed {
            table: "ranges.csv",
            axis: &c,
            steps: &steps,
            stations: Vec::new(),
            mounts: &[],
            mount_names: Vec::new(),
            errors: &of_first,
            seen: Vec::new(),
            sight: Sight::Range(&[]),
            away_mm: Vector3::zeros(),
            has_direction: false,
            order: ErrorOrder::Fixed,
            carried: Some(Carried { axis: &b, angles_rad: &[0.2], errors: &of_second, stand_rad }),
        };
        let mount = Point3::new(50.0, 10.0, -200.0);
        let about = |arm: Vector3<f64>| Vector3::z().cross(&arm) * 1e-4;
        // C at 1 rad, 1.5 rad from where it stands, B where it stands.
        let turned = |angle: f64, v: Vector3<f64>| {
            let (sin, cos) = angle.sin_cos();
            Vector3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
        };
        let swung = |angle: f64, v: Vector3<f64>| {
            let (sin, cos) = angle.sin_cos();
            Vector3::new(cos * v.x + sin * v.z, v.y, -sin * v.x + cos * v.z)
        };
        let arm = turned(1.5, o2 - o1 + swung(0.2, mount.coords));
        let expected = o1 + arm + Vector3::new(0.01, 0.0, 0.0) + about(arm);
        assert!((surveyed.target(&mount, [1.0, 0.2]) - expected).norm() < 1e-10);
        // B at −0.7 rad, C where it stands.
        let arm = swung(-0.7, mount.coords);
        let expected = o2 + arm + Vector3::new(-0.02, 0.0, 0.0) + about(arm);
        assert!((surveyed.target(&mount, [-0.5, -0.7]) - expected).norm() < 1e-10);
        assert!((surveyed.pose(0)[1] - stand_rad[1]).abs() < 1e-15);
    }
}
