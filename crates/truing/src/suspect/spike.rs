//! Samples of a record that lie far from where all others do.

use super::channel::rows_left_out;
use super::hypothesis::{Hypothesis, lines_of, listed};
use super::odd::{goes_on, jumps};
use super::order::farthest;
use crate::case::Table;
use crate::measured::Fitted;

/// Spikes at most: more are a stretch.
const MOST: usize = 5;
/// Times by which the least of them is farther off than any other sample; and from which on, or where the channel or what
/// is left jumps as many times as far as anywhere else, they need not spoil the fit: of one in 200 records whose noise has
/// tails like 1/x³.
const APART: f64 = 4.0;
const CLEARLY_APART: f64 = 6.0;

/// A few readings, each of which is several times as far off as any other, in their order.
pub(super) fn far_apart(fitted: &Fitted) -> Option<Vec<usize>> {
    far_apart_by(fitted, APART)
}

fn far_apart_by(fitted: &Fitted, apart: f64) -> Option<Vec<usize>> {
    let off = |row: usize| fitted.observations[row].square().sqrt();
    let mut far = farthest(fitted, MOST + 1);
    let are_apart = |n: &usize| far.len() > *n && off(far[n - 1]) >= apart * off(far[*n]);
    let last = (1..=MOST).find(are_apart)?;
    far.truncate(last);
    far.sort_unstable();
    Some(far)
}

/// A few samples of a record, each of which is several times as far off as any other, or the farthest where a channel
/// jumps in that alone: of the one of these columns that jumps there, else of the first.
pub(crate) fn spikes(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&'static str],
    fitted: &Fitted,
) -> Option<Hypothesis> {
    let table = table.filter(|table| fitted.observations.len() == table.n_rows())?;
    let alone = |name: &&str, rows: &[usize]| {
        table.numbers(name).is_some_and(|values| jumps_there_alone(&values, rows))
    };
    let left: Vec<f64> =
        fitted.observations.iter().filter_map(|o| o.residual.first().copied()).collect();
    let of_left = || Some(vec![highest(&left)?]).filter(|one| jumps_there_alone(&left, one));
    let one = || Some(farthest(fitted, 1)).filter(|one| columns.iter().any(|of| alone(of, one)));
    let far = far_apart(fitted).or_else(of_left).or_else(one)?;
    let marked: Vec<bool> = (0..table.n_rows()).map(|row| far.contains(&row)).collect();
    let jumping = jumping(table, columns, &far);
    let are_clear = jumps_there_alone(&left, &far)
        || jumping.is_some_and(|name| {
            far_apart_by(fitted, CLEARLY_APART).is_some_and(|clear| clear == far)
                || alone(&name, &far)
        });
    let column = jumping.or_else(|| columns.first().copied())?;
    let channel = jumping.map_or_else(|| "a channel".to_owned(), |name| listed(&[name]));
    let (rows, do_not) = if far.len() == 1 { ("a row", "does not") } else { ("rows", "do not") };
    let description = format!(
        "{rows} of {file} in line {} {do_not} fit the others, by several times as much as any other: a spike of \
         {channel}, or mistyped; look there, and leave out what is wrong",
        lines_of(table, &marked)
    );
    let edits = vec![rows_left_out(file, &marked)];
    let found = Hypothesis::of("input:spike", (file, &[column]), description, edits);
    Some(if are_clear { found.clear() } else { found.unphysical() })
}

/// The column that jumps most in these rows, of those that do not go on there.
fn jumping(table: &Table, columns: &[&'static str], rows: &[usize]) -> Option<&'static str> {
    let most = |name: &&'static str| {
        let jumps = jumps(&table.numbers(name)?);
        let jumping = rows.iter().filter(|row| !goes_on(&jumps, **row));
        Some((*name, jumping.map(|row| jumps[*row]).max_by(f64::total_cmp)?))
    };
    columns.iter().filter_map(most).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name)
}

/// Where a series jumps most.
fn highest(values: &[f64]) -> Option<usize> {
    let jumps = jumps(values);
    (0..jumps.len()).max_by(|&a, &b| jumps[a].total_cmp(&jumps[b]))
}

/// Whether a series jumps in each of these rows so many times as far as anywhere else but beside them.
fn jumps_there_alone(values: &[f64], rows: &[usize]) -> bool {
    let jumps = jumps(values);
    let is_elsewhere = |row: &usize| !rows.iter().any(|spike| spike.abs_diff(*row) <= 1);
    let elsewhere = (0..jumps.len()).filter(is_elsewhere).map(|row| jumps[row]);
    let most = elsewhere.fold(0.0, f64::max);
    rows.iter().all(|row| jumps[*row] >= CLEARLY_APART * most)
}
