//! Channels that clip at the end of their range, or stand still.

use super::hypothesis::{Hypothesis, Proof, lines_of, listed};
use super::label::labels_of;
use crate::case::{Change, Edit, Table};

/// Fewest readings at one end that are no accident.
const FEWEST: usize = 10;
/// The same of readings that are all equal there.
const FEWEST_EQUAL: usize = 5;
/// A reading at the end of the range is this many times more frequent than any other value.
const TIES: usize = 5;
/// Readings in the last window before the end of a range over those in either window before it:
/// 2.4 at the turning points of a sine, more only where something holds the readings there.
const PILE: usize = 4;
/// Widths of that window, as shares of the range.
const WINDOWS: [f64; 4] = [0.005, 0.01, 0.02, 0.04];
/// Equal readings in a row of a channel that stands still, beside one in twenty of the record.
const STILL: usize = 20;
/// The same of a table of few rows, where the fit without them decides; as many must be left.
const STILL_OF_FEW: usize = 5;
/// The same of one series among many, in which everything else moves.
const STILL_OF_SERIES: usize = 3;
/// Readings at one end of a table of few rows that may have been clipped.
const CLIPPED_OF_FEW: usize = 4;
/// Rows that share a label, on average, at least: of a column of readings most are alone.
const FEWEST_OF_LABEL: usize = 8;
/// What a run of rows is called.
const IN_A_ROW: &str = "rows one after the other";
/// Share of equal neighbours elsewhere, below which a channel is alive.
const ALIVE: f64 = 0.05;

/// Channels of a table that clip, or stand still; `without` makes the change that leaves out rows.
pub(crate) fn channels(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let read: Vec<(&str, Vec<f64>)> =
        columns.iter().filter_map(|name| Some((*name, table.numbers(name)?))).collect();
    let (mut stuck, mut all) = (Vec::new(), Vec::new());
    let mut clipped: Vec<(&str, Clipping)> = Vec::new();
    let moving =
        read.iter().filter(|(_, values)| longest_run(values, &whole(values)).1 < ALIVE).count();
    for (name, values) in &read {
        let clip = clipping(values);
        if let Some(run) = still(values, moving > 0) {
            // What stands still at a limit that the channel has elsewhere, or at the end of its range, clips there.
            let is_limit =
                is_end(values, values[run[0]]) && clip.as_ref().is_some_and(|clip| clip.is_exact);
            if !is_limit {
                let channel = (&[*name][..], std::slice::from_ref(values));
                stuck.push(stuck_at((file, table), channel, &run, IN_A_ROW, &without).shown());
                if is_once(values, &run) {
                    continue;
                }
            }
        }
        let Some(clip) = clip.filter(|clip| clip.is_exact || !are_whole_labels(table, &clip.rows))
        else {
            continue;
        };
        let with_noise = with_noise_below(values, &clip);
        all.extend([Some(&clip), with_noise.as_ref()].into_iter().flatten().map(|cut| {
            saturation(file, &[*name], &cut.words, clip.is_exact, without(table, &cut.rows))
        }));
        clipped.push((name, clip));
    }
    let exact = || clipped.iter().filter(|(_, clip)| clip.is_exact);
    let several = |some: &[&(&str, Clipping)]| {
        let names: Vec<&str> = some.iter().map(|(name, _)| *name).collect();
        let is_clipped = |row: usize| some.iter().any(|(_, clip)| clip.rows[row]);
        let rows: Vec<bool> = (0..table.n_rows()).map(is_clipped).collect();
        let is_exact = some.iter().all(|(_, clip)| clip.is_exact);
        saturation(file, &names, "their limits", is_exact, without(table, &rows))
    };
    if (2..clipped.len()).contains(&exact().count()) {
        all.push(several(&exact().collect::<Vec<_>>()));
    }
    if clipped.len() > 1 {
        all.push(several(&clipped.iter().collect::<Vec<_>>()));
    }
    all.extend(stuck);
    all
}

/// Channels that stand still over a good part of a table, as they may: to be decided by the fit
/// without these rows.
pub(crate) fn standing_still(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let of_column = |name: &&str| {
        let values = table.numbers(name)?;
        let run = still_of_few(&values)?;
        Some(stuck_at((file, table), (&[*name], &[values]), &run, IN_A_ROW, &without))
    };
    columns.iter().filter_map(of_column).collect()
}

/// Columns that read the same in every row while others do not, as a plane part may have one: where the fit is
/// worse than any physics makes it, they were not recorded.
pub(crate) fn silent(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let read: Vec<(&str, Vec<f64>)> =
        columns.iter().filter_map(|name| Some((*name, table.numbers(name)?))).collect();
    let run_of = |values: &[f64]| longest_run(values, &whole(values)).0;
    let is_whole =
        |values: &[f64]| values.len() > STILL_OF_FEW && run_of(values).len() == values.len();
    if read.iter().all(|(_, values)| is_whole(values)) {
        return Vec::new();
    }
    let of_column = |(name, values): &(&str, Vec<f64>)| {
        let channel = (&[*name][..], std::slice::from_ref(values));
        let stuck = stuck_at(
            (file, table),
            channel,
            &run_of(values),
            IN_A_ROW,
            &|_: &Table, _: &[bool]| Vec::new(),
        );
        Hypothesis { proof: Proof::Gross, ..stuck }
    };
    read.iter().filter(|(_, values)| is_whole(values)).map(of_column).collect()
}

/// A channel that stands still over successive rows of one of several series, which a description says, as it
/// may: to be decided by the fit without these rows.
pub(crate) fn standing_still_within(
    file: &'static str,
    table: Option<&Table>,
    column: &str,
    (series, said): (&[Vec<usize>], &str),
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let table = table?;
    let values = table.numbers(column)?;
    let (run, elsewhere) = longest_run(&values, series);
    let is_still = run.len() >= STILL_OF_SERIES && elsewhere < ALIVE;
    is_still.then(|| stuck_at((file, table), (&[column], &[values]), &run, said, &without))
}

/// A channel that stands still over successive rows of several series, as where an instrument hung while it read
/// them all: to be decided by the fit without these rows.
pub(crate) fn standing_still_in_several(
    file: &'static str,
    table: Option<&Table>,
    column: &str,
    (series, said): (&[Vec<usize>], &str),
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let table = table?;
    let values = table.numbers(column)?;
    let one = |rows: &Vec<usize>| longest_run(&values, std::slice::from_ref(rows)).0;
    let mut runs: Vec<Vec<usize>> = series.iter().map(one).collect();
    runs.retain(|run| run.len() >= STILL_OF_SERIES);
    if runs.len() < 2 {
        return None;
    }
    let rows: Vec<bool> =
        (0..table.n_rows()).map(|row| runs.iter().flatten().any(|r| *r == row)).collect();
    let description = format!(
        "the channel {} of {file} is stuck in several of the {said}, in line {}, while others go on; repair the \
         channel, or leave these rows out",
        listed(&[column]),
        lines_of(table, &rows)
    );
    let edits = without(table, &rows);
    Some(Hypothesis::of("input:stuck", (file, &[column]), description, edits))
}

/// Columns of a table of few rows whose readings at one end are all the same, as a design may have them: to
/// be decided by the fit without these rows.
pub(crate) fn clipped_of_few(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let of_column = |name: &&str| {
        let values = table.numbers(name)?;
        let of_end = |sign: f64| {
            let (end, rows) = at_end(&values, sign);
            let at_it = rows.iter().filter(|row| **row).count();
            // What was not recorded is written as zeros.
            let is_pile = at_it >= CLIPPED_OF_FEW && 2 * at_it < values.len() && end != 0.0;
            is_pile
                .then(|| saturation(file, &[*name], &end.to_string(), false, without(table, &rows)))
        };
        Some([1.0, -1.0].into_iter().filter_map(of_end).collect::<Vec<_>>())
    };
    columns.iter().filter_map(of_column).flatten().collect()
}

/// The readings of one instrument, by its name in `label`, that clip to the last digit where those of others go on.
pub(crate) fn clipped_of_one(
    file: &'static str,
    table: Option<&Table>,
    [label, column]: [&str; 2],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let Some((values, named)) = table.numbers(column).zip(table.column(label)) else {
        return Vec::new();
    };
    let of_one = |(name, rows): (&str, Vec<usize>)| {
        let own: Vec<f64> = rows.iter().map(|row| values[*row]).collect();
        let clip = clipping(&own).filter(|clip| clip.is_exact)?;
        let mut marked = vec![false; values.len()];
        for (row, is_clipped) in rows.iter().zip(&clip.rows) {
            marked[*row] = *is_clipped;
        }
        let limits = format!("{} where `{label}` is `{name}`", clip.words);
        let found = saturation(file, &[column], &limits, true, without(table, &marked));
        Some(Hypothesis { subject: format!("{file}: {column} of {name}"), ..found })
    };
    labels_of(table, named).into_iter().filter_map(of_one).collect()
}

/// A place all of whose coordinates stand still over the same rows, as no place does that is measured
/// anew: the data show it.
pub(crate) fn place_standing_still(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let table = table?;
    let read: Vec<Vec<f64>> = columns.iter().map(|c| table.numbers(c)).collect::<Option<_>>()?;
    let mut place = 0.0;
    let of_row = |row: usize| {
        let is_new = row > 0 && read.iter().any(|c| c[row].total_cmp(&c[row - 1]).is_ne());
        place += f64::from(u8::from(is_new));
        place
    };
    let places: Vec<f64> = (0..table.n_rows()).map(of_row).collect();
    let run = still_of_few(&places)?;
    Some(stuck_at((file, table), (columns, &read), &run, IN_A_ROW, &without).shown())
}

fn stuck_at(
    (file, table): (&'static str, &Table),
    (names, values): (&[&str], &[Vec<f64>]),
    run: &[usize],
    said: &str,
    without: &impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Hypothesis {
    let n = table.n_rows();
    let rows: Vec<bool> = (0..n).map(|row| run.contains(&row)).collect();
    let edits = if run.len() == n { Vec::new() } else { without(table, &rows) };
    let at: Vec<String> = values.iter().map(|column| column[run[0]].to_string()).collect();
    let (channel, is_stuck) = if names.len() > 1 {
        ("channels", "are stuck: they read")
    } else {
        ("channel", "is stuck: it reads")
    };
    let description = format!(
        "the {channel} {} of {file} {is_stuck} {} in {} {said}, from line {}, while \
         others go on; repair the {channel}, or leave these rows out",
        listed(names),
        at.join(", "),
        run.len(),
        table.line(run[0])
    );
    Hypothesis::of("input:stuck", (file, names), description, edits)
}

/// The rows over which a channel stands still while others move.
fn still(values: &[f64], others_move: bool) -> Option<Vec<usize>> {
    let (run, elsewhere) = longest_run(values, &whole(values));
    let is_constant = run.len() == values.len() && others_move && values[0] != 0.0;
    let is_long = run.len() >= STILL.max(values.len() / 20) && elsewhere < ALIVE;
    (is_constant || is_long).then_some(run)
}

/// The rows over which a channel may stand still, for the fit to decide.
fn still_of_few(values: &[f64]) -> Option<Vec<usize>> {
    let (run, elsewhere) = longest_run(values, &whole(values));
    let is_long = run.len() >= STILL_OF_FEW.max(values.len() / 20) && elsewhere < ALIVE;
    (is_long && values.len() >= run.len() + STILL_OF_FEW).then_some(run)
}

/// Whether a channel reads what it stands still at hardly ever else: a limit it meets again.
fn is_once(values: &[f64], run: &[usize]) -> bool {
    let held = values[run[0]];
    values.iter().filter(|v| v.total_cmp(&held).is_eq()).count() < run.len() + TIES
}

/// Whether a value is the largest or the smallest of all.
fn is_end(values: &[f64], of: f64) -> bool {
    let ends = [1.0, -1.0].map(|sign| at_end(values, sign).0);
    ends.iter().any(|end| end.total_cmp(&of).is_eq())
}

fn saturation(
    file: &str,
    columns: &[&str],
    limits: &str,
    is_certain: bool,
    edits: Vec<Edit>,
) -> Hypothesis {
    let description = format!(
        "{} of {file} saturates: the readings clip at {limits}; repeat the measurement with a wider \
         range, or leave out what was clipped",
        listed(columns)
    );
    let found = Hypothesis::of("input:saturation", (file, columns), description, edits);
    if is_certain { found.shown() } else { found }
}

/// Whether the marked rows are all of those that share a label, of one label or several: the lowest or highest of several
/// segments, and presses at the least of several loads, are no limit.
fn are_whole_labels(table: &Table, marked: &[bool]) -> bool {
    let count = marked.iter().filter(|is_marked| **is_marked).count();
    let of_column = |column: usize| {
        let labels = labels_of(table, column);
        let is_whole = |rows: &&Vec<usize>| rows.iter().all(|row| marked[*row]);
        let whole = labels.values().filter(is_whole);
        let [n, of_whole] = [whole.clone().count(), whole.map(Vec::len).sum()];
        n < labels.len() && of_whole == count && of_whole >= FEWEST_OF_LABEL * n
    };
    (0..table.names().len()).any(of_column)
}

/// Only the rows that are not marked.
pub(crate) fn rows_left_out(file: &'static str, marked: &[bool]) -> Edit {
    let rows = (0..marked.len()).filter(|&row| !marked[row]).collect();
    Edit { file, change: Change::Keep { rows } }
}

/// The largest value, or with a negative sign the smallest, and the rows that read the same.
pub(crate) fn at_end(values: &[f64], sign: f64) -> (f64, Vec<bool>) {
    let end = values.iter().map(|v| sign * v).fold(f64::NEG_INFINITY, f64::max);
    (sign * end, values.iter().map(|v| (sign * v).total_cmp(&end).is_eq()).collect())
}

struct Clipping {
    rows: Vec<bool>,
    words: String,
    /// Whether the readings at the end are all the same.
    is_exact: bool,
}

/// Readings piled up at either end of their range; where those of one end are all the same, only such: a
/// channel that clips to the last digit does so at both ends, and the other end may be a record near it.
fn clipping(values: &[f64]) -> Option<Clipping> {
    let end = |sign: f64| {
        let turned: Vec<f64> = values.iter().map(|v| sign * v).collect();
        pile(&turned).map(|(floor, exact)| (sign, floor, exact))
    };
    let mut ends: Vec<(f64, f64, bool)> = [1.0, -1.0].into_iter().filter_map(end).collect();
    let is_exact = ends.iter().any(|(_, _, exact)| *exact);
    ends.retain(|(_, _, exact)| *exact == is_exact);
    let is_there = |v: &f64| ends.iter().any(|(sign, floor, _)| sign * v >= *floor);
    let rows = values.iter().map(is_there).collect();
    let limits =
        ends.iter().map(|(sign, floor, _)| format!("{}", (sign * floor * 1e4).round() / 1e4));
    let words = limits.collect::<Vec<_>>().join(" and ");
    (!ends.is_empty()).then_some(Clipping { rows, words, is_exact })
}

/// The same where readings that are not all the same pile up below an exact limit, as where an amplifier clips at one
/// before the recorder does, and its noise is between.
fn with_noise_below(values: &[f64], exact: &Clipping) -> Option<Clipping> {
    let others = values.iter().zip(&exact.rows).filter(|(_, is_there)| !**is_there);
    let others: Vec<f64> = others.map(|(value, _)| *value).collect();
    let below = clipping(&others).filter(|below| exact.is_exact && !below.is_exact)?;
    let mut of_others = below.rows.iter();
    let rows = exact.rows.iter().map(|is_there| *is_there || of_others.next() == Some(&true));
    Some(Clipping { rows: rows.collect(), words: exact.words.clone(), is_exact: false })
}

/// Value from which on the largest readings are piled up, and whether they are all equal.
fn pile(values: &[f64]) -> Option<(f64, bool)> {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let (max, min) = (*sorted.first()?, *sorted.last()?);
    let range = max - min;
    if range <= 0.0 {
        return None;
    }
    let at = |value: f64| move |v: &&f64| v.total_cmp(&value).is_eq();
    let at_max = sorted.iter().take_while(at(max)).count();
    let inner = sorted.iter().filter(|v| **v < max && **v > min);
    // Of readings that are all different, as of many digits, fewer are no accident either.
    if at_max >= FEWEST_EQUAL && max != 0.0 && at_max >= TIES * most_frequent(inner) {
        return Some((max, true));
    }
    let within = |from: f64, to: f64| {
        sorted.iter().filter(|v| (max - **v) >= from && (max - **v) < to).count()
    };
    let window = WINDOWS.iter().map(|share| share * range).find(|w| {
        let last = within(0.0, *w);
        let before = within(*w, 2.0 * w).max(within(2.0 * w, 3.0 * w)).max(1);
        last >= FEWEST && last >= PILE * before
    })?;
    // Noise on top of the limit reaches as far below it as above.
    Some((max - 2.0 * window, false))
}

/// How often the most frequent of sorted values comes.
fn most_frequent<'v>(sorted: impl Iterator<Item = &'v f64>) -> usize {
    let (mut most, mut run, mut last) = (0, 0, f64::NAN);
    for value in sorted {
        run = if value.total_cmp(&last).is_eq() { run + 1 } else { 1 };
        last = *value;
        most = most.max(run);
    }
    most.max(1)
}

/// The longest run of equal readings in any of several series of rows, and the share of equal neighbours
/// elsewhere.
fn longest_run(values: &[f64], series: &[Vec<usize>]) -> (Vec<usize>, f64) {
    let (mut longest, mut equal, mut all) = (&[][..], 0, 0);
    for rows in series {
        all += rows.len();
        let mut start = 0;
        for at in 0..rows.len() {
            if at > 0 && values[rows[at]].total_cmp(&values[rows[at - 1]]).is_eq() {
                equal += 1;
            } else {
                start = at;
            }
            if at + 1 - start > longest.len() {
                longest = &rows[start..=at];
            }
        }
    }
    let equal = equal - longest.len().saturating_sub(1);
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let share = equal as f64 / (all - longest.len()).max(1) as f64;
    (longest.to_vec(), share)
}

/// All rows as one series.
fn whole(values: &[f64]) -> [Vec<usize>; 1] {
    [(0..values.len()).collect()]
}

#[cfg(test)]
mod tests {
    use super::{clipping, longest_run, pile, whole};

    /// A sine with a little deterministic noise.
    fn sine(n: usize) -> Vec<f64> {
        #[expect(clippy::cast_precision_loss, reason = "small counts")]
        let at = |i: usize| {
            let t = i as f64;
            (t * 0.37).sin() + 0.01 * (t * t * 0.71).sin()
        };
        (0..n).map(at).collect()
    }

    #[test]
    fn turning_points_of_a_sine_are_no_limit() {
        assert!(clipping(&sine(2000)).is_none());
    }

    #[test]
    fn equal_extremes_are_a_limit_and_zeros_are_none() {
        let clipped: Vec<f64> = sine(500).into_iter().map(|v| v.min(0.8)).collect();
        assert_eq!(pile(&clipped), Some((0.8, true)));
        let rectified: Vec<f64> = sine(500).into_iter().map(|v| -v.max(0.0)).collect();
        assert!(pile(&rectified).is_none_or(|(_, exact)| !exact));
    }

    #[test]
    fn a_limit_with_noise_on_top_is_one_still() {
        let noise = sine(500);
        let clipped = sine(500).into_iter().map(|v| v.min(0.5));
        let noisy: Vec<f64> = clipped.zip(&noise).map(|(v, n)| v + 0.002 * n).collect();
        let found = clipping(&noisy).expect("a third of the readings are at the limit");
        assert!(!found.is_exact && found.rows.iter().filter(|row| **row).count() > 100);
    }

    #[test]
    fn a_record_near_one_end_is_no_limit_where_the_other_end_clips() {
        // Twelve readings within a hundredth of the range below the largest, and a floor.
        let near = (0..12).map(|i| 1.0 - 1e-4 * f64::from(i));
        let values: Vec<f64> =
            sine(500).into_iter().map(|v| 0.5 * v.max(-0.8)).chain(near).collect();
        let found = clipping(&values).expect("a floor");
        assert!(found.is_exact && found.words == "-0.4", "{}", found.words);
        assert!(found.rows.iter().zip(&values).all(|(row, v)| *row == (*v <= -0.4)));
    }

    #[test]
    fn a_run_is_looked_for_in_one_series_at_a_time() {
        let values = [1.0, 5.0, 2.0, 5.0, 3.0, 5.0, 3.0, 6.0];
        let (run, elsewhere) = longest_run(&values, &[vec![0, 2, 4, 6], vec![1, 3, 5, 7]]);
        assert_eq!(run, [1, 3, 5]);
        // Of the five rows elsewhere one reads as the one before it.
        assert!((elsewhere - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_run_is_found_with_what_is_elsewhere() {
        let values = [1.0, 2.0, 2.0, 2.0, 3.0, 4.0];
        let (run, elsewhere) = longest_run(&values, &whole(&values));
        assert_eq!(run, [1, 2, 3]);
        assert!(elsewhere.abs() < 1e-12);
    }
}
