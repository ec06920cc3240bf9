//! A stretch of readings that scatters otherwise than all others.

use statrs::distribution::{Binomial, DiscreteCDF};

use crate::Remaining;
use crate::count::count;
use crate::levels::ODD_STRETCH;
use crate::model::covariate::ORDER;
use crate::noise::linear::Linear;

/// Readings of a stretch, and beside it, at least.
const FEWEST: usize = 6;
const FEWEST_OTHERS: usize = 12;
/// Most readings of which every stretch is looked at.
const MOST: usize = 2000;
/// Medians of what the others are off by from which on a reading counts as far off, and that a stretch has in the middle.
const FAR: f64 = 3.0;
const MUCH: f64 = 5.0;
/// Mean of a stretch over its root mean square, at most: what lies to one side is an offset.
const TO_ONE_SIDE: f64 = 0.5;

/// Readings one after the other that scatter several times as much as all others, about the same middle, where no other
/// reading is off by as much as theirs in the middle.
///
/// Noise may be uneven, and grows with something then; what begins at one reading and ends at another is of another unit,
/// instrument or hand. Held against the others is how many of the stretch are off by three times what is usual among these
/// (binomial), for every stretch that was looked at.
pub(crate) fn odd_stretch(lin: &Linear<'_>) -> Option<Remaining> {
    let off = off(lin);
    let n = off.len();
    if !(FEWEST + FEWEST_OTHERS..=MOST).contains(&n) {
        return None;
    }
    let usual = median(off.iter().map(|(_, size, _)| *size));
    // It begins and ends with readings that are far off, and so are most between.
    let far: Vec<usize> = (0..n).filter(|&at| off[at].1 > FAR * usual).collect();
    let mut best: Option<(f64, usize, usize, f64)> = None;
    for (i, &first) in far.iter().enumerate() {
        for (j, &last) in far.iter().enumerate().skip(i + FEWEST / 2) {
            let own = last + 1 - first;
            let are_most = 2 * (j + 1 - i) > own;
            if !are_most || own < FEWEST || n - own < FEWEST_OTHERS || 2 * own > n {
                continue;
            }
            let Some((p_value, times)) = scatters_more(&off, first, last) else { continue };
            if best.is_none_or(|(least, ..)| p_value < least) {
                best = Some((p_value, first, last, times));
            }
        }
    }
    let (p_value, first, last, times) = best?;
    let p_value = (p_value * count(n) * count(n) / 2.0).min(1.0);
    let name = |at: usize| &lin.layout.groups[lin.layout.observations[off[at].0]].name;
    (p_value <= ODD_STRETCH).then(|| Remaining {
        covariate: ORDER.to_owned(),
        shape: format!(
            "{} readings one after the other, from {} to {}, scatter {times:.0} times as much as all others: look there for \
             another unit or instrument",
            last + 1 - first,
            name(first),
            name(last)
        ),
        p_value,
    })
}

/// Every fitted observation with the size of what is left of it, and with its first component.
fn off(lin: &Linear<'_>) -> Vec<(usize, f64, f64)> {
    let residual = lin.clean_residual();
    let mut all: Vec<(usize, f64, f64)> = Vec::new();
    for (i, &row) in lin.rows.iter().enumerate() {
        let row = &lin.layout.rows[row];
        if !row.reported {
            continue;
        }
        match all.last_mut().filter(|(observation, ..)| *observation == row.observation) {
            Some((_, size, _)) => *size = size.hypot(residual[i]),
            None => all.push((row.observation, residual[i].abs(), residual[i])),
        }
    }
    all
}

/// Significance and size of the scatter from `first` to `last` beside that of all others.
fn scatters_more(off: &[(usize, f64, f64)], first: usize, last: usize) -> Option<(f64, f64)> {
    let own = &off[first..=last];
    let others = || off[..first].iter().chain(&off[last + 1..]).map(|(_, size, _)| *size);
    let (middle, usual) = (median(own.iter().map(|(_, size, _)| *size)), median(others()));
    let n = count(own.len());
    let mean = own.iter().map(|(.., value)| value).sum::<f64>() / n;
    let rms = (own.iter().map(|(.., value)| value * value).sum::<f64>() / n).sqrt();
    let is_more = usual > 0.0
        && middle >= MUCH * usual
        && others().all(|size| size <= middle)
        && mean.abs() <= TO_ONE_SIDE * rms;
    if !is_more {
        return None;
    }
    let are_far = |sizes: &mut dyn Iterator<Item = f64>| sizes.filter(|s| *s > FAR * usual).count();
    let share = (count(are_far(&mut others())) + 1.0) / (count(off.len() - own.len()) + 1.0);
    let far = are_far(&mut own.iter().map(|(_, size, _)| *size));
    let law = Binomial::new(share, own.len() as u64).ok()?;
    Some((law.sf((far - 1) as u64), middle / usual))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What scatters evenly, without visible order, by so much.
    fn even(n: usize, size: f64) -> impl Iterator<Item = (usize, f64, f64)> {
        (0..n).map(move |i| {
            let value = size * (2.0 * (0.618_034 * count(i * i + 3)).fract() - 1.0);
            (i, value.abs(), value)
        })
    }

    #[test]
    fn twelve_readings_that_scatter_ten_times_as_much_are_no_chance() {
        let off: Vec<_> = even(20, 1.0).chain(even(12, 10.0)).chain(even(20, 1.0)).collect();
        let (p_value, times) = scatters_more(&off, 20, 31).expect("it scatters more");
        assert!(p_value < 1e-9 && (5.0..20.0).contains(&times), "{p_value:e} {times}");
    }

    #[test]
    fn readings_that_lie_to_one_side_do_not_scatter() {
        let aside = even(12, 1.0).map(|(i, _, value)| (i, (value + 10.0).abs(), value + 10.0));
        let off: Vec<_> = even(20, 1.0).chain(aside).chain(even(20, 1.0)).collect();
        assert_eq!(scatters_more(&off, 20, 31), None);
    }
}
