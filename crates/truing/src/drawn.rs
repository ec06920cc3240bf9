//! Data as they might have been read as well.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::case::{Change, Edit, Table};
use crate::kind::Files;
use crate::uncertain::{Std, Uncertain};

/// The first of all draws; each has a stream of its own, whatever thread it is drawn on.
const SEED: u64 = 0x6375_6d31;

/// Uncertain numbers of one table, drawn.
pub(crate) struct Source {
    /// Table and key.
    pub(crate) name: String,
    /// Changes that add to every one of them a draw from its normal distribution.
    pub(crate) edits: Vec<Edit>,
}

/// One draw of everything that is uncertain and declared so.
pub(crate) fn drawn(uncertain: &[Uncertain], files: &Files, draw: u64) -> Vec<Source> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    rng.set_stream(draw);
    let mut sources: Vec<Source> = Vec::new();
    for numbers in uncertain.iter().filter(|numbers| files.folder.has(numbers.table)) {
        let Ok(table) = files.folder.table(numbers.table, &[]) else { continue };
        let is_done = |column: &str| {
            sources.iter().flat_map(|source| &source.edits).any(|edit| {
                edit.file == numbers.table
                    && matches!(&edit.change, Change::Add { column: done, .. } if done == column)
            })
        };
        if numbers.columns.iter().any(|column| is_done(column)) {
            continue;
        }
        let added = added(numbers, files, &table, &mut rng);
        let edit = |(column, values): (&str, Vec<f64>)| Edit {
            file: numbers.table,
            change: Change::Add { column: column.to_owned(), values },
        };
        let edits: Vec<Edit> = added.into_iter().map(edit).collect();
        if !edits.is_empty() {
            sources.push(Source { name: numbers.name(), edits });
        }
    }
    sources
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
