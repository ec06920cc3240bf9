//! Rows without which the others are right.

use std::ops::Range;

use rayon::prelude::*;

/// Parts of the rows that are left out to find a stretch, in sixteenths: each is tried from every half of it on.
const PARTS: [usize; 9] = [1, 2, 4, 6, 8, 9, 10, 11, 12];
/// Rows of a stretch looked at one by one, at most.
const MOST_SINGLE: usize = 64;
/// Stretches looked at, at most: where half of the rows are wrong, the others are as likely.
const MOST: usize = 2;

/// The shortest stretches of `n` rows that are known to be wrong, as the others are right `without` them.
pub(super) fn shortest(
    (n, fewest): (usize, usize),
    without: &(impl Fn(&Range<usize>) -> bool + Sync),
) -> Vec<Range<usize>> {
    for part in PARTS {
        let length = (n * part / 16).max(fewest + usize::from(fewest > 1)).min(n - 1);
        let step = (length / 2).min(n / 8).max(1);
        let starts = (0..n - length).step_by(step).chain([n - length]);
        let parts: Vec<_> = starts.map(|start| start..start + length).collect();
        let mut known: Vec<Range<usize>> = parts.into_par_iter().filter(without).collect();
        known.truncate(MOST);
        if !known.is_empty() {
            let mut all: Vec<_> = known.into_iter().map(|rows| cut_down(rows, without)).collect();
            all.retain(|rows| rows.len() >= fewest);
            all.dedup();
            return all;
        }
    }
    Vec::new()
}

/// Those of some rows without which the others are right: each is put back that can be.
pub(super) fn only_wrong(rows: Vec<usize>, without: &impl Fn(&[usize]) -> bool) -> Vec<usize> {
    let mut wrong = rows.clone();
    if rows.len() > MOST_SINGLE {
        return wrong;
    }
    for row in rows {
        let fewer: Vec<usize> = wrong.iter().copied().filter(|other| *other != row).collect();
        if !fewer.is_empty() && without(&fewer) {
            wrong = fewer;
        }
    }
    wrong
}

/// A stretch without the rows at its ends that need not be left out.
fn cut_down(rows: Range<usize>, without: &impl Fn(&Range<usize>) -> bool) -> Range<usize> {
    // The last start and the first end with which the others are right.
    let (mut low, mut high) = (rows.start, rows.end);
    while low + 1 < high {
        let middle = low.midpoint(high);
        if without(&(middle..rows.end)) { low = middle } else { high = middle }
    }
    let start = low;
    let (mut low, mut high) = (start, rows.end);
    while low + 1 < high {
        let middle = low.midpoint(high);
        if without(&(start..middle)) { high = middle } else { low = middle }
    }
    start..high
}

#[cfg(test)]
mod tests {
    use super::shortest;

    #[test]
    fn a_stretch_is_found_to_the_row_wherever_it_lies() {
        for wrong in [0..4, 3..7, 11..16, 20..40, 36..40, 5..35] {
            let without = |rows: &std::ops::Range<usize>| {
                rows.start <= wrong.start && rows.end >= wrong.end && rows.len() < 39
            };
            assert_eq!(shortest((40, 3), &without), std::slice::from_ref(&wrong), "{wrong:?}");
        }
    }

    #[test]
    fn one_row_is_no_stretch() {
        let without = |rows: &std::ops::Range<usize>| rows.contains(&9);
        assert!(shortest((40, 3), &without).is_empty());
    }
}
