//! Readings that were rounded to coarser steps than the declared noise: to round them once more leaves twice what
//! was left.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand::distr::{Distribution, Uniform};
use rand_chacha::ChaCha8Rng;

use super::coarse::{Coarse, coarse};
use super::hypothesis::{Hypothesis, is_or_are, listed, present, stretches_of};
use super::search::{Found, Plain, misfit_with};
use super::unit::{Dimension, all_and_each};
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::kind::Files;
use crate::measured::Measured;

/// Rows that are looked at, at most: each draw costs a fit of all.
const MOST_ROWS: usize = 20_000;
/// Decimals looked at.
const DECIMALS: std::ops::RangeInclusive<usize> = 0..=6;
/// Times that another rounding is drawn, with either sign: then it goes with what is left by no chance.
const DRAWS: u32 = 4;
/// χ² per degree of freedom above the noise, after another rounding over before it: two, where rounding is all
/// there is. Of n readings the mean square of one rounding is known to 0.9/√n.
const TWICE: std::ops::Range<f64> = 1.6..2.8;

/// Rows from which on one draw with both signs is as good as all, to a tenth: where it shows twice as much as there may
/// be, or half as little, the others are not asked.
const MANY_ROWS: usize = 400;
const CLEARLY: f64 = 2.0;
/// Share of the rows whose numbers come again, from which on these are asked, and the share of what they leave that is not
/// the same each time.
const AGAIN: f64 = 0.5;
const HALF: f64 = 0.5;
/// An error of a length that was read leaves as much at most: a step so many times less than what is left above the noise
/// is no part of it.
const FAR_FINER: f64 = 20.0;

/// The columns of which rounding explains what is left above the declared noise.
pub(super) fn rounded(files: &Files, plain: &Plain, measured: &dyn Measured) -> Option<Found> {
    let above = plain.misfit.above_noise()?;
    let of_readings = files.kind.readings.iter().flat_map(|of| {
        let samples = of.samples.iter().flat_map(|s| s.sets.iter().map(move |set| (s.file, set)));
        of.sets.iter().map(|set| (of.file, set)).chain(samples)
    });
    let left_mm = plain.misfit.above_noise_rms().filter(|_| plain.misfit.unit == "mm");
    let least_mm = left_mm.map(|left_mm| left_mm / FAR_FINER);
    let mut found = of_readings.filter_map(|(file, (columns, dimension))| {
        let table = files.folder.table(file, &[]).ok().filter(|t| t.n_rows() <= MOST_ROWS)?;
        let there = present(Some(&table), columns);
        let sets = all_and_each(&there).into_iter();
        let mut of_set = sets.flat_map(|set| {
            let to = |decimals: usize| -> Option<Vec<Coarse<'_>>> {
                set.iter().map(|column| coarse(&table, column, decimals)).collect()
            };
            let least_mm = least_mm.filter(|_| *dimension == Dimension::Length);
            let is_step = |of: &Coarse<'_>| {
                least_mm
                    .is_none_or(|least| last_digit(&table, of).is_some_and(|step| step >= least))
            };
            let may_be =
                |all: &Vec<Coarse<'_>>| all.iter().any(|of| of.is_read) && all.iter().any(is_step);
            DECIMALS.filter_map(to).filter(may_be).collect::<Vec<_>>()
        });
        let is_it = |coarse: &Vec<Coarse<'_>>| {
            let of = (files, (file, &table), &coarse[..]);
            let in_the_middle = || left_with(of, How::Truncated, None).filter(|left| *left < above);
            explains(of, How::Rounded, above)
                || in_the_middle().is_some_and(|left| explains(of, How::Truncated, left))
        };
        of_set
            .find(is_it)
            .filter(|coarse| !scatters_where_it_comes_again(measured, &table, coarse))
            .map(|coarse| told((file, &table), &coarse))
    });
    found.next().map(Found::unmended)
}

/// Whether rows of the same numbers in these columns scatter among each other as much as all: places that are told over and over
/// with few digits are rounded in the same way every time.
fn scatters_where_it_comes_again(
    measured: &dyn Measured,
    table: &Table,
    coarse: &[Coarse<'_>],
) -> bool {
    let Some(fitted) = measured.fit().ok().filter(|f| f.observations.len() == table.n_rows())
    else {
        return false;
    };
    let places: Option<Vec<usize>> =
        coarse.iter().map(|of| table.read_as(of.column).map(|(at, _)| at)).collect();
    let Some(places) = places else { return false };
    let mut of_number: BTreeMap<Vec<&str>, Vec<&[f64]>> = BTreeMap::new();
    for (row, observation) in fitted.observations.iter().enumerate() {
        let numbers = places.iter().map(|at| table.cell(row, *at)).collect();
        of_number.entry(numbers).or_default().push(&observation.residual);
    }
    let again = of_number.into_values().filter(|rows| rows.len() > 1).collect::<Vec<_>>();
    let n = count(again.iter().map(Vec::len).sum());
    if n < AGAIN * count(table.n_rows()) {
        return false;
    }
    let of_all =
        |rows: &Vec<&[f64]>| rows.iter().flat_map(|r| r.iter()).map(|v| v * v).sum::<f64>();
    let own = |rows: &Vec<&[f64]>| {
        let components = 0..rows.iter().map(|row| row.len()).min().unwrap_or(0);
        let of_mean = |k: usize| {
            let mean = rows.iter().map(|row| row[k]).sum::<f64>() / count(rows.len());
            count(rows.len()) * mean * mean
        };
        of_all(rows) - components.map(of_mean).sum::<f64>()
    };
    let share_of = count(again.len()) / n;
    let within: f64 = again.iter().map(own).sum();
    within > HALF * (1.0 - share_of) * again.iter().map(of_all).sum::<f64>()
}

/// How digits went: to the nearest number, or towards zero.
#[derive(Clone, Copy, PartialEq, Eq)]
enum How {
    Rounded,
    Truncated,
}

/// Files, the table of the columns, and these.
type Of<'f> = (&'f Files, (&'static str, &'f Table), &'f [Coarse<'f>]);

/// Whether another rounding leaves twice what is left `above` the noise.
fn explains(of: Of<'_>, how: How, above: f64) -> bool {
    let (_, _, coarse) = of;
    let are_many = coarse.iter().all(|of| of.rows.len() >= MANY_ROWS);
    let mut sum = 0.0;
    for draw in 0..DRAWS {
        let both = [1.0, -1.0].map(|sign| left_with(of, how, Some((draw, sign))));
        let [Some(one), Some(other)] = both else { return false };
        sum += one + other;
        let added = mean_ratio(sum, draw + 1, above) - 1.0;
        let may_be = (TWICE.start - 1.0) / CLEARLY..(TWICE.end - 1.0) * CLEARLY;
        if are_many && !may_be.contains(&added) {
            return false;
        }
    }
    TWICE.contains(&mean_ratio(sum, DRAWS, above))
}

/// What so many draws with both signs leave, on average, over what there is above the noise.
fn mean_ratio(sum: f64, draws: u32, above: f64) -> f64 {
    sum / (2.0 * f64::from(draws)) / above
}

/// What is left above the noise once truncated numbers are in the middle of those that they may have been, with
/// another rounding of either sign.
fn left_with((files, table, coarse): Of<'_>, how: How, draw: Option<(u32, f64)>) -> Option<f64> {
    let edits: Option<Vec<Edit>> = coarse.iter().map(|of| again(table, of, how, draw)).collect();
    misfit_with(files, &edits?)?.above_noise()
}

/// A step of the last digit of a column, in the unit of its name.
fn last_digit(table: &Table, of: &Coarse<'_>) -> Option<f64> {
    Some(table.unit_of(&[of.column])? * 10f64.powi(-i32::try_from(of.decimals).ok()?))
}

fn again(
    (file, table): (&'static str, &Table),
    of: &Coarse<'_>,
    how: How,
    draw: Option<(u32, f64)>,
) -> Option<Edit> {
    let step = last_digit(table, of)?;
    let read = table.numbers(of.column)?;
    let (draw, sign) = draw.unwrap_or_default();
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(draw));
    random.set_stream(of.column.bytes().map(u64::from).sum());
    let even = Uniform::new(-0.5, 0.5).ok()?;
    let mut values = vec![0.0; read.len()];
    for &row in &of.rows {
        let middle = if how == How::Truncated { 0.5 * read[row].signum() } else { 0.0 };
        values[row] = step * (middle + sign * even.sample(&mut random));
    }
    let change = Change::Add { column: of.column.to_owned(), values };
    Some(Edit { file, change })
}

fn told((file, table): (&'static str, &Table), coarse: &[Coarse<'_>]) -> Hypothesis {
    let columns: Vec<&str> = coarse.iter().map(|of| of.column).collect();
    let [Coarse { decimals, rows, .. }, ..] = coarse else { unreachable!("sets are not empty") };
    let lines: Vec<usize> = rows.iter().map(|row| table.line(*row)).collect();
    let those = if rows.len() == table.n_rows() {
        String::new()
    } else {
        format!(" in lines {}", stretches_of(&lines))
    };
    let description = format!(
        "{} of {file} {} rounded{those}, to {} (resolution too coarse, digits truncated or cut off): what is left above \
         the declared noise is what such a rounding leaves; record all digits, or declare `[noise]` with the rounding in it",
        listed(&columns),
        is_or_are(&columns),
        match decimals {
            0 => "whole numbers (integers)".to_owned(),
            1 => "one decimal".to_owned(),
            _ => format!("{decimals} decimals"),
        }
    );
    Hypothesis::of("input:rounded", (file, &columns), description, Vec::new())
}
