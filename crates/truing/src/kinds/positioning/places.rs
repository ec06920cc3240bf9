//! Places at which an axis stopped, and what was read there again and again.

use std::collections::BTreeMap;

use ft_center::Approach;

use crate::count::count;

/// Sides from which a target is come to.
const SIDES: usize = 2;
/// Repeats beyond the one at each place from which on their scatter is known.
const FEWEST_REPEATS: usize = 10;

/// The place of every row: a target come to from one side.
pub(super) struct Places {
    /// Two for each target: come to rising, and falling.
    of_row: Vec<usize>,
    n: usize,
}

/// Mean of what was read at one place.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    pub value: f64,
    pub of: usize,
}

impl Places {
    pub(super) fn of(targets: &[f64], ways: &[Approach]) -> Self {
        let mut known = BTreeMap::new();
        let of_row = |(target, way): (&f64, &Approach)| {
            let next = known.len();
            let target = *known.entry(target.to_bits()).or_insert(next);
            SIDES * target + usize::from(*way == Approach::Falling)
        };
        let of_row = targets.iter().zip(ways).map(of_row).collect();
        Self { of_row, n: SIDES * known.len() }
    }

    pub(super) fn of_row(&self, row: usize) -> usize {
        self.of_row[row]
    }

    /// Mean at every place, over the rows that are asked for; `None` where there are none.
    pub(super) fn means(&self, values: &[f64], is_in: impl Fn(usize) -> bool) -> Vec<Option<Mean>> {
        let mut sums = vec![(0, 0.0); self.n];
        for row in (0..values.len()).filter(|row| is_in(*row)) {
            let (n, sum) = &mut sums[self.of_row[row]];
            *n += 1;
            *sum += values[row];
        }
        let mean = |(of, sum)| (of > 0).then(|| Mean { value: sum / count(of), of });
        sums.into_iter().map(mean).collect()
    }

    /// Means of the targets that were come to from both sides: rising, falling.
    pub(super) fn both_sides(&self, values: &[f64]) -> Vec<[Mean; SIDES]> {
        let means = self.means(values, |_| true);
        means.chunks_exact(SIDES).filter_map(|side| Some([side[0]?, side[1]?])).collect()
    }

    /// Scatter of the repeats about the means of their places, over the rows that are asked for; `None` of too few.
    pub(super) fn scatter(&self, values: &[f64], is_in: impl Fn(usize) -> bool) -> Option<f64> {
        let means = self.means(values, &is_in);
        let rows = || (0..values.len()).filter(|row| is_in(*row));
        let of_places = means.iter().flatten().count();
        let dof = rows().count().checked_sub(of_places).filter(|dof| *dof >= FEWEST_REPEATS)?;
        let off = |row: usize| means[self.of_row[row]].map_or(0.0, |mean| values[row] - mean.value);
        Some((rows().map(|row| off(row).powi(2)).sum::<f64>() / count(dof)).sqrt())
    }
}
