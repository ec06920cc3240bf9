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
    kinds: Vec<Vec<Row>>,
    patterns: Vec<Pattern>,
    kind_of: Vec<usize>,
}

/// What one row of a step is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Row {
    /// A range from a station to a mount, with its dead path.
    Range([usize; 3]),
    /// The distance of a pair of mounts.
    Distance(usize),
    /// A coordinate of a point that was not seen: it stays where it starts.
    Unseen(usize),
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
        let (kinds, patterns) = (Vec::new(), Vec::new());
        let mut problem =
            Self { network, chart, weight, rigid_weight, pairs, kinds, patterns, kind_of };
        for step in firsts {
            problem.add_kind(step);
        }
        problem
    }

    /// The rows and the pattern of all steps that see what this one sees.
    fn add_kind(&mut self, step: usize) {
        let network = self.network;
        let seen = network.mounts_at(step);
        let ranges = network.ranges_of_step[step].iter().map(|&r| Row::Range(network.seen_by(r)));
        let distances = pairs_of(seen).map(|pair| {
            let index = self.pairs.binary_search(&pair);
            Row::Distance(index.expect("the list holds every pair seen"))
        });
        let unseen = (0..network.survey.mounts.len()).filter(|j| !seen.contains(j));
        let unseen = unseen.flat_map(|j| (0..3).map(move |axis| Row::Unseen(3 * j + axis)));
        let rows: Vec<Row> = ranges.chain(distances).chain(unseen).collect();
        let mut pattern = Pattern::new();
        for row in &rows {
            pattern.push(&self.of_block(*row), &self.of_shared(*row));
        }
        self.kinds.push(rows);
        self.patterns.push(pattern);
    }

    /// Rows of a step, and the displacements of its ranges, which are the first of them.
    #[inline(always)]
    fn rows(&self, step: usize) -> (&[Row], impl Iterator<Item = f64> + '_) {
        let ranges = &self.network.survey.ranges;
        let displacements =
            self.network.ranges_of_step[step].iter().map(|&r| ranges[r].displacement_mm);
        (&self.kinds[self.kind_of[step]], displacements.chain(std::iter::repeat(0.0)))
    }

    fn of_block(&self, row: Row) -> Vec<usize> {
        let point = |mount: usize| 3 * mount..3 * mount + 3;
        match row {
            Row::Range([_, mount, _]) => point(mount).collect(),
            Row::Distance(pair) => {
                let (a, b) = self.pairs[pair];
                point(a).chain(point(b)).collect()
            }
            Row::Unseen(coordinate) => vec![coordinate],
        }
    }

    fn of_shared(&self, row: Row) -> Vec<usize> {
        match row {
            Row::Range([station, _, dead_path]) => {
                let moves = self.chart.moves(station).iter().map(|(p, _)| *p);
                moves.chain([self.chart.dim() + dead_path]).collect()
            }
            Row::Distance(pair) => vec![self.distance_start() + pair],
            Row::Unseen(_) => Vec::new(),
        }
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

    /// Path from station to target less the dead path, and the unit vector along it.
    #[inline(always)]
    fn beam(
        &self,
        [station, mount, dead_path]: [usize; 3],
        places: &Places<'_>,
        shared: &[f64],
        block: &[f64],
    ) -> (f64, Vector3<f64>) {
        let along = point_of(block, mount) - places.at_mm(station);
        let path = along.norm();
        (path - shared[self.chart.dim() + dead_path], along * path.recip())
    }

    #[inline(always)]
    fn across(&self, pair: usize, shared: &[f64], block: &[f64]) -> (f64, Vector3<f64>) {
        let (a, b) = self.pairs[pair];
        let along = point_of(block, a) - point_of(block, b);
        let distance = along.norm();
        (distance - shared[self.distance_start() + pair], along * distance.recip())
    }

    /// Where an unseen coordinate is held: at zero, which is as good as anywhere.
    #[inline(always)]
    fn residual(
        &self,
        (row, displacement_mm): (Row, f64),
        places: &Places<'_>,
        shared: &[f64],
        block: &[f64],
    ) -> f64 {
        match row {
            Row::Range(seen) => {
                (self.beam(seen, places, shared, block).0 - displacement_mm) * self.weight
            }
            Row::Distance(pair) => self.across(pair, shared, block).0 * self.rigid_weight,
            Row::Unseen(coordinate) => block[coordinate],
        }
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
        let places = self.chart.places(shared);
        let (rows, displacements) = self.rows(block);
        for ((row, displacement_mm), out) in rows.iter().zip(displacements).zip(out) {
            *out = self.residual((*row, displacement_mm), &places, shared, point);
        }
    }

    #[inline(always)]
    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let (mut own, mut common) = (0, 0);
        let put = |to: &mut [f64], at: &mut usize, values: &[f64]| {
            to[*at..*at + values.len()].copy_from_slice(values);
            *at += values.len();
        };
        let places = self.chart.places(shared);
        let (listed, displacements) = self.rows(block);
        for ((n, row), displacement_mm) in listed.iter().enumerate().zip(displacements) {
            match *row {
                Row::Range(seen) => {
                    let (read_mm, beam) = self.beam(seen, &places, shared, point);
                    let beam = beam * self.weight;
                    rows.residuals[n] = (read_mm - displacement_mm) * self.weight;
                    put(rows.by_block, &mut own, beam.as_slice());
                    let [station, ..] = seen;
                    for (_, way) in self.chart.moves(station) {
                        put(rows.by_shared, &mut common, &[-way.dot(&beam)]);
                    }
                    put(rows.by_shared, &mut common, &[-self.weight]);
                }
                Row::Distance(pair) => {
                    let (residual_mm, along) = self.across(pair, shared, point);
                    let along = along * self.rigid_weight;
                    rows.residuals[n] = residual_mm * self.rigid_weight;
                    put(rows.by_block, &mut own, along.as_slice());
                    put(rows.by_block, &mut own, (-along).as_slice());
                    put(rows.by_shared, &mut common, &[-self.rigid_weight]);
                }
                Row::Unseen(coordinate) => {
                    rows.residuals[n] = point[coordinate];
                    put(rows.by_block, &mut own, &[1.0]);
                }
            }
        }
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
        self.network.ranges_of_step[block].len()
    }
}
