//! Order of points in which neighbours lie together.

use nalgebra::Point3;

/// Points in a leaf at most, and queries that are answered together: two registers of four `f64`.
pub(crate) const LANES: usize = 8;

/// Ranges below this are split by one thread.
const PARALLEL_MIN: usize = 1 << 14;

/// Points looked at to find the direction in which a range extends most.
const EXTENT_SAMPLES: usize = 256;

#[derive(Clone, Copy)]
struct Entry {
    point: [f64; 3],
    index: u32,
}

/// Smallest power of two for which no leaf holds more than [`LANES`] points.
pub(super) fn n_leaves(n_points: usize) -> usize {
    n_points.div_ceil(LANES).next_power_of_two()
}

pub(super) fn leaf_start(leaf: usize, n_leaves: usize, n_points: usize) -> usize {
    // Leaf counts are powers of two, so that this is a shift.
    (n_points * leaf) >> n_leaves.trailing_zeros()
}

/// The points in the order of a balanced k-d tree's leaves, and where each was.
///
/// Splits at medians across the widest extent.
pub(crate) fn spatial_order(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let count = u32::try_from(points.len()).expect("clouds are checked to have below 2^32 points");
    let mut entries: Vec<Entry> =
        points.iter().zip(0..count).map(|(p, index)| Entry { point: (*p).into(), index }).collect();
    let layout = Layout { n_leaves: n_leaves(points.len()), n_points: points.len() };
    layout.split(&mut entries, 0, layout.n_leaves);
    entries.iter().map(|e| (Point3::from(e.point), e.index)).unzip()
}

#[derive(Clone, Copy)]
struct Layout {
    n_leaves: usize,
    n_points: usize,
}

impl Layout {
    /// Sorts `entries`, which belong to the leaves `first..last`, so that each is in its leaf.
    fn split(self, entries: &mut [Entry], first: usize, last: usize) {
        if last - first < 2 || entries.len() < 2 {
            return;
        }
        let start = |leaf| leaf_start(leaf, self.n_leaves, self.n_points);
        let middle = usize::midpoint(first, last);
        let at = start(middle) - start(first);
        let axis = widest(entries);
        if at < entries.len() {
            entries.select_nth_unstable_by(at, |a, b| a.point[axis].total_cmp(&b.point[axis]));
        }
        let is_large = entries.len() > PARALLEL_MIN;
        let (low, high) = entries.split_at_mut(at);
        if is_large {
            rayon::join(|| self.split(low, first, middle), || self.split(high, middle, last));
        } else {
            self.split(low, first, middle);
            self.split(high, middle, last);
        }
    }
}

fn widest(entries: &[Entry]) -> usize {
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for entry in entries.iter().step_by(entries.len().div_ceil(EXTENT_SAMPLES)) {
        for k in 0..3 {
            min[k] = min[k].min(entry.point[k]);
            max[k] = max[k].max(entry.point[k]);
        }
    }
    let extent = |k: usize| max[k] - min[k];
    let mut axis = 0;
    for k in 1..3 {
        if extent(k) > extent(axis) {
            axis = k;
        }
    }
    axis
}
