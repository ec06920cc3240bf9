//! The document's formulation: every target point is free, and distances between reflectors that
//! stay the same are further, weighted rows (\[B\], step S2).
//!
//! `u = |P − S| − (l + L)` and `r = |P_j − P_j'| − d_jj'`, one block of all points per step.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem, Pattern};
use nalgebra::Vector3;

use crate::gauge::StationChart;
use crate::network::Network;
use crate::spread::Columns;
use crate::start::Start;

/// Free points over a network.
#[derive(Clone, Debug)]
pub(crate) struct FreePoints<'a> {
    pub(crate) network: &'a Network<'a>,
    pub(crate) chart: &'a StationChart,
    sigma_mm: f64,
    rigid_mm: f64,
    /// Pairs of mounts that are seen together at some step.
    pairs: Vec<(usize, usize)>,
    /// Rows of each step.
    rows: Vec<Vec<Row>>,
    patterns: Vec<Pattern>,
    pattern_of: Vec<usize>,
}

/// What one row of a step is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Row {
    /// A range.
    Range(usize),
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
        let steps = 0..network.survey.steps.len();
        let seen: Vec<_> = steps.clone().map(|step| network.mounts_at(step)).collect();
        let mut pairs: Vec<(usize, usize)> =
            seen.iter().flat_map(|mounts| pairs_of(mounts)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let rows = steps
            .map(|step| {
                let ranges = network.ranges_of_step[step].iter().map(|&r| Row::Range(r));
                let distances = pairs_of(&seen[step]).map(|pair| {
                    let index = pairs.binary_search(&pair);
                    Row::Distance(index.expect("the list holds every pair seen"))
                });
                let unseen = (0..network.survey.mounts.len()).filter(|j| !seen[step].contains(j));
                let unseen = unseen.flat_map(|j| (0..3).map(move |axis| Row::Unseen(3 * j + axis)));
                ranges.chain(distances).chain(unseen).collect()
            })
            .collect();
        let mut problem = Self {
            network,
            chart,
            sigma_mm,
            rigid_mm,
            pairs,
            rows,
            patterns: Vec::new(),
            pattern_of: Vec::new(),
        };
        problem.find_patterns();
        problem
    }

    /// One pattern for all steps that see the same.
    fn find_patterns(&mut self) {
        let mut known = std::collections::HashMap::new();
        for rows in &self.rows {
            let ids: Vec<_> =
                rows.iter().map(|row| (self.of_block(*row), self.of_shared(*row))).collect();
            let next = self.patterns.len();
            let index = *known.entry(ids.clone()).or_insert(next);
            if index == next {
                let mut pattern = Pattern::new();
                for (of_block, of_shared) in &ids {
                    pattern.push(of_block, of_shared);
                }
                self.patterns.push(pattern);
            }
            self.pattern_of.push(index);
        }
    }

    fn of_block(&self, row: Row) -> Vec<usize> {
        let point = |mount: usize| 3 * mount..3 * mount + 3;
        match row {
            Row::Range(range) => point(self.network.survey.ranges[range].mount).collect(),
            Row::Distance(pair) => {
                let (a, b) = self.pairs[pair];
                point(a).chain(point(b)).collect()
            }
            Row::Unseen(coordinate) => vec![coordinate],
        }
    }

    fn of_shared(&self, row: Row) -> Vec<usize> {
        match row {
            Row::Range(range) => {
                let station = self.network.survey.ranges[range].station;
                let moves = self.chart.moves(station).iter().map(|(p, _)| *p);
                moves.chain([self.chart.dim() + self.network.dead_path_of[range]]).collect()
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

    /// Path from station to target less what was read, and the unit vector along it.
    #[inline]
    fn beam(&self, range: usize, shared: &[f64], block: &[f64]) -> (f64, Vector3<f64>) {
        let r = &self.network.survey.ranges[range];
        let along = point_of(block, r.mount) - self.chart.position_mm(r.station, shared);
        let path = along.norm();
        let dead_path = shared[self.chart.dim() + self.network.dead_path_of[range]];
        (path - dead_path - r.displacement_mm, along / path)
    }

    #[inline]
    fn across(&self, pair: usize, shared: &[f64], block: &[f64]) -> (f64, Vector3<f64>) {
        let (a, b) = self.pairs[pair];
        let along = point_of(block, a) - point_of(block, b);
        let distance = along.norm();
        (distance - shared[self.distance_start() + pair], along / distance)
    }

    /// Where an unseen coordinate is held: at zero, which is as good as anywhere.
    fn residual(&self, row: Row, shared: &[f64], block: &[f64]) -> f64 {
        match row {
            Row::Range(range) => self.beam(range, shared, block).0 / self.sigma_mm,
            Row::Distance(pair) => self.across(pair, shared, block).0 / self.rigid_mm,
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
        self.rows.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        self.pattern_of[block]
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        for (row, out) in self.rows[block].iter().zip(out) {
            *out = self.residual(*row, shared, point);
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let (mut own, mut common) = (0, 0);
        let put = |to: &mut [f64], at: &mut usize, values: &[f64]| {
            to[*at..*at + values.len()].copy_from_slice(values);
            *at += values.len();
        };
        for (n, row) in self.rows[block].iter().enumerate() {
            match *row {
                Row::Range(range) => {
                    let (residual_mm, beam) = self.beam(range, shared, point);
                    let beam = beam / self.sigma_mm;
                    rows.residuals[n] = residual_mm / self.sigma_mm;
                    put(rows.by_block, &mut own, beam.as_slice());
                    let station = self.network.survey.ranges[range].station;
                    for (_, way) in self.chart.moves(station) {
                        put(rows.by_shared, &mut common, &[-way.dot(&beam)]);
                    }
                    put(rows.by_shared, &mut common, &[-1.0 / self.sigma_mm]);
                }
                Row::Distance(pair) => {
                    let (residual_mm, along) = self.across(pair, shared, point);
                    let along = along / self.rigid_mm;
                    rows.residuals[n] = residual_mm / self.rigid_mm;
                    put(rows.by_block, &mut own, along.as_slice());
                    put(rows.by_block, &mut own, (-along).as_slice());
                    put(rows.by_shared, &mut common, &[-1.0 / self.rigid_mm]);
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

impl Columns for FreePoints<'_> {
    fn range_count(&self, block: usize) -> usize {
        self.network.ranges_of_step[block].len()
    }

    fn columns(&self, block: usize) -> Vec<(Vec<usize>, Vec<usize>)> {
        let row = |&row: &Row| (self.of_block(row), self.of_shared(row));
        self.rows[block].iter().map(row).collect()
    }
}
