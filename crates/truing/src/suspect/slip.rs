//! One number written down wrong.

use super::hypothesis::{Hypothesis, listed, owned};
use crate::case::{Change, Edit, Table};
use crate::measured::Fitted;

/// What a number was multiplied by, whose point was lost or set elsewhere, or whose sign.
const FACTORS: [f64; 7] = [10.0, 100.0, 1000.0, 0.1, 0.01, 0.001, -1.0];
/// Those by which a number is far too large.
const LOST: [f64; 3] = [10.0, 100.0, 1000.0];
/// Numbers of a column looked at for that, the largest first.
const LARGEST: usize = 2;
/// A slip changes a number by at least the residual over this, and at most by as many times it: the
/// others turn a little towards a point that is far off, and a residual is but a part of what moves it.
const LIKE: f64 = 4.0;

/// One number of these columns with its decimal point or its sign wrong: of the rows given where that
/// changes it by about as much as the row is off, and the largest of each column, whatever the fit says.
pub(crate) fn slips(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    far: Option<(&Fitted, &[usize])>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let read = columns.iter().filter_map(|name| Some((*name, table.numbers(name)?)));
    let of_column = |(name, values): (&str, Vec<f64>)| {
        let mut all: Vec<(usize, f64)> =
            largest(&values).flat_map(|row| LOST.map(|factor| (row, factor))).collect();
        if let Some((fitted, rows)) = far {
            let known = rows.iter().copied().filter(|&row| row < values.len());
            all.extend(known.flat_map(|row| like(fitted, row, values[row])));
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        all.dedup();
        let of_one = |(row, factor)| slip((file, table), (name, &values), row, factor);
        all.into_iter().map(of_one).collect::<Vec<_>>()
    };
    read.flat_map(of_column).collect()
}

/// One number whose sign is wrong.
pub(crate) fn slip_of_sign(
    file: &'static str,
    table: &Table,
    (name, values): (&str, &[f64]),
    row: usize,
) -> Hypothesis {
    slip((file, table), (name, values), row, -1.0)
}

fn largest(values: &[f64]) -> impl Iterator<Item = usize> {
    let mut rows: Vec<usize> = (0..values.len()).collect();
    rows.sort_by(|&a, &b| values[b].abs().total_cmp(&values[a].abs()));
    rows.into_iter().take(LARGEST)
}

/// Factors that change a number of a row by about as much as it is off.
fn like(fitted: &Fitted, row: usize, read: f64) -> impl Iterator<Item = (usize, f64)> {
    let square = fitted.observations[row].residual.iter().map(|r| r * r).sum::<f64>();
    let off = square.sqrt();
    let is_like = move |factor: &f64| {
        let change = (read - read / factor).abs();
        change >= off / LIKE && change <= off * LIKE
    };
    FACTORS.into_iter().filter(is_like).map(move |factor| (row, factor))
}

fn slip(
    (file, table): (&'static str, &Table),
    (name, values): (&str, &[f64]),
    row: usize,
    factor: f64,
) -> Hypothesis {
    let (line, read, meant) = (table.line(row), values[row], values[row] / factor);
    let (effect, what) = if factor < 0.0 {
        ("input:sign", "has the opposite sign")
    } else {
        ("input:decimal-point", "has its decimal point in another place")
    };
    let description = format!(
        "{read} of {} in line {line} of {file} ({}) {what}: it should be {}",
        listed(&[name]),
        table.cell(row, 0),
        shortest(meant)
    );
    let columns = owned(&[name]);
    let change = Change::Scale { columns, rows: Some(vec![row]), factor: 1.0 / factor };
    let found = Hypothesis::of(effect, (file, &[name]), description, vec![Edit { file, change }]);
    Hypothesis { subject: format!("{file}: {name} in line {line}"), ..found }
}

/// Without the digits that dividing by ten adds.
fn shortest(value: f64) -> f64 {
    let rounded = format!("{value:.12e}");
    rounded.parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_was_divided_reads_as_it_was_meant() {
        assert_eq!(shortest(-1089.539 / 10.0).to_string(), "-108.9539");
        assert_eq!(shortest(0.3 / 0.001).to_string(), "300");
    }
}
