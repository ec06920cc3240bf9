//! factrs on the tracker problem: factrs-peer FOLDER RUNS
//!
//! One factor per range and per distance, derivatives by hand, Levenberg-Marquardt with the sparse
//! Cholesky factorisation that it comes with. Prints a line of JSON per run, with the most memory
//! that the process has had so far; the solution goes to factrs.bin beside the problem.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Instant;
use std::{env, fs};

use cpu_time::ProcessTime;
use factrs::assign_symbols;
use factrs::containers::{FactorBuilder, Graph, Key, Values};
use factrs::linalg::{Const, DiffResult, MatrixX, Numeric, NumericalDiff, VectorX};
use factrs::optimizers::{BaseOptParams, LevenMarquardt, LevenParams, OptObserver};
use factrs::residuals::{Residual2, Residual3};
use factrs::traits::*;
use factrs::variables::{VectorVar1, VectorVar2, VectorVar3};

// Their first letters must differ.
assign_symbols!(
    Target: VectorVar3;
    Along: VectorVar1;
    Within: VectorVar2;
    Station: VectorVar3;
    DeadPath: VectorVar1;
    Length: VectorVar1
);

/// Distance and direction from `b` to `a`.
fn distance(a: [f64; 3], b: [f64; 3]) -> (f64, [f64; 3]) {
    let d: [f64; 3] = std::array::from_fn(|c| a[c] - b[c]);
    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
    (length, d.map(|v| v / length))
}

fn apart<T: Numeric>(a: [T; 3], b: [T; 3]) -> T {
    let d: [T; 3] = std::array::from_fn(|c| a[c] - b[c]);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

/// A range from the station that is the origin.
#[derive(Clone, Debug)]
struct FromOrigin {
    displacement: f64,
    station: [f64; 3],
}

#[factrs::mark]
impl Residual2 for FromOrigin {
    type Differ = NumericalDiff<6>;
    type V1 = VectorVar3;
    type V2 = VectorVar1;
    type DimIn = Const<4>;
    type DimOut = Const<1>;

    fn residual2<T: Numeric>(&self, target: VectorVar3<T>, dead_path: VectorVar1<T>) -> VectorX<T> {
        let at = std::array::from_fn(|c| target.0[c]);
        let length = apart(at, self.station.map(T::from));
        VectorX::from_element(1, length - T::from(self.displacement) - dead_path.0[0])
    }

    fn residual2_jacobian(&self, values: &Values, keys: &[Key]) -> DiffResult<VectorX, MatrixX> {
        let target: &VectorVar3 = values.get_unchecked(keys[0]).expect("a target");
        let dead_path: &VectorVar1 = values.get_unchecked(keys[1]).expect("a dead path");
        let (length, g) = distance(target.0.into(), self.station);
        let value = VectorX::from_element(1, length - self.displacement - dead_path.0[0]);
        DiffResult { value, diff: MatrixX::from_row_slice(1, 4, &[g[0], g[1], g[2], -1.0]) }
    }
}

/// A range from a station of which the first coordinates are free.
macro_rules! range_from {
    ($name:ident, $station:ident, $free:literal, $width:literal) => {
        #[derive(Clone, Debug)]
        struct $name {
            displacement: f64,
            station: [f64; 3],
        }

        #[factrs::mark]
        impl Residual3 for $name {
            type Differ = NumericalDiff<6>;
            type V1 = VectorVar3;
            type V2 = $station;
            type V3 = VectorVar1;
            type DimIn = Const<$width>;
            type DimOut = Const<1>;

            fn residual3<T: Numeric>(
                &self,
                target: VectorVar3<T>,
                station: $station<T>,
                dead_path: VectorVar1<T>,
            ) -> VectorX<T> {
                let at = std::array::from_fn(|c| target.0[c]);
                let from = std::array::from_fn(|c| {
                    if c < $free { station.0[c] } else { T::from(self.station[c]) }
                });
                let read = T::from(self.displacement) + dead_path.0[0];
                VectorX::from_element(1, apart(at, from) - read)
            }

            fn residual3_jacobian(
                &self,
                values: &Values,
                keys: &[Key],
            ) -> DiffResult<VectorX, MatrixX> {
                let target: &VectorVar3 = values.get_unchecked(keys[0]).expect("a target");
                let station: &$station = values.get_unchecked(keys[1]).expect("a station");
                let dead_path: &VectorVar1 = values.get_unchecked(keys[2]).expect("a dead path");
                let from =
                    std::array::from_fn(|c| if c < $free { station.0[c] } else { self.station[c] });
                let (length, g) = distance(target.0.into(), from);
                let value = VectorX::from_element(1, length - self.displacement - dead_path.0[0]);
                let mut diff = MatrixX::zeros(1, $width);
                for c in 0..3 {
                    diff[c] = g[c];
                }
                for c in 0..$free {
                    diff[3 + c] = -g[c];
                }
                diff[3 + $free] = -1.0;
                DiffResult { value, diff }
            }
        }
    };
}

range_from!(FromLine, VectorVar1, 1, 5);
range_from!(FromPlane, VectorVar2, 2, 6);
range_from!(FromSpace, VectorVar3, 3, 7);

/// Two targets of one step are as far apart as at every other.
#[derive(Clone, Debug)]
struct Rigid;

#[factrs::mark]
impl Residual3 for Rigid {
    type Differ = NumericalDiff<6>;
    type V1 = VectorVar3;
    type V2 = VectorVar3;
    type V3 = VectorVar1;
    type DimIn = Const<7>;
    type DimOut = Const<1>;

    fn residual3<T: Numeric>(
        &self,
        a: VectorVar3<T>,
        b: VectorVar3<T>,
        length: VectorVar1<T>,
    ) -> VectorX<T> {
        let at = |v: &VectorVar3<T>| std::array::from_fn(|c| v.0[c]);
        VectorX::from_element(1, apart(at(&a), at(&b)) - length.0[0])
    }

    fn residual3_jacobian(&self, values: &Values, keys: &[Key]) -> DiffResult<VectorX, MatrixX> {
        let a: &VectorVar3 = values.get_unchecked(keys[0]).expect("a target");
        let b: &VectorVar3 = values.get_unchecked(keys[1]).expect("a target");
        let length: &VectorVar1 = values.get_unchecked(keys[2]).expect("a distance");
        let (found, g) = distance(a.0.into(), b.0.into());
        let value = VectorX::from_element(1, found - length.0[0]);
        let row = [g[0], g[1], g[2], -g[0], -g[1], -g[2], -1.0];
        DiffResult { value, diff: MatrixX::from_row_slice(1, 7, &row) }
    }
}

/// A problem as the folder holds it.
struct Scene {
    stations: usize,
    targets: usize,
    steps: usize,
    displacements: Vec<f64>,
    start: Vec<f64>,
}

impl Scene {
    fn read(folder: &str) -> Self {
        let dims = fs::read_to_string(format!("{folder}/dims.txt")).expect("dims.txt");
        let dims: Vec<usize> =
            dims.split_whitespace().map(|n| n.parse().expect("a number")).collect();
        Self {
            stations: dims[0],
            targets: dims[1],
            steps: dims[2],
            displacements: numbers(&format!("{folder}/obs.bin")),
            start: numbers(&format!("{folder}/init.bin")),
        }
    }

    fn pairs(&self) -> Vec<(usize, usize)> {
        let n = self.targets;
        (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).collect()
    }

    fn dead_path(&self, station: usize, target: usize) -> usize {
        3 * self.stations + station * self.targets + target
    }

    fn pair(&self, pair: usize) -> usize {
        self.dead_path(self.stations, 0) + pair
    }

    fn target(&self, step: usize, target: usize) -> usize {
        self.pair(self.pairs().len()) + 3 * (step * self.targets + target)
    }

    fn three(&self, at: usize) -> [f64; 3] {
        std::array::from_fn(|c| self.start[at + c])
    }

    fn graph(&self) -> Graph {
        let pairs = self.pairs();
        let mut graph = Graph::with_capacity(self.displacements.len() + self.steps * pairs.len());
        for k in 0..self.steps {
            for j in 0..self.targets {
                let at = Target(symbol(k * self.targets + j));
                for i in 0..self.stations {
                    let displacement =
                        self.displacements[(k * self.targets + j) * self.stations + i];
                    let station = self.three(3 * i);
                    let lock = DeadPath(symbol(i * self.targets + j));
                    graph.add_factor(match i {
                        0 => FactorBuilder::new2(FromOrigin { displacement, station }, at, lock)
                            .build(),
                        1 => {
                            let range = FromLine { displacement, station };
                            FactorBuilder::new3(range, at, Along(0), lock).build()
                        }
                        2 => {
                            let range = FromPlane { displacement, station };
                            FactorBuilder::new3(range, at, Within(0), lock).build()
                        }
                        _ => {
                            let range = FromSpace { displacement, station };
                            FactorBuilder::new3(range, at, Station(symbol(i)), lock).build()
                        }
                    });
                }
            }
            for (n, &(a, b)) in pairs.iter().enumerate() {
                let [a, b] = [a, b].map(|j| Target(symbol(k * self.targets + j)));
                graph.add_factor(FactorBuilder::new3(Rigid, a, b, Length(symbol(n))).build());
            }
        }
        graph
    }

    fn values(&self) -> Values {
        let mut values = Values::new();
        let one = |at: usize| VectorVar1::new(self.start[at]);
        let three =
            |at: usize| VectorVar3::new(self.start[at], self.start[at + 1], self.start[at + 2]);
        values.insert(Along(0), one(3));
        values.insert(Within(0), VectorVar2::new(self.start[6], self.start[7]));
        for i in 3..self.stations {
            values.insert(Station(symbol(i)), three(3 * i));
        }
        for i in 0..self.stations {
            for j in 0..self.targets {
                values.insert(DeadPath(symbol(i * self.targets + j)), one(self.dead_path(i, j)));
            }
        }
        for n in 0..self.pairs().len() {
            values.insert(Length(symbol(n)), one(self.pair(n)));
        }
        for k in 0..self.steps {
            for j in 0..self.targets {
                values.insert(Target(symbol(k * self.targets + j)), three(self.target(k, j)));
            }
        }
        values
    }

    fn solution(&self, values: &Values) -> Vec<f64> {
        let mut all = self.start.clone();
        let known = "every variable has a value";
        all[3] = values.get(Along(0)).expect(known).0[0];
        let within = values.get(Within(0)).expect(known);
        (all[6], all[7]) = (within.0[0], within.0[1]);
        for i in 3..self.stations {
            let at = values.get(Station(symbol(i))).expect(known);
            all[3 * i..3 * i + 3].copy_from_slice(at.0.as_slice());
        }
        for i in 0..self.stations {
            for j in 0..self.targets {
                let lock = DeadPath(symbol(i * self.targets + j));
                all[self.dead_path(i, j)] = values.get(lock).expect(known).0[0];
            }
        }
        for n in 0..self.pairs().len() {
            all[self.pair(n)] = values.get(Length(symbol(n))).expect(known).0[0];
        }
        for k in 0..self.steps {
            for j in 0..self.targets {
                let at = values.get(Target(symbol(k * self.targets + j))).expect(known);
                let to = self.target(k, j);
                all[to..to + 3].copy_from_slice(at.0.as_slice());
            }
        }
        all
    }
}

fn symbol(index: usize) -> u32 {
    index.try_into().expect("fewer than 2^32 variables")
}

fn numbers(path: &str) -> Vec<f64> {
    let bytes = fs::read(path).expect(path);
    let (words, _) = bytes.as_chunks::<8>();
    words.iter().map(|word| f64::from_le_bytes(*word)).collect()
}

fn peak_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

fn main() {
    let arguments: Vec<String> = env::args().collect();
    let [_, folder, runs] = &arguments[..] else { panic!("factrs-peer FOLDER RUNS") };
    let scene = Scene::read(folder);
    let mut found = None;
    for _ in 0..runs.parse().expect("a number of runs") {
        let base = BaseOptParams {
            // At the minimum no step gains and the search counts as failed: it ends with the first
            // step that gains little, and the caller compares the costs.
            error_tol_relative: 1e-2,
            error_tol_absolute: 0.0,
            ..BaseOptParams::default()
        };
        let parameters = LevenParams { base, ..LevenParams::default() };
        let (begun, cpu_begun) = (Instant::now(), ProcessTime::now());
        let (graph, values) = (scene.graph(), scene.values());
        let mut solver = LevenMarquardt::new(parameters, graph);
        let steps = Rc::new(Cell::new(0_u32));
        solver.observers_mut().add(Steps(steps.clone()));
        let end = solver.optimize(values).expect("a minimum");
        let (taken, cpu) = (begun.elapsed(), cpu_begun.elapsed());
        println!(
            "{{\"ms\": {}, \"cpu_ms\": {}, \"cost\": {:e}, \"evaluations\": {}, \"jacobians\": {}, \
             \"peak_kib\": {}}}",
            1e3 * taken.as_secs_f64(),
            1e3 * cpu.as_secs_f64(),
            solver.error(&end),
            steps.get() + 1,
            steps.get(),
            peak_kib()
        );
        found = Some(end);
    }
    let solution = scene.solution(&found.expect("at least one run"));
    let bytes: Vec<u8> = solution.iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(format!("{folder}/factrs.bin"), bytes).expect("factrs.bin");
}

/// Counts steps.
struct Steps(Rc<Cell<u32>>);

impl OptObserver for Steps {
    fn on_step(&self, _: &Values, _: i64) {
        self.0.set(self.0.get() + 1);
    }
}
