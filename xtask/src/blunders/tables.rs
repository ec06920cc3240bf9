//! Mistakes made in the text of a case, as people make them.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Files of a case by name.
pub(crate) type Files = BTreeMap<&'static str, String>;

/// A table as cells; the files of the simulators have no comments.
struct Cells {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Cells {
    fn read(text: &str) -> Self {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect();
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let header = lines.next().map(cells).unwrap_or_default();
        Self { header, rows: lines.map(cells).collect() }
    }

    fn write(&self) -> String {
        let lines = std::iter::once(&self.header).chain(&self.rows).map(|row| row.join(","));
        lines.collect::<Vec<_>>().join("\n") + "\n"
    }

    /// Indices of the columns; `None` where one is not there.
    fn columns(&self, names: &[&str]) -> Option<Vec<usize>> {
        names.iter().map(|name| self.header.iter().position(|h| h == name)).collect()
    }

    /// Two different names of a column of names.
    fn two_names(&self, column: usize, seed: u64) -> [String; 2] {
        let mut names: Vec<&String> = self.rows.iter().map(|row| &row[column]).collect();
        names.sort();
        names.dedup();
        let (one, other) = two(names.len(), seed);
        [one, other].map(|index| names[index].clone())
    }
}

/// Changes one table; says whether it could.
fn change(
    files: &mut Files,
    (file, columns): (&str, &[&str]),
    of: impl FnOnce(&mut Cells, &[usize]),
) -> bool {
    let Some(text) = files.get_mut(file) else { return false };
    let mut cells = Cells::read(text);
    let Some(indices) = cells.columns(columns) else { return false };
    of(&mut cells, &indices);
    *text = cells.write();
    true
}

/// Writes every number of some columns of these rows otherwise.
fn rewrite<'r>(
    rows: impl IntoIterator<Item = &'r mut Vec<String>>,
    columns: &[usize],
    to: impl Fn(f64) -> String,
) {
    for row in rows {
        for &column in columns {
            if let Ok(value) = row[column].parse::<f64>() {
                row[column] = to(value);
            }
        }
    }
}

/// Numbers of some columns times a factor.
pub(crate) fn scaled(files: &mut Files, at: (&str, &[&str]), factor: f64) -> bool {
    change(files, at, |cells, columns| {
        rewrite(&mut cells.rows, columns, |value| format!("{}", value * factor));
    })
}

/// The readings of one name times a factor.
pub(crate) fn scaled_of_one(
    files: &mut Files,
    (file, columns): (&str, [&str; 2]),
    (factor, seed): (f64, u64),
) -> bool {
    change(files, (file, &columns), |cells, columns| {
        let (of, column) = (columns[0], columns[1]);
        let [one, _] = cells.two_names(of, seed);
        let own = cells.rows.iter_mut().filter(|row| row[of] == one);
        rewrite(own, &[column], |value| format!("{}", value * factor));
    })
}

/// The readings of one name, but for those beyond a share of its largest, which are that.
pub(crate) fn clipped_of_one(
    files: &mut Files,
    (file, columns): (&str, [&str; 2]),
    (share, seed): (f64, u64),
) -> bool {
    change(files, (file, &columns), |cells, columns| {
        let (of, column) = (columns[0], columns[1]);
        let [one, _] = cells.two_names(of, seed);
        let own = || cells.rows.iter().filter(|row| row[of] == one);
        let sizes = own().filter_map(|row| row[column].parse::<f64>().ok()).map(f64::abs);
        let limit = share * sizes.fold(0.0, f64::max);
        let own = cells.rows.iter_mut().filter(|row| row[of] == one);
        rewrite(own, &[column], |value| format!("{}", value.clamp(-limit, limit)));
    })
}

/// Columns exchanged in the last two fifths of the rows.
pub(crate) fn exchanged_at_end(files: &mut Files, at: (&str, &[&str])) -> bool {
    change(files, at, |cells, columns| {
        let from = 3 * cells.rows.len() / 5;
        for row in &mut cells.rows[from..] {
            row.swap(columns[0], columns[1]);
        }
    })
}

/// A column in reverse order within the rows of one name.
pub(crate) fn reversed_of_one(
    files: &mut Files,
    (file, columns): (&str, [&str; 2]),
    seed: u64,
) -> bool {
    change(files, (file, &columns), |cells, columns| {
        let (of, column) = (columns[0], columns[1]);
        let [one, _] = cells.two_names(of, seed);
        let rows: Vec<usize> =
            (0..cells.rows.len()).filter(|&row| cells.rows[row][of] == one).collect();
        let read: Vec<String> = rows.iter().map(|&row| cells.rows[row][column].clone()).collect();
        for (&row, cell) in rows.iter().zip(read.into_iter().rev()) {
            cells.rows[row][column] = cell;
        }
    })
}

/// The last two fifths of a column as on another machine: beside what it is a slope along another column, and a wave.
pub(crate) fn of_another_machine(
    files: &mut Files,
    at: (&str, &[&str]),
    [slope, wave]: [f64; 2],
) -> bool {
    change(files, at, |cells, columns| {
        let (along, column) = (columns[0], columns[1]);
        let from = 3 * cells.rows.len() / 5;
        for row in &mut cells.rows[from..] {
            let (Ok(at), Ok(read)) = (row[along].parse::<f64>(), row[column].parse::<f64>()) else {
                continue;
            };
            row[column] = format!("{:.6}", read + slope * at + wave * (0.07 * at).sin());
        }
    })
}

/// Numbers of some columns times a factor in the middle third of the rows.
pub(crate) fn scaled_in_a_third(files: &mut Files, at: (&str, &[&str]), factor: f64) -> bool {
    change(files, at, |cells, columns| {
        let third = cells.rows.len() / 3;
        let middle = &mut cells.rows[third..2 * third];
        rewrite(middle, columns, |value| format!("{}", value * factor));
    })
}

/// Numbers of some columns in the middle third of the rows farther on by so much, and by half of it in the next column.
pub(crate) fn moved_in_a_third(files: &mut Files, at: (&str, &[&str]), by: f64) -> bool {
    change(files, at, |cells, columns| {
        let third = cells.rows.len() / 3;
        let mut by = by;
        for column in columns {
            let middle = &mut cells.rows[third..2 * third];
            rewrite(middle, &[*column], |value| format!("{:.6}", value + by));
            by *= 0.5;
        }
    })
}

/// Every two neighbours of the middle third exchanged.
pub(crate) fn neighbours_exchanged(files: &mut Files, at: (&str, &[&str])) -> bool {
    reordered(files, at, |row, n| {
        let (start, end) = (n / 3, n / 3 + n / 6 * 2);
        if (start..end).contains(&row) { start + ((row - start) ^ 1) } else { row }
    })
}

/// A fifth of the rows that repeats those before it.
pub(crate) fn pasted(files: &mut Files, at: (&str, &[&str])) -> bool {
    let from = |row: usize, n: usize| {
        if (n / 2..n / 2 + n / 5).contains(&row) { row - n / 5 } else { row }
    };
    reordered(files, at, from)
}

/// The second half so many rows further up; the last rows repeat the last.
pub(crate) fn half_up(files: &mut Files, at: (&str, &[&str]), by: usize) -> bool {
    reordered(files, at, |row, n| if 2 * row >= n { (row + by).min(n - 1) } else { row })
}

/// Columns one row further down from two fifths of the rows on; the last row comes first there.
pub(crate) fn end_shifted(files: &mut Files, at: (&str, &[&str])) -> bool {
    reordered(files, at, |row, n| match row.cmp(&(2 * n / 5)) {
        Ordering::Less => row,
        Ordering::Equal => n - 1,
        Ordering::Greater => row - 1,
    })
}

/// Columns so many rows further down; the first rows repeat the first.
pub(crate) fn late(files: &mut Files, at: (&str, &[&str]), by: usize) -> bool {
    reordered(files, at, |row, _| row.saturating_sub(by))
}

fn reordered(files: &mut Files, at: (&str, &[&str]), from: impl Fn(usize, usize) -> usize) -> bool {
    change(files, at, |cells, columns| {
        let n = cells.rows.len();
        let others: Vec<Vec<String>> = (0..n).map(|row| cells.rows[from(row, n)].clone()).collect();
        take(&mut cells.rows, &others, columns);
    })
}

/// Each row as a difference from the one before.
pub(crate) fn in_increments(files: &mut Files, at: (&str, &[&str])) -> bool {
    change(files, at, |cells, columns| {
        let old = cells.rows.clone();
        for (row, before) in cells.rows[1..].iter_mut().zip(&old) {
            for &column in columns {
                if let (Ok(value), Ok(less)) =
                    (row[column].parse::<f64>(), before[column].parse::<f64>())
                {
                    row[column] = format!("{:.7}", value - less);
                }
            }
        }
    })
}

/// Numbers with so many decimals.
pub(crate) fn rounded(files: &mut Files, at: (&str, &[&str]), decimals: usize) -> bool {
    change(files, at, |cells, columns| {
        rewrite(&mut cells.rows, columns, |value| format!("{value:.decimals$}"));
    })
}

/// The mean of every block that has a name of its own, in place of its numbers.
pub(crate) fn averaged(files: &mut Files, (file, within, column): (&str, &str, &str)) -> bool {
    change(files, (file, &[within, column]), |cells, columns| {
        let old = cells.rows.clone();
        for row in &mut cells.rows {
            let own = old.iter().filter(|other| other[columns[0]] == row[columns[0]]);
            let values: Vec<f64> = own.filter_map(|other| other[columns[1]].parse().ok()).collect();
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            row[columns[1]] = format!("{mean:.6}");
        }
    })
}

/// A number ten times too large.
pub(crate) fn point_lost(files: &mut Files, at: (&str, &[&str]), seed: u64) -> bool {
    change(files, at, |cells, columns| {
        let (row, _) = two(cells.rows.len(), seed);
        rewrite(&mut cells.rows[row..=row], columns, |value| format!("{}", 10.0 * value));
    })
}

/// The cells of the first column in the others, too.
pub(crate) fn copied(files: &mut Files, at: (&str, &[&str])) -> bool {
    change(files, at, |cells, columns| {
        for row in &mut cells.rows {
            for &column in &columns[1..] {
                row[column] = row[columns[0]].clone();
            }
        }
    })
}

/// Each column under the name of the next, the last under that of the first.
pub(crate) fn exchanged(files: &mut Files, at: (&str, &[&str])) -> bool {
    change(files, at, |cells, columns| {
        for row in &mut cells.rows {
            let old: Vec<String> = columns.iter().map(|&column| row[column].clone()).collect();
            for (i, &column) in columns.iter().enumerate() {
                row[column].clone_from(&old[(i + 1) % old.len()]);
            }
        }
    })
}

/// Columns one row further down; the last row comes first.
pub(crate) fn shifted(files: &mut Files, at: (&str, &[&str])) -> bool {
    reordered(files, at, |row, n| (row + n - 1) % n)
}

/// Columns one row further up; the first row comes last.
pub(crate) fn shifted_up(files: &mut Files, at: (&str, &[&str])) -> bool {
    reordered(files, at, |row, n| (row + 1) % n)
}

/// Columns from the last row to the first.
pub(crate) fn reversed(files: &mut Files, at: (&str, &[&str])) -> bool {
    reordered(files, at, |row, n| n - 1 - row)
}

/// Columns sorted by the numbers of the first of them.
pub(crate) fn sorted(files: &mut Files, at: (&str, &[&str])) -> bool {
    change(files, at, |cells, columns| {
        let number = |row: &Vec<String>| row[columns[0]].parse::<f64>().unwrap_or(f64::NAN);
        let mut sorted = cells.rows.clone();
        sorted.sort_by(|a, b| number(a).total_cmp(&number(b)));
        take(&mut cells.rows, &sorted, columns);
    })
}

/// Some columns as other rows have them.
fn take(rows: &mut [Vec<String>], others: &[Vec<String>], columns: &[usize]) {
    for (row, source) in rows.iter_mut().zip(others) {
        for &column in columns {
            row[column].clone_from(&source[column]);
        }
    }
}

/// Columns as they were read on another day, as many rows as both days have.
pub(crate) fn of_another_session(
    files: &mut Files,
    (file, columns): (&str, &[&str]),
    other: &Files,
) -> bool {
    let Some(other) = other.get(file).map(|text| Cells::read(text)) else { return false };
    let Some(sources) = other.columns(columns) else { return false };
    change(files, (file, columns), |cells, columns| {
        for (row, taken) in cells.rows.iter_mut().zip(&other.rows) {
            for (&column, &source) in columns.iter().zip(&sources) {
                row[column].clone_from(&taken[source]);
            }
        }
    })
}

/// Cells of some columns exchanged between two blocks of rows that have a name of their own.
pub(crate) fn blocks_exchanged(
    files: &mut Files,
    (file, within, columns): (&str, &str, &[&str]),
    seed: u64,
) -> bool {
    let all = [&[within], columns].concat();
    change(files, (file, &all), |cells, indices| {
        let mut names: Vec<String> = cells.rows.iter().map(|r| r[indices[0]].clone()).collect();
        names.dedup();
        let (one, other) = two(names.len(), seed);
        let rows = |name: &String| -> Vec<usize> {
            (0..cells.rows.len()).filter(|&row| cells.rows[row][indices[0]] == *name).collect()
        };
        let (one, other) = (rows(&names[one]), rows(&names[other]));
        for (a, b) in one.into_iter().zip(other) {
            for &column in &indices[1..] {
                let cell = cells.rows[a][column].clone();
                let taken = std::mem::replace(&mut cells.rows[b][column], cell);
                cells.rows[a][column] = taken;
            }
        }
    })
}

/// Cells of some columns exchanged between two rows.
pub(crate) fn rows_exchanged(files: &mut Files, at: (&str, &[&str]), seed: u64) -> bool {
    change(files, at, |cells, columns| {
        let (one, other) = two(cells.rows.len(), seed);
        for &column in columns {
            let cell = cells.rows[one][column].clone();
            let taken = std::mem::replace(&mut cells.rows[other][column], cell);
            cells.rows[one][column] = taken;
        }
    })
}

/// Two names of a column exchanged.
pub(crate) fn names_exchanged(files: &mut Files, (file, column): (&str, &str), seed: u64) -> bool {
    change(files, (file, &[column]), |cells, columns| {
        let [one, other] = cells.two_names(columns[0], seed);
        for row in &mut cells.rows {
            let cell = &mut row[columns[0]];
            if *cell == one {
                cell.clone_from(&other);
            } else if *cell == other {
                cell.clone_from(&one);
            }
        }
    })
}

/// Two different indices below `n`.
fn two(n: usize, seed: u64) -> (usize, usize) {
    let seed = usize::try_from(seed % 1_000_003).unwrap_or_default();
    let one = seed * 7 % n;
    (one, (one + 1 + seed * 3 % (n - 1)) % n)
}

/// A channel that reads no more than the share of its readings says.
pub(crate) fn clipped(files: &mut Files, at: (&str, &[&str]), share: f64) -> bool {
    change(files, at, |cells, columns| {
        for &column in columns {
            let number = |row: &Vec<String>| row[column].parse::<f64>().unwrap_or(f64::NAN);
            let mut values: Vec<f64> = cells.rows.iter().map(number).collect();
            values.sort_by(f64::total_cmp);
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
            let limit = values[(values.len() as f64 * share) as usize];
            for row in &mut cells.rows {
                let clipped = number(row).min(limit);
                row[column] = format!("{clipped}");
            }
        }
    })
}

/// A channel that stands still from a share of the rows on.
pub(crate) fn stuck(files: &mut Files, at: (&str, &[&str]), share: f64) -> bool {
    change(files, at, |cells, columns| {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
        let from = (cells.rows.len() as f64 * share) as usize;
        let held: Vec<String> = columns.iter().map(|&c| cells.rows[from][c].clone()).collect();
        for row in &mut cells.rows[from..] {
            for (&column, held) in columns.iter().zip(&held) {
                row[column].clone_from(held);
            }
        }
    })
}

/// A channel of another clock: late by a time, by a share of the time, and by a time that is
/// another for every reading, of that standard deviation, s; read on straight lines between its
/// readings, within a segment.
pub(crate) fn on_another_clock(
    files: &mut Files,
    (file, column): (&str, &str),
    ([late_s, rate, jitter_s], seed): ([f64; 3], u64),
) -> bool {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    change(files, (file, &[column, "time_s", "segment"]), |cells, columns| {
        let number = |row: &Vec<String>, i: usize| row[columns[i]].parse::<f64>().ok();
        let read: Vec<(f64, f64)> = (cells.rows.iter())
            .filter_map(|row| Some((number(row, 1)?, number(row, 0)?)))
            .collect();
        let segments: Vec<String> = cells.rows.iter().map(|r| r[columns[2]].clone()).collect();
        for (i, row) in cells.rows.iter_mut().enumerate() {
            // The sum of twelve uniform numbers is as good as normal here.
            let unit = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
            let at_s = read[i].0 * (1.0 - rate) - late_s + jitter_s * unit;
            let own = |j: &usize| segments[*j] == segments[i];
            let before = (0..read.len()).filter(own).rfind(|&j| read[j].0 <= at_s);
            let after = (0..read.len()).filter(own).find(|&j| read[j].0 > at_s);
            let value = match (before, after) {
                (Some(a), Some(b)) => {
                    let share = (at_s - read[a].0) / (read[b].0 - read[a].0);
                    read[a].1 + share * (read[b].1 - read[a].1)
                }
                (Some(only), None) | (None, Some(only)) => read[only].1,
                (None, None) => read[i].1,
            };
            row[columns[0]] = format!("{value}");
        }
    })
}

/// A number of `case.toml`, or all numbers of a list, times a factor.
pub(crate) fn setting_scaled(files: &mut Files, key: &str, factor: f64) -> bool {
    let scaled = |number: &str| {
        let value = number.trim().parse::<f64>().ok()?;
        Some(format!("{:?}", value * factor))
    };
    setting(files, key, |value| {
        let list = value.strip_prefix('[').and_then(|list| list.strip_suffix(']'));
        let Some(list) = list else { return scaled(value) };
        let numbers: Option<Vec<String>> = list.split(',').map(scaled).collect();
        Some(format!("[{}]", numbers?.join(", ")))
    })
}

/// Two settings of `case.toml` under each other's names.
pub(crate) fn settings_exchanged(files: &mut Files, [one, other]: [&str; 2]) -> bool {
    let Some(text) = files.get_mut("case.toml") else { return false };
    let renamed = |line: &str| match line.split_once('=').map(|(name, _)| name.trim()) {
        Some(name) if name == one => line.replacen(one, other, 1),
        Some(name) if name == other => line.replacen(other, one, 1),
        _ => line.to_owned(),
    };
    let changed: String = text.lines().map(|line| renamed(line) + "\n").collect();
    let is_other = changed != *text;
    *text = changed;
    is_other
}

/// A setting of `case.toml` given otherwise.
pub(crate) fn setting_to(files: &mut Files, key: &str, value: &str) -> bool {
    setting(files, key, |_| Some(value.to_owned()))
}

fn setting(files: &mut Files, key: &str, to: impl Fn(&str) -> Option<String>) -> bool {
    let Some(text) = files.get_mut("case.toml") else { return false };
    let mut found = false;
    let line = |line: &str| {
        let given = line.split_once('=').filter(|(name, _)| name.trim() == key);
        match given.and_then(|(_, value)| to(value.trim())) {
            Some(value) => {
                found = true;
                format!("{key} = {value}")
            }
            None => line.to_owned(),
        }
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    *text = lines.join("\n") + "\n";
    found
}
