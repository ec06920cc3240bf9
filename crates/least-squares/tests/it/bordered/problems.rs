//! Bordered problems that several tests share.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem, Pattern};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Ranges from stations to one target per block, each less an offset of its station: shared are
/// three coordinates and an offset per station, and a prior on each offset.
///
/// Six coordinates of the first three stations are for the caller to hold.
pub(crate) struct Ranging {
    pub(crate) stations: usize,
    /// By block and station; NaN where absent.
    pub(crate) ranges: Vec<f64>,
    pub(crate) sigma: f64,
    pub(crate) offset_sigma: f64,
    patterns: Vec<Pattern>,
}

/// Coordinates that fix where the stations are, as directions of [`Ranging`].
pub(crate) const GAUGE: [usize; 6] = [0, 1, 2, 4, 5, 8];

impl Ranging {
    pub(crate) fn new(stations: usize, ranges: Vec<f64>, sigma: f64) -> Self {
        let mut pattern = Pattern::new();
        for i in 0..stations {
            pattern.push(&[0, 1, 2], &[3 * i, 3 * i + 1, 3 * i + 2, 3 * stations + i]);
        }
        Self { stations, ranges, sigma, offset_sigma: 1.0, patterns: vec![pattern] }
    }

    /// The truth, readings of it, and a start some distance away.
    pub(crate) fn simulate(
        stations: usize,
        targets: usize,
        sigma: f64,
        away: f64,
        seed: u64,
    ) -> (BorderedPoint, Self, BorderedPoint) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let corners = [
            [0.0, 0.0, 0.0],
            [800.0, 0.0, 0.0],
            [100.0, 700.0, 0.0],
            [700.0, 600.0, 500.0],
            [400.0, 100.0, 600.0],
            [50.0, 650.0, 550.0],
        ];
        let mut shared: Vec<f64> = corners[..stations].concat();
        shared.extend((0..stations).map(|_| rng.random_range(-1.0..1.0)));
        let blocks = (0..3 * targets).map(|_| rng.random_range(100.0..900.0)).collect();
        let truth = BorderedPoint { shared, blocks };
        let noise = Normal::new(0.0, sigma).unwrap();
        let mut ranges = Vec::new();
        for target in truth.blocks.chunks(3) {
            for i in 0..stations {
                let distance = distance(target, &truth.shared[3 * i..][..3]);
                ranges.push(distance - truth.shared[3 * stations + i] + noise.sample(&mut rng));
            }
        }
        let mut start = truth.clone();
        start.shared.iter_mut().for_each(|v| *v += rng.random_range(-away..=away));
        start.blocks.iter_mut().for_each(|v| *v += rng.random_range(-away..=away));
        for i in GAUGE {
            start.shared[i] = truth.shared[i];
        }
        (truth, Self::new(stations, ranges, sigma), start)
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

impl BorderedProblem for Ranging {
    fn shared_dim(&self) -> usize {
        4 * self.stations
    }

    fn block_dim(&self) -> usize {
        3
    }

    fn block_count(&self) -> usize {
        self.ranges.len() / self.stations
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn observed_count(&self, block: usize) -> usize {
        let ranges = &self.ranges[block * self.stations..][..self.stations];
        ranges.iter().filter(|l| !l.is_nan()).count()
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            let reading = self.ranges[block * self.stations + i];
            let offset = shared[3 * self.stations + i];
            let residual = (distance(point, &shared[3 * i..][..3]) - offset - reading) / self.sigma;
            *out = if reading.is_nan() { 0.0 } else { residual };
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        self.residuals(block, shared, point, rows.residuals);
        let by_shared = rows.by_shared.chunks_exact_mut(4);
        for (i, (own, shared_row)) in rows.by_block.chunks_exact_mut(3).zip(by_shared).enumerate() {
            let station = &shared[3 * i..][..3];
            let present = !self.ranges[block * self.stations + i].is_nan();
            let weight = f64::from(u8::from(present)) / self.sigma;
            let length = distance(point, station);
            for c in 0..3 {
                own[c] = weight * (point[c] - station[c]) / length;
                shared_row[c] = -own[c];
            }
            shared_row[3] = -weight;
        }
    }

    fn shared_residual_count(&self) -> usize {
        self.stations
    }

    fn linearise_shared(&self, shared: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) {
        jacobian.fill(0.0);
        for i in 0..self.stations {
            residuals[i] = shared[3 * self.stations + i] / self.offset_sigma;
            jacobian[i * self.shared_dim() + 3 * self.stations + i] = 1.0 / self.offset_sigma;
        }
    }

    fn shared_name(&self, index: usize) -> String {
        match index.checked_sub(3 * self.stations) {
            Some(station) => format!("offset of station {station}"),
            None => format!("{} of station {}", ["x", "y", "z"][index % 3], index / 3),
        }
    }

    fn block_name(&self, block: usize, index: usize) -> String {
        format!("{} of target {block}", ["x", "y", "z"][index])
    }
}

/// Poses of one body from the coordinates of its markers: shared are the markers, three numbers
/// each, of which the first pose, for the caller to hold, fixes where the body's frame is. A
/// pose is a quaternion (i, j, k, w) and a translation; every other block sees one marker less.
pub(crate) struct Poses {
    markers: usize,
    /// By block, marker and coordinate.
    coordinates: Vec<f64>,
    sigma: f64,
    patterns: Vec<Pattern>,
}

impl Poses {
    pub(crate) fn simulate(
        markers: usize,
        poses: usize,
        sigma: f64,
        seed: u64,
    ) -> (Self, BorderedPoint) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut vector = |half: f64| Vector3::from_fn(|_, _| rng.random_range(-half..half));
        let body: Vec<Vector3<f64>> = (0..markers).map(|_| vector(100.0)).collect();
        let mut coordinates = Vec::new();
        let mut start = BorderedPoint { shared: Vec::new(), blocks: Vec::new() };
        for block in 0..poses {
            let truth = if block == 0 {
                Isometry3::identity()
            } else {
                Isometry3::new(vector(300.0), vector(1.0))
            };
            for marker in &body {
                let noise = vector(1.0) * (sigma * 3_f64.sqrt());
                let seen = (truth * Point3::from(*marker)).coords + noise;
                coordinates.extend_from_slice(seen.as_slice());
            }
            let near =
                if block == 0 { truth } else { Isometry3::new(vector(1.0), vector(0.02)) * truth };
            start.blocks.extend_from_slice(near.rotation.coords.as_slice());
            start.blocks.extend_from_slice(near.translation.vector.as_slice());
        }
        for marker in &body {
            start.shared.extend_from_slice((marker + vector(0.5)).as_slice());
        }
        let pattern = |seen: usize| {
            let mut pattern = Pattern::new();
            for row in 0..3 * seen {
                let first = 3 * (row / 3);
                pattern.push(&[0, 1, 2, 3, 4, 5], &[first, first + 1, first + 2]);
            }
            pattern
        };
        let patterns = vec![pattern(markers), pattern(markers - 1)];
        (Self { markers, coordinates, sigma, patterns }, start)
    }
}

fn pose(numbers: &[f64]) -> Isometry3<f64> {
    let [i, j, k, w] = [numbers[0], numbers[1], numbers[2], numbers[3]];
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Translation3::new(numbers[4], numbers[5], numbers[6]), rotation)
}

/// A unit quaternion and a position.
const POSE_NUMBERS: usize = 7;

impl BorderedProblem for Poses {
    fn shared_dim(&self) -> usize {
        3 * self.markers
    }

    fn block_dim(&self) -> usize {
        6
    }

    fn block_count(&self) -> usize {
        self.coordinates.len() / (3 * self.markers)
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        block % 2
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let pose = pose(point);
        let seen = self.coordinates[block * 3 * self.markers..].chunks_exact(3);
        for ((out, marker), seen) in out.chunks_exact_mut(3).zip(shared.chunks_exact(3)).zip(seen) {
            let predicted = pose * Point3::new(marker[0], marker[1], marker[2]);
            for c in 0..3 {
                out[c] = (predicted[c] - seen[c]) / self.sigma;
            }
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        self.residuals(block, shared, point, rows.residuals);
        let pose = pose(point);
        let rotation = pose.rotation.to_rotation_matrix();
        let by_shared = rows.by_shared.chunks_exact_mut(9);
        let by_block = rows.by_block.chunks_exact_mut(18);
        for ((own, of_marker), marker) in by_block.zip(by_shared).zip(shared.chunks_exact(3)) {
            let moved = (pose * Point3::new(marker[0], marker[1], marker[2])).coords;
            let turned = -moved.cross_matrix();
            for row in 0..3 {
                for c in 0..3 {
                    own[6 * row + c] = f64::from(u8::from(row == c)) / self.sigma;
                    own[6 * row + 3 + c] = turned[(row, c)] / self.sigma;
                    of_marker[3 * row + c] = rotation[(row, c)] / self.sigma;
                }
            }
        }
    }

    fn is_point(&self, point: &BorderedPoint) -> bool {
        point.shared.len() == self.shared_dim()
            && point.blocks.len() == POSE_NUMBERS * self.block_count()
    }

    /// `T = exp(ξ) T̂`, translation first and apart from the rotation.
    fn retract_block(&self, _: usize, point: &[f64], step: &[f64], out: &mut [f64]) {
        let shift = Vector3::new(step[0], step[1], step[2]);
        let turn = Vector3::new(step[3], step[4], step[5]);
        let moved = Isometry3::new(shift, turn) * pose(point);
        out[..4].copy_from_slice(moved.rotation.coords.as_slice());
        out[4..].copy_from_slice(moved.translation.vector.as_slice());
    }
}
