use super::hypothesis::{Hypothesis, Proof, listed, owned, pairs, present};
use super::label::labels_of;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use crate::case::{Change, Edit, Order, Table};
use crate::measured::Fitted;

/// Rows in which targets must come again before they are known by it.
const FEWEST_TARGETS: usize = 8;

/// Different values of two columns that read the same, from which on it is no accident.
const FEWEST_COPIED: usize = 5;

/// Two columns of a table exchanged, every pair of those given.
pub(crate) fn exchanges(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let of_pair = |pair: [&str; 2]| {
        let description = format!(
            "the columns {} of {file} are exchanged (swapped): exchange their headings",
            listed(&pair)
        );
        let sources = owned(&[pair[1], pair[0]]);
        let change = Change::Permute { columns: owned(&pair), sources, rows: None };
        Hypothesis::of("input:exchanged", (file, &pair), description, vec![Edit { file, change }])
    };
    pairs(&present(table, columns)).map(of_pair).collect()
}

/// Two columns that read the same in every row, as a design may ask for and no two readings do.
fn copied(file: &'static str, table: &Table, pair: [&str; 2]) -> Option<Hypothesis> {
    let (mut one, other) = (table.numbers(pair[0])?, table.numbers(pair[1])?);
    let is_same = one.iter().zip(&other).all(|(a, b)| a.total_cmp(b).is_eq());
    one.sort_by(f64::total_cmp);
    one.dedup();
    if !is_same || one.len() < FEWEST_COPIED {
        return None;
    }
    let description = format!(
        "the columns {} of {file} read the same in all {} rows: one was copied over the other; put \
         back its own values",
        listed(&pair),
        other.len()
    );
    Some(Hypothesis::of("input:copied", (file, &pair), description, Vec::new()))
}

/// Columns of which two read the same in every row, with what that proves: of channels that are measured
/// no two do, of places on a diagonal they may.
pub(crate) fn copies(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    proof: Proof,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let there = present(Some(table), columns);
    let found = pairs(&there).filter_map(|pair| copied(file, table, pair));
    found.map(|found| Hypothesis { proof, ..found }).collect()
}

/// Times as many different deviations as targets.
const MANY_MORE: usize = 4;

/// Targets and what was reached under each other's names: targets come again to the last digit, and
/// not at once, as a reading does that is coarser than the steps.
pub(crate) fn exchanged_targets(
    file: &'static str,
    table: Option<&Table>,
    [target, reached]: [&str; 2],
) -> Option<Hypothesis> {
    let distinct = |name: &str| {
        let mut values = table?.numbers(name)?;
        let n = values.len();
        let at_once = values.windows(2).filter(|pair| pair[0].total_cmp(&pair[1]).is_eq()).count();
        values.sort_by(f64::total_cmp);
        values.dedup();
        (n >= FEWEST_TARGETS && 4 * at_once <= n).then_some((values.len(), n))
    };
    let ((targets, n), (reached_at, _)) = (distinct(target)?, distinct(reached)?);
    let is_exchanged = targets == n && 2 * reached_at <= n;
    let mut found = exchanges(file, table, &[target, reached]).pop().filter(|_| is_exchanged)?;
    found.description += ", as those of `";
    found.description += target;
    found.description += "` never come again and those of the other do";
    Some(found.certain())
}

/// Targets and deviations under each other's names: all of the one come again to the last digit, twice and more, and
/// of the other there are many times as many.
pub(crate) fn exchanged_deviations(
    file: &'static str,
    table: &Table,
    [target, read]: [&str; 2],
) -> Option<Hypothesis> {
    let visits = |name: &str| {
        let mut values = table.numbers(name)?;
        values.sort_by(f64::total_cmp);
        let visits: Vec<usize> =
            values.chunk_by(|a, b| a.total_cmp(b).is_eq()).map(<[f64]>::len).collect();
        Some((visits.len(), visits.into_iter().min()?))
    };
    let ((targets, _), (read_at, fewest)) = (visits(target)?, visits(read)?);
    let is_exchanged =
        table.n_rows() >= FEWEST_TARGETS && fewest >= 2 && targets >= MANY_MORE * read_at;
    let mut found = exchanges(file, Some(table), &[target, read]).pop().filter(|_| is_exchanged)?;
    found.description = format!(
        "{}, as every number of `{read}` comes again to the last digit, which targets do",
        found.description
    );
    Some(found.certain())
}

/// Three columns of a table permuted in a circle, either way round.
pub(crate) fn cycles(
    file: &'static str,
    table: Option<&Table>,
    columns: [&str; 3],
) -> Vec<Hypothesis> {
    if present(table, &columns).len() < 3 {
        return Vec::new();
    }
    let one = |by: usize| {
        let sources: Vec<&str> = (0..3).map(|i| columns[(i + by) % 3]).collect();
        let description = format!(
            "the columns {} of {file} are exchanged (permuted) in a circle: their headings should \
             be {}",
            listed(&columns),
            listed(&(0..3).map(|i| columns[(i + 3 - by) % 3]).collect::<Vec<_>>())
        );
        let sources = owned(&sources);
        let change = Change::Permute { columns: owned(&columns), sources, rows: None };
        Hypothesis::of(
            "input:exchanged",
            (file, &columns),
            description,
            vec![Edit { file, change }],
        )
    };
    [1, 2].map(one).to_vec()
}

/// Some columns of a table one row further down or up than the others, or in reverse order.
pub(crate) fn rows_shifted(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    within: Option<&str>,
) -> Vec<Hypothesis> {
    let mut all = rows_shifted_by(file, table, columns, within, 1);
    all.extend(rows_shifted_by(file, table, columns, within, -1));
    let there = present(table, columns);
    let Some(table) = table.filter(|t| !there.is_empty() && t.n_rows() > 2) else { return all };
    let order = Order::Reversed(table.n_rows());
    let change = Change::Rows { columns: owned(&there), order };
    let description = format!(
        "the rows of {} of {file} are in reverse order against the other columns: turn them round",
        listed(&there)
    );
    let edits = vec![Edit { file, change }];
    all.push(Hypothesis::of("input:row-shift", (file, &there), description, edits));
    all
}

/// Some columns of a table in the order of its labels sorted as text, where the labels are not.
pub(crate) fn sorted_as_text(
    file: &'static str,
    table: Option<&Table>,
    label: &str,
    columns: &[&str],
) -> Option<Hypothesis> {
    let (table, at) = table.and_then(|table| Some((table, table.column(label)?)))?;
    let labels: Vec<&str> = (0..table.n_rows()).map(|row| table.cell(row, at)).collect();
    let said =
        format!("`{label}`, sorted as text (a permutation of labels): sort them as the labels are");
    as_text((file, table), columns, &labels, &said)
}

/// The same in the order of the numbers of its rows sorted as text: 1, 10, 11, …
pub(super) fn sorted_as_row_numbers(
    file: &'static str,
    table: &Table,
    columns: &[&str],
) -> Option<Hypothesis> {
    let numbers: Vec<String> = (1..=table.n_rows()).map(|row| row.to_string()).collect();
    let labels: Vec<&str> = numbers.iter().map(String::as_str).collect();
    let said = "the other columns, that of the row numbers sorted as text (1, 10, 11, …): sort them by number";
    as_text((file, table), columns, &labels, said)
}

fn as_text(
    (file, table): (&'static str, &Table),
    columns: &[&str],
    labels: &[&str],
    said: &str,
) -> Option<Hypothesis> {
    let there = present(Some(table), columns);
    let mut sorted = labels.to_vec();
    sorted.sort_unstable();
    let is_distinct = sorted.windows(2).all(|pair| pair[0] != pair[1]);
    if there.is_empty() || !is_distinct || sorted == labels {
        return None;
    }
    let order = labels.iter().filter_map(|name| sorted.binary_search(name).ok()).collect();
    let change = Change::Rows { columns: owned(&there), order: Order::Listed(order) };
    let description = format!("{} of {file} stand in another order than {said}", listed(&there));
    let edits = vec![Edit { file, change }];
    Some(Hypothesis::of("input:labels", (file, &there), description, edits))
}

/// Some columns of a table so many rows further down than the others, or up where that is negative; rows
/// that have lost their partner go, or take those that fell off at the other end.
pub(crate) fn rows_shifted_by(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    within: Option<&str>,
    by: isize,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let said = if within.is_some() { " within each block" } else { "" };
    blocks_shifted((file, table), columns, (&blocks(table, within), said), by)
}

/// The same of these blocks of a table, which a description says.
pub(crate) fn blocks_shifted(
    (file, table): (&'static str, &Table),
    columns: &[&str],
    (blocks, said): (&[Range<usize>], &str),
    by: isize,
) -> Vec<Hypothesis> {
    let there = present(Some(table), columns);
    let far = by.unsigned_abs();
    if there.is_empty() || blocks.iter().all(|block| block.len() <= far + 1) {
        return Vec::new();
    }
    let description = format!(
        "the rows of {} of {file} are shifted {} {}{said} against the other columns: shift them back",
        listed(&there),
        if far == 1 { "one row".to_owned() } else { format!("{far} rows") },
        if by > 0 { "down" } else { "up" },
    );
    let is_lost = |row: usize| {
        let of_block = |Range { start, end }: &Range<usize>| {
            (*start..*end).contains(&row)
                && if by > 0 { row + far >= *end } else { row < *start + far }
        };
        blocks.iter().any(of_block)
    };
    let rows = (0..table.n_rows()).filter(|&row| !is_lost(row)).collect();
    let blocks = Arc::from(blocks);
    let order = Order::Rolled { blocks, by };
    let rolled = Edit { file, change: Change::Rows { columns: owned(&there), order } };
    let kept = Edit { file, change: Change::Keep { rows } };
    [vec![rolled.clone()], vec![rolled, kept]]
        .map(|edits| Hypothesis::of("input:row-shift", (file, &there), description.clone(), edits))
        .to_vec()
}

/// Some columns exchanged between two blocks of as many rows, every pair of the first `most`.
pub(crate) fn exchanged_blocks(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    within: &str,
    most: usize,
) -> Vec<Hypothesis> {
    let there = present(table, columns);
    let Some((table, names)) =
        table.filter(|_| !there.is_empty()).and_then(|t| Some((t, t.column(within)?)))
    else {
        return Vec::new();
    };
    let blocks = blocks(table, Some(within));
    let blocks = &blocks[..blocks.len().min(most)];
    let mut all = Vec::new();
    for (i, one) in blocks.iter().enumerate() {
        for other in blocks[i + 1..].iter().filter(|other| other.len() == one.len()) {
            let description = format!(
                "the values of {} of {file} in `{}` and `{}` of `{within}` are exchanged (swapped \
                 labels): exchange them",
                listed(&there),
                table.cell(one.start, names),
                table.cell(other.start, names)
            );
            let order = Order::Exchanged([one.clone(), other.clone()]);
            let change = Change::Rows { columns: owned(&there), order };
            let edits = vec![Edit { file, change }];
            all.push(Hypothesis::of("input:labels", (file, &there), description, edits));
        }
    }
    all
}

/// Rows that follow each other with one name in the column; all of them where there is none.
pub(super) fn blocks(table: &Table, within: Option<&str>) -> Vec<Range<usize>> {
    let column = within.and_then(|name| table.column(name));
    let is_same = |row: usize| column.is_none_or(|c| table.cell(row, c) == table.cell(row - 1, c));
    let mut blocks: Vec<Range<usize>> = Vec::new();
    for row in 0..table.n_rows() {
        let is_next = row > 0 && is_same(row);
        match blocks.last_mut().filter(|_| is_next) {
            Some(block) => block.end = row + 1,
            None => blocks.push(row..row + 1),
        }
    }
    blocks
}

/// Names in a column exchanged, two or three of them, in the rows alone that have one label, of every label
/// whose rows have no more names than the first of two numbers; three of them up to the second.
pub(crate) fn names_of_one_exchanged(
    file: &'static str,
    table: Option<&Table>,
    [label, column]: [&str; 2],
    [most, most_in_three]: [usize; 2],
) -> Vec<Hypothesis> {
    let columns = |table: &Table| Some((table.column(label)?, table.column(column)?));
    let Some((table, (of, named))) = table.and_then(|t| Some((t, columns(t)?))) else {
        return Vec::new();
    };
    let exchanged = |name: &str, rows: &[usize], cycle: &[&str]| {
        let pairs = cycle.iter().zip(cycle.iter().cycle().skip(1));
        let said: Vec<String> =
            pairs.clone().map(|(one, other)| format!("`{one}` to `{other}`")).collect();
        let description = format!(
            "the labels in `{column}` of {file} are exchanged (swapped) where `{label}` is `{name}`: there \
             change {}",
            said.join(", ")
        );
        let names = pairs.map(|(one, other)| [one, other].map(|name| (*name).to_owned())).collect();
        let change = Change::Rename { column: column.to_owned(), rows: Some(rows.to_vec()), names };
        let edits = vec![Edit { file, change }];
        Hypothesis::of("input:labels", (file, &[column]), description, edits)
    };
    let mut all = Vec::new();
    for (name, rows) in labels_of(table, of) {
        let names: BTreeSet<&str> = rows.iter().map(|row| table.cell(*row, named)).collect();
        let names: Vec<&str> = names.into_iter().collect();
        if names.len() > most {
            continue;
        }
        for [i, j] in (0..names.len()).flat_map(|j| (0..j).map(move |i| [i, j])) {
            let [one, other] = [names[i], names[j]];
            all.push(exchanged(name, &rows, &[one, other]));
            let thirds = if names.len() > most_in_three { &[] } else { &names[..i] };
            for third in thirds {
                all.push(exchanged(name, &rows, &[third, one, other]));
                all.push(exchanged(name, &rows, &[other, one, third]));
            }
        }
    }
    all
}

/// Two names in a column exchanged, every pair; none where there are more than `most` names.
pub(crate) fn swapped_names(
    file: &'static str,
    table: Option<&Table>,
    column: &str,
    most: usize,
) -> Vec<Hypothesis> {
    let Some((table, index)) = table.and_then(|t| Some((t, t.column(column)?))) else {
        return Vec::new();
    };
    let mut names: Vec<&str> = Vec::new();
    for row in 0..table.n_rows() {
        let name = table.cell(row, index);
        if !names.contains(&name) {
            names.push(name);
        }
        if names.len() > most {
            return Vec::new();
        }
    }
    let mut all = Vec::new();
    for (i, one) in names.iter().enumerate() {
        for other in &names[i + 1..] {
            let description = format!(
                "the labels `{one}` and `{other}` in `{column}` of {file} are exchanged (swapped): \
                 exchange them"
            );
            let edits = vec![Edit { file, change: Change::swap(column, [*one, *other]) }];
            all.push(Hypothesis::of("input:labels", (file, &[column]), description, edits));
        }
    }
    all
}

/// The cells of some columns exchanged between two of the rows given.
pub(crate) fn exchanged_rows(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    rows: &[usize],
) -> Vec<Hypothesis> {
    let later = |i: usize| rows[i + 1..].iter().map(move |other| (rows[i], *other));
    exchanged_pairs((file, columns), table, (0..rows.len()).flat_map(later))
}

/// The cells of some columns exchanged between one row and any other.
pub(crate) fn exchanged_with(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    row: usize,
) -> Vec<Hypothesis> {
    let others = (0..table.map_or(0, Table::n_rows)).filter(|other| *other != row);
    exchanged_pairs((file, columns), table, others.map(|other| (row, other)))
}

fn exchanged_pairs(
    (file, columns): (&'static str, &[&str]),
    table: Option<&Table>,
    pairs: impl Iterator<Item = (usize, usize)>,
) -> Vec<Hypothesis> {
    let there = present(table, columns);
    let Some(table) = table.filter(|_| !there.is_empty()) else { return Vec::new() };
    let of_pair = |(one, other): (usize, usize)| {
        let order = Order::Exchanged([one..one + 1, other..other + 1]);
        let (one, other) = (table.line(one.min(other)), table.line(one.max(other)));
        let description = format!(
            "the values of {} in lines {one} and {other} of {file} are exchanged (swapped \
             labels): exchange them",
            listed(&there)
        );
        let change = Change::Rows { columns: owned(&there), order };
        let edits = vec![Edit { file, change }];
        Hypothesis::of("input:labels", (file, &there), description, edits)
    };
    pairs.map(of_pair).collect()
}

/// Observations with the largest residuals, the largest first.
pub(crate) fn farthest(fitted: &Fitted, most: usize) -> Vec<usize> {
    let square = |row: usize| fitted.observations[row].square();
    let mut rows: Vec<usize> = (0..fitted.observations.len()).collect();
    rows.sort_by(|&a, &b| square(b).total_cmp(&square(a)));
    rows.truncate(most);
    rows
}
