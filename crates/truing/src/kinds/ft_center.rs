//! `ft-center`: where a polishing head presses, by a six-axis force/torque sensor.

mod displacement_estimates;
mod displacements;
mod gravity;
mod gravity_estimates;
mod presses;
mod suspects;
mod wrench;

use ft_center::{FtCenterError, Handedness, Noise};
use serde::Deserialize;

use crate::Error;
use crate::case::{Document, Finite, Folder, Location, LoopSettings, Positive, Problem};
use crate::kind::Kind;
use crate::measured::Reading;

pub use displacement_estimates::{DisplacementEstimates, DisplacementResidual};
pub use gravity_estimates::{GravityEstimates, LineMiss, WrenchEstimate};
pub use presses::{CenterEstimate, FrameEstimate, FtCenterEstimates, MeanWrench};

pub(crate) const KIND: Kind = Kind {
    name: "ft-center",
    summary: "centre of a polishing head by a six-axis force/torque sensor",
    read,
    mistakes: suspects::mistakes,
    example: &[
        ("case.toml", include_str!("../../templates/ft-center/case.toml")),
        ("presses.csv", include_str!("../../templates/ft-center/presses.csv")),
        ("wrench.csv", include_str!("../../templates/ft-center/wrench.csv")),
    ],
};

const PRESSES: &str = "presses.csv";
const WRENCH: &str = "wrench.csv";
const DISPLACEMENTS: &str = "displacements.csv";
const GRAVITY: &str = "gravity.csv";

/// Settings of the kind; which of them are needed depends on the tables.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    #[serde(rename = "kind")]
    _kind: serde::de::IgnoredAny,
    #[serde(default)]
    contact: ContactSettings,
    #[serde(default)]
    model: ModelSettings,
    #[serde(default)]
    noise: NoiseSettings,
    #[serde(default, rename = "loop")]
    closure: LoopSettings,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ContactSettings {
    z0_mm: Option<Finite>,
    min_fz_n: Option<Positive>,
    spin_hz: Option<Positive>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelSettings {
    handedness: Option<HandednessName>,
    gravity: Option<[Finite; 3]>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseSettings {
    force_n: Option<Positive>,
    moment_nmm: Option<Positive>,
    displacement_mm: Option<Positive>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum HandednessName {
    Same,
    Opposed,
}

impl From<HandednessName> for Handedness {
    fn from(name: HandednessName) -> Self {
        match name {
            HandednessName::Same => Self::Same,
            HandednessName::Opposed => Self::Opposed,
        }
    }
}

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    let has_presses = folder.has(PRESSES) || folder.has(WRENCH);
    let present: Vec<&str> = [
        (has_presses, PRESSES),
        (folder.has(DISPLACEMENTS), DISPLACEMENTS),
        (folder.has(GRAVITY), GRAVITY),
    ]
    .into_iter()
    .filter_map(|(present, file)| present.then_some(file))
    .collect();
    match present.as_slice() {
        [PRESSES] => presses::read(folder, document, settings),
        [DISPLACEMENTS] => displacements::read(folder, document, settings),
        [GRAVITY] => gravity::read(folder, document, settings),
        [first, second, ..] => {
            let problem = Problem::ExclusiveTables { other: (*first).to_owned() };
            Err(Error::case(folder.location(second), problem))
        }
        _ => Err(Error::case(
            folder.location(""),
            Problem::NoTables {
                needs: "`presses.csv` with `wrench.csv`, or `displacements.csv`, or `gravity.csv`",
            },
        )),
    }
}

impl NoiseSettings {
    /// Noise of one reading of the sensor: both standard uncertainties, or none.
    fn of_sensor(
        &self,
        document: &Document,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Noise>, Error> {
        let missing = |key: &str| {
            let purpose = "the other standard uncertainty of the sensor is declared, so this one \
                           must be too";
            let problem = Problem::MissingKey { key: key.to_owned(), purpose };
            Err(Error::case(document.at_file(), problem))
        };
        match (self.force_n, self.moment_nmm) {
            (Some(Positive(force_n)), Some(Positive(moment_nmm))) => {
                Ok(Some(Noise { force_n, moment_nmm }))
            }
            (None, Some(_)) => missing("[noise] force_n"),
            (Some(_), None) => missing("[noise] moment_nmm"),
            (None, None) => {
                warnings.push(
                    "no `[noise] force_n, moment_nmm`: standard uncertainties are estimated from \
                     the data"
                        .to_owned(),
                );
                Ok(None)
            }
        }
    }
}

/// Settings that have no meaning for the tables given, as warnings.
fn unused(settings: &[(&str, bool)], table: &str) -> Vec<String> {
    (settings.iter().filter(|(_, is_set)| *is_set))
        .map(|(key, _)| format!("`{key}` is not used with {table}"))
        .collect()
}

fn error(at: Location, source: FtCenterError) -> Error {
    Error::FtCenter { at: Box::new(at), source: Box::new(source) }
}
