//! Public numbers and vectors carry their unit in their name.

use std::fs;

use anyhow::{Context, Result};

use super::Finding;
use super::source::{code_only, is_library, is_rust};
use crate::shell;

/// Endings that name a unit; quotients and powers are made of them.
const UNITS: [&str; 23] = [
    "mm", "um", "rad", "deg", "n", "nmm", "s", "ms", "ns", "hz", "kg", "c", "k", "ppm", "h", "mm2",
    "n2", "nmm2", "rad2", "s2", "s3", "mm3", "pct",
];

/// Words for what has no unit, or the unit of whatever is fitted; `s` is the squared normalised
/// residual of a robust loss, a twist mixes mm and rad; `u` and `v` are places by the knots of a spline;
/// target, deviation and lead are those of an axis, which is linear or rotary; elapsed is time, or readings
/// where no time was recorded.
const DIMENSIONLESS: [&str; 93] = [
    "absorbed",
    "alpha",
    "amplitude",
    "analytic",
    "axis",
    "base",
    "block",
    "blocks",
    "chi2",
    "coefficients",
    "condition",
    "confidence",
    "conic",
    "correlation",
    "cosine",
    "cost",
    "covariance",
    "coverage",
    "critical_p",
    "damping",
    "degrees_of_freedom",
    "derivative",
    "deviation",
    "df",
    "direction",
    "directions",
    "dof",
    "elapsed",
    "eps",
    "f_statistic",
    "factor",
    "fraction",
    "gain",
    "gradient",
    "handedness",
    "jacobian",
    "lead",
    "leverage",
    "loss",
    "maximum",
    "mean",
    "minimum",
    "norm",
    "normal",
    "normals",
    "numeric",
    "p_value",
    "parameters",
    "power",
    "probability",
    "quantile",
    "ratio",
    "reduction",
    "redundancy",
    "relative",
    "residual",
    "residuals",
    "rms",
    "s",
    "samples",
    "scale",
    "score",
    "share",
    "shared",
    "shear",
    "sigma",
    "significance",
    "sine",
    "singular_values",
    "slope",
    "spread",
    "resampled",
    "perturbed",
    "resolution",
    "start",
    "statistic",
    "std",
    "step",
    "target",
    "tolerance",
    "truth",
    "twist",
    "u",
    "unit",
    "v",
    "value",
    "values",
    "values_before",
    "variance",
    "vector",
    "weight",
    "weights",
    "widened_by",
];

/// Numbers of a page are shown in the unit that is written beside them.
const PAGES: &str = "crates/truing-report/";

/// Checks the public fields and arguments of all library crates.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let is_checked = |file: &&String| is_rust(file) && is_library(file) && !file.starts_with(PAGES);
    for file in files.iter().filter(is_checked) {
        let text = fs::read_to_string(shell::root().join(file)).with_context(|| file.clone())?;
        let code = code_only(&text);
        for (line, name) in unnamed(&code) {
            let text = format!("{file}:{line} `{name}` names no unit and no dimensionless word");
            findings.push(Finding::error(text));
        }
    }
    Ok(findings)
}

/// Line and name of every public number or vector without a unit.
fn unnamed(code: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut signature: Option<(usize, String)> = None;
    for (index, line) in code.lines().enumerate() {
        let line = line.trim();
        if let Some((start, mut text)) = signature.take() {
            text.push(' ');
            text.push_str(line);
            signature = Some((start, text));
        } else if starts_public_function(line) {
            signature = Some((index, line.to_owned()));
        } else if let Some(field) = line.strip_prefix("pub ") {
            let declared = field.trim_end_matches(',').split_once(':');
            found.extend(declared.and_then(|(name, kind)| judge(index, name, kind)));
        }
        if let Some((start, text)) = &signature
            && (text.contains('{') || text.contains(';'))
        {
            found.extend(arguments(text).filter_map(|(name, kind)| judge(*start, name, kind)));
            signature = None;
        }
    }
    found
}

fn starts_public_function(line: &str) -> bool {
    let Some(rest) = line.strip_prefix("pub ") else { return false };
    ["fn ", "const fn ", "unsafe fn "].iter().any(|start| rest.starts_with(start))
}

/// Name and type of each argument of a signature on one line.
fn arguments(signature: &str) -> impl Iterator<Item = (&str, &str)> {
    let open = signature.find('(').map_or(signature.len(), |at| at + 1);
    let mut depth = 0_i32;
    let mut end = signature.len();
    let mut cuts = vec![open];
    for (at, symbol) in signature.char_indices().skip_while(|(at, _)| *at < open) {
        match symbol {
            '(' | '<' | '[' => depth += 1,
            ')' if depth == 0 => {
                end = at;
                break;
            }
            // The arrow of a function type closes nothing.
            '>' if signature[..at].ends_with('-') => {}
            ')' | '>' | ']' => depth -= 1,
            ',' if depth == 0 => cuts.push(at + 1),
            _ => {}
        }
    }
    cuts.push(end + 1);
    let pieces: Vec<(usize, usize)> = cuts.windows(2).map(|cut| (cut[0], cut[1])).collect();
    pieces.into_iter().filter_map(move |(from, to)| {
        signature.get(from..to.saturating_sub(1).max(from))?.split_once(':')
    })
}

fn judge(index: usize, name: &str, kind: &str) -> Option<(usize, String)> {
    let name = name.trim().trim_start_matches("mut ");
    (is_measured(kind) && !names_unit(name)).then(|| (index + 1, name.to_owned()))
}

/// Whether a type is a number or a geometric vector, or a container of them.
fn is_measured(kind: &str) -> bool {
    let mut kind = kind.trim().trim_start_matches('&').trim_start_matches("mut ").trim();
    for wrapper in ["Option<", "Vec<", "["] {
        kind = kind.strip_prefix(wrapper).unwrap_or(kind);
    }
    let exact = ["f64", "f64>", "f64]"].contains(&kind) || kind.starts_with("f64;");
    exact
        || ["Vector2<f64", "Vector3<f64", "Point2<f64", "Point3<f64"]
            .iter()
            .any(|v| kind.starts_with(v))
}

/// A unit at the end, alone or as a quotient, or a dimensionless word anywhere.
fn names_unit(name: &str) -> bool {
    let last = name.rsplit('_').next().unwrap_or(name);
    let has_unit = name.contains('_') && UNITS.contains(&last) || UNITS[..3].contains(&name);
    let words = format!("_{name}_");
    has_unit || DIMENSIONLESS.iter().any(|word| words.contains(&format!("_{word}_")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_and_arguments_without_units_are_found() {
        let code = "\
pub struct A {
    pub height: f64,
    pub height_mm: f64,
    pub force: Vector3<f64>,
    pub points: Vec<Point3<f64>>,
    pub n_points: usize,
    pub p_value: f64,
    pub speed_mm_per_s: Option<f64>,
}
pub fn f(
    angle: f64,
    other_rad: f64,
    g: impl Fn(f64) -> f64,
) -> f64 {
pub(crate) fn hidden(angle: f64) {}
";
        let names: Vec<String> = unnamed(code).into_iter().map(|(_, name)| name).collect();
        assert_eq!(names, ["height", "force", "points", "angle"]);
    }
}
