//! `tracker-lm`: six errors of a rotary axis from laser-tracer displacements.

mod axis_error;
mod estimates;
mod form;
mod measured;
mod of_axis;
mod plan;
mod plan_settings;
mod plausible;
mod ranges;
mod settings;
mod suspects;
mod tables;
mod target_case;
mod targets;

use nalgebra::{Point3, Vector3};
use tracker_lm::{
    AxisLetter, AxisModel, DeadPath, ErrorOrder, Formulation, Gauge, Noise, Options, RotaryAxis,
    Sought,
};

use crate::Error;
use crate::case::{Document, Finite, Folder, LoopSettings, Positive, Problem};
use crate::kind::Kind;
use crate::measured::Reading;
use crate::suspect::{Dimension, Readings, Samples, Set, Typed};
use crate::uncertain::{Std, Uncertain};

pub use axis_error::{AxisErrorEstimate, AxisLocationEstimate};
pub use estimates::{
    AxesRelationEstimate, AxisEstimate, MountEstimate, SecondAxisEstimate, StationEstimate,
    TrackerLmEstimates,
};

use settings::{
    AxisName, DeadPathName, FormulationName, GaugeName, LetterName, MOUNTS, OrderName, RANGES,
    STATIONS, Settings, TARGETS, error,
};
use suspects::DISPLACEMENT;
use tables::PLACE;

pub(crate) const KIND: Kind = Kind {
    name: "tracker-lm",
    summary: "six errors of a rotary axis by multilateration with a laser tracer",
    read,
    mistakes: suspects::mistakes,
    record: None,
    touches: None,
    readings: &[
        of_places(STATIONS, RANGES, "station"),
        of_places(STATIONS, TARGETS, "station"),
        of_places(MOUNTS, RANGES, "mount"),
        read_at_steps(
            RANGES,
            &[(&[DISPLACEMENT], Dimension::Length), (&["angle_deg"], Dimension::Angle)],
        ),
        read_at_steps(TARGETS, &[(&PLACE, Dimension::Length), (&["angle_deg"], Dimension::Angle)]),
    ],
    typed: &[Typed::of(&["axis", "origin_mm"])],
    uncertain: &[
        Uncertain {
            table: RANGES,
            columns: &["displacement_mm"],
            std: Std::Declared("displacement_mm"),
        },
        Uncertain {
            table: STATIONS,
            columns: &["x_mm", "y_mm", "z_mm"],
            std: Std::Declared("station_mm"),
        },
        Uncertain {
            table: TARGETS,
            columns: &["x_mm", "y_mm", "z_mm"],
            std: Std::Polar { range: "range_mm", angle: "angle_rad" },
        },
        Uncertain {
            table: TARGETS,
            columns: &["x_mm", "y_mm", "z_mm"],
            std: Std::Declared("point_mm"),
        },
    ],
    example: &[
        ("case.toml", include_str!("../../templates/tracker-lm/case.toml")),
        ("stations.csv", include_str!("../../templates/tracker-lm/stations.csv")),
        ("mounts.csv", include_str!("../../templates/tracker-lm/mounts.csv")),
        ("ranges.csv", include_str!("../../templates/tracker-lm/ranges.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    if !folder.has(TARGETS) {
        return ranges::read(folder, document, &settings);
    }
    if folder.has(RANGES) {
        let problem = Problem::ExclusiveTables { other: RANGES.to_owned() };
        return Err(Error::case(folder.location(TARGETS), problem));
    }
    targets::read(folder, document, &settings)
}

/// Effects added at most to a perfect axis: a place, six motion errors, and the six steps of any case
/// but one.
const MOST_STEPS_OF_PERFECT_AXIS: u8 = 12;

/// Cosine between an axis and the machine axis of its letter below which the letter is wrong: the
/// table of a nutating head stands at 45°, no axis at 60°.
const LEAST_COSINE: f64 = 0.5;

/// What is wrong where a direction is not about the machine axis of the letter.
fn wrong_letter(
    section: &str,
    letter: AxisLetter,
    along: Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<String> {
    let unit = direction.try_normalize(f64::MIN_POSITIVE)?;
    if unit.dot(&along).abs() >= LEAST_COSINE {
        return None;
    }
    let nearest = unit.iamax();
    let fitting = [AxisLetter::A, AxisLetter::B, AxisLetter::C][nearest].letter();
    let machine_axis = ["x", "y", "z"][nearest];
    Some(format!(
        "`[{section}] letter = \"{}\"` does not fit `[{section}] direction`, which is nearest to \
         {machine_axis}: an axis about {machine_axis} is {fitting} (ISO 841); write `letter = \
         \"{fitting}\"`, or the direction of the axis meant",
        letter.letter()
    ))
}

/// Letter, point and direction that a section declares; the direction may be that of the letter.
fn declared_axis(
    section: &str,
    (name, origin_mm, direction): (LetterName, Point3<f64>, Option<[Finite; 3]>),
    document: &Document,
) -> Result<RotaryAxis, Error> {
    let letter = match name {
        LetterName::A => AxisLetter::A,
        LetterName::B => AxisLetter::B,
        LetterName::C => AxisLetter::C,
    };
    let along = match name {
        LetterName::A => Vector3::x(),
        LetterName::B => Vector3::y(),
        LetterName::C => Vector3::z(),
    };
    let direction = direction.map_or(along, |d| Vector3::from(d.map(|Finite(v)| v)));
    if let Some(message) = wrong_letter(section, letter, along, &direction) {
        return Err(Error::case(document.at_file(), Problem::WrongValue { message }));
    }
    RotaryAxis::new(letter, origin_mm, direction).map_err(|e| error(document.at_file(), e))
}

fn point(of: [Finite; 3]) -> Point3<f64> {
    Point3::from(of.map(|Finite(v)| v))
}

impl Settings {
    /// The declared axis; of one that is to be found, the letter and a first direction.
    fn axis(&self, document: &Document) -> Result<RotaryAxis, Error> {
        let origin_mm = self.axis.origin_mm.map_or_else(Point3::origin, point);
        declared_axis("axis", (self.axis.letter, origin_mm, self.axis.direction), document)
    }

    /// The axis that rides on the other one, where there are two.
    fn second_axis(&self, document: &Document) -> Result<Option<RotaryAxis>, Error> {
        let Some(second) = &self.second_axis else { return Ok(None) };
        if second.letter == self.axis.letter {
            let message =
                "`[second_axis] letter` is that of `[axis]`: two axes of a head have two \
                           letters"
                    .to_owned();
            return Err(Error::case(document.at_file(), Problem::WrongValue { message }));
        }
        let declared = (second.letter, point(second.origin_mm), second.direction);
        declared_axis("second_axis", declared, document).map(Some)
    }

    /// What is to be found of the axis before it is calibrated.
    fn sought(&self) -> Option<Sought> {
        match (self.axis.origin_mm, self.axis.direction) {
            (Some(_), _) => None,
            (None, Some(_)) => Some(Sought::Origin),
            (None, None) => Some(Sought::OriginAndDirection),
        }
    }

    fn axis_model(&self) -> AxisModel {
        match self.model.axis {
            AxisName::Free => AxisModel::Free,
            // No place is declared that it could be off.
            AxisName::Fixed if self.axis.origin_mm.is_none() => AxisModel::Located,
            AxisName::Fixed => AxisModel::Fixed,
        }
    }

    /// Settings of the loop: a perfect axis may be missing its place and six motion errors beside all
    /// that an axis with free errors may.
    fn loop_settings(&self) -> LoopSettings {
        match self.axis_model() {
            AxisModel::Free => self.closure.clone(),
            _ => self.closure.clone().or_at_most(MOST_STEPS_OF_PERFECT_AXIS),
        }
    }

    fn options(&self) -> Options {
        let value = |of: Option<Positive>| of.map(|Positive(value)| value);
        Options {
            formulation: match self.model.formulation {
                FormulationName::Joint => Formulation::Joint,
                FormulationName::FreePoints => Formulation::FreePoints,
            },
            axis: self.axis_model(),
            dead_path: match self.model.dead_path {
                DeadPathName::Lock => DeadPath::Lock,
                DeadPathName::Station => DeadPath::Station,
            },
            gauge: match self.model.gauge {
                GaugeName::Stations => Gauge::Stations,
                GaugeName::Minimal => Gauge::Minimal,
                GaugeName::Inner => Gauge::Inner,
            },
            order: match self.model.order {
                OrderName::Fixed => ErrorOrder::Fixed,
                OrderName::Rotating => ErrorOrder::Rotating,
            },
            noise: Noise {
                displacement_mm: value(self.noise.displacement_mm),
                rigid_mm: value(self.noise.rigid_mm),
                station_mm: value(self.noise.station_mm),
            },
            ..Options::default()
        }
    }

    /// Settings that have no meaning with others, as warnings.
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.noise.displacement_mm.is_none() {
            warnings.push(
                "no `[noise] displacement_mm`: standard uncertainties are estimated from the \
                 residual"
                    .to_owned(),
            );
        }
        if self.noise.rigid_mm.is_some() && matches!(self.model.formulation, FormulationName::Joint)
        {
            warnings.push(
                "`[noise] rigid_mm` is not used: in the joint formulation the reflectors are \
                 rigid"
                    .to_owned(),
            );
        }
        if self.noise.station_mm.is_some() && !matches!(self.model.gauge, GaugeName::Stations) {
            warnings.push(
                "`[noise] station_mm` is not used: the gauge takes nominal positions as without \
                 error"
                    .to_owned(),
            );
        }
        let noise = &self.noise;
        let of_points = [noise.range_mm, noise.angle_rad, noise.point_mm];
        if of_points.iter().any(Option::is_some) {
            warnings.push(
                "`[noise] range_mm`, `angle_rad` and `point_mm` are not used: they belong to \
                 `targets.csv`"
                    .to_owned(),
            );
        }
        warnings
    }

    /// The same where points were measured.
    fn target_warnings(&self) -> Vec<String> {
        let noise = &self.noise;
        let mut warnings = Vec::new();
        let of_points = [noise.range_mm, noise.angle_rad, noise.point_mm];
        if of_points.iter().all(Option::is_none) {
            warnings.push(
                "no `[noise] range_mm` and `angle_rad`, and no `point_mm`: standard uncertainties \
                 are estimated from the residual"
                    .to_owned(),
            );
        }
        if noise.point_mm.is_some() && noise.range_mm.is_some() {
            warnings.push(
                "`[noise] point_mm` is not used: `range_mm` and `angle_rad` say more".to_owned(),
            );
        }
        let of_ranges = [noise.displacement_mm, noise.rigid_mm, noise.station_mm];
        if of_ranges.iter().any(Option::is_some) {
            warnings.push(
                "`[noise] displacement_mm`, `rigid_mm` and `station_mm` are not used: they belong \
                 to `ranges.csv`"
                    .to_owned(),
            );
        }
        warnings
    }
}

/// Places of which each may be wrong, with what was read there.
const fn of_places(file: &'static str, read: &'static str, label: &'static str) -> Readings {
    let samples = Some(Samples { file: read, label, sets: &[] });
    Readings {
        fewest: 1,
        are_places: true,
        samples,
        ..Readings::of(file, &[(&PLACE, Dimension::Length)])
    }
}

/// What stations read of reflectors at every step.
const fn read_at_steps(file: &'static str, sets: &'static [Set]) -> Readings {
    Readings {
        of: &[(STATIONS, "station"), (MOUNTS, "mount")],
        labels: &["mount", "station"],
        orders: &[&["step"], &["station", "step"], &["station", "mount", "step"]],
        ..Readings::of(file, sets)
    }
}
