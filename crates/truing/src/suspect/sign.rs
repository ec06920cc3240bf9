use super::hypothesis::{Hypothesis, listed, owned, present};
use crate::case::{Change, Edit, Table};

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
