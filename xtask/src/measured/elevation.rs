//! SO LAT: eight reflectors on two mirrors, while the elevation axis stepped there and back.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::photogrammetry::{LAT, LAT_LICENCE};
use super::readings::{Shot, files, shots};
use super::{Case, Set};

/// Angle from one stop to the next.
const STEP_DEG: f64 = 10.0;
/// Elevation at which the nominal places of the reflectors are taken.
const UPRIGHT_DEG: f64 = 90.0;

const PLACE: &str = "so_lat_tracker/elevation_step_20250610";
/// Of targets left out.
const REFERENCE: &str =
    "0.954 mm about a fixed axis, 0.346 with six errors per angle, 0.166 with two bodies";

pub(super) const BY_TARGET: Set = Set {
    name: "lat-elevation",
    source: LAT,
    licence: LAT_LICENCE,
    place: PLACE,
    reference: REFERENCE,
    left_out: "target",
    convert: |folder| convert(folder, "\n[loop]\ngroup = \"mount\"\n"),
};

pub(super) const BY_STOP: Set = Set {
    name: "lat-elevation-stops",
    source: LAT,
    licence: LAT_LICENCE,
    place: PLACE,
    reference: REFERENCE,
    left_out: "stop of the axis",
    convert: |folder| convert(folder, ""),
};

/// One reading: where the axis was, and where the reflector.
#[derive(Clone, Copy)]
struct Reading {
    angle_deg: f64,
    rising: bool,
    at_mm: [f64; 3],
}

fn convert(folder: &Path, grouping: &str) -> Result<Vec<Case>> {
    let mut targets = Vec::new();
    let mut dropped = 0;
    // The receiver was measured in another run, with steps of its own.
    for (name, path) in files(folder, |name| name.starts_with('M') && name.contains("_start"))? {
        let (shots, bad) = shots(&path)?;
        dropped += bad;
        let (target, start) = name.split_once("_step_").context("no step in the name")?;
        let digits: String = start
            .rsplit_once("start")
            .map_or(start, |(_, after)| after)
            .chars()
            .filter(char::is_ascii_digit)
            .collect();
        let start_deg: f64 = digits.parse().with_context(|| format!("no start angle in {name}"))?;
        targets.push((target.to_owned(), readings(&shots, start_deg)?));
    }
    ensure!(!targets.is_empty(), "no table of a reflector");
    let n_readings: usize = targets.iter().map(|(_, readings)| readings.len()).sum();
    let settings = format!(
        "kind = \"tracker-lm\"\n\n[axis]\nletter = \"B\"\norigin_mm = [0.0, 0.0, 0.0]\n\
         direction = [0.0, 1.0, 0.0]\n{grouping}"
    );
    Ok(vec![Case {
        name: "mirrors".to_owned(),
        settings,
        tables: vec![
            ("stations.csv", "station,x_mm,y_mm,z_mm\ntracker,0,0,0\n".to_owned()),
            ("mounts.csv", mounts(&targets)?),
            ("targets.csv", table(&targets)),
        ],
        notes: vec![
            format!(
                "{n_readings} readings of {} reflectors; {dropped} rows not enabled or \
                     unreadable",
                targets.len()
            ),
            "angles from the shots themselves: numbers of missing shots were used again".to_owned(),
        ],
        carry: None,
    }])
}

/// Angle and way of every shot.
///
/// The numbers count stops there and back, but not always those that were missed: the angle is
/// that of the shot, and it came on the way back where counting back from the last says so.
fn readings(shots: &[Shot], start_deg: f64) -> Result<Vec<Reading>> {
    let (first, last) = (shots.first().context("no shots")?, shots.last().context("no shots")?);
    let reading = |shot: &Shot| {
        let turned = azimuth_deg(shot.at_mm) - azimuth_deg(first.at_mm);
        let stops = (turned.rem_euclid(360.0) / STEP_DEG).round().rem_euclid(360.0 / STEP_DEG);
        let counted = |from: u32| (stops - f64::from(from)).abs() < 0.5;
        let rising = counted(shot.id - first.id) || !counted(last.id - shot.id);
        Reading { angle_deg: start_deg + STEP_DEG * stops, rising, at_mm: shot.at_mm }
    };
    Ok(shots.iter().map(reading).collect())
}

/// Angle about y, from z towards x.
fn azimuth_deg(at_mm: [f64; 3]) -> f64 {
    at_mm[0].atan2(at_mm[2]).to_degrees()
}

/// Places in the turning frame at angle zero, from the shot nearest to upright.
fn mounts(targets: &[(String, Vec<Reading>)]) -> Result<String> {
    let mut text = "mount,x_mm,y_mm,z_mm,body\n".to_owned();
    for (name, readings) in targets {
        let off = |r: &&Reading| (r.angle_deg - UPRIGHT_DEG).abs();
        let nearest = readings.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let Reading { angle_deg, at_mm: [x, y, z], .. } = nearest.context("no readings")?;
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let body = name.split('_').next().unwrap_or(name);
        // A string takes every character.
        let _ = writeln!(
            text,
            "{name},{:.4},{y:.4},{:.4},{body}",
            cos * x - sin * z,
            sin * x + cos * z
        );
    }
    Ok(text)
}

/// Stop by stop, there and back.
fn table(targets: &[(String, Vec<Reading>)]) -> String {
    let mut stops: BTreeMap<i64, Vec<String>> = BTreeMap::new();
    for (name, readings) in targets {
        for Reading { angle_deg, rising, at_mm: [x, y, z] } in readings {
            let (way, order) = if *rising { (1, *angle_deg) } else { (-1, 1000.0 - angle_deg) };
            let step = format!("{}{angle_deg:03}", if *rising { "up" } else { "down" });
            #[expect(clippy::cast_possible_truncation, reason = "whole degrees")]
            let order = order.round() as i64;
            stops
                .entry(order)
                .or_default()
                .push(format!("tracker,{name},{step},{angle_deg},{way},{x:.4},{y:.4},{z:.4}\n"));
        }
    }
    let header = "station,mount,step,angle_deg,direction,x_mm,y_mm,z_mm\n".to_owned();
    stops.into_values().flatten().fold(header, |text, line| text + &line)
}
