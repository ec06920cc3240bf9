//! The probe on a reference sphere: what it adds to a touch, found and taken off.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::answer::{asked, closed, emptied, imported, planned, text};
use super::drawing::{BALL_MM, SPHERE_CENTER_MM, SPHERE_MM, sphere_touches};
use super::machine::Machine;
use super::touch::{SAFE_Z_MM, TRAVEL_MM_PER_MIN, Touch, program, spread};
use crate::program::Truing;

/// Feeds of the plan; the first touches, and those of the part, have the last.
const FEEDS_MM_PER_MIN: [f64; 3] = [100.0, 200.0, PART_FEED_MM_PER_MIN];
pub(super) const PART_FEED_MM_PER_MIN: f64 = 300.0;
const FIRST: u32 = 14;
const AGAIN: u32 = 18;
/// From before the contact to beyond it.
const REACH_MM: f64 = 0.6;
/// Largest angle between approach and normal of the touches that judge.
const LEAN_RAD: f64 = 0.35;
/// What a probe that was never calibrated is asked for, and how much may be measured at a time.
const AIM: [&str; 4] = ["--for", "tip-radius,pretravel,latency", "--budget", "12"];
/// Plans run one after another.
const ROUNDS: usize = 2;
/// What the error of the touches that judge has to fall by: ball, latency and place, some 10 µm each,
/// go; lobes of the switch and the servo cycle's 1.4 µm stay.
const AT_LEAST: f64 = 2.0;

/// Runs it; the radius with which a touch along the normal at the feed of the part is compensated, mm.
pub(super) fn qualify(truing: &Truing, machine: &mut Machine, folder: &Path) -> Result<f64> {
    println!("── reference sphere: ball, pretravel, latency and place are not declared");
    let mut case = emptied(folder)?.join("first");
    let touches = sphere_touches(FIRST, &[PART_FEED_MM_PER_MIN], &[0.0], 0.0);
    let log = machine.run("sphere", &program(&touches, REACH_MM, "sphere.log"))?;
    let feed = PART_FEED_MM_PER_MIN.to_string();
    imported(truing, &log, &["--feed", &feed], &settings(), &case)?;
    println!("  first program: {FIRST} touches along the normal");
    let mut answer = closed(truing, &case)?;
    for round in 1..=ROUNDS {
        let next = folder.join(format!("plan-{round}"));
        if planned(truing, machine, (&case, &next), &AIM)? == 0 {
            break;
        }
        case = next;
        answer = closed(truing, &case)?;
    }
    again(truing, machine, &case)?;
    Ok(effective_radius_mm(&answer))
}

fn settings() -> String {
    format!(
        "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = {SPHERE_MM:?}\n\
         center_mm = {SPHERE_CENTER_MM:?}\n[probe]\ntip_radius_mm = {BALL_MM:?}\nstylus = [0, 0, 1]\n\
         [noise]\npoint_mm = 0.0015\n[plan]\nfeeds_mm_per_min = {FEEDS_MM_PER_MIN:?}\n\
         z_mm = [4.0, 12.5]\napproach_mm = {REACH_MM:?}\nsafe_z_mm = {SAFE_Z_MM:?}\n\
         travel_mm_per_min = {TRAVEL_MM_PER_MIN:?}\n"
    )
}

/// Touches other places from other sides at all feeds: the sphere is round, so what they say of its form
/// is their error, with the probe as declared and with what the loop found.
fn again(truing: &Truing, machine: &mut Machine, case: &Path) -> Result<()> {
    let touches = sphere_touches(AGAIN, &FEEDS_MM_PER_MIN, &[0.0, LEAN_RAD], 1.0);
    let log = machine.run("again", &program(&touches, REACH_MM, "again.log"))?;
    let judged = case.with_file_name("again");
    fs::create_dir(&judged)?;
    fs::write(judged.join("case.toml"), settings())?;
    let measured = fs::read_to_string(case.join("touches.csv"))?;
    fs::write(
        judged.join("touches.csv"),
        with_judged(&measured, &touches, &super::touch::logged(&log)?)?,
    )?;
    let before = asked(truing, &["solve", text(&judged)?, "--json"])?;
    let after = asked(truing, &["loop", text(&judged)?, "--json"])?;
    let of = |answer: &Value| -> Result<[f64; 2]> {
        let touches = answer["estimates"]["touches"].as_array().context("no touches")?;
        let judged = touches.iter().filter(|touch| touch["use"] == "check");
        Ok(spread(&judged.filter_map(|touch| touch["deviation_mm"].as_f64()).collect::<Vec<_>>()))
    };
    let ([before, worst_before], [after, worst_after]) = (of(&before)?, of(&after)?);
    println!(
        "  touched again, {AGAIN} other places, feeds and approaches: error {:.1} µm rms, {:.1} µm at most → \
         {:.1} µm rms, {:.1} µm at most",
        1e3 * before,
        1e3 * worst_before,
        1e3 * after,
        1e3 * worst_after
    );
    ensure!(before > AT_LEAST * after, "the loop's answer does not hold for other touches");
    Ok(())
}

/// The table with touches that are only judged.
fn with_judged(measured: &str, touches: &[Touch], at: &[[f64; 3]]) -> Result<String> {
    ensure!(touches.len() == at.len(), "{} touches, {} triggers", touches.len(), at.len());
    let mut reader = csv::Reader::from_reader(measured.as_bytes());
    let names = reader.headers()?.clone();
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(names.iter().chain(["use"]))?;
    for record in reader.records() {
        writer.write_record(record?.iter().chain(["fit"]))?;
    }
    for (n, (touch, at)) in touches.iter().zip(at).enumerate() {
        let cells = names.iter().map(|name| match name {
            "touch" => format!("A{}", n + 1),
            "x_mm" => at[0].to_string(),
            "y_mm" => at[1].to_string(),
            "z_mm" => at[2].to_string(),
            "nx" => touch.way[0].to_string(),
            "ny" => touch.way[1].to_string(),
            "nz" => touch.way[2].to_string(),
            "feed_mm_per_min" => touch.feed_mm_per_min.to_string(),
            _ => String::new(),
        });
        writer.write_record(cells.chain(["check".to_owned()]))?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Declared ball with what was found of it along the normal at the feed of the part.
fn effective_radius_mm(answer: &Value) -> f64 {
    let mut radius_mm = BALL_MM;
    for step in answer["steps"].as_array().into_iter().flatten() {
        let value = step["parameters"][0]["value"].as_f64().unwrap_or(0.0);
        radius_mm += match step["effect"].as_str() {
            Some("tip-radius") => value,
            Some("pretravel") => -1e-3 * value,
            Some("latency") => -1e-3 * value * PART_FEED_MM_PER_MIN / 60.0,
            _ => 0.0,
        };
    }
    println!(
        "  a touch along the normal at {PART_FEED_MM_PER_MIN} mm/min is compensated with {radius_mm:.4} mm"
    );
    radius_mm
}
