//! Order of points in which neighbours lie together.

use nalgebra::Point3;

/// Points in a leaf at most, and queries that are answered together: two registers of four `f64`.
pub(crate) const LANES: usize = 8;

/// Ranges below this are split by one thread.
const PARALLEL_MIN: usize = 1 << 13;

/// Levels of the tree that one distribution into slices makes.
const LEVELS_AT_ONCE: u32 = 3;

/// Parts that those levels have.
const PARTS: usize = 1 << LEVELS_AT_ONCE;

/// Ranges below this are halved: distribution costs as much as its slices are many.
const DISTRIBUTE_MIN: usize = 96;

/// Slices that a range is distributed into at most.
const MAX_SLICES: usize = 1 << 11;

/// Points to a slice, in the mean, as long as there are not too many slices.
const POINTS_PER_SLICE: usize = 2;

/// A point, from the corner of all points, and its place among them.
///
/// Single precision decides who is whose neighbour, and nothing else: boxes and distances come from
/// the points themselves.
#[derive(Clone, Copy)]
struct Entry {
    point: [f32; 3],
    index: u32,
}

impl Entry {
    const NONE: Self = Self { point: [0.0; 3], index: 0 };
}

/// Smallest power of two for which no leaf holds more than [`LANES`] points.
pub(crate) fn n_leaves(n_points: usize) -> usize {
    n_points.div_ceil(LANES).next_power_of_two()
}

pub(crate) fn leaf_start(leaf: usize, n_leaves: usize, n_points: usize) -> usize {
    // Leaf counts are powers of two, so that this is a shift.
    (n_points * leaf) >> n_leaves.trailing_zeros()
}

/// The leaf that a slot belongs to.
pub(crate) fn leaf_of(slot: usize, n_leaves: usize, n_points: usize) -> usize {
    ((slot + 1) * n_leaves - 1) / n_points
}

/// The points in the order of a balanced k-d tree's leaves, and where each was.
///
/// Splits at medians across the widest extent, three levels at a time as long as there are many.
pub(crate) fn spatial_order(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let mut entries = entries(points);
    let mut room = vec![Entry::NONE; entries.len()];
    let layout = Layout { n_leaves: n_leaves(points.len()), n_points: points.len() };
    layout.split(&mut entries, &mut room, 0, layout.n_leaves);
    let order: Vec<u32> = entries.iter().map(|e| e.index).collect();
    (order.iter().map(|&i| points[i as usize]).collect(), order)
}

fn entries(points: &[Point3<f64>]) -> Vec<Entry> {
    let count = u32::try_from(points.len()).expect("clouds are checked to have below 2^32 points");
    let mut corner = [f64::INFINITY; 3];
    for point in points {
        for k in 0..3 {
            corner[k] = if point[k] < corner[k] { point[k] } else { corner[k] };
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "a choice of neighbours, not a result")]
    let from_corner = |p: &Point3<f64>| [0, 1, 2].map(|k| (p[k] - corner[k]) as f32);
    let entry = |(point, index)| Entry { point: from_corner(point), index };
    points.iter().zip(0..count).map(entry).collect()
}

#[derive(Clone, Copy)]
struct Layout {
    n_leaves: usize,
    n_points: usize,
}

impl Layout {
    /// Where the points of a leaf begin in `entries`, which belong to the leaves from `first` on.
    fn start(self, leaf: usize, first: usize) -> usize {
        leaf_start(leaf, self.n_leaves, self.n_points)
            - leaf_start(first, self.n_leaves, self.n_points)
    }

    /// Sorts `entries`, which belong to the leaves `first..last`, so that each is in its leaf.
    fn split(self, entries: &mut [Entry], room: &mut [Entry], first: usize, last: usize) {
        if last - first < 2 || entries.len() < 2 {
            return;
        }
        let extent = Extent::of(entries);
        if entries.len() >= DISTRIBUTE_MIN && last - first >= PARTS && extent.width > 0.0 {
            let each = (last - first) / PARTS;
            let cuts: [usize; PARTS + 1] =
                std::array::from_fn(|part| self.start(first + part * each, first));
            distribute(entries, room, &extent, &cuts[1..PARTS]);
            self.split_parts(entries, room, first, last, LEVELS_AT_ONCE);
            return;
        }
        let middle = usize::midpoint(first, last);
        let at = self.start(middle, first);
        if at < entries.len() {
            select(entries, at, extent.axis);
        }
        self.split_parts(entries, room, first, last, 1);
    }

    /// Goes on with the parts of a range that is sorted into `2^levels` of them.
    fn split_parts(
        self,
        entries: &mut [Entry],
        room: &mut [Entry],
        first: usize,
        last: usize,
        levels: u32,
    ) {
        if levels == 0 {
            return self.split(entries, room, first, last);
        }
        let middle = usize::midpoint(first, last);
        let is_large = entries.len() > PARALLEL_MIN;
        let at = self.start(middle, first);
        let (low, high) = entries.split_at_mut(at);
        let (low_room, high_room) = room.split_at_mut(at);
        let mut lower = || self.split_parts(low, low_room, first, middle, levels - 1);
        let mut upper = || self.split_parts(high, high_room, middle, last, levels - 1);
        if is_large {
            rayon::join(lower, upper);
        } else {
            lower();
            upper();
        }
    }
}

/// The axis along which entries extend furthest.
struct Extent {
    axis: usize,
    min: f32,
    width: f32,
}

impl Extent {
    fn of(entries: &[Entry]) -> Self {
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for entry in entries {
            for k in 0..3 {
                let x = entry.point[k];
                min[k] = if x < min[k] { x } else { min[k] };
                max[k] = if x > max[k] { x } else { max[k] };
            }
        }
        let width = |k: usize| max[k] - min[k];
        let mut axis = 0;
        for k in 1..3 {
            if width(k) > width(axis) {
                axis = k;
            }
        }
        Self { axis, min: min[axis], width: width(axis) }
    }
}

/// Brings what lies below each cut along the axis before it: by slices, then within the slice that
/// a cut goes through.
fn distribute(entries: &mut [Entry], room: &mut [Entry], extent: &Extent, cuts: &[usize]) {
    let n_slices = (entries.len() / POINTS_PER_SLICE).next_power_of_two().min(MAX_SLICES);
    #[expect(clippy::cast_precision_loss, reason = "a power of two")]
    let scale = n_slices as f32 / extent.width;
    let slice = |entry: &Entry| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "casts saturate; the last slice takes what rounding puts beyond it"
        )]
        let slice = ((entry.point[extent.axis] - extent.min) * scale) as usize;
        slice.min(n_slices - 1)
    };
    let mut starts = [0_u32; MAX_SLICES + 1];
    for entry in &*entries {
        starts[slice(entry) + 1] += 1;
    }
    for s in 0..n_slices {
        starts[s + 1] += starts[s];
    }
    let mut next = starts;
    for entry in &*entries {
        let at = &mut next[slice(entry)];
        room[*at as usize] = *entry;
        *at += 1;
    }
    entries.copy_from_slice(room);
    let mut s = 0;
    let mut sorted = 0;
    for &cut in cuts {
        while starts[s + 1] as usize <= cut && s + 1 < n_slices {
            s += 1;
        }
        let from = sorted.max(starts[s] as usize);
        let to = starts[s + 1] as usize;
        if cut > from && cut < to {
            select(&mut entries[from..to], cut - from, extent.axis);
        }
        sorted = cut;
    }
}

fn select(entries: &mut [Entry], at: usize, axis: usize) {
    entries.select_nth_unstable_by(at, |a, b| a.point[axis].total_cmp(&b.point[axis]));
}

#[cfg(test)]
mod tests {
    use super::{leaf_of, leaf_start, n_leaves};

    #[test]
    fn every_slot_lies_in_its_leaf() {
        for n_points in [1, 2, 7, 8, 9, 17, 100, 1000, 4097] {
            let n_leaves = n_leaves(n_points);
            for slot in 0..n_points {
                let leaf = leaf_of(slot, n_leaves, n_points);
                let start = |leaf| leaf_start(leaf, n_leaves, n_points);
                assert!((start(leaf)..start(leaf + 1)).contains(&slot), "{slot} of {n_points}");
            }
        }
    }
}
