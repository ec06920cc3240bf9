//! SO LAT: thirteen reflectors on three sub-assemblies, watched for a night while nothing moved on
//! purpose.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, ensure};

use super::photogrammetry::{LAT, LAT_LICENCE};
use super::readings::{files, shots};
use super::{Case, Set};

/// Epochs that are compared with the first, evenly over the night.
const EPOCHS: usize = 12;
/// Cycles averaged for the first epoch.
const FIRST_CYCLES: u8 = 5;

pub(super) const SET: Set = Set {
    name: "lat-stability",
    source: LAT,
    licence: LAT_LICENCE,
    place: "so_lat_tracker/stability_20250609",
    reference: "0.98 mm static, 0.76 one rigid motion, 0.164 one per sub-assembly, 0.095 with scale",
    left_out: "target",
    convert,
};

fn convert(folder: &Path) -> Result<Vec<Case>> {
    let mut targets = Vec::new();
    let mut dropped = 0;
    for (name, path) in files(folder, |_| true)? {
        let (shots, bad) = shots(&path)?;
        dropped += bad;
        let by_cycle: BTreeMap<u32, [f64; 3]> = shots.iter().map(|s| (s.id, s.at_mm)).collect();
        targets.push((name, by_cycle));
    }
    ensure!(!targets.is_empty(), "no table of a target");
    let complete: Vec<u32> = targets[0]
        .1
        .keys()
        .copied()
        .filter(|cycle| targets.iter().all(|(_, shots)| shots.contains_key(cycle)))
        .collect();
    ensure!(
        complete.len() > usize::from(FIRST_CYCLES) + EPOCHS,
        "{} complete cycles",
        complete.len()
    );
    let first = &complete[..usize::from(FIRST_CYCLES)];
    let rest = &complete[usize::from(FIRST_CYCLES)..];
    let later = (1..=EPOCHS).map(|k| rest[k * (rest.len() - 1) / EPOCHS]);
    let case = |cycle: u32| {
        let header = "point,body,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n";
        let mut table = header.to_owned();
        for (name, shots) in &targets {
            let mean: [f64; 3] = std::array::from_fn(|k| {
                first.iter().map(|c| shots[c][k]).sum::<f64>() / f64::from(FIRST_CYCLES)
            });
            let body = name.split('_').next().unwrap_or(name);
            let numbers: Vec<String> =
                mean.iter().chain(&shots[&cycle]).map(|v| format!("{v:.4}")).collect();
            // A string takes every character.
            let _ = writeln!(table, "{name},{body},{}", numbers.join(","));
        }
        Case {
            name: format!("cycle-{cycle:04}"),
            settings: "kind = \"frame-fit\"\n".to_owned(),
            tables: vec![("pairs.csv", table)],
            notes: vec![format!(
                "{} complete cycles of {} targets; {dropped} rows not enabled or unreadable",
                complete.len(),
                targets.len()
            )],
            carry: None,
        }
    };
    Ok(later.map(case).collect())
}
