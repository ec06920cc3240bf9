//! Presses with their records.

mod affine;
mod estimates;
mod measured;
mod repeatability;
mod saved;

use std::collections::HashMap;
use std::sync::OnceLock;

use ft_center::{Contact, LocateOptions, OrbitOptions, Press, PressRole, Sample};
use nalgebra::Point2;
use toml::Spanned;

use super::settings::{PRESSES, Settings, WRENCH, unused};
use super::wrench::wrenches;
use crate::Error;
use crate::case::{
    ColumnKinds, Columns, Document, Extras, Finite, Folder, NumberColumn, Positive, Problem, Table,
    group_name, nearest, no_column,
};
use crate::measured::Reading;

pub use affine::AffineEstimate;
pub use estimates::{CenterEstimate, FrameEstimate, FtCenterEstimates, MeanWrench};
pub(super) use measured::PressCase;
pub use repeatability::{Conformity, RepeatabilityEstimate};

const KNOWN: &[&str] = &["press", "machine_x_mm", "machine_y_mm", "use"];
const KNOWN_WRENCH: &[&str] =
    &["press", "time_s", "fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];

const ROLES: &[(&str, PressRole)] =
    &[("frame", PressRole::Frame), ("check", PressRole::Check), ("locate", PressRole::Locate)];

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let contact = contact(document, &settings)?;
    let mut warnings = unused(
        &[
            ("[model] gravity", settings.model.gravity.is_some()),
            ("[noise] displacement_mm", settings.noise.displacement_mm.is_some()),
        ],
        PRESSES,
    );
    let noise = settings.noise.of_sensor(document, &mut warnings)?;

    let saved = saved::saved_frame(folder, document, &settings, &mut warnings)?;

    let table = folder.table(PRESSES, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let names = columns.ids("press")?;
    let x_mm = columns.numbers("machine_x_mm")?;
    let y_mm = columns.numbers("machine_y_mm")?;
    let roles = columns.words("use", ROLES, None)?;
    let closure = &settings.closure;
    let extras = columns.rest(&closure.columns)?;
    warnings.extend(extras.warnings.iter().cloned());

    let samples = folder.table(WRENCH, KNOWN_WRENCH)?;
    let records = Records::read(&samples, &table, &names, &closure.columns)?;
    warnings.extend(records.extras.warnings.iter().cloned());
    let group = closure.group.as_ref();
    let groups = match group {
        Some(group) => Some(groups(group, &table, &samples, &records, document)?),
        None => None,
    };
    let covariates = covariates(extras, &records, &mut warnings);
    let presses = (names.iter().enumerate())
        .map(|(i, name)| Press {
            name: (*name).to_owned(),
            role: roles[i],
            machine_mm: Point2::new(x_mm[i], y_mm[i]),
            record: records.rows[i].iter().map(|row| records.samples[*row]).collect(),
        })
        .collect();
    let lines = (records.rows.iter())
        .map(|rows| rows.iter().map(|row| samples.line(*row)).collect())
        .collect();
    let measured = PressCase {
        presses_file: table.at_file(),
        wrench_file: samples.at_file(),
        lines,
        presses,
        contact,
        orbit: OrbitOptions {
            spin_hz: settings.contact.spin_hz.map(|Positive(spin_hz)| spin_hz),
            ..OrbitOptions::default()
        },
        saved,
        plan: settings.plan.clone(),
        document: document.at_file(),
        tolerance: settings.tolerance,
        options: LocateOptions { noise, handedness: settings.model.handedness.map(Into::into) },
        covariates,
        groups,
        group_noun: group.map_or_else(|| "press".to_owned(), |g| g.get_ref().clone()),
        solved: OnceLock::new(),
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: vec![PRESSES, WRENCH],
    })
}

fn contact(document: &Document, settings: &Settings) -> Result<Contact, Error> {
    let Some(Finite(z0_mm)) = settings.contact.z0_mm else {
        let purpose = "it is the height of the contact plane above the sensor's reference point, \
                       which no wrench can tell";
        let problem = Problem::MissingKey { key: "[contact] z0_mm".to_owned(), purpose };
        return Err(Error::case(document.at_file(), problem));
    };
    let min_fz_n = settings.contact.min_fz_n.map(|Positive(min_fz_n)| min_fz_n);
    Ok(Contact { z0_mm, min_fz_n })
}

/// The samples, and which of them belong to which press.
struct Records {
    samples: Vec<Sample>,
    /// Rows of `wrench.csv`, per press.
    rows: Vec<Vec<usize>>,
    extras: Extras,
}

impl Records {
    fn read(
        samples: &Table,
        presses: &Table,
        names: &[&str],
        kinds: &ColumnKinds,
    ) -> Result<Self, Error> {
        let mut columns = Columns::new(samples, KNOWN_WRENCH);
        let of = columns.texts("press")?;
        let time_s = columns.numbers("time_s")?;
        let wrenches = wrenches(&mut columns)?;
        let extras = columns.rest(kinds)?;
        let index: HashMap<&str, usize> = names.iter().copied().zip(0..).collect();
        let mut rows = vec![Vec::new(); names.len()];
        for (row, press) in of.iter().enumerate() {
            let Some(press) = index.get(press) else {
                let nearest = nearest(press, names.iter().copied()).map(str::to_owned);
                let id = (*press).to_owned();
                let problem = Problem::UnknownId { what: "press", id, table: PRESSES, nearest };
                let column = samples.column("press").unwrap_or_default();
                return Err(Error::case(samples.at_cell(row, column), problem));
            };
            rows[*press].push(row);
        }
        if let Some(press) = rows.iter().position(Vec::is_empty) {
            let id = names[press].to_owned();
            let problem = Problem::UnusedId { what: "press", id, table: WRENCH };
            return Err(Error::case(presses.at_row(press), problem));
        }
        let samples = (time_s.into_iter().zip(wrenches))
            .map(|(time_s, wrench)| Sample { time_s, wrench })
            .collect();
        Ok(Self { samples, rows, extras })
    }
}

/// Columns of `presses.csv`, and the means over each press of those of `wrench.csv`.
fn covariates(extras: Extras, records: &Records, warnings: &mut Vec<String>) -> Vec<NumberColumn> {
    let mut all = extras.covariates;
    for column in &records.extras.covariates {
        if all.iter().any(|c| c.name == column.name) {
            warnings.push(format!(
                "column `{}` of {WRENCH} is left out: {PRESSES} has one of that name",
                column.name
            ));
            continue;
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let mean = |rows: &Vec<usize>| {
            rows.iter().map(|row| column.values[*row]).sum::<f64>() / rows.len() as f64
        };
        let values = records.rows.iter().map(mean).collect();
        all.push(NumberColumn { values, ..column.clone() });
    }
    all
}

/// The group of each press, from a column of either table.
fn groups(
    setting: &Spanned<String>,
    presses: &Table,
    samples: &Table,
    records: &Records,
    document: &Document,
) -> Result<Vec<String>, Error> {
    if let Some(column) = presses.column(setting.get_ref()) {
        return (0..presses.n_rows()).map(|row| group_name(presses, row, column)).collect();
    }
    let Some(column) = samples.column(setting.get_ref()) else {
        return Err(no_column(setting, &[presses, samples], document.at(&setting.span())));
    };
    let group = |rows: &Vec<usize>| {
        let first = group_name(samples, rows[0], column)?;
        for row in rows {
            let second = group_name(samples, *row, column)?;
            if second != first {
                let press = samples.column("press").unwrap_or_default();
                let problem = Problem::SplitGroup {
                    what: "press",
                    id: samples.cell(*row, press).to_owned(),
                    column: setting.get_ref().clone(),
                    first,
                    second,
                };
                return Err(Error::case(samples.at_cell(*row, column), problem));
            }
        }
        Ok(first)
    };
    records.rows.iter().map(group).collect()
}
