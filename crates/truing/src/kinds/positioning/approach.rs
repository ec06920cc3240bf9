//! Which way an axis came, and names of readings that repeat a place.

use std::cmp::Ordering;
use std::collections::HashMap;

use ft_center::Approach;

use crate::Error;
use crate::case::{Columns, Table};

pub(super) const POSITIONS: &str = "positions.csv";
/// Whether a target was come to from below or from above.
pub(super) const DIRECTION: &str = "direction";

/// Words for the direction of approach.
const WORDS: [(&str, Option<Approach>); 19] = [
    ("1", Some(Approach::Rising)),
    ("+1", Some(Approach::Rising)),
    ("1.0", Some(Approach::Rising)),
    ("+", Some(Approach::Rising)),
    ("up", Some(Approach::Rising)),
    ("rising", Some(Approach::Rising)),
    ("forward", Some(Approach::Rising)),
    ("positive", Some(Approach::Rising)),
    ("↑", Some(Approach::Rising)),
    ("-1", Some(Approach::Falling)),
    ("−1", Some(Approach::Falling)),
    ("-1.0", Some(Approach::Falling)),
    ("-", Some(Approach::Falling)),
    ("down", Some(Approach::Falling)),
    ("falling", Some(Approach::Falling)),
    ("backward", Some(Approach::Falling)),
    ("reverse", Some(Approach::Falling)),
    ("negative", Some(Approach::Falling)),
    ("↓", Some(Approach::Falling)),
];

/// Whether a column `direction` says of every row which way the axis came.
pub(crate) fn has_directions(table: &Table) -> bool {
    let is_word = |cell: &str| WORDS.iter().any(|(word, _)| *word == cell);
    table
        .column(DIRECTION)
        .is_some_and(|column| (0..table.n_rows()).all(|row| is_word(table.cell(row, column))))
}

/// The column `direction`.
pub(crate) fn approaches(columns: &mut Columns<'_>) -> Result<Vec<Option<Approach>>, Error> {
    columns.words(DIRECTION, &WORDS, None)
}

/// What one cell of the column `direction` says.
pub(super) fn approach_of(cell: &str) -> Option<Approach> {
    WORDS.iter().find(|(word, _)| *word == cell).and_then(|(_, approach)| *approach)
}

/// From the target before; the first, and those that stay, as they go on.
pub(crate) fn derived(targets: &[f64]) -> Vec<Option<Approach>> {
    let coming = |i: usize| {
        let before = i.checked_sub(1).and_then(|before| way(targets[before], targets[i]));
        before.or_else(|| way(targets[i], *targets.get(i + 1)?))
    };
    (0..targets.len()).map(coming).collect()
}

/// Which way it is from one target to the next.
pub(super) fn way(from: f64, to: f64) -> Option<Approach> {
    match to.total_cmp(&from) {
        Ordering::Greater => Some(Approach::Rising),
        Ordering::Less => Some(Approach::Falling),
        Ordering::Equal => None,
    }
}

/// Names of which each occurs once: with the line of the table where one recurs.
pub(crate) fn names_of(given: &[String], lines: &[usize]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for name in given {
        *counts.entry(name).or_default() += 1;
    }
    let name = |(name, line): (&String, &usize)| match counts[name.as_str()] {
        1 => name.clone(),
        _ => format!("{name}, line {line}"),
    };
    given.iter().zip(lines).map(name).collect()
}
