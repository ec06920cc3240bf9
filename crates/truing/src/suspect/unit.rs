use super::hypothesis::{Hypothesis, is_or_are, listed, owned, present};
use crate::case::{Change, Edit, Table};
use crate::count::count;

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dimension {
    Length,
    Force,
    Moment,
    Angle,
    /// A difference from what is expected: in any unit in which it is small it fits.
    Deviation,
    /// A part of a direction or of a turn, without a unit.
    Direction,
}

/// Exact: the international inch and pound of 1959, and standard gravity.
const MM_PER_INCH: f64 = 25.4;
const N_PER_LBF: f64 = 4.448_221_615_260_5;
const N_PER_KGF: f64 = 9.806_65;
const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;
/// Share by which two units differ that are one: round-off.
const SAME_UNIT: f64 = 1e-12;

impl Dimension {
    /// The unit that files speak.
    fn own(self) -> &'static str {
        match self {
            Self::Length => "mm",
            Self::Force => "N",
            Self::Moment => "N·mm",
            Self::Angle => "degrees",
            Self::Deviation | Self::Direction => "the column's own",
        }
    }

    /// Units in which numbers may be instead of one that is so many of the file's own, and by what they are
    /// then to be multiplied.
    pub(super) fn instead_of(self, declared: f64) -> impl Iterator<Item = (&'static str, f64)> {
        let all = std::iter::once((self.own(), 1.0)).chain(self.others().iter().copied());
        all.map(move |(unit, size)| (unit, size / declared)).filter(|(_, factor)| !is_one(*factor))
    }

    /// Factors of another range, or of a decimal point in the wrong place, that are no unit.
    pub(super) fn tenfold(self, declared: f64) -> impl Iterator<Item = f64> {
        let is_unit = move |factor: f64| self.instead_of(declared).any(|(_, f)| is_one(f / factor));
        [10.0, 0.1, 100.0, 0.01].into_iter().filter(move |factor| !is_unit(*factor))
    }

    /// The unit that is so many of the file's own.
    pub(super) fn name_of(self, size: f64) -> &'static str {
        let known = self.others().iter().find(|(_, other)| is_one(other / size));
        known.map_or(self.own(), |(unit, _)| unit)
    }

    /// Units that people write instead, and what they are in the file's own.
    fn others(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Length => &[
                ("inches", MM_PER_INCH),
                ("metres", 1e3),
                ("µm", 1e-3),
                ("thousandths of an inch (mil)", MM_PER_INCH / 1e3),
                ("cm", 10.0),
                ("mm divided by the inch twice over", 1.0 / MM_PER_INCH),
            ],
            Self::Force => &[
                ("lbf (pounds)", N_PER_LBF),
                ("kgf", N_PER_KGF),
                ("gf (grams)", N_PER_KGF / 1e3),
                ("ozf (ounces)", N_PER_LBF / 16.0),
                ("kN", 1e3),
                ("mN", 1e-3),
                ("N taken for pounds (lbf) and converted", 1.0 / N_PER_LBF),
                ("N taken for kgf and converted", 1.0 / N_PER_KGF),
            ],
            Self::Moment => &[
                ("N·m", 1e3),
                ("N·in (inch)", MM_PER_INCH),
                ("lbf·in (inch pounds, in·lb)", N_PER_LBF * MM_PER_INCH),
                ("lbf·ft (foot pounds)", N_PER_LBF * MM_PER_INCH * 12.0),
                ("N·cm", 10.0),
                ("kgf·mm", N_PER_KGF),
                ("kgf·cm", N_PER_KGF * 10.0),
                ("kgf·m", N_PER_KGF * 1e3),
                ("mN·mm", 1e-3),
                ("lbf·mm", N_PER_LBF),
                ("ozf·in (inch ounces)", N_PER_LBF * MM_PER_INCH / 16.0),
            ],
            Self::Angle => &[
                ("radians", DEG_PER_RAD),
                ("gon", 0.9),
                ("arc minutes", 1.0 / 60.0),
                ("arc seconds", 1.0 / 3600.0),
                ("turns", 360.0),
                ("degrees taken for radians and converted", 1.0 / DEG_PER_RAD),
            ],
            Self::Deviation | Self::Direction => &[],
        }
    }
}

/// Columns of a table in another unit: each alone, of three every two, and all of them.
pub(crate) fn units(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let there = present(table, columns);
    let mut sets = all_and_each(&there);
    if let [x, y, z] = there[..] {
        sets.extend([vec![x, y], vec![x, z], vec![y, z]]);
    }
    let of_set = |set: &Vec<&str>| -> Vec<Hypothesis> {
        let Some(declared) = table.and_then(|table| table.unit_of(set)) else { return Vec::new() };
        let (is, own) = (is_or_are(set), dimension.name_of(declared));
        let one = |(unit, factor): (&str, f64)| {
            let description = format!(
                "{} of {file} {is} in another unit than its name says, {unit} instead of {own}: \
                 multiply by {}",
                listed(set),
                shown(factor)
            );
            let change = Change::Scale { columns: owned(set), rows: None, factor };
            Hypothesis::of("input:unit", (file, set), description, vec![Edit { file, change }])
        };
        dimension.instead_of(declared).map(one).collect()
    };
    sets.iter().flat_map(of_set).collect()
}

/// Whether two units are one.
fn is_one(ratio: f64) -> bool {
    (ratio - 1.0).abs() < SAME_UNIT
}

/// What a column is that is twice or half of what it says.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Twice {
    /// A coordinate given as a diameter.
    Diameter,
    /// A channel set to another range.
    Gain,
    /// A displacement that counts the way of the beam there and back, or half of that of the reflector.
    Path,
}

/// Columns that are twice or half of what they say, each alone.
pub(crate) fn doubled(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    twice: Twice,
) -> Vec<Hypothesis> {
    let (effect, what, why) = match twice {
        Twice::Diameter => ("input:diameter", "coordinate", "as a diameter is of a radius"),
        Twice::Gain => {
            ("input:gain", "reading", "a factor of two, as of a channel set to another range")
        }
        Twice::Path => {
            ("input:unit", "displacement", "the factor two of a beam that goes there and back")
        }
    };
    let of_column = |column: &str| {
        [("twice", 0.5), ("half of", 2.0)].map(|(how, factor)| {
            let description = format!(
                "`{column}` of {file} is {how} the {what}: multiply by {} ({why})",
                shown(factor)
            );
            let change = Change::Scale { columns: owned(&[column]), rows: None, factor };
            Hypothesis::of(effect, (file, &[column]), description, vec![Edit { file, change }])
        })
    };
    present(table, columns).into_iter().flat_map(of_column).collect()
}

/// All columns, where there are several, and each alone.
pub(super) fn all_and_each<'c>(columns: &[&'c str]) -> Vec<Vec<&'c str>> {
    let all = (columns.len() > 1).then(|| columns.to_vec());
    all.into_iter().chain(columns.iter().map(|column| vec![*column])).collect()
}

/// Fewest rows on either side of one from which on the unit is another.
const FEWEST_OF_A_UNIT: usize = 4;
/// Size of the readings before and after over that, times or a part of a factor between units, as far as it
/// may be off: what is measured need not be as large everywhere.
const NEAR_FACTOR: f64 = 2.0;

/// Columns in another unit from a row on, or up to there, all and each alone: where the size of the readings
/// changes most clearly, and a row to either side.
pub(crate) fn units_from_a_row(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let sets = all_and_each(&present(Some(table), columns));
    sets.iter().flat_map(|set| of_set_from_a_row(file, table, set, dimension)).collect()
}

fn of_set_from_a_row(
    file: &'static str,
    table: &Table,
    columns: &[&str],
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let read: Option<Vec<Vec<f64>>> = columns.iter().map(|column| table.numbers(column)).collect();
    let Some(read) = read else { return Vec::new() };
    let n = table.n_rows();
    let Some((row, change)) = change_of_size(&read, n) else { return Vec::new() };
    let Some(declared) = table.unit_of(columns) else { return Vec::new() };
    let of = |effect: &'static str, what: &str, factor: f64| {
        let is_near = |ratio: f64| (ratio / factor).ln().abs() < NEAR_FACTOR.ln();
        // Numbers in a larger unit are smaller.
        let is_after = is_near(1.0 / change);
        if !is_after && !is_near(change) {
            return Vec::new();
        }
        let at = |row: usize| {
            let rows: Vec<usize> = if is_after { (row..n).collect() } else { (0..row).collect() };
            let description = format!(
                "{} of {file} {} {what} from line {} to line {}: multiply these by {}",
                listed(columns),
                is_or_are(columns),
                table.line(rows[0]),
                table.line(rows[rows.len() - 1]),
                shown(factor)
            );
            let change = Change::Scale { columns: owned(columns), rows: Some(rows), factor };
            Hypothesis::of(effect, (file, columns), description, vec![Edit { file, change }])
        };
        (row.saturating_sub(1).max(1)..=(row + 1).min(n - 1)).map(at).collect()
    };
    let own = dimension.name_of(declared);
    let units = dimension.instead_of(declared).flat_map(|(unit, factor)| {
        let what = format!("in another unit than in the other rows, {unit} instead of {own},");
        of("input:unit", &what, factor)
    });
    let ten = "ten or a hundred times what it is in the other rows, or so small a part of it (another range, a decimal \
               point),";
    let tenfold = dimension.tenfold(declared).flat_map(|f| of("input:decimal-point", ten, f));
    units.chain(tenfold).collect()
}

/// The row from which on the readings have most clearly another size, and how many times that of those before.
fn change_of_size(read: &[Vec<f64>], n: usize) -> Option<(usize, f64)> {
    let square = |row: usize| read.iter().map(|column| column[row].powi(2)).sum::<f64>();
    let whole: f64 = (0..n).map(square).sum();
    let mut before = 0.0;
    let mut best: Option<(f64, usize, f64)> = None;
    for row in 1..n {
        before += square(row - 1);
        if row < FEWEST_OF_A_UNIT || n - row < FEWEST_OF_A_UNIT {
            continue;
        }
        let [first, last] = [count(row), count(n - row)];
        let [size, after] = [before / first, (whole - before).max(0.0) / last];
        // Of normal deviates with two variances.
        let likelihood = -first * size.ln() - last * after.ln();
        if size > 0.0 && after > 0.0 && best.is_none_or(|(most, ..)| likelihood > most) {
            best = Some((likelihood, row, (after / size).sqrt()));
        }
    }
    best.map(|(_, row, change)| (row, change))
}

/// All lengths of some tables in metres: nothing but the declared noise then says so.
pub(crate) fn all_in_metres(tables: &[(&'static str, Option<&Table>, &[&str])]) -> Vec<Hypothesis> {
    const MM_PER_M: f64 = 1e3;
    let there: Vec<(&'static str, Vec<&str>)> = (tables.iter())
        .filter_map(|(file, table, columns)| Some((*file, (*table)?, columns)))
        .map(|(file, table, columns)| (file, present(Some(table), columns)))
        .filter(|(_, columns)| !columns.is_empty())
        .collect();
    let Some((first, columns)) = there.first() else { return Vec::new() };
    let named: Vec<String> =
        there.iter().map(|(file, columns)| format!("{} of {file}", listed(columns))).collect();
    let description = format!(
        "{} are in another unit than their names say, metres instead of mm: multiply by {}",
        named.join(" and "),
        shown(MM_PER_M)
    );
    let edit = |(file, columns): &(&'static str, Vec<&str>)| {
        let change = Change::Scale { columns: owned(columns), rows: None, factor: MM_PER_M };
        Edit { file, change }
    };
    let edits = there.iter().map(edit).collect();
    vec![Hypothesis::of("input:unit", (first, columns), description, edits)]
}

/// A factor with as many digits as it takes.
pub(super) fn shown(factor: f64) -> String {
    let short = format!("{factor:.6}");
    let short = short.trim_end_matches('0').trim_end_matches('.');
    if factor.abs() < 0.01 { format!("{factor:.6e}") } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::change_of_size;

    #[test]
    fn the_row_from_which_on_readings_are_smaller_is_found() {
        let read: Vec<f64> = (0..30)
            .map(|i| (f64::from(i) * 0.7).cos() * if i < 13 { 100.0 } else { 100.0 / 25.4 })
            .collect();
        let (row, change) = change_of_size(&[read], 30).expect("thirty rows");
        assert_eq!(row, 13);
        assert!((change * 25.4 - 1.0).abs() < 0.3, "{change}");
    }
}
