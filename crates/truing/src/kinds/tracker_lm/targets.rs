//! The tables of a survey of points.

use nalgebra::Point3;
use tracker_lm::{
    AxisModel, HoldOut, Target, TargetNoise, TargetOptions, TargetRecords, TargetSurvey,
};

use super::measured::recorded;
use super::settings::{MOUNTS, STATIONS, Settings, TARGETS};
use super::tables::{PLACE, References, Setup};
use super::target_case::TargetCase;
use crate::Error;
use crate::case::{Columns, Document, Folder, Problem, group_names};
use crate::measured::Reading;

const NEEDED: &[&str] = &["station", "mount", "step", "angle_deg", PLACE[0], PLACE[1], PLACE[2]];
const KNOWN: &[&str] =
    &["station", "mount", "step", "angle_deg", PLACE[0], PLACE[1], PLACE[2], "time_s", "direction"];

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: &Settings,
) -> Result<Reading, Error> {
    let setup = Setup::read(folder, document, settings)?;
    if setup.second_axis.is_some() {
        let message =
            "`[second_axis]` needs `ranges.csv`: both axes of a head are calibrated from \
                       ranges; give each axis a case of its own for points"
                .to_owned();
        return Err(Error::case(document.at_file(), Problem::WrongValue { message }));
    }
    let table = folder.table(TARGETS, NEEDED)?;
    let mut columns = Columns::new(&table, KNOWN);
    let references = setup.references(&mut columns, &table, TARGETS)?;
    let [x, y, z] = PLACE.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let extras = columns.rest(&settings.closure.columns)?;
    let mut warnings = settings.target_warnings();
    warnings.extend(extras.warnings);
    let groups = group_names(settings.closure.group.as_ref(), &table, document)?;
    let References { station_of, mount_of, steps, step_of, time_s } = references;
    let targets = (0..table.n_rows())
        .map(|row| Target {
            station: station_of[row],
            mount: mount_of[row],
            step: step_of[row],
            at_mm: Point3::new(x[row], y[row], z[row]),
        })
        .collect();
    let hold_out = hold_out(groups.as_deref(), &mount_of, setup.mounts.len());
    let mut axis_model = settings.axis_model();
    if axis_model == AxisModel::Fixed && hold_out == HoldOut::Mount {
        // What is left of the reflectors cannot say where the axis is against them all.
        axis_model = AxisModel::Located;
        warnings.push(
            "whole reflectors are held out, and the fit of all to their nominal places says where the \
             axis should be: its location is fitted, and not judged"
                .to_owned(),
        );
    }
    if settings.sought().is_some() {
        warnings.push(
            "`[axis] origin_mm` is not declared: places are counted from the axis, in the frame of the \
             reflectors' nominal places"
                .to_owned(),
        );
    }
    let (order, noise) = (settings.options().order, noise(settings, document)?);
    let options = TargetOptions { axis: axis_model, order, noise };
    let Setup { axis, stations, mounts, bodies, away_mm, .. } = setup;
    let covariates = recorded(None, &extras.covariates);
    let case = TargetCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        survey: TargetSurvey { axis, stations, mounts, steps, targets },
        options,
        records: TargetRecords { time_s, covariates, bodies },
        hold_out,
        groups,
        group_noun: settings.closure.group.as_ref().map(|g| g.get_ref().clone()),
        away_mm,
        has_direction: table.column("direction").is_some(),
        plan: settings.plan.clone(),
        solved: std::sync::OnceLock::new(),
    };
    Ok(Reading {
        measured: Box::new(case),
        loop_settings: settings.loop_settings(),
        warnings,
        tables: vec![STATIONS, MOUNTS, TARGETS],
    })
}

fn noise(settings: &Settings, document: &Document) -> Result<TargetNoise, Error> {
    let noise = &settings.noise;
    let missing = |key: &str| {
        let purpose = "distance and angle have uncertainties of their own: declare both, or \
                       `point_mm`";
        let problem = Problem::MissingKey { key: key.to_owned(), purpose };
        Err(Error::case(document.at_file(), problem))
    };
    match (noise.range_mm, noise.angle_rad, noise.point_mm) {
        (Some(range), Some(angle), _) => {
            Ok(TargetNoise::Polar { range_mm: range.0, angle_rad: angle.0 })
        }
        (Some(_), None, _) => missing("[noise] angle_rad"),
        (None, Some(_), _) => missing("[noise] range_mm"),
        (None, None, Some(point)) => Ok(TargetNoise::Point { point_mm: point.0 }),
        (None, None, None) => Ok(TargetNoise::Estimated),
    }
}

/// Groups that are made of whole reflectors hold these out; all others, steps or parts of them.
fn hold_out(groups: Option<&[String]>, mount_of: &[usize], n_mounts: usize) -> HoldOut {
    let Some(groups) = groups else { return HoldOut::Step };
    let mut of_mount: Vec<Option<&String>> = vec![None; n_mounts];
    let mut is_of_mounts = true;
    for (group, &mount) in groups.iter().zip(mount_of) {
        is_of_mounts &= *of_mount[mount].get_or_insert(group) == group;
    }
    let is_one = groups.iter().all(|g| *g == groups[0]);
    if is_of_mounts && !is_one { HoldOut::Mount } else { HoldOut::Step }
}
