//! The part: where it lies, and its program where it lies.

use std::fs;
use std::path::Path;

use anyhow::{Result, ensure};

use super::answer::{asked, closed, emptied, imported, planned, text};
use super::drawing::{HALF_MM, TERMS, UNIT_MM, part_touches};
use super::machine::Machine;
use super::sphere::PART_FEED_MM_PER_MIN;
use super::touch::{SAFE_Z_MM, TRAVEL_MM_PER_MIN, errors_mm, program, spread};
use crate::program::Truing;

/// From before the drawn contact to beyond it: the part lies up to 0.5 mm elsewhere.
const REACH_MM: f64 = 1.2;
const PLANNED: &str = "12";
/// What the error of the program has to fall by: half a millimetre of place goes, 10 µm of form stay.
const AT_LEAST: f64 = 10.0;

/// Touches it, plans, touches again, corrects a program and runs it before and after.
pub(super) fn locate(
    truing: &Truing,
    machine: &mut Machine,
    folder: &Path,
    radius_mm: f64,
) -> Result<()> {
    println!("── part: its place and its error of form are not declared");
    let first = emptied(folder)?.join("first");
    let touches = part_touches(3, 3, 0.0, radius_mm, PART_FEED_MM_PER_MIN);
    let log = machine.run("part", &program(&touches, REACH_MM, "part.log"))?;
    imported(truing, &log, &["--kind", "pose-icp"], &settings(radius_mm), &first)?;
    println!("  first program: {} touches", touches.len());
    closed(truing, &first)?;
    let next = folder.join("plan");
    let aim = ["--for", "all", "--budget", PLANNED];
    planned(truing, machine, (&first, &next), &aim)?;
    closed(truing, &next)?;

    // Other places than those that were touched.
    let touches = part_touches(4, 3, 0.2, radius_mm, PART_FEED_MM_PER_MIN);
    let drawn = program(&touches, REACH_MM, "inspection.log");
    let log = machine.run("inspection", &drawn)?;
    let [before, worst_before] = spread(&errors_mm(&drawn, &log)?);

    let file = folder.join("inspection.ngc");
    fs::write(&file, &drawn)?;
    let moved = folder.join("inspection-corrected.ngc");
    let answer = next.join("answer.json");
    asked(
        truing,
        &[
            "correct",
            text(&next)?,
            text(&file)?,
            "--answer",
            text(&answer)?,
            "--output",
            text(&moved)?,
        ],
    )?;
    let corrected = fs::read_to_string(&moved)?;
    let log = machine.run("corrected", &corrected)?;
    let [after, worst_after] = spread(&errors_mm(&corrected, &log)?);
    println!(
        "  inspection program, {} touches at other places: error {:.1} µm rms, {:.1} µm at most → corrected \
         {:.1} µm rms, {:.1} µm at most",
        touches.len(),
        1e3 * before,
        1e3 * worst_before,
        1e3 * after,
        1e3 * worst_after
    );
    ensure!(before > AT_LEAST * after, "the corrected program is not where the part is");
    Ok(())
}

fn settings(radius_mm: f64) -> String {
    let terms: Vec<String> =
        TERMS.iter().map(|(i, j, height)| format!("[{i}, {j}, {height:?}]")).collect();
    let [x, y] = HALF_MM;
    format!(
        "kind = \"pose-icp\"\n[surface]\nshape = \"polynomial\"\nunit_mm = {UNIT_MM:?}\nterms = [{}]\n\
         diameter_mm = 100.0\n[probe]\ntip_radius_mm = {radius_mm:.4}\nside = \"+z\"\n[noise]\n\
         point_mm = 0.002\n[plan]\nx_mm = [{:?}, {x:?}]\ny_mm = [{:?}, {y:?}]\n\
         feeds_mm_per_min = [{PART_FEED_MM_PER_MIN:?}]\napproach_mm = 0.6\nsafe_z_mm = {SAFE_Z_MM:?}\n\
         travel_mm_per_min = {TRAVEL_MM_PER_MIN:?}\n",
        terms.join(", "),
        -x,
        -y
    )
}
