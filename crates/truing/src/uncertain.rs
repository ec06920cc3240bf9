//! Which numbers of a case are uncertain, and data as they might have been read as well.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::case::{Change, Edit, Table};
use crate::kind::Files;

/// Numbers of one table and their standard uncertainty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertain {
    pub(crate) table: &'static str,
    pub(crate) columns: &'static [&'static str],
    pub(crate) std: Std,
}

/// Where a standard uncertainty stands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Std {
    /// A key of `[noise]`.
    Declared(&'static str),
    /// Columns of the same table, one for all numbers or one for each.
    Columns(&'static [&'static str]),
    /// Keys of `[noise]`: along the beam, and per distance across it, of a point about its tracker.
    Polar { range: &'static str, angle: &'static str },
}

/// The first of all draws; each has a stream of its own, whatever thread it is drawn on.
const SEED: u64 = 0x6375_6d31;

/// Changes that add to every uncertain number of a case a draw from its normal distribution;
/// `None` where the case declares none of them.
pub(crate) fn drawn(uncertain: &[Uncertain], files: &Files, draw: u64) -> Option<Vec<Edit>> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    rng.set_stream(draw);
    let mut edits: Vec<Edit> = Vec::new();
    for numbers in uncertain.iter().filter(|numbers| files.folder.has(numbers.table)) {
        let Ok(table) = files.folder.table(numbers.table, &[]) else { continue };
        let is_done = |column: &str| {
            edits.iter().any(|edit| {
                edit.file == numbers.table
                    && matches!(&edit.change, Change::Add { column: done, .. } if done == column)
            })
        };
        if numbers.columns.iter().any(|column| is_done(column)) {
            continue;
        }
        let added = added(numbers, files, &table, &mut rng);
        edits.extend(added.into_iter().map(|(column, values)| Edit {
            file: numbers.table,
            change: Change::Add { column: column.to_owned(), values },
        }));
    }
    Some(edits).filter(|edits| !edits.is_empty())
}

/// What is added to each row of each column; nothing where their uncertainty is not declared.
fn added(
    numbers: &Uncertain,
    files: &Files,
    table: &Table,
    rng: &mut ChaCha8Rng,
) -> Vec<(&'static str, Vec<f64>)> {
    let declared = |key: &str| {
        let value = files.document.value(&["noise", key])?;
        value
            .as_float()
            .or_else(|| value.as_integer().and_then(|i| i32::try_from(i).ok()).map(f64::from))
    };
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let rows = 0..table.n_rows();
    match numbers.std {
        Std::Declared(key) => {
            let Some(std) = declared(key) else { return Vec::new() };
            let of =
                |column: &&'static str| (*column, rows.clone().map(|_| std * normal()).collect());
            numbers.columns.iter().map(of).collect()
        }
        Std::Columns(stds) => {
            let of = |(k, column): (usize, &&'static str)| {
                let std = table.numbers(stds.get(k).or(stds.last())?)?;
                Some((*column, std.into_iter().map(|std| std * normal()).collect()))
            };
            numbers.columns.iter().enumerate().filter_map(of).collect()
        }
        Std::Polar { range, angle } => {
            let (Some(range), Some(angle)) = (declared(range), declared(angle)) else {
                return Vec::new();
            };
            let Some(places) =
                numbers.columns.iter().map(|c| table.numbers(c)).collect::<Option<Vec<_>>>()
            else {
                return Vec::new();
            };
            let mut added: Vec<(&'static str, Vec<f64>)> =
                numbers.columns.iter().map(|column| (*column, Vec::new())).collect();
            for row in rows {
                let at: Vec<f64> = places.iter().map(|of| of[row]).collect();
                let distance = at.iter().map(|v| v * v).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
                // Isotropic across the beam, and along it what the range is uncertain by.
                let across: Vec<f64> = at.iter().map(|_| angle * distance * normal()).collect();
                let unit: Vec<f64> = at.iter().map(|v| v / distance).collect();
                let along: f64 = across.iter().zip(&unit).map(|(a, u)| a * u).sum();
                let by = range * normal() - along;
                for (k, (_, values)) in added.iter_mut().enumerate() {
                    values.push(across[k] + by * unit[k]);
                }
            }
            added
        }
    }
}

/// Keys of `[noise]` that would say how uncertain the numbers are.
pub(crate) fn keys(uncertain: &[Uncertain]) -> Vec<String> {
    let mut keys = Vec::new();
    for numbers in uncertain {
        match numbers.std {
            Std::Declared(key) => keys.push(key.to_owned()),
            Std::Polar { range, angle } => keys.extend([range.to_owned(), angle.to_owned()]),
            Std::Columns(_) => {}
        }
    }
    keys.sort();
    keys.dedup();
    keys
}
