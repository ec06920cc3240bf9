//! How the solver's time grows with the number of steps: a table and a plot.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::contender::{Contender, compare};
use super::solver_scene::{self, Size};
use crate::shell;

/// Steps of the problems; the last has a million ranges.
const STEPS: [usize; 5] = [361, 1000, 3601, 10_000, 31_250];
/// Plot, and how the page names it.
const PLOT: &str = "docs/benchmarks-growth.svg";
const PLOT_LINK: &str = "benchmarks-growth.svg";

/// Solves ever longer runs with both contenders, one thread and two; table and link go to `page`.
pub(super) fn write(
    page: &mut String,
    folder: &Path,
    contenders: &[&Contender],
    rounds: usize,
) -> Result<()> {
    writeln!(page, "\n### Truing on ever longer runs, 8 stations, 4 reflectors\n")?;
    writeln!(
        page,
        "| ranges | ns per range, 1 thread | 2 threads | peak MiB |\n|---|---|---|---|"
    )?;
    let mut curves: [Vec<(f64, f64)>; 2] = Default::default();
    for (seed, steps) in (201..).zip(STEPS) {
        let size = Size { name: "growth", stations: 8, reflectors: 4, steps };
        let problem = folder.join(size.name);
        solver_scene::write(size, seed, &problem)?;
        let outcomes = compare(contenders, &problem, size, rounds)?;
        let ranges = size.stations * size.reflectors * steps;
        #[expect(clippy::cast_precision_loss, reason = "a few million, and KiB")]
        let (count, peak_mib) = (ranges as f64, outcomes[0].usual.peak_kib as f64 / 1024.0);
        for (curve, outcome) in curves.iter_mut().zip(&outcomes) {
            curve.push((count, outcome.usual.ms));
        }
        let [one, two] = [0, 1].map(|i| 1e6 * outcomes[i].usual.ms / count);
        writeln!(page, "| {ranges} | {one:.0} | {two:.0} | {peak_mib:.1} |")?;
    }
    let [one, two] = curves.each_ref().map(|curve| exponent(curve));
    writeln!(
        page,
        "\nTime grows with the ranges to the power {one:.2} on one thread, {two:.2} on two.\n\n\
         ![Time against ranges, both logarithmic; dashed, in proportion]({PLOT_LINK})"
    )?;
    fs::write(shell::root().join(PLOT), plot(&curves)?)
        .with_context(|| format!("cannot write {PLOT}"))
}

/// Slope of the logarithms.
fn exponent(curve: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = curve.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let (sum, n) = logs.iter().fold((0.0, 0.0), |(s, n), p| (s + of(p), n + 1.0));
        sum / n
    };
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
}

/// Both curves on logarithmic axes: 10⁴ to 10⁶ ranges, 1 to 1000 ms, and a dashed line of slope one.
fn plot(curves: &[Vec<(f64, f64)>; 2]) -> Result<String> {
    let x = |ranges: f64| 60.0 + 200.0 * (ranges.log10() - 4.0);
    let y = |ms: f64| 250.0 - 75.0 * ms.log10();
    let mut svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 480 300\" \
                   font-family=\"sans-serif\" font-size=\"12\">\n\
                   <rect width=\"480\" height=\"300\" fill=\"white\"/>\n"
        .to_owned();
    for (value, label) in [(1e4, "10⁴"), (1e5, "10⁵"), (1e6, "10⁶")] {
        let at = x(value);
        writeln!(svg, "<path d=\"M{at} 25V250\" stroke=\"#ddd\"/>")?;
        writeln!(svg, "<text x=\"{at}\" y=\"267\" text-anchor=\"middle\">{label}</text>")?;
    }
    for value in [1.0, 10.0, 100.0, 1000.0] {
        let at = y(value);
        writeln!(svg, "<path d=\"M60 {at}H460\" stroke=\"#ddd\"/>")?;
        let below = at + 4.0;
        writeln!(svg, "<text x=\"54\" y=\"{below}\" text-anchor=\"end\">{value}</text>")?;
    }
    writeln!(svg, "<text x=\"260\" y=\"290\" text-anchor=\"middle\">ranges</text>")?;
    writeln!(svg, "<text x=\"60\" y=\"15\">time of a solution, ms</text>")?;
    let last = curves[0].last().context("no runs")?;
    let (start, end) = (y(last.1 * 1e4 / last.0), y(last.1 * 1e6 / last.0));
    writeln!(
        svg,
        "<path d=\"M60 {start:.1}L460 {end:.1}\" stroke=\"#888\" stroke-dasharray=\"4 3\"/>"
    )?;
    let names = [("#1b6ca8", "1 thread", "end", -10.0), ("#c8553d", "2 threads", "start", 20.0)];
    for (curve, (colour, label, anchor, below)) in curves.iter().zip(names) {
        let points = curve.iter().map(|&(n, ms)| format!("{:.1},{:.1}", x(n), y(ms)));
        let points = points.collect::<Vec<_>>().join(" ");
        writeln!(svg, "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\"/>")?;
        for &(n, ms) in curve {
            let (cx, cy) = (x(n), y(ms));
            writeln!(svg, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\" fill=\"{colour}\"/>")?;
        }
        let place = curve.get(1).context("too few runs")?;
        let (tx, ty) = (x(place.0), y(place.1) + below);
        let text = format!("fill=\"{colour}\" text-anchor=\"{anchor}\">{label}");
        writeln!(svg, "<text x=\"{tx:.1}\" y=\"{ty:.1}\" {text}</text>")?;
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::exponent;

    #[test]
    fn a_power_law_has_its_exponent() {
        let curve = [10.0, 100.0, 1000.0].map(|x: f64| (x, 3.0 * x.powf(1.5)));
        assert!((exponent(&curve) - 1.5).abs() < 1e-12);
    }
}
