//! Samples of a record that lie far from where all others do.

use model_discrepancy::chance_as_far;

use super::channel::rows_left_out;
use super::hypothesis::{Hypothesis, lines_of, listed};
use super::odd::{from_the_middle, goes_on, heights, jumps};
use super::order::farthest;
use crate::case::Table;
use crate::count::rms;
use crate::measured::Fitted;

/// Spikes at most: more are a stretch.
const MOST: usize = 5;
/// Times by which the least of them is farther off than any other sample; and from which on, or where the channel or what
/// is left jumps as many times as far as anywhere else, they need not spoil the fit: of one in 200 records whose noise has
/// tails like 1/x³.
const APART: f64 = 4.0;
const CLEARLY_APART: f64 = 6.0;
/// Chance of noise below which a sample is a spike, and above which it may be none: once in a thousand records, and in 250.
const NO_NOISE: f64 = 1e-3;
const MAY_BE_NOISE: f64 = 4e-3;
/// Times by which one sample is farther off than any other where the law of all others says the same, and where a channel
/// does.
const FARTHER_BY_LAW: f64 = 3.0;
const FARTHER: f64 = 2.0;

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
/// jumps in that alone: of the one of these columns that jumps there, else of any.
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
    let of_left = || Some(vec![highest(&left)?]).filter(|one| stands_out(&left, one));
    let is_no_noise =
        |one: &Vec<usize>| chance_of_noise(&left, one).is_some_and(|chance| chance <= NO_NOISE);
    let one = |apart: f64| far_apart_by(fitted, apart).filter(|rows| rows.len() == 1);
    let by_law = || one(FARTHER_BY_LAW).filter(is_no_noise);
    let by_channel = || one(FARTHER).filter(|rows| columns.iter().any(|of| alone(of, rows)));
    let far = far_apart(fitted).or_else(of_left).or_else(by_law).or_else(by_channel)?;
    let marked: Vec<bool> = (0..table.n_rows()).map(|row| far.contains(&row)).collect();
    let jumping = jumping(table, columns, &far);
    let of_noise = chance_of_noise(&left, &far);
    if of_noise.is_some_and(|chance| chance > MAY_BE_NOISE) {
        return None;
    }
    let are_clear = stands_out(&left, &far)
        || of_noise.is_some_and(|chance| chance <= NO_NOISE)
        || jumping.is_some_and(|name| {
            far_apart_by(fitted, CLEARLY_APART).is_some_and(|clear| clear == far)
                || alone(&name, &far)
        });
    let channel = jumping.map_or_else(|| "a channel".to_owned(), |name| listed(&[name]));
    let of: &[&str] = jumping.as_ref().map_or(columns, std::slice::from_ref);
    let (rows, do_not) = if far.len() == 1 { ("a row", "does not") } else { ("rows", "do not") };
    let description = format!(
        "{rows} of {file} in line {} {do_not} fit the others, by several times as much as any other: a spike of \
         {channel}, or mistyped; look there, and leave out what is wrong",
        lines_of(table, &marked)
    );
    let edits = vec![rows_left_out(file, &marked)];
    let found = Hypothesis::of("input:spike", (file, of), description, edits);
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
    let heights = heights(values);
    (0..heights.len()).max_by(|&a, &b| heights[a].total_cmp(&heights[b]))
}

/// Whether a series jumps in each of these rows so many times as far as anywhere else but beside them.
fn jumps_there_alone(values: &[f64], rows: &[usize]) -> bool {
    let heights = heights(values);
    let most = elsewhere(&heights, rows).fold(0.0, f64::max);
    rows.iter().all(|row| heights[*row] > 0.0 && heights[*row] >= CLEARLY_APART * most)
}

/// The same, and by several times what it is off by elsewhere: of what is smooth a corner is the only jump.
fn stands_out(left: &[f64], rows: &[usize]) -> bool {
    let heights = heights(left);
    let usual = rms(elsewhere(left, rows));
    jumps_there_alone(left, rows) && rows.iter().all(|row| heights[*row] >= APART * usual)
}

/// Chance that noise of the law which all others show puts any as far from the middle of both beside it as the least of
/// these rows; `None` where one of them lies between both.
fn chance_of_noise(left: &[f64], rows: &[usize]) -> Option<f64> {
    let off = from_the_middle(left);
    let heights = heights(left);
    let others: Vec<f64> = elsewhere(&off, rows).collect();
    let least = rows.iter().map(|row| off[*row].abs()).fold(f64::INFINITY, f64::min);
    rows.iter().all(|row| heights[*row] > 0.0).then(|| chance_as_far(&others, least))
}

/// The values of all rows but these and those beside them.
fn elsewhere<'v>(values: &'v [f64], rows: &'v [usize]) -> impl Iterator<Item = f64> + 'v {
    let is_elsewhere = |row: &usize| !rows.iter().any(|spike| spike.abs_diff(*row) <= 1);
    (0..values.len()).filter(is_elsewhere).map(|row| values[row])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::count;

    const ROWS: usize = 60;

    #[test]
    fn what_fits_without_noise_has_no_spike() {
        assert!(!stands_out(&[0.0; ROWS], &[30]));
        // A lag along a ramp up and down: one corner, and no other jump.
        let corner: Vec<f64> = (0..ROWS).map(|i| 30.0 - (count(i) - 30.0).abs()).collect();
        assert_eq!(highest(&corner), Some(30));
        assert!(jumps_there_alone(&corner, &[30]));
        assert!(!stands_out(&corner, &[30]));
    }

    #[test]
    fn a_spike_on_a_drift_stands_out() {
        let mut left: Vec<f64> = (0..ROWS).map(|i| 0.03 * count(i) + 0.1 * count(i % 2)).collect();
        left[20] += 9.0;
        assert_eq!(highest(&left), Some(20));
        assert!(stands_out(&left, &[20]));
    }
}
