//! Which way an axis came, and which readings were made in one pass.

use std::collections::{BTreeSet, HashMap};

use ft_center::{Approach, AxisReading};

use crate::Error;
use crate::case::{Columns, Table};

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

/// Fewest passes that are left out in turn; of fewer every reading is one by itself.
const FEWEST_PASSES: usize = 4;

/// Whether a column `direction` says of every row which way the axis came.
pub(crate) fn has_directions(table: &Table) -> bool {
    let is_word = |cell: &str| WORDS.iter().any(|(word, _)| *word == cell);
    table
        .column("direction")
        .is_some_and(|column| (0..table.n_rows()).all(|row| is_word(table.cell(row, column))))
}

/// The column `direction`.
pub(crate) fn approaches(columns: &mut Columns<'_>) -> Result<Vec<Option<Approach>>, Error> {
    columns.words("direction", &WORDS, None)
}

/// From the target before; the first, and those that stay, as they go on.
pub(crate) fn derived(targets: &[f64]) -> Vec<Option<Approach>> {
    let way = |from: f64, to: f64| match to.total_cmp(&from) {
        std::cmp::Ordering::Greater => Some(Approach::Rising),
        std::cmp::Ordering::Less => Some(Approach::Falling),
        std::cmp::Ordering::Equal => None,
    };
    let coming = |i: usize| {
        let before = i.checked_sub(1).and_then(|before| way(targets[before], targets[i]));
        before.or_else(|| way(targets[i], *targets.get(i + 1)?))
    };
    (0..targets.len()).map(coming).collect()
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

/// The pass of every reading, one way in one cycle, and what a group is called.
///
/// Without cycles the visits to each target are counted. Too few passes to leave out in turn: every
/// reading by itself.
pub(crate) fn passes(readings: &[AxisReading], cycles: Option<&[&str]>) -> (Vec<String>, String) {
    let way = |reading: &AxisReading| match reading.approach {
        Some(Approach::Rising) => "rising",
        Some(Approach::Falling) => "falling",
        None => "either way",
    };
    let mut visits: HashMap<(u64, &str), usize> = HashMap::new();
    let passes: Vec<String> = (readings.iter().enumerate())
        .map(|(row, reading)| {
            let way = way(reading);
            if let Some(cycles) = cycles {
                return format!("cycle {}, {way}", cycles[row]);
            }
            let visit = visits.entry(((reading.target + 0.0).to_bits(), way)).or_default();
            *visit += 1;
            format!("visit {visit}, {way}")
        })
        .collect();
    if passes.iter().collect::<BTreeSet<_>>().len() >= FEWEST_PASSES {
        return (passes, "pass".to_owned());
    }
    (readings.iter().map(|reading| reading.name.clone()).collect(), "reading".to_owned())
}
