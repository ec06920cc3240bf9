//! Samples of a record that lie far from where all others do.

use super::channel::rows_left_out;
use super::hypothesis::{Hypothesis, lines_of};
use super::order::farthest;
use crate::case::Table;
use crate::measured::Fitted;

/// Spikes at most: more are a stretch.
const MOST: usize = 5;
/// Times by which the least of them is farther off than any other sample.
const APART: f64 = 4.0;

/// A few readings, each of which is several times as far off as any other, in their order.
pub(super) fn far_apart(fitted: &Fitted) -> Option<Vec<usize>> {
    let off = |row: usize| fitted.observations[row].square().sqrt();
    let mut far = farthest(fitted, MOST + 1);
    let apart = |n: &usize| far.len() > *n && off(far[n - 1]) >= APART * off(far[*n]);
    let last = (1..=MOST).find(apart)?;
    far.truncate(last);
    far.sort_unstable();
    Some(far)
}

/// A few samples of a record, each of which is several times as far off as any other.
pub(crate) fn spikes(
    file: &'static str,
    table: Option<&Table>,
    column: &str,
    fitted: &Fitted,
) -> Option<Hypothesis> {
    let table = table.filter(|table| fitted.observations.len() == table.n_rows())?;
    let far = far_apart(fitted)?;
    let marked: Vec<bool> = (0..table.n_rows()).map(|row| far.contains(&row)).collect();
    let (rows, do_not) = if far.len() == 1 { ("a row", "does not") } else { ("rows", "do not") };
    let description = format!(
        "{rows} of {file} in line {} {do_not} fit the others, by several times as much as any other: a spike of a \
         channel, or mistyped; look there, and leave out what is wrong",
        lines_of(table, &marked)
    );
    let edits = vec![rows_left_out(file, &marked)];
    Some(Hypothesis::of("input:spike", (file, &[column]), description, edits).unphysical())
}
