use super::hypothesis::{Hypothesis, is_or_are, listed, present};
use super::unit::all_and_each;
use crate::case::{Change, Edit, Table};

/// Columns that give each row as a difference from the one before, in runs of rows (none: the whole table): all,
/// and each alone.
pub(crate) fn increments(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    runs: &[Vec<usize>],
) -> Vec<Hypothesis> {
    let there = present(table, columns);
    let Some(table) = table else { return Vec::new() };
    let summed = |column: &&str| {
        let mut values = table.numbers(column)?;
        let whole = [(0..values.len()).collect()];
        for run in if runs.is_empty() { &whole } else { runs } {
            for pair in run.windows(2) {
                values[pair[1]] += values[pair[0]];
            }
        }
        Some(Edit { file, change: Change::Replace { column: (*column).to_owned(), values } })
    };
    let of_set = |set: Vec<&str>| {
        let edits: Option<Vec<Edit>> = set.iter().map(summed).collect();
        let description = format!(
            "{} of {file} {} relative, each row a difference (increment) from the row before, as in G91: add them up",
            listed(&set),
            is_or_are(&set)
        );
        Some(Hypothesis::of("input:increments", (file, &set), description, edits?))
    };
    all_and_each(&there).into_iter().filter_map(of_set).collect()
}
