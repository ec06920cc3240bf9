//! Samples of a record that lie far from where all others do.

use super::channel::rows_left_out;
use super::hypothesis::{Hypothesis, lines_of};
use crate::case::Table;
use crate::measured::Fitted;

/// Spikes at most: more are a stretch.
const MOST: usize = 5;
/// Times by which the least of them is farther off than any other sample.
const APART: f64 = 4.0;

/// A few samples of a record, each of which is several times as far off as any other.
pub(crate) fn spikes(
    file: &'static str,
    table: Option<&Table>,
    column: &str,
    fitted: &Fitted,
) -> Option<Hypothesis> {
    let table = table.filter(|table| fitted.observations.len() == table.n_rows())?;
    let off: Vec<f64> = fitted.observations.iter().map(|o| o.square().sqrt()).collect();
    let mut sorted = off.clone();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let apart = |n: &usize| sorted.get(*n).is_some_and(|next| sorted[n - 1] >= APART * next);
    let last = (1..=MOST).find(apart)?;
    let marked: Vec<bool> = off.iter().map(|square| *square >= sorted[last - 1]).collect();
    let (rows, do_not) = if last == 1 { ("a row", "does not") } else { ("rows", "do not") };
    let description = format!(
        "{rows} of {file} in line {} {do_not} fit the others, by several times as much as any other: a spike of a \
         channel, or mistyped; look there, and leave out what is wrong",
        lines_of(table, &marked)
    );
    let edits = vec![rows_left_out(file, &marked)];
    Some(Hypothesis::of("input:spike", (file, &[column]), description, edits).unphysical())
}
