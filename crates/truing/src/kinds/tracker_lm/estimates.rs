use model_discrepancy::Step;
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;
use tracker_lm::{
    AxesRelation, AxisError, AxisLetter, AxisLocation, Calibration, ErrorOrder, Mount, PointError,
    RotaryAxis, SecondCalibration, StationPose, Survey, TargetCalibration, TargetSurvey,
    fixed_frame_error, point_errors, point_errors_csv,
};
use truing_report::{ExtraPlot, Form};

use super::axis_error::{AxisErrorEstimate, AxisLocationEstimate};
use super::form::{AxisOfForm, axis_form};
use super::of_axis::{OfAxis, file, plots_of};
use super::plausible::MAX_ROTATION_DEG;
use crate::estimated::{Estimated, Export};
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::TextTable;

/// What a `tracker-lm` case is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackerLmEstimates {
    /// In the order of the table.
    pub stations: Vec<StationEstimate>,
    /// In the order of the table.
    pub mounts: Vec<MountEstimate>,
    /// Target points measured.
    pub points: usize,
    /// The axis that the errors are against: as declared, or found where nothing was declared.
    pub axis: AxisEstimate,
    /// One per angle, in the order in which the angles were first measured.
    pub axis_errors: Vec<AxisErrorEstimate>,
    /// Errors of an axis that is declared perfect about where it was found, as far as effects were
    /// accepted (ISO 230-7); `None` of an axis with six errors at every angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis_motion: Option<Vec<AxisErrorEstimate>>,
    /// Location of the axis; `None` where the angles do not show it, or where it is as declared.
    pub axis_location: Option<AxisLocationEstimate>,
    /// The second axis of a head with two, which rides on the first one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_axis: Option<SecondAxisEstimate>,
    /// How the two axes of a head lie to each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes_relation: Option<AxesRelationEstimate>,
    /// Difference of `[e_x, e_y, e_z, e_a, e_b, e_c]` between coming with rising and with falling
    /// angles, mm and rad, where the loop found one.
    pub reversal: Option<[f64; 6]>,
    #[serde(skip)]
    letter: AxisLetter,
    #[serde(skip)]
    errors: Vec<AxisError>,
    /// Frame of the errors.
    #[serde(skip)]
    order: ErrorOrder,
}

/// The second of two axes, where the first one stands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SecondAxisEstimate {
    /// The axis that its errors are against, as declared.
    pub axis: AxisEstimate,
    /// One per angle, relative to where it stands while the first one turns.
    pub axis_errors: Vec<AxisErrorEstimate>,
    /// Its location; `None` where the angles do not show it.
    pub axis_location: Option<AxisLocationEstimate>,
    #[serde(skip)]
    letter: AxisLetter,
    #[serde(skip)]
    errors: Vec<AxisError>,
}

/// How the second axis lies to the first one, without the uncertainty of the machine's frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxesRelationEstimate {
    /// Across both axes, machine frame.
    pub direction: [f64; 3],
    /// From the first axis to the second one along it, as declared.
    pub nominal_offset_mm: f64,
    /// What the offset is beyond that.
    pub offset_error_mm: f64,
    /// Standard uncertainty of the offset.
    pub std_offset_mm: f64,
    /// Angle between the axes as declared.
    pub nominal_angle_deg: f64,
    /// Rotation of the second axis about `direction` against the first one, beyond what is declared: of
    /// axes at right angles their squareness.
    pub rotation_error_rad: f64,
    /// Its standard uncertainty.
    pub std_rotation_rad: f64,
}

impl From<&AxesRelation> for AxesRelationEstimate {
    fn from(relation: &AxesRelation) -> Self {
        let std = relation.covariance.diagonal().map(|v| v.max(0.0).sqrt());
        Self {
            direction: relation.direction.into_inner().into(),
            nominal_offset_mm: relation.nominal_offset_mm,
            offset_error_mm: relation.offset_error_mm,
            std_offset_mm: std[0],
            nominal_angle_deg: relation.nominal_angle_rad.to_degrees(),
            rotation_error_rad: relation.rotation_error_rad,
            std_rotation_rad: std[1],
        }
    }
}

/// A rotary axis, machine frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisEstimate {
    /// Its letter, ISO 841.
    pub letter: char,
    /// A point on it.
    pub origin_mm: [f64; 3],
    /// Its direction; angles count right-handed about it.
    pub direction: [f64; 3],
}

impl AxisEstimate {
    /// The axis itself; `None` only of a direction without length, which no answer has.
    fn rotary(&self, letter: AxisLetter) -> Option<RotaryAxis> {
        RotaryAxis::new(letter, self.origin_mm.into(), self.direction.into()).ok()
    }
}

impl From<&RotaryAxis> for AxisEstimate {
    fn from(axis: &RotaryAxis) -> Self {
        Self {
            letter: axis.letter.letter(),
            origin_mm: axis.origin_mm.into(),
            direction: axis.direction.into_inner().into(),
        }
    }
}

/// A station, machine frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StationEstimate {
    /// Name.
    pub station: String,
    /// Position.
    pub x_mm: f64,
    /// Its y coordinate.
    pub y_mm: f64,
    /// Its z coordinate.
    pub z_mm: f64,
    /// Rows of the rotation matrix, machine frame from the station's own, of a tracker that measures
    /// points; ranges do not say how a station is turned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Standard uncertainty of a coordinate, root mean square over the three.
    pub std_mm: f64,
    /// Standard uncertainties of x, y and z.
    pub std_xyz_mm: [f64; 3],
}

/// A reflector, in the frame that turns with the axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MountEstimate {
    /// Name.
    pub mount: String,
    /// Position.
    pub x_mm: f64,
    /// Its y coordinate.
    pub y_mm: f64,
    /// Its z coordinate.
    pub z_mm: f64,
    /// Standard uncertainty of a coordinate, root mean square over the three.
    pub std_mm: f64,
    /// Standard uncertainties of x, y and z.
    pub std_xyz_mm: [f64; 3],
}

/// A name with its place and the place's covariance.
type Placed<'a> = (&'a String, Point3<f64>, Matrix3<f64>);

/// What a calibration from ranges and one from points have in common.
struct Parts<'a> {
    axis: &'a RotaryAxis,
    stations: Vec<Placed<'a>>,
    /// Of every station, machine frame from its own; empty where ranges were measured.
    rotations: Vec<Matrix3<f64>>,
    mounts: Vec<Placed<'a>>,
    points: usize,
    errors: &'a [AxisError],
    motion: Option<&'a [AxisError]>,
    location: Option<&'a AxisLocation>,
    second: Option<(&'a RotaryAxis, &'a SecondCalibration)>,
    reversal: Option<[f64; 6]>,
}

fn mounts<'a>(named: &'a [Mount], found: &[tracker_lm::MountEstimate]) -> Vec<Placed<'a>> {
    let pairs = named.iter().zip(found);
    pairs.map(|(mount, at)| (&mount.name, at.position_mm, at.covariance_mm2)).collect()
}

impl TrackerLmEstimates {
    pub(crate) fn of(survey: &Survey, found: &Calibration, reversal: Option<[f64; 6]>) -> Self {
        let named = survey.stations.iter().zip(&found.stations);
        Self::from_parts(&Parts {
            axis: &survey.axis,
            stations: named.map(|(s, at)| (&s.name, at.position_mm, at.covariance_mm2)).collect(),
            rotations: Vec::new(),
            mounts: mounts(&survey.mounts, &found.mounts),
            points: found.n_points,
            errors: &found.axis_errors,
            motion: found.motion.as_deref(),
            location: found.location.as_ref(),
            second: survey.second.as_ref().map(|s| &s.axis).zip(found.second.as_ref()),
            reversal,
        })
    }

    pub(crate) fn of_targets(
        survey: &TargetSurvey,
        found: &TargetCalibration,
        reversal: Option<[f64; 6]>,
    ) -> Self {
        let named = survey.stations.iter().zip(&found.stations);
        let at = |pose: &StationPose| Point3::from(pose.machine_from_station.translation.vector);
        let turned = |pose: &StationPose| {
            pose.machine_from_station.rotation.to_rotation_matrix().into_inner()
        };
        let stations = named.map(|(s, pose)| (&s.name, at(pose), pose.covariance_mm2)).collect();
        Self::from_parts(&Parts {
            axis: &survey.axis,
            stations,
            rotations: found.stations.iter().map(turned).collect(),
            mounts: mounts(&survey.mounts, &found.mounts),
            points: found.n_points,
            errors: &found.axis_errors,
            motion: found.motion.as_deref(),
            location: found.location.as_ref(),
            second: None,
            reversal,
        })
    }

    /// With stations and axis counted from a zero so far away.
    pub(crate) fn moved(mut self, away_mm: Vector3<f64>) -> Self {
        let second = self.second_axis.iter_mut().map(|second| &mut second.axis);
        for axis in std::iter::once(&mut self.axis).chain(second) {
            for (at, away) in axis.origin_mm.iter_mut().zip(away_mm.iter()) {
                *at += away;
            }
        }
        for station in &mut self.stations {
            station.x_mm += away_mm.x;
            station.y_mm += away_mm.y;
            station.z_mm += away_mm.z;
        }
        self
    }

    fn from_parts(parts: &Parts<'_>) -> Self {
        let letter = parts.axis.letter;
        let location = |letter: AxisLetter, location: &AxisLocation| AxisLocationEstimate {
            names: letter.location_names(),
            values: location.errors.into(),
            std: location.covariance.diagonal().map(|v| v.max(0.0).sqrt()).into(),
        };
        let second_axis = parts.second.map(|(axis, found)| SecondAxisEstimate {
            axis: axis.into(),
            axis_errors: found.axis_errors.iter().map(AxisErrorEstimate::of).collect(),
            axis_location: found.location.as_ref().map(|l| location(axis.letter, l)),
            letter: axis.letter,
            errors: found.axis_errors.clone(),
        });
        let relation = parts.second.and_then(|(_, found)| found.relation.as_ref());
        let std_mm = |spread: &Matrix3<f64>| (spread.trace() / 3.0).max(0.0).sqrt();
        let rows = |turned: &Matrix3<f64>| {
            std::array::from_fn(|i| std::array::from_fn(|j| turned[(i, j)]))
        };
        let all = parts.stations.iter().enumerate();
        let stations = all.map(|(i, (name, at, spread))| StationEstimate {
            rotation: parts.rotations.get(i).map(rows),
            station: (*name).clone(),
            x_mm: at.x,
            y_mm: at.y,
            z_mm: at.z,
            std_mm: std_mm(spread),
            std_xyz_mm: spread.diagonal().map(|v| v.max(0.0).sqrt()).into(),
        });
        let mounts = parts.mounts.iter().map(|(name, at, spread)| MountEstimate {
            mount: (*name).clone(),
            x_mm: at.x,
            y_mm: at.y,
            z_mm: at.z,
            std_mm: std_mm(spread),
            std_xyz_mm: spread.diagonal().map(|v| v.max(0.0).sqrt()).into(),
        });
        Self {
            stations: stations.collect(),
            mounts: mounts.collect(),
            points: parts.points,
            axis: parts.axis.into(),
            axis_errors: parts.errors.iter().map(AxisErrorEstimate::of).collect(),
            axis_motion: parts.motion.map(|m| m.iter().map(AxisErrorEstimate::of).collect()),
            axis_location: parts.location.map(|l| location(letter, l)),
            second_axis,
            axes_relation: relation.map(AxesRelationEstimate::from),
            reversal: parts.reversal,
            letter,
            errors: parts.errors.to_vec(),
            order: ErrorOrder::Fixed,
        }
    }

    /// With errors of another frame than the fixed one.
    pub(crate) fn in_order(self, order: ErrorOrder) -> Self {
        Self { order, ..self }
    }

    /// The axes: one, or the two of a head.
    fn axes(&self) -> Vec<OfAxis<'_>> {
        let first = OfAxis {
            letter: self.letter,
            direction: self.axis.direction,
            errors: &self.axis_errors,
            location: self.axis_location.as_ref(),
        };
        let second = self.second_axis.as_ref().map(|second| OfAxis {
            letter: second.letter,
            direction: second.axis.direction,
            errors: &second.axis_errors,
            location: second.axis_location.as_ref(),
        });
        std::iter::once(first).chain(second).collect()
    }

    /// What the errors of the first axis do to a point; of a head the point turns with the second one,
    /// which then stands where its errors are counted from.
    fn point_errors(&self, point_mm: Vector3<f64>) -> Option<String> {
        let axis = self.axis.rotary(self.letter)?;
        let of = match &self.second_axis {
            None => point_errors(&axis, self.order, &self.errors, &point_mm),
            Some(second) => {
                let carried = second.axis.rotary(second.letter)?;
                let [first_rad, second_rad] = [stand(&self.errors)?, stand(&second.errors)?];
                let arm =
                    carried.origin_mm - axis.origin_mm + carried.rotation(second_rad) * point_mm;
                let one = |error: &AxisError| {
                    let fixed = fixed_frame_error(&axis, self.order, error);
                    PointError::of(&fixed, axis.rotation(error.angle_rad - first_rad) * arm)
                };
                self.errors.iter().map(one).collect()
            }
        };
        Some(point_errors_csv(self.letter, &of))
    }

    /// What the errors are relative to.
    fn reference(&self) -> &'static str {
        match self.second_axis {
            None => "relative to the first angle",
            Some(_) => "relative to where it stands while the other axis turns",
        }
    }
}

/// Angle from which errors are counted: that at which they are zero without uncertainty.
pub(super) fn stand(errors: &[AxisError]) -> Option<f64> {
    errors.iter().find(|e| e.error.amax() == 0.0 && e.covariance.amax() == 0.0).map(|e| e.angle_rad)
}

impl AxesRelationEstimate {
    /// Offset and rotation for people.
    fn parameters(&self, [first, second]: [char; 2]) -> [Estimated; 2] {
        let direction = Vector3::from(self.direction);
        let along = ["x", "y", "z"][direction.iamax()];
        let offset = format!("offset of {second} from {first} along {along}, beyond nominal");
        let is_square = (self.nominal_angle_deg - 90.0).abs() < SQUARE_DEG;
        let what = if is_square { "squareness" } else { "rotation" };
        let rotation = format!("{what} of {second} to {first} about {along}");
        [
            Estimated::new(&offset, "mm", self.offset_error_mm, Some(self.std_offset_mm)),
            Estimated::new(
                &rotation,
                "µrad",
                1e6 * self.rotation_error_rad,
                Some(1e6 * self.std_rotation_rad),
            ),
        ]
    }
}

/// Axes whose nominal angle is nearer to a right one are square to each other.
const SQUARE_DEG: f64 = 1.0;

impl Estimates for TrackerLmEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let mut all = Vec::new();
        for location in self.axes().iter().filter_map(|axis| axis.location) {
            for (i, name) in location.names.iter().enumerate() {
                let (unit, factor) = if i < 2 { ("mm", 1.0) } else { ("µrad", 1e6) };
                let (value, std) = (factor * location.values[i], factor * location.std[i]);
                all.push(Estimated::new(name, unit, value, Some(std)));
            }
        }
        if let (Some(relation), Some(second)) = (&self.axes_relation, &self.second_axis) {
            all.extend(relation.parameters([self.letter, second.letter].map(AxisLetter::letter)));
        }
        for s in &self.stations {
            let places = [("x", s.x_mm), ("y", s.y_mm), ("z", s.z_mm)];
            for ((axis, value), std) in places.into_iter().zip(s.std_xyz_mm) {
                let name = format!("station {} {axis}", s.station);
                all.push(Estimated::new(&name, "mm", value, Some(std)));
            }
        }
        all
    }

    fn tables(&self) -> Vec<TextTable> {
        self.axes().iter().map(|axis| axis.table(self.reference())).collect()
    }

    /// The six curves of every axis with their 95 % bands.
    fn plots(&self) -> Vec<ExtraPlot> {
        let reference = match self.second_axis {
            None => "Relative to the first angle measured; bands are 95 % intervals.",
            Some(_) => {
                "Relative to where the axis stands while the other one turns; bands are 95 % \
                 intervals."
            }
        };
        let all =
            self.axes().into_iter().map(|axis| (axis.letter, axis.errors, "errors", reference));
        let motion = self.axis_motion.as_ref().map(|motion| {
            let caption =
                "About the axis where it was found, as far as they were named (ISO 230-7); bands \
                 are 95 % intervals.";
            (self.letter, &motion[..], "motion errors", caption)
        });
        let curves: Vec<_> = match motion {
            Some(motion) => vec![motion],
            None => all.collect(),
        };
        curves.into_iter().flat_map(plots_of).collect()
    }

    fn form(&self) -> Option<Form> {
        // Where there is one, of one axis.
        let motion = self.axis_motion.as_deref();
        let axes: Vec<AxisOfForm<'_>> = (self.axes().into_iter())
            .map(|axis| AxisOfForm {
                letter: axis.letter,
                errors: motion.unwrap_or(axis.errors),
                is_motion: motion.is_some(),
                location: axis.location,
            })
            .collect();
        Some(axis_form(&axes, self.stations.len(), self.points))
    }

    /// Gives the place of the axis among the steps the uncertainty that it has in the machine's frame,
    /// of which the readings know nothing.
    fn widen(&self, steps: &mut [Step]) {
        let Some(location) = &self.axis_location else { return };
        let steps = steps.iter_mut().filter(|s| s.effect == "axis-location");
        for parameter in steps.flat_map(|s| &mut s.parameters) {
            let Some(c) = location.names.iter().position(|name| *name == parameter.name) else {
                continue;
            };
            let factor = if c < 2 { 1e3 } else { 1e6 };
            parameter.std = parameter.std.max(factor * location.std[c]);
        }
    }

    fn export(&self, format: Export) -> Option<String> {
        if let Export::PointErrors(point_mm) = format {
            return self.point_errors(point_mm.into());
        }
        Some(file(self.letter, &self.errors, self.reversal, format))
    }

    fn export_of_second(&self, format: Export) -> Option<(char, String)> {
        let second = self.second_axis.as_ref()?;
        if let Export::PointErrors(point_mm) = format {
            let axis = second.axis.rotary(second.letter)?;
            let of = point_errors(&axis, self.order, &second.errors, &point_mm.into());
            return Some((second.letter.letter(), point_errors_csv(second.letter, &of)));
        }
        let content = file(second.letter, &second.errors, None, format);
        Some((second.letter.letter(), content))
    }

    fn implausible(&self, max_correction_deg: Option<f64>) -> Option<ImplausibleResult> {
        let limit_deg = max_correction_deg.unwrap_or(MAX_ROTATION_DEG);
        self.axes().iter().find_map(|axis| axis.implausible(limit_deg))
    }
}
