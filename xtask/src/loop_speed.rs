//! `cargo xtask bench loop`: what closing the loop costs beside solving the declared model.

use std::fs;

use anyhow::{Context, Result};

use crate::generators::tracer::{Run, simulate};
use crate::generators::tracer_tables::tables;
use crate::program::{Truing, number_at};
use crate::shell;

/// Runs of either; the least counts, for a busy machine only adds.
const ROUNDS: usize = 5;

/// Times `truing solve` and `truing loop` on one thread, on a run with eight stations.
pub(crate) fn run() -> Result<()> {
    let truing = Truing::build()?;
    let folder = shell::root().join("target/loop-speed");
    fs::create_dir_all(&folder).context("cannot make target/loop-speed")?;
    let scene = Run { n_stations: 8, n_angles: 19, record_air: true, ..Run::new(11) };
    for (name, text) in tables(&scene, &simulate(&scene)) {
        fs::write(folder.join(name), text).with_context(|| format!("cannot write {name}"))?;
    }
    let at = folder.to_string_lossy();
    let least_ms = |command: &str, key: &str| -> Result<f64> {
        let mut least_ms = f64::INFINITY;
        for _ in 0..ROUNDS {
            let answer = truing.run(&[command, &*at, "--json", "--threads", "1"])?;
            let seconds = number_at(&answer.json, key).with_context(|| answer.message.clone())?;
            least_ms = least_ms.min(1e3 * seconds);
        }
        Ok(least_ms)
    };
    let solve_ms = least_ms("solve", "timing.solve_s")?;
    let loop_ms = least_ms("loop", "timing.loop_s")?;
    println!(
        "8 stations, 4 reflectors, 19 angles, one thread: solved in {solve_ms:.2} ms; loop over the \
         catalogue, chosen anew without each angle, in {loop_ms:.0} ms: {:.0} times as long",
        loop_ms / solve_ms
    );
    Ok(())
}
