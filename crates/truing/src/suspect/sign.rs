use super::hypothesis::{Hypothesis, listed, owned, present, stretches_of};
use super::some_rows::{OPPOSITE, Rows};
use crate::case::{Change, Edit, Table};
use crate::measured::{Fitted, Observation};

/// Times the lower quartile of the residuals, the median of the sound ones where half are not, of those that lie off as
/// they do with a sign lost.
const FAR: f64 = 15.0;
/// Signs lost at least: of fewer each is a slip.
const FEWEST_LOST: usize = 3;

/// Numbers of the other sign are at most so many times as large as those of the sign that most have, and as small.
const ROOM: f64 = 1.5;
/// Share of their width by which those of one sign stay away from zero.
const APART: f64 = 0.1;

/// Columns of a table with the other sign: each alone, and all of them.
pub(crate) fn signs(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let there = present(table, columns);
    let mut sets: Vec<Vec<&str>> = there.iter().map(|column| vec![*column]).collect();
    for (i, one) in there.iter().enumerate() {
        sets.extend(there[i + 1..].iter().map(|other| vec![*one, *other]));
    }
    if there.len() > 2 {
        sets.push(there.clone());
    }
    let of_set = |set: &Vec<&str>| {
        let description = format!(
            "{} of {file} {} the opposite sign, as of a mirrored or reversed axis: multiply by −1",
            listed(set),
            if set.len() == 1 { "has" } else { "have" }
        );
        let change = Change::Scale { columns: owned(set), rows: None, factor: -1.0 };
        Hypothesis::of("input:sign", (file, set), description, vec![Edit { file, change }])
    };
    sets.iter().map(of_set).collect()
}

/// Rows of a column with the sign that fewer have, all of which lie among the others with that of the rest, and none of
/// which does as it is.
pub(super) fn signs_of_the_fewer(
    file: &'static str,
    table: &Table,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let of_column = |column: &str| {
        let values = table.numbers(column)?;
        let (below, above): (Vec<usize>, Vec<usize>) =
            (0..values.len()).filter(|&row| values[row] != 0.0).partition(|&row| values[row] < 0.0);
        let (few, most) = if below.len() < above.len() { (below, above) } else { (above, below) };
        let sizes = || most.iter().map(|&row| values[row].abs());
        let (least, largest) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
        let is_among = |row: &usize| {
            let size = values[*row].abs();
            (least / ROOM..=largest * ROOM).contains(&size)
        };
        // What goes through zero has small numbers on either side of it.
        let lie_apart = least > 0.0 && least > APART * (largest - least);
        if few.len() < FEWEST_LOST || !few.iter().all(is_among) || !lie_apart {
            return None;
        }
        let rows = Rows { file, table, these: few };
        Some(rows.scaled("input:sign", (&[column], OPPOSITE), -1.0))
    };
    columns.iter().filter_map(|column| of_column(column)).collect()
}

/// Columns without any sign, negative in the rows that lie far off: of these the minus signs are lost.
pub(crate) fn minus_lost(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let Some((table, fitted)) = table.zip(fitted) else { return Vec::new() };
    let squares: Vec<f64> = fitted.observations.iter().map(Observation::square).collect();
    let mut sorted = squares.clone();
    sorted.sort_by(f64::total_cmp);
    let Some(quartile) = sorted.get(sorted.len() / 4).filter(|_| squares.len() == table.n_rows())
    else {
        return Vec::new();
    };
    let is_far = |row: &usize| squares[*row] > FAR * FAR * quartile;
    let far: Vec<usize> = (0..squares.len()).filter(is_far).collect();
    let of_column = |column: &str| {
        let is_unsigned = table.numbers(column)?.iter().all(|value| *value >= 0.0);
        if !is_unsigned || far.len() < FEWEST_LOST {
            return None;
        }
        let lines: Vec<usize> = far.iter().map(|row| table.line(*row)).collect();
        let description = format!(
            "`{column}` of {file} has no sign, and lost its minus (absolute values) in lines {}: multiply by −1 there",
            stretches_of(&lines)
        );
        let rows = Some(far.clone());
        let change = Change::Scale { columns: owned(&[column]), rows, factor: -1.0 };
        let edits = vec![Edit { file, change }];
        Some(Hypothesis::of("input:sign", (file, &[column]), description, edits))
    };
    present(Some(table), columns).into_iter().filter_map(of_column).collect()
}
