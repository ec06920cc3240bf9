//! `ft-center`: where a polishing head presses, by a six-axis force/torque sensor.

mod copied_records;
mod displacement_estimates;
mod displacements;
mod gravity;
mod gravity_estimates;
mod plan;
mod plan_settings;
mod presses;
mod settings;
mod suspects;
mod wrench;

use ft_center::Noise;

use crate::Error;
use crate::case::{Document, Folder, Positive, Problem};
use crate::kind::Kind;
use crate::kinds::orientation::QUATERNION;
use crate::kinds::positioning::{AXIS, has_targets, read_targets};
use crate::measured::Reading;
use crate::suspect::{Dimension, Readings, Samples, Typed};
use crate::uncertain::{Std, Uncertain};

pub use displacement_estimates::{DisplacementEstimates, DisplacementResidual};
pub use gravity_estimates::{GravityEstimates, LineMiss, WrenchEstimate};
pub use presses::{
    AffineEstimate, CenterEstimate, Conformity, FrameEstimate, FtCenterEstimates, MeanWrench,
    RepeatabilityEstimate,
};

use settings::{DISPLACEMENTS, GRAVITY, NoiseSettings, PRESSES, Settings, WRENCH};
use suspects::{FORCES, MACHINE, MOMENTS};

pub(crate) const KIND: Kind = Kind {
    name: "ft-center",
    summary: "centre of a polishing head by a six-axis force/torque sensor",
    read,
    mistakes: suspects::mistakes,
    record: Some((WRENCH, "press")),
    touches: None,
    readings: &[
        Readings::of(DISPLACEMENTS, AXIS),
        Readings::of(
            GRAVITY,
            &[
                (&FORCES, Dimension::Force),
                (&MOMENTS, Dimension::Moment),
                (&QUATERNION, Dimension::Direction),
            ],
        ),
        Readings {
            fewest: 1,
            fitted: "frame",
            samples: Some(Samples {
                file: WRENCH,
                label: "press",
                sets: &[(&FORCES, Dimension::Force), (&MOMENTS, Dimension::Moment)],
            }),
            ..Readings::of(PRESSES, &[(&MACHINE, Dimension::Length)])
        },
    ],
    typed: &[Typed::of(&["contact", "z0_mm"])],
    uncertain: &[
        Uncertain {
            table: WRENCH,
            columns: &["fx_n", "fy_n", "fz_n"],
            std: Std::Declared("force_n"),
        },
        Uncertain {
            table: WRENCH,
            columns: &["mx_nmm", "my_nmm", "mz_nmm"],
            std: Std::Declared("moment_nmm"),
        },
        Uncertain {
            table: GRAVITY,
            columns: &["fx_n", "fy_n", "fz_n"],
            std: Std::Declared("force_n"),
        },
        Uncertain {
            table: GRAVITY,
            columns: &["mx_nmm", "my_nmm", "mz_nmm"],
            std: Std::Declared("moment_nmm"),
        },
    ],
    example: &[
        ("case.toml", include_str!("../../templates/ft-center/case.toml")),
        ("presses.csv", include_str!("../../templates/ft-center/presses.csv")),
        ("wrench.csv", include_str!("../../templates/ft-center/wrench.csv")),
    ],
};

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    if folder.has(DISPLACEMENTS) && has_targets(&folder.table(DISPLACEMENTS, &[])?) {
        return read_targets(DISPLACEMENTS, folder, document);
    }
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
                workbook: folder.workbooks().into_iter().next(),
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
