//! Tables as instruments write them.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// One shot of a laser tracker: the centre of its reflector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    /// Number in the series; missing numbers are missing shots.
    pub(crate) id: u32,
    pub(crate) at_mm: [f64; 3],
}

/// Shots of a tracker's table, separated by tabs or commas, with thousands separators inside
/// numbers of the former; and how many rows were not enabled or not readable.
pub(crate) fn shots(path: &Path) -> Result<(Vec<Shot>, usize)> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut lines = text.lines();
    let header = lines.next().with_context(|| format!("{} is empty", path.display()))?;
    let separator = if header.contains('\t') { '\t' } else { ',' };
    let names: HashMap<&str, usize> =
        header.split(separator).map(str::trim).enumerate().map(|(i, name)| (name, i)).collect();
    let column = |name: &str| {
        let missing = || format!("{} has no column {name}", path.display());
        names.get(name).copied().with_context(missing)
    };
    let (enabled, id) = (column("Enabled")?, column("ID")?);
    let axes = [column("x")?, column("y")?, column("z")?];
    let (mut found, mut dropped) = (Vec::new(), 0);
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split(separator).map(str::trim).collect();
        let cell = |column: usize| cells.get(column).copied().unwrap_or("");
        let shot = || {
            let at = axes.map(|axis| number(cell(axis)));
            let at_mm = [at[0]?, at[1]?, at[2]?];
            Some(Shot { id: cell(id).parse().ok()?, at_mm })
        };
        match shot() {
            Some(shot) if cell(enabled) == "Checked" => found.push(shot),
            _ => dropped += 1,
        }
    }
    Ok((found, dropped))
}

/// A number with thousands separators.
pub(crate) fn number(cell: &str) -> Option<f64> {
    cell.replace(',', "").parse().ok().filter(|v: &f64| v.is_finite())
}

/// Numbers of a table without header, separated by commas, tabs or spaces.
pub(crate) fn rows(path: &Path) -> Result<Vec<Vec<f64>>> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(n, line)| {
            let cells = line.split([',', '\t', ' ']).filter(|cell| !cell.is_empty());
            cells
                .map(|cell| cell.parse().with_context(|| format!("{}:{}", path.display(), n + 1)))
                .collect()
        })
        .collect()
}

/// Files of a folder whose names `accepts`, sorted by name.
pub(crate) fn files(
    folder: &Path,
    accepts: impl Fn(&str) -> bool,
) -> Result<Vec<(String, std::path::PathBuf)>> {
    let mut found = Vec::new();
    for entry in
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?
    {
        let path = entry?.path();
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        if path.is_file() && accepts(&name) {
            found.push((name, path));
        }
    }
    found.sort();
    Ok(found)
}
