use super::hypothesis::Hypothesis;
use super::order::blocks_shifted;
use crate::case::Table;
use crate::count::count;
use crate::measured::Fitted;

/// Times the median residual from which on a row is far off.
const FAR: f64 = 5.0;
/// Fewest rows of a stretch, and the share of them that must be far off: of two neighbours a shift makes
/// little where they are alike.
const FEWEST: usize = 4;
const MOSTLY: f64 = 0.6;

/// Columns one row further down or up in the one stretch of rows that is far off: of a run that was typed from
/// the wrong line.
pub(crate) fn stretch_shifted(
    file: &'static str,
    table: Option<&Table>,
    sets: &[&[&str]],
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let Some((table, fitted)) = table.zip(fitted) else { return Vec::new() };
    let Some((first, last)) = far_off(fitted).filter(|(_, last)| *last < table.n_rows()) else {
        return Vec::new();
    };
    let said = format!(" from line {} to line {}", table.line(first), table.line(last));
    let stretch = first..last + 1;
    let block = (std::slice::from_ref(&stretch), &*said);
    let of_set = |columns: &&[&str]| {
        [1, -1].map(|by| blocks_shifted((file, table), columns, block, by)).concat()
    };
    sets.iter().flat_map(of_set).collect()
}

/// First and last row of those far off, where most between them are and others are not.
fn far_off(fitted: &Fitted) -> Option<(usize, usize)> {
    let norms: Vec<f64> = fitted.observations.iter().map(|o| o.square().sqrt()).collect();
    let mut sorted = norms.clone();
    sorted.sort_by(f64::total_cmp);
    let far = FAR * sorted.get(sorted.len() / 2)?;
    let first = norms.iter().position(|norm| *norm > far)?;
    let last = norms.iter().rposition(|norm| *norm > far)?;
    let n = last - first + 1;
    let among = norms[first..=last].iter().filter(|norm| **norm > far).count();
    let are_most = count(among) >= MOSTLY * count(n);
    (n >= FEWEST && are_most).then_some((first, last))
}
