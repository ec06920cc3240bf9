//! Numbers written down wrong.

use super::hypothesis::{Hypothesis, listed, owned, present};
use super::odd::{goes_on, jumps};
use super::written::{digits_exchanged, shortest};
use crate::case::{Change, Edit, Table};
use crate::measured::Fitted;

/// What a number was multiplied by, whose point was lost or set elsewhere, or whose sign.
const FACTORS: [f64; 7] = [10.0, 100.0, 1000.0, 0.1, 0.01, 0.001, -1.0];
/// Those by which a number is far too large.
const LOST: [f64; 3] = [10.0, 100.0, 1000.0];
/// Numbers of a column looked at for that, the largest first.
const LARGEST: usize = 2;
/// A slip changes a number by at least the residual over the first, as the others turn a little towards a point that is
/// far off, and at most by the second times it, as along a flat surface a residual is a small part of what moves it.
const LIKE: [f64; 2] = [4.0, 20.0];
/// Numbers of a column without their point lie apart from the others by a factor of this.
const APART: f64 = 4.0;
/// A number with its point put back is at most so many times as large as the largest of the others.
const ROOM: f64 = 2.0;
/// Share of the width of the others beyond which a number with its point put back does not lie.
const BEYOND: f64 = 0.1;
/// Most places by which a point is looked for.
const MOST_PLACES: i32 = 6;
/// Lines listed of those in which numbers are wrong.
const MOST_LINES: usize = 8;
/// Places by which a number in µm is too large for mm.
const THOUSANDS: i32 = 3;

/// One number of these columns with its decimal point or its sign wrong, or two of its digits exchanged: of the rows
/// given where that changes it by about as much as the row is off, and the largest of each column with its point lost,
/// whatever the fit says. Of a record, a number that goes on as those before and after it do is not wrong.
pub(super) fn slips(
    (file, table): (&'static str, Option<&Table>),
    columns: &[&str],
    is_record: bool,
    far: Option<(&Fitted, &[usize])>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let read = columns.iter().filter_map(|name| Some((*name, table.numbers(name)?)));
    let of_column = |(name, values): (&str, Vec<f64>)| {
        let lost = |row: usize| LOST.map(|factor| (row, Wrong::Point, values[row] / factor));
        let mut all: Vec<(usize, Wrong, f64)> = largest(&values).flat_map(lost).collect();
        all.extend(
            beyond_others(&values).into_iter().flat_map(|row| may_be_meant(row, values[row])),
        );
        if let Some((fitted, rows)) = far {
            let known = rows.iter().copied().filter(|&row| row < values.len());
            all.extend(known.flat_map(|row| like(fitted, row, values[row])));
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.2.total_cmp(&b.2)));
        all.dedup_by(|a, b| a.0 == b.0 && a.2.total_cmp(&b.2).is_eq());
        let jumps = if is_record { jumps(&values) } else { Vec::new() };
        all.retain(|(row, ..)| !goes_on(&jumps, *row));
        let of_one = |(row, wrong, meant)| {
            let is_known = far.is_some_and(|(_, rows)| rows.contains(&row));
            let is_free = is_known && !matches!(wrong, Wrong::Point);
            let may_be = values[row] != 0.0 && (is_free || is_among_others(&values, row, meant));
            may_be.then(|| slip((file, table), (name, values[row]), row, (wrong, meant)))
        };
        all.into_iter().filter_map(of_one).collect::<Vec<_>>()
    };
    let mut all: Vec<Hypothesis> = read.flat_map(of_column).collect();
    all.extend(points_lost(file, Some(table), columns));
    all
}

/// Several numbers of a column, or of all columns, without their decimal point: they lie apart from the
/// others by powers of ten.
pub(crate) fn points_lost(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let there = present(Some(table), columns);
    let of_column = |name: &&str| {
        let lost = |(rows, places)| Lost { column: (*name).to_owned(), rows, places };
        let found: Vec<Lost> = apart(&table.numbers(name)?).into_iter().map(lost).collect();
        (!found.is_empty()).then_some(found)
    };
    let found: Vec<Vec<Lost>> = there.iter().filter_map(of_column).collect();
    let mut all = Vec::new();
    if found.len() > 1 {
        let of_all: Vec<Lost> = found.iter().map(|gaps| gaps[0].clone()).collect();
        let most = of_all.iter().map(|lost| lost.places).max().unwrap_or(1);
        let as_many: Vec<Lost> =
            of_all.iter().map(|lost| Lost { places: most, ..lost.clone() }).collect();
        all.push(of_lost(file, table, &of_all));
        if of_all.iter().any(|lost| lost.places < most) {
            all.push(of_lost(file, table, &as_many));
        }
    }
    for lost in found.iter().flatten() {
        let one_more = Lost { places: lost.places + 1, ..lost.clone() };
        all.push(of_lost(file, table, std::slice::from_ref(lost)));
        all.push(of_lost(file, table, &[one_more]));
    }
    all
}

/// Numbers of a column that have lost their point.
#[derive(Clone)]
struct Lost {
    column: String,
    rows: Vec<usize>,
    /// Places by which it is too far to the right.
    places: i32,
}

/// The rows, two at least and the fewer, whose numbers lie apart from all others by a factor, and by how many
/// places their points are too far to the right at least: above the first such gap, and above the widest.
fn apart(values: &[f64]) -> Vec<(Vec<usize>, i32)> {
    let n = values.len();
    let mut sorted: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let gap = |first: usize| sorted[first] / sorted[first - 1];
    let is_gap = |first: &usize| sorted[first - 1] > 0.0 && gap(*first) >= APART;
    let gaps: Vec<usize> = (n / 2 + 1..n.saturating_sub(1)).filter(is_gap).collect();
    let widest = gaps.iter().copied().max_by(|&a, &b| gap(a).total_cmp(&gap(b)));
    let mut firsts: Vec<usize> = gaps.first().copied().into_iter().chain(widest).collect();
    firsts.dedup();
    let of_gap = |first: usize| {
        let below = sorted[first - 1];
        let places = (sorted[n - 1] / (ROOM * below)).log10().ceil().max(1.0);
        let rows = (0..n).filter(|&row| values[row].abs() > below).collect();
        #[expect(clippy::cast_possible_truncation, reason = "between one and six")]
        (places <= f64::from(MOST_PLACES)).then_some((rows, places as i32))
    };
    firsts.into_iter().filter_map(of_gap).collect()
}

fn of_lost(file: &'static str, table: &Table, found: &[Lost]) -> Hypothesis {
    let names: Vec<&str> = found.iter().map(|lost| lost.column.as_str()).collect();
    let of_column = |lost: &Lost| {
        let lines: Vec<String> =
            lost.rows.iter().take(MOST_LINES).map(|row| table.line(*row).to_string()).collect();
        let more = if lost.rows.len() > MOST_LINES { " and more" } else { "" };
        format!(
            "{} numbers of `{}` by {} places in the lines {}{more}",
            lost.rows.len(),
            lost.column,
            lost.places,
            lines.join(", ")
        )
    };
    let said: Vec<String> = found.iter().map(of_column).collect();
    // What is a thousand times as large may be in another unit as well.
    let is_thousands = found.iter().all(|lost| lost.places == THOUSANDS);
    let unit =
        if is_thousands { ", or are in a unit a thousand times smaller (µm for mm)" } else { "" };
    let description = format!(
        "numbers of {file} have lost their decimal point (a comma?), which stands too far to the right{unit}: {}; \
         divide them by so many powers of ten",
        said.join(", ")
    );
    let edit = |lost: &Lost| {
        let columns = vec![lost.column.clone()];
        let factor = 10_f64.powi(-lost.places);
        Edit { file, change: Change::Scale { columns, rows: Some(lost.rows.clone()), factor } }
    };
    let edits = found.iter().map(edit).collect();
    Hypothesis::of("input:decimal-point", (file, &names), description, edits)
}

/// One number whose sign is wrong.
pub(crate) fn slip_of_sign(
    file: &'static str,
    table: &Table,
    (name, values): (&str, &[f64]),
    row: usize,
) -> Hypothesis {
    slip((file, table), (name, values[row]), row, (Wrong::Sign, -values[row]))
}

/// What may be wrong with one number.
#[derive(Clone, Copy)]
enum Wrong {
    Point,
    Sign,
    Digits,
}

fn largest(values: &[f64]) -> impl Iterator<Item = usize> {
    let mut rows: Vec<usize> = (0..values.len()).collect();
    rows.sort_by(|&a, &b| values[b].abs().total_cmp(&values[a].abs()));
    rows.into_iter().take(LARGEST)
}

/// Whether a number lies where the others of its column do.
fn is_among_others(values: &[f64], row: usize, meant: f64) -> bool {
    let others = || (0..values.len()).filter(|other| *other != row).map(|other| values[other]);
    let (low, high) =
        (others().fold(f64::INFINITY, f64::min), others().fold(f64::NEG_INFINITY, f64::max));
    let beyond = BEYOND * (high - low);
    (low - beyond..=high + beyond).contains(&meant)
}

/// The numbers at either end of a column that lie apart from all others.
fn beyond_others(values: &[f64]) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..values.len()).collect();
    rows.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let [Some(&low), Some(&high)] = [rows.first(), rows.last()] else { return Vec::new() };
    [low, high].into_iter().filter(|&row| !is_among_others(values, row, values[row])).collect()
}

/// What may have been meant by a number of a row, of what changes it by about as much as it is off.
fn like(
    fitted: &Fitted,
    row: usize,
    read: f64,
) -> impl Iterator<Item = (usize, Wrong, f64)> + use<> {
    let off = fitted.observations[row].square().sqrt();
    let is_like = move |(_, _, meant): &(usize, Wrong, f64)| {
        let change = (read - meant).abs();
        change >= off / LIKE[0] && change <= off * LIKE[1]
    };
    may_be_meant(row, read).filter(is_like)
}

/// What may have been meant by a number of a row: with its point, its sign or two of its digits otherwise.
fn may_be_meant(row: usize, read: f64) -> impl Iterator<Item = (usize, Wrong, f64)> + use<> {
    let of_factor =
        move |factor: f64| (if factor < 0.0 { Wrong::Sign } else { Wrong::Point }, read / factor);
    let digits = digits_exchanged(read).into_iter().map(|meant| (Wrong::Digits, meant));
    FACTORS.into_iter().map(of_factor).chain(digits).map(move |(wrong, meant)| (row, wrong, meant))
}

fn slip(
    (file, table): (&'static str, &Table),
    (name, read): (&str, f64),
    row: usize,
    (wrong, meant): (Wrong, f64),
) -> Hypothesis {
    let line = table.line(row);
    let (effect, what) = match wrong {
        Wrong::Sign => ("input:sign", "has the opposite sign"),
        Wrong::Point => ("input:decimal-point", "has its decimal point in another place"),
        Wrong::Digits => ("input:digits", "is written with two digits exchanged (a typing slip)"),
    };
    let description = format!(
        "{read} of {} in line {line} of {file} ({}) {what}: it should be {}",
        listed(&[name]),
        table.cell(row, 0),
        shortest(meant)
    );
    let columns = owned(&[name]);
    let change = Change::Scale { columns, rows: Some(vec![row]), factor: meant / read };
    let found = Hypothesis::of(effect, (file, &[name]), description, vec![Edit { file, change }]);
    Hypothesis { subject: format!("{file}: {name} in line {line}"), ..found }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_without_their_point_lie_apart() {
        let mut values: Vec<f64> = (0..40).map(|i| 200.0 * (f64::from(i) * 0.37).sin()).collect();
        assert!(apart(&values).is_empty());
        for row in [4, 17, 30] {
            values[row] *= 1000.0;
        }
        assert_eq!(apart(&values)[0], (vec![4, 17, 30], 3));
    }
}
