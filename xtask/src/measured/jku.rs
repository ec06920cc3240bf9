//! JKU Linz: force control of a polishing-type tool along a ramp and a straight profile, by a robot
//! and by a pneumatic flange, read by a sensor under the workpiece.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::readings::files;
use super::{Case, Set};

/// The first contact, when the tool lands and bounces, is not the following of a path.
const LANDED_S: f64 = 1.0;
/// A force asked for below this is none.
const NO_FORCE_N: f64 = 1e-6;

pub(super) const SET: Set = Set {
    name: "jku-force",
    source: "github.com/JKU-Linz-Institute-of-Robotics/ur10e_force_control_comparison, commit \
             3b9b1b2d7b79, Test_scenarios/*/2_Measurements-UR10e_ACF/TcpUR_FzATI, vertices of the \
             vector plots, GPL-3.0",
    licence: "GPL-3.0",
    place: "jku_force_1250hz",
    reference: "ramp: 5.83 → 3.45 N at 0.10 m/s, 4.20 → 2.62 N at 0.25 m/s",
    left_out: "run",
    convert,
};

/// One recorded run.
struct Recorded {
    start_s: f64,
    step_s: f64,
    /// Force read and asked for.
    forces_n: Vec<[f64; 2]>,
}

/// Runs of one profile, one kind of control and one speed are one case.
fn convert(folder: &Path) -> Result<Vec<Case>> {
    let mut cases: BTreeMap<String, Vec<(String, Recorded)>> = BTreeMap::new();
    for (name, path) in files(folder, |name| name.contains("_control_F_"))? {
        let (profile, rest) = name.split_once("_control_F_").context("no setting in the name")?;
        let (set, speed) = rest.rsplit_once("_v_").context("no speed in the name")?;
        let case = format!("{profile}_v_{speed}");
        cases.entry(case).or_default().push((format!("F {set}"), read(&path)?));
    }
    let enough = |runs: &Vec<_>| runs.len() >= 3;
    let few: Vec<String> = (cases.iter().filter(|(_, runs)| !enough(runs)))
        .map(|(name, runs)| format!("{name}: {} runs, too few to leave one out", runs.len()))
        .collect();
    let enough = cases.into_iter().filter(|(_, runs)| enough(runs));
    enough.map(|(name, runs)| case(name, &runs, &few)).collect()
}

fn case(name: String, runs: &[(String, Recorded)], few: &[String]) -> Result<Case> {
    let speed = name.rsplit_once("_v_").map_or("", |(_, speed)| speed).replace('p', ".");
    let speed_m_per_s: f64 = speed.parse().with_context(|| format!("no speed in {name}"))?;
    let mut table = "run,time_s,path_mm,force_n,reference_n\n".to_owned();
    let (mut kept, mut before) = (0, 0);
    for (run, recorded) in runs {
        for (i, [force_n, asked_n]) in recorded.forces_n.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            let time_s = recorded.start_s + recorded.step_s * i as f64;
            if asked_n.abs() < NO_FORCE_N || time_s < LANDED_S {
                before += 1;
                continue;
            }
            kept += 1;
            let path_mm = 1000.0 * speed_m_per_s * time_s;
            // A string takes every character.
            let _ = writeln!(table, "{run},{time_s:.6},{path_mm:.5},{force_n},{asked_n}");
        }
    }
    let mut notes = vec![
        format!(
            "{} runs, {kept} readings; {before} before {LANDED_S} s after first contact, or with \
             no force asked for, left out",
            runs.len()
        ),
        "place on the path = time since first contact × path speed".to_owned(),
    ];
    notes.extend(few.iter().cloned());
    Ok(Case {
        name,
        settings: "kind = \"force-impedance\"\n".to_owned(),
        tables: vec![("path.csv", table)],
        notes,
        carry: None,
    })
}

fn read(path: &Path) -> Result<Recorded> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let header = text.lines().next().unwrap_or("");
    let value = |key: &str| -> Result<f64> {
        let cell = header.split_whitespace().find_map(|word| word.strip_prefix(key));
        let cell = cell.with_context(|| format!("{}: no {key} in the header", path.display()))?;
        cell.parse().with_context(|| format!("{}: {key}", path.display()))
    };
    let (start_s, step_s) = (value("t0_s=")?, value("dt_s=")?);
    let mut forces_n = Vec::new();
    for (n, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with('#')) {
        let number = |cell: Option<&str>| -> Result<f64> {
            let cell = cell.unwrap_or("").trim();
            cell.parse().with_context(|| format!("{}:{}", path.display(), n + 1))
        };
        let mut cells = line.split(',');
        forces_n.push([number(cells.next())?, number(cells.next())?]);
    }
    ensure!(!forces_n.is_empty(), "{}: no readings", path.display());
    Ok(Recorded { start_s, step_s, forces_n })
}
