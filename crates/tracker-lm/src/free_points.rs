//! The document's formulation: every target point is free, and distances between reflectors that
//! stay the same are further, weighted rows (\[B\], step S2).
//!
//! `u = |P − S| − (l + L)` and `r = |P_j − P_j'| − d_jj'`, one block of all points per step.

#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use least_squares::{BlockRows, BorderedPoint, BorderedProblem, Pattern};
use nalgebra::Vector3;

use crate::gauge::{Places, StationChart};
use crate::kinds::Kinds;
use crate::network::Network;
use crate::readings::Readings;
use crate::start::Start;

/// Free points over a network.
#[derive(Clone, Debug)]
pub(crate) struct FreePoints<'a> {
    pub(crate) network: &'a Network<'a>,
    pub(crate) chart: &'a StationChart,
    /// Reciprocals of the standard uncertainties of a range and of a distance.
    weight: f64,
    rigid_weight: f64,
    /// Pairs of mounts that are seen together at some step.
    pairs: Vec<(usize, usize)>,
    /// Rows by kind of step: what is seen at it.
    kinds: Vec<Rows>,
    patterns: Vec<Pattern>,
    kind_of: Vec<usize>,
}

/// Rows of a step, in this order.
#[derive(Clone, Debug)]
struct Rows {
    /// Ranges, from a station to a mount, with their dead paths.
    ranges: Vec<[usize; 3]>,
    /// Number of ways in which the station of each range moves, and the ways of all.
    way_counts: Vec<usize>,
    ways: Vec<Vector3<f64>>,
    /// Distances of pairs of mounts, with those.
    distances: Vec<(usize, [usize; 2])>,
    /// Coordinates of points that were not seen: they stay where they start.
    unseen: Vec<usize>,
}

/// Ranges that are worked out side by side.
const SIDE: usize = 4;

/// Where a step is evaluated.
struct At<'a> {
    places: Places<'a>,
    shared: &'a [f64],
    block: &'a [f64],
}

/// Lines from stations to targets, side by side.
struct Lines<const N: usize> {
    along_mm: [[f64; N]; 3],
    path_mm: [f64; N],
}

impl<'a> FreePoints<'a> {
    pub(crate) fn new(
        network: &'a Network<'a>,
        chart: &'a StationChart,
        sigma_mm: f64,
        rigid_mm: f64,
    ) -> Self {
        let mut kinds = Kinds::default();
        let (mut kind_of, mut firsts) = (Vec::new(), Vec::new());
        for (step, ranges) in network.ranges_of_step.iter().enumerate() {
            let (kind, is_new) = kinds.number(ranges.iter().map(|&r| network.seen_by(r)));
            if is_new {
                firsts.push(step);
            }
            kind_of.push(kind);
        }
        let mut pairs: Vec<(usize, usize)> =
            firsts.iter().flat_map(|&step| pairs_of(network.mounts_at(step))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let [weight, rigid_weight] = [sigma_mm, rigid_mm].map(f64::recip);
        let mut problem = Self {
            network,
            chart,
            weight,
            rigid_weight,
            pairs,
            kinds: Vec::new(),
            patterns: Vec::new(),
            kind_of,
        };
        for step in firsts {
            problem.add_kind(step);
        }
        problem
    }

    /// The rows and the pattern of all steps that see what this one sees.
    fn add_kind(&mut self, step: usize) {
        let network = self.network;
        let seen = network.mounts_at(step);
        let ranges: Vec<[usize; 3]> =
            network.ranges_of_step.at(step).iter().map(|&r| network.seen_by(r)).collect();
        let moves = |&[station, ..]: &[usize; 3]| self.chart.moves(station);
        let way_counts = ranges.iter().map(|range| moves(range).len()).collect();
        let ways = ranges.iter().flat_map(moves).map(|(_, way)| *way).collect();
        let distances = pairs_of(seen).map(|(a, b)| {
            let index = self.pairs.binary_search(&(a, b));
            (index.expect("the list holds every pair seen"), [a, b])
        });
        let unseen = (0..network.survey.mounts.len()).filter(|j| !seen.contains(j));
        let unseen = unseen.flat_map(|j| 3 * j..3 * j + 3).collect();
        let distances = distances.collect();
        let rows = Rows { ranges, way_counts, ways, distances, unseen };
        let point = |mount: usize| [3 * mount, 3 * mount + 1, 3 * mount + 2];
        let mut pattern = Pattern::new();
        for &[station, mount, dead_path] in &rows.ranges {
            let moves = self.chart.moves(station).iter().map(|(p, _)| *p);
            let of_shared: Vec<usize> = moves.chain([self.chart.dim() + dead_path]).collect();
            pattern.push(&point(mount), &of_shared);
        }
        for &(pair, ends) in &rows.distances {
            pattern.push(ends.map(point).as_flattened(), &[self.distance_start() + pair]);
        }
        for &coordinate in &rows.unseen {
            pattern.push(&[coordinate], &[]);
        }
        self.kinds.push(rows);
        self.patterns.push(pattern);
    }

    fn distance_start(&self) -> usize {
        self.chart.dim() + self.network.dead_paths.len()
    }

    /// A start as parameters.
    pub(crate) fn start(&self, start: &Start) -> BorderedPoint {
        let points_mm = start.points_mm(self.network);
        let stations = self.chart.parameters(&start.stations);
        let distance = |&(a, b): &(usize, usize)| (start.mounts[a] - start.mounts[b]).norm();
        let shared = stations.iter().copied().chain(start.dead_paths.iter().copied());
        let blocks = points_mm.iter().flatten().flat_map(|p| p.iter().copied());
        BorderedPoint {
            shared: shared.chain(self.pairs.iter().map(distance)).collect(),
            blocks: blocks.collect(),
        }
    }

    /// Residual of a range from the length of its path.
    #[inline(always)]
    fn residual(&self, path_mm: f64, dead_path: usize, range: u32, at: &At<'_>) -> f64 {
        let read_mm = path_mm - at.shared[self.chart.dim() + dead_path];
        (read_mm - self.network.survey.ranges[range as usize].displacement_mm) * self.weight
    }

    #[inline(always)]
    fn write_residuals<const N: usize>(
        &self,
        (seen, ranges): (&[[usize; 3]; N], &[u32]),
        at: &At<'_>,
        out: &mut [f64],
    ) {
        let Lines { path_mm, .. } = Lines::of(seen, at);
        for n in 0..N {
            out[n] = self.residual(path_mm[n], seen[n][2], ranges[n], at);
        }
    }

    /// Writes residuals of ranges with their derivatives by the points.
    #[inline(always)]
    fn linearise_ranges<const N: usize>(
        &self,
        (seen, ranges): (&[[usize; 3]; N], &[u32]),
        at: &At<'_>,
        (residuals, by_block): (&mut [f64], &mut [f64]),
    ) {
        let Lines { along_mm: [x, y, z], path_mm } = Lines::of(seen, at);
        let mut beams = [[0.0; N]; 3];
        for n in 0..N {
            let inverse = 1.0 / path_mm[n];
            beams[0][n] = x[n] * inverse * self.weight;
            beams[1][n] = y[n] * inverse * self.weight;
            beams[2][n] = z[n] * inverse * self.weight;
        }
        for (n, by_block) in by_block.as_chunks_mut::<3>().0.iter_mut().enumerate().take(N) {
            residuals[n] = self.residual(path_mm[n], seen[n][2], ranges[n], at);
            *by_block = [beams[0][n], beams[1][n], beams[2][n]];
        }
    }

    /// Writes derivatives of ranges by the shared point from those by the points; their number.
    #[inline(always)]
    fn move_stations(&self, rows: &Rows, by_block: &[f64], by_shared: &mut [f64]) -> usize {
        let (mut ways, mut common) = (&rows.ways[..], 0);
        for (beam, &count) in by_block.as_chunks::<3>().0.iter().zip(&rows.way_counts) {
            let (own, rest) = ways.split_at(count);
            let out = &mut by_shared[common..=common + count];
            for (out, way) in out.iter_mut().zip(own) {
                *out = -(way.x * beam[0] + way.y * beam[1] + way.z * beam[2]);
            }
            out[count] = -self.weight;
            (ways, common) = (rest, common + count + 1);
        }
        common
    }

    /// Distance of a pair of mounts less what it is on the body, and the unit vector along it.
    #[inline(always)]
    fn across(&self, pair: usize, [a, b]: [usize; 2], at: &At<'_>) -> (f64, Vector3<f64>) {
        let along = point_of(at.block, a) - point_of(at.block, b);
        let distance = along.norm();
        (distance - at.shared[self.distance_start() + pair], along * distance.recip())
    }
}

impl<const N: usize> Lines<N> {
    #[inline(always)]
    fn of(seen: &[[usize; 3]; N], at: &At<'_>) -> Self {
        let (mut along_mm, mut path_mm) = ([[0.0; N]; 3], [0.0; N]);
        for (n, &[station, mount, _]) in seen.iter().enumerate() {
            let along = point_of(at.block, mount) - at.places.at_mm(station);
            for c in 0..3 {
                along_mm[c][n] = along[c];
            }
        }
        let [x, y, z] = &along_mm;
        for n in 0..N {
            path_mm[n] = (x[n] * x[n] + y[n] * y[n] + z[n] * z[n]).sqrt();
        }
        Self { along_mm, path_mm }
    }
}

fn pairs_of(mounts: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    mounts.iter().enumerate().flat_map(move |(i, &a)| mounts[i + 1..].iter().map(move |&b| (a, b)))
}

/// A point of a block, by mount.
pub(crate) fn point_of(block: &[f64], mount: usize) -> Vector3<f64> {
    Vector3::new(block[3 * mount], block[3 * mount + 1], block[3 * mount + 2])
}

impl BorderedProblem for FreePoints<'_> {
    fn shared_dim(&self) -> usize {
        self.distance_start() + self.pairs.len()
    }

    fn block_dim(&self) -> usize {
        3 * self.network.survey.mounts.len()
    }

    fn block_count(&self) -> usize {
        self.kind_of.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        self.kind_of[block]
    }

    #[inline(always)]
    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let at = At { places: self.chart.places(shared), shared, block: point };
        let Rows { ranges: seen, distances, unseen, .. } = &self.kinds[self.kind_of[block]];
        let of_step = self.network.ranges_of_step.at(block);
        let (several, rest) = seen.as_chunks::<SIDE>();
        let mut row = 0;
        for seen in several {
            self.write_residuals((seen, &of_step[row..]), &at, &mut out[row..]);
            row += SIDE;
        }
        for seen in rest.as_chunks::<1>().0 {
            self.write_residuals((seen, &of_step[row..]), &at, &mut out[row..]);
            row += 1;
        }
        let (of_distances, of_unseen) = out[row..].split_at_mut(distances.len());
        for (out, &(pair, ends)) in of_distances.iter_mut().zip(distances) {
            *out = self.across(pair, ends, &at).0 * self.rigid_weight;
        }
        // An unseen coordinate is held at zero, which is as good as anywhere.
        for (out, &coordinate) in of_unseen.iter_mut().zip(unseen) {
            *out = point[coordinate];
        }
    }

    #[inline(always)]
    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let at = At { places: self.chart.places(shared), shared, block: point };
        let kind = &self.kinds[self.kind_of[block]];
        let Rows { ranges: seen, distances, unseen, .. } = kind;
        let of_step = self.network.ranges_of_step.at(block);
        let BlockRows { residuals, by_block, by_shared } = rows;
        let (several, rest) = seen.as_chunks::<SIDE>();
        let mut row = 0;
        for seen in several {
            let out = (&mut residuals[row..], &mut by_block[3 * row..]);
            self.linearise_ranges((seen, &of_step[row..]), &at, out);
            row += SIDE;
        }
        for seen in rest.as_chunks::<1>().0 {
            let out = (&mut residuals[row..], &mut by_block[3 * row..]);
            self.linearise_ranges((seen, &of_step[row..]), &at, out);
            row += 1;
        }
        let common = self.move_stations(kind, by_block, by_shared);
        let (of_distances, of_unseen) = residuals[row..].split_at_mut(distances.len());
        let (own, by_unseen) = by_block[3 * row..].split_at_mut(6 * distances.len());
        let own = own.as_chunks_mut::<6>().0;
        for ((&(pair, ends), residual), own) in distances.iter().zip(of_distances).zip(own) {
            let (residual_mm, along) = self.across(pair, ends, &at);
            let [x, y, z] = (along * self.rigid_weight).into();
            *residual = residual_mm * self.rigid_weight;
            *own = [x, y, z, -x, -y, -z];
        }
        by_shared[common..].fill(-self.rigid_weight);
        for (residual, &coordinate) in of_unseen.iter_mut().zip(unseen) {
            *residual = point[coordinate];
        }
        by_unseen.fill(1.0);
    }

    fn shared_residual_count(&self) -> usize {
        self.chart.prior_mm.map_or(0, |_| self.chart.dim())
    }

    fn linearise_shared(&self, shared: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) {
        self.chart.linearise_prior(shared, residuals, jacobian);
    }

    fn shared_name(&self, index: usize) -> String {
        if index >= self.distance_start() {
            let (a, b) = self.pairs[index - self.distance_start()];
            let name = |j: usize| &self.network.survey.mounts[j].name;
            return format!("distance from {} to {} (mm)", name(a), name(b));
        }
        self.network.name_of_shared(self.chart, index)
    }

    fn block_name(&self, block: usize, index: usize) -> String {
        let mount = &self.network.survey.mounts[index / 3].name;
        let step = &self.network.survey.steps[block].name;
        format!("{} of {mount} at step {step} (mm)", ["x", "y", "z"][index % 3])
    }
}

impl Readings for FreePoints<'_> {
    fn range_count(&self, block: usize) -> usize {
        self.network.ranges_of_step.at(block).len()
    }
}
