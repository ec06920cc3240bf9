//! The polishing head in servo cycles of LinuxCNC: what it presses, and what its cycles take.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::installed::{Component, Installed, lay_out};
use crate::shell;

const FILES: [&str; 2] =
    ["xtask/linuxcnc/head.hal", "crates/force-impedance-c/include/force_impedance.h"];
const CONTROLLER: &str = "crates/force-impedance-c/hal/force_impedance.comp";
const HEAD: &str = "xtask/linuxcnc/pressed_part.comp";
/// Directions of the legs of `head.hal`, and those that the controller takes where none are given.
const LEGS_DEG: [f64; 3] = [60.0, 190.0, 320.0];
const USUAL_DEG: [f64; 3] = [90.0, 210.0, 330.0];
/// Force asked for in `head.hal`, N.
const REFERENCE_N: f64 = 30.0;
/// Until the head has come down and the reference is reached.
const SETTLED: usize = 2000;
/// The surface moves by 0.66 mm/s at most, which a damping of 1 N s/mm lets pass as 0.47 N rms; noise and
/// last digits add a tenth.
const MOST_ERROR_N: f64 = 0.7;
const CYCLE_NS: f64 = 1e6;
const WRONG_SECONDS: u32 = 4;

/// One cycle as sampled.
struct Cycle {
    interval_ns: f64,
    clocks: f64,
    step_clocks: f64,
    pressed_n: f64,
    force_n: f64,
    fault: f64,
    error: f64,
}

/// Presses for some seconds, then shortly with the legs taken for others.
pub(super) fn press(installed: Installed, folder: &Path, seconds: u32) -> Result<()> {
    println!(
        "── polishing head: legs at 60, 190 and 320°, a normal 19° beside the tool, a spring that moves"
    );
    shell::cargo(&["build", "--release", "--workspace", "--all-features", "--lib"])?;
    let metadata = shell::metadata(false)?;
    let target = metadata["target_directory"].as_str().context("no target directory")?;
    let library = Path::new(target).join("release/libforce_impedance_c.so");
    let library = library.to_str().context("the path of the library is no text")?;
    let place = folder.display();
    let flags = format!("-L{place} -Wl,--no-as-needed -lforce_impedance_c -Wl,-rpath,{place}");
    let components =
        [Component { source: CONTROLLER, flags: &flags }, Component { source: HEAD, flags: "" }];
    lay_out(folder, &[&FILES[..], &[library]].concat(), &components)?;

    let cycles = sampled(installed, folder, seconds, LEGS_DEG)?;
    let pressing = &cycles[SETTLED.min(cycles.len())..];
    ensure!(
        !pressing.is_empty(),
        "{} cycles were sampled, the first {SETTLED} settle",
        cycles.len()
    );
    let faults = pressing.iter().filter(|cycle| cycle.fault != 0.0 || cycle.error != 0.0).count();
    let error_n = rms(pressing.iter().map(|cycle| cycle.pressed_n - REFERENCE_N));
    let reading_n = rms(pressing.iter().map(|cycle| cycle.force_n - cycle.pressed_n));
    println!(
        "  {} cycles of 1 ms, {faults} with a fault: {error_n:.3} N rms beside the 30 N asked for; the force read \
         is {reading_n:.3} N rms beside the true one",
        cycles.len()
    );
    times(&cycles);
    ensure!(faults == 0, "{faults} cycles with a fault");
    ensure!(error_n < MOST_ERROR_N, "the force is {error_n} N beside what was asked for");

    let wrong = sampled(installed, folder, WRONG_SECONDS, USUAL_DEG)?;
    let late = &wrong[SETTLED.min(wrong.len())..];
    let wrong_n = rms(late.iter().map(|cycle| cycle.pressed_n - REFERENCE_N));
    println!(
        "  told that the legs are at 90, 210 and 330°: {wrong_n:.1} N rms beside the 30 N asked for"
    );
    ensure!(wrong_n > 2.0 * error_n, "the controller does not go by the directions of the legs");
    Ok(())
}

/// Runs `head.hal` and reads what it sampled.
fn sampled(
    installed: Installed,
    folder: &Path,
    seconds: u32,
    legs_deg: [f64; 3],
) -> Result<Vec<Cycle>> {
    let file = folder.join("samples.txt");
    if file.exists() {
        fs::remove_file(&file)?;
    }
    let mut command = installed.running(folder, "halrun -f head.hal");
    for (name, angle) in ["LEG0", "LEG1", "LEG2"].into_iter().zip(legs_deg) {
        command.env(name, angle.to_string());
    }
    let output = command
        .env("SAMPLES", (1000 * seconds).to_string())
        .env("SECONDS", (seconds + 2).to_string())
        .output()
        .context("cannot start halrun")?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "halrun ended with {}: {said}", output.status);
    let text = fs::read_to_string(&file).with_context(|| format!("no samples: {said}"))?;
    let cycles = text.lines().map(cycle).collect::<Result<Vec<_>>>()?;
    ensure!(!cycles.is_empty(), "no samples: {said}");
    Ok(cycles)
}

/// A line of the sampler: its number, then the pins.
fn cycle(line: &str) -> Result<Cycle> {
    let numbers: Vec<f64> = (line.split_whitespace().map(str::parse).collect::<Result<_, _>>())
        .with_context(|| format!("a sample that is none: {line}"))?;
    let [_, interval_ns, clocks, step_clocks, pressed_n, force_n, _, fault, error] = numbers[..]
    else {
        anyhow::bail!("a sample of {} numbers: {line}", numbers.len());
    };
    Ok(Cycle { interval_ns, clocks, step_clocks, pressed_n, force_n, fault, error })
}

/// Jitter of the cycles and time of a step.
fn times(cycles: &[Cycle]) {
    // The first interval has no cycle before it.
    let timed = &cycles[1..];
    let ns_per_clock = timed.iter().map(|cycle| cycle.interval_ns).sum::<f64>()
        / timed.iter().map(|cycle| cycle.clocks).sum::<f64>();
    let late = sorted(timed.iter().map(|cycle| (cycle.interval_ns - CYCLE_NS).abs() / 1e3));
    let step = sorted(timed.iter().map(|cycle| cycle.step_clocks * ns_per_clock));
    println!(
        "  interval beside 1 ms: median {:.1} µs, p99 {:.0} µs, p99.99 {:.0} µs, most {:.0} µs",
        share(&late, 0.5),
        share(&late, 0.99),
        share(&late, 0.9999),
        share(&late, 1.0)
    );
    println!(
        "  step of the controller: median {:.0} ns, p99 {:.0} ns, p99.99 {:.0} ns, most {:.0} ns",
        share(&step, 0.5),
        share(&step, 0.99),
        share(&step, 0.9999),
        share(&step, 1.0)
    );
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value that a share of all does not pass.
fn share(sorted: &[f64], share: f64) -> f64 {
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a count below 2^52"
    )]
    let index = (share * sorted.len() as f64).ceil() as usize;
    sorted[index.clamp(1, sorted.len()) - 1]
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    (sum / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn a_share_of_all_does_not_pass_its_value() {
        let values: Vec<f64> = (1..=10_000).map(f64::from).collect();
        let found = [0.5, 0.9999, 1.0].map(|of| share(&values, of).to_bits());
        assert_eq!(found, [5000.0, 9999.0, 10_000.0].map(f64::to_bits));
        assert_eq!(share(&[7.0], 0.99).to_bits(), 7.0_f64.to_bits());
    }
}
