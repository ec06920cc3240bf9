//! SO LAT: photogrammetry bundles of the same coded targets on a telescope.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::readings::files;
use super::{Case, Set};

pub(super) const LAT: &str =
    "github.com/simonsobs/LAT_Alignment, commit 46a92d776fbd, BSD-2-Clause";

pub(super) const LAT_LICENCE: &str =
    "BSD-2-Clause, the Simons Observatory; fixtures/licences/lat-alignment.txt";

const INCH_MM: f64 = 25.4;
/// A telescope is some ten metres wide: a bundle below this extent is not in millimetres.
const SMALLEST_EXTENT_MM: f64 = 1500.0;
/// Fewest common targets of two bundles that are compared.
const MIN_COMMON: usize = 20;

pub(super) const SET: Set = Set {
    name: "lat-photogrammetry",
    source: LAT,
    licence: LAT_LICENCE,
    place: "so_lat_tracker/photogrammetry",
    reference: "2.19 mm rigid, 0.37 with a scale of −429 ppm",
    left_out: "target",
    convert,
};

type Bundle = BTreeMap<String, [f64; 3]>;

/// Every bundle against the one after it, where enough targets are common.
fn convert(folder: &Path) -> Result<Vec<Case>> {
    let mut bundles = Vec::new();
    for (name, path) in files(folder, |_| true)? {
        let (bundle, inches) = read(&path)?;
        bundles.push((name, bundle, inches));
    }
    let mut cases = Vec::new();
    for pair in bundles.windows(2) {
        let [(from, source, from_inches), (to, target, to_inches)] = pair else { continue };
        let common: Vec<_> =
            source.iter().filter_map(|(name, at)| Some((name, at, target.get(name)?))).collect();
        if common.len() < MIN_COMMON {
            continue;
        }
        let mut table = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n".to_owned();
        for (name, a, b) in &common {
            let numbers: Vec<String> = a.iter().chain(*b).map(|v| format!("{v:.4}")).collect();
            // A string takes every character.
            let _ = writeln!(table, "{name},{}", numbers.join(","));
        }
        let mut notes = vec![format!("{} common targets", common.len())];
        for (name, inches) in [(from, from_inches), (to, to_inches)] {
            if *inches {
                notes.push(format!("{name} converted from inches"));
            }
        }
        cases.push(Case {
            name: format!("{from}-{to}"),
            settings: "kind = \"frame-fit\"\n".to_owned(),
            tables: vec![("pairs.csv", table)],
            notes,
            carry: None,
        });
    }
    Ok(cases)
}

/// Coded targets by name, in mm, and whether they came in inches.
fn read(path: &Path) -> Result<(Bundle, bool)> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut bundle = Bundle::new();
    for (n, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(name) = cells.first().filter(|name| name.starts_with("CODE")) else { continue };
        let axis = |k: usize| -> Result<f64> {
            let cell = cells.get(k).copied().unwrap_or("");
            cell.parse().with_context(|| format!("{}:{}", path.display(), n + 1))
        };
        bundle.insert((*name).to_owned(), [axis(1)?, axis(2)?, axis(3)?]);
    }
    let inches = extent(&bundle) < SMALLEST_EXTENT_MM;
    if inches {
        for at in bundle.values_mut() {
            *at = at.map(|v| v * INCH_MM);
        }
    }
    Ok((bundle, inches))
}

fn extent(bundle: &Bundle) -> f64 {
    (0..3)
        .map(|k| {
            let values = || bundle.values().map(|at| at[k]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max)
}
