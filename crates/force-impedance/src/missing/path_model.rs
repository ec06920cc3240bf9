//! Runs along one path as a model for the loop.

use model_discrepancy::{
    Covariate, Declared, Effect, Group, Inside, Layout, Model, Parameter, Proposal, Quantity, Role,
    Row, Scope, State, independent_share, lag_one, resolution_of,
};
use nalgebra::{DMatrix, DVector};

use crate::missing::path::{Cell, Stretch, cells, check};
use crate::{ForceImpedanceError, PathSample};

/// Knots of the coarse shape along a path: what surface and feed do over a twelfth of it.
const COARSE_KNOTS: usize = 24;

/// Runs along the same path, force read against force asked for, and what repeats in them.
///
/// One row per run and cell of the path (at most 96, equal over the stretch that every run went over):
/// mean of (force read − force asked for), N. The declared model has no free parameters: the
/// force is what was asked for. Groups are runs.
///
/// Two effects are empirical, a value at each knot of the path and linear between: an
/// error that repeats at the same place in every run, in N, and one that is the same share of the force
/// asked for, in percent. They say where, not why.
#[derive(Clone, Debug)]
pub struct PathModel {
    declared: Declared,
    catalogue: Vec<PathEffect>,
    cells: Vec<Cell>,
    stretch: Stretch,
    /// One per cell and reading in it, where the noise was declared.
    readings: Vec<Vec<Reading>>,
    sigma_n: Option<f64>,
}

/// One reading in its cell.
#[derive(Clone, Copy, Debug)]
struct Reading {
    error_n: f64,
    /// Between the middles of cells, counted in cells.
    place: f64,
    reference_n: f64,
    elapsed_share: f64,
}

/// Settings of a [`PathModel`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathOptions {
    /// Standard uncertainty of one reading of the instrument, where declared.
    pub sigma_n: Option<f64>,
    /// Name of each run.
    pub runs: Vec<String>,
}

/// What the force asked for leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PathEffect {
    /// Zero of the instrument.
    Zero,
    /// The force follows the one asked for by a wrong ratio.
    Gain,
    /// In proportion to time.
    Drift,
    /// At each knot, N.
    Repeatable(usize),
    /// At each knot, a share of the force asked for.
    Share(usize),
}

impl PathModel {
    /// Averages runs; readings outside the stretch that all went over are left out.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::Sample`], [`ForceImpedanceError::TimeNotIncreasing`],
    /// [`ForceImpedanceError::NoCommonPath`], [`ForceImpedanceError::TooFewSamples`] where a run
    /// has fewer than eight readings on the common stretch.
    pub fn new(samples: &[PathSample], options: &PathOptions) -> Result<Self, ForceImpedanceError> {
        check(samples)?;
        let stretch = Stretch::of(samples)?;
        let cells = cells(samples, &stretch);
        let mut catalogue = vec![PathEffect::Zero, PathEffect::Gain, PathEffect::Drift];
        let coarse = (stretch.cells > 2 * COARSE_KNOTS).then_some(COARSE_KNOTS);
        for knots in coarse.into_iter().chain([stretch.cells]) {
            catalogue.extend([PathEffect::Repeatable(knots), PathEffect::Share(knots)]);
        }
        let effects = catalogue.iter().map(|e| description(*e, &stretch)).collect();
        let layout = layout(&cells, options);
        let of_reading = resolution_of(samples.iter().map(|s| s.force_n));
        let averaged = crate::count(samples.len()) / crate::count(cells.len());
        let declared = Declared {
            // A run each: between runs the tool leaves the workpiece.
            records: Some(layout.observations.clone()),
            // Every run goes over the same cells.
            places: Some(cells.iter().map(|cell| cell.place).collect()),
            resolution: of_reading / averaged.sqrt(),
            ..Declared::new(layout, Vec::new(), effects)
        };
        let readings = readings(samples, &cells, &stretch);
        let sigma_n = options.sigma_n;
        Ok(Self { declared, catalogue, cells, stretch, readings, sigma_n })
    }

    /// Readings that each observation of the layout averages.
    pub fn samples(&self) -> impl Iterator<Item = &[usize]> {
        self.cells.iter().map(|c| c.samples.as_slice())
    }

    /// Means over the cells of a column with one value per reading.
    #[must_use]
    pub fn averaged(&self, values: &[f64]) -> Vec<f64> {
        let mean = |c: &Cell| {
            c.samples.iter().map(|&i| values[i]).sum::<f64>() / crate::count(c.samples.len())
        };
        self.cells.iter().map(mean).collect()
    }

    /// Place and force asked for as covariates for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        let of = |value: fn(&Cell) -> f64| self.cells.iter().map(value).collect();
        vec![
            Covariate::coordinate("path_mm", Quantity::Position, of(|c| c.path_mm)),
            Covariate::coordinate("reference_n", Quantity::Other, of(|c| c.reference_n)),
        ]
    }

    /// Where the stretch that is judged begins and ends.
    #[must_use]
    pub fn stretch_mm(&self) -> [f64; 2] {
        [self.stretch.from_mm, self.stretch.to_mm]
    }

    /// Mean force error of all runs in each cell that any of them has seen: middle of the cell,
    /// mm, and error, N.
    #[must_use]
    pub fn profile(&self) -> Vec<[f64; 2]> {
        let errors_n: Vec<f64> = self.cells.iter().map(|c| c.residual_n).collect();
        self.profile_of(&errors_n)
    }

    /// The same of other forces, one per observation of the layout, N.
    #[must_use]
    pub fn profile_of(&self, forces_n: &[f64]) -> Vec<[f64; 2]> {
        let width_mm =
            (self.stretch.to_mm - self.stretch.from_mm) / crate::count(self.stretch.cells);
        let of_place = |place: usize| {
            let seen: Vec<f64> = (self.cells.iter().zip(forces_n))
                .filter(|(c, _)| c.place == place)
                .map(|(_, force_n)| *force_n)
                .collect();
            let middle_mm = self.stretch.from_mm + (crate::count(place) + 0.5) * width_mm;
            (!seen.is_empty())
                .then(|| [middle_mm, seen.iter().sum::<f64>() / crate::count(seen.len())])
        };
        (0..self.stretch.cells).filter_map(of_place).collect()
    }

    /// What one unit of each amplitude of an effect adds to a cell's residual.
    fn slopes(&self, effect: PathEffect, cell: &Cell) -> Vec<f64> {
        let at = Reading {
            error_n: cell.residual_n,
            place: crate::count(cell.place),
            reference_n: cell.reference_n,
            elapsed_share: cell.elapsed_share,
        };
        self.slopes_at(effect, &at)
    }

    fn slopes_at(&self, effect: PathEffect, at: &Reading) -> Vec<f64> {
        match effect {
            PathEffect::Zero => vec![1.0],
            PathEffect::Gain => vec![at.reference_n],
            PathEffect::Drift => vec![at.elapsed_share],
            PathEffect::Repeatable(knots) => self.hats(knots, at.place, 1.0),
            PathEffect::Share(knots) => self.hats(knots, at.place, at.reference_n),
        }
    }

    /// Weight of each knot at a place, in cells, linear between knots, times a factor.
    fn hats(&self, knots: usize, place: f64, factor: f64) -> Vec<f64> {
        let last = crate::count(knots - 1);
        let at = (place / crate::count(self.stretch.cells - 1) * last).clamp(0.0, last);
        (0..knots).map(|k| factor * (1.0 - (at - crate::count(k)).abs()).max(0.0)).collect()
    }

    /// The runs, and one more with every force asked for changed.
    fn with_run(&self, reference_n: impl Fn(f64) -> f64) -> Self {
        let mut more = self.clone();
        let sigma = self.declared.layout.rows.iter().map(|r| r.sigma).sum::<f64>()
            / crate::count(self.declared.layout.rows.len());
        let layout = &mut more.declared.layout;
        let group = layout.groups.len();
        layout.groups.push(Group { name: "proposed".to_owned(), role: Role::Fit });
        for cell in self.cells.iter().filter(|c| c.run == self.cells[0].run) {
            let observation = layout.observations.len();
            layout.observations.push(group);
            layout.rows.push(Row { observation, component: 0, sigma, reported: true });
            more.cells.push(Cell {
                run: group,
                reference_n: reference_n(cell.reference_n),
                elapsed_share: 1.0,
                ..cell.clone()
            });
        }
        more.declared.records = Some(more.declared.layout.observations.clone());
        more
    }
}

/// The readings of each cell.
fn readings(samples: &[PathSample], cells: &[Cell], stretch: &Stretch) -> Vec<Vec<Reading>> {
    let width_mm = (stretch.to_mm - stretch.from_mm) / crate::count(stretch.cells);
    let of_cell = |cell: &Cell| {
        let reading = |&i: &usize| Reading {
            error_n: samples[i].force_n - samples[i].reference_n,
            place: (samples[i].path_mm - stretch.from_mm) / width_mm - 0.5,
            reference_n: samples[i].reference_n,
            elapsed_share: cell.elapsed_share,
        };
        cell.samples.iter().map(reading).collect()
    };
    cells.iter().map(of_cell).collect()
}

fn layout(cells: &[Cell], options: &PathOptions) -> Layout {
    let runs = cells.iter().map(|c| c.run).max().map_or(0, |last| last + 1);
    let name =
        |run: usize| options.runs.get(run).cloned().unwrap_or_else(|| format!("run {}", run + 1));
    let row = |(observation, cell): (usize, &Cell)| {
        let share = crate::count(cell.samples.len()).sqrt();
        let sigma = options.sigma_n.unwrap_or(1.0) / share;
        Row { observation, component: 0, sigma, reported: true }
    };
    Layout {
        rows: cells.iter().enumerate().map(row).collect(),
        observations: cells.iter().map(|c| c.run).collect(),
        groups: (0..runs).map(|run| Group { name: name(run), role: Role::Fit }).collect(),
        unit: "N".to_owned(),
        sigma_declared: options.sigma_n.is_some(),
    }
}

fn description(effect: PathEffect, stretch: &Stretch) -> Effect {
    let one = |name: &str, unit: &str, report_factor: f64| {
        vec![Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }]
    };
    let knots = |n: usize, unit: &str, report_factor: f64| -> Vec<Parameter> {
        let width_mm = (stretch.to_mm - stretch.from_mm) / crate::count(stretch.cells);
        // Knots stand in the middles of cells, the first and the last one included.
        let span_mm = stretch.to_mm - stretch.from_mm - width_mm;
        let place = |k: usize| {
            let share = crate::count(k) / crate::count(n - 1);
            format!("at {:.1} mm", stretch.from_mm + 0.5 * width_mm + share * span_mm)
        };
        let parameter = |k| Parameter { name: place(k), unit: unit.to_owned(), report_factor };
        (0..n).map(parameter).collect()
    };
    let places = |n: usize| Some(format!("{n} places"));
    let (id, subject, text, parameters) = match effect {
        PathEffect::Zero => {
            ("force-zero", None, "the force is off by a constant", one("zero", "N", 1.0))
        }
        PathEffect::Gain => (
            "force-gain",
            None,
            "the force is larger than the one asked for by a ratio",
            one("gain error", "%", 100.0),
        ),
        PathEffect::Drift => (
            "force-drift",
            None,
            "the force drifts evenly from the first reading to the last",
            one("drift over all runs", "N", 1.0),
        ),
        PathEffect::Repeatable(n) => (
            "path-repeatable",
            places(n),
            "the same force error at the same place of the path in every run (empirical)",
            knots(n, "N", 1.0),
        ),
        PathEffect::Share(n) => (
            "path-share",
            places(n),
            "the same share of the force asked for is missing at the same place of the path in \
             every run (empirical)",
            knots(n, "%", 100.0),
        ),
    };
    // Where no force was asked for, a share of it is nothing; a knot may lie where no run was.
    let scope = match effect {
        PathEffect::Zero | PathEffect::Drift => Scope::Everywhere,
        _ => Scope::SomeDesigns,
    };
    Effect { subject, scope, ..Effect::new(id, text, parameters) }
}

impl Model for PathModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut all =
            DVector::from_iterator(self.cells.len(), self.cells.iter().map(|c| c.residual_n));
        for (effect, amplitude) in self.catalogue.iter().zip(&at.amplitudes) {
            if amplitude.iter().any(|a| *a != 0.0) {
                for (r, cell) in all.iter_mut().zip(&self.cells) {
                    let slopes = self.slopes(*effect, cell);
                    *r -= slopes.iter().zip(amplitude.iter()).map(|(s, a)| s * a).sum::<f64>();
                }
            }
        }
        all
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        DMatrix::zeros(self.cells.len(), 0)
    }

    fn tangent(&self, _: &State, effect: usize) -> DMatrix<f64> {
        let rows: Vec<Vec<f64>> =
            self.cells.iter().map(|cell| self.slopes(self.catalogue[effect], cell)).collect();
        let columns = self.declared.effects[effect].parameters.len();
        DMatrix::from_fn(rows.len(), columns, |i, k| -rows[i][k])
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        let sigma_n = self.sigma_n?;
        let n_readings: usize = self.readings.iter().map(Vec::len).sum();
        let dof = n_readings - self.readings.len();
        let (mut square, mut runs) = (0.0, vec![Vec::new(); self.declared.layout.groups.len()]);
        for (readings, cell) in self.readings.iter().zip(&self.cells) {
            let left = |reading: &Reading| {
                let off_n = |(effect, amplitude): (&PathEffect, &DVector<f64>)| {
                    let slopes = self.slopes_at(*effect, reading);
                    slopes.iter().zip(amplitude.iter()).map(|(s, a)| s * a).sum::<f64>()
                };
                let effects = self.catalogue.iter().zip(&at.amplitudes);
                let present = effects.filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0));
                (reading.error_n - present.map(off_n).sum::<f64>()) / sigma_n
            };
            let left: Vec<f64> = readings.iter().map(left).collect();
            let mean = left.iter().sum::<f64>() / crate::count(left.len());
            square += left.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
            runs[cell.run].extend(left);
        }
        let (correlation, pairs) = lag_one(runs.iter().map(Vec::as_slice));
        let share = independent_share(correlation, pairs);
        (dof > 0).then(|| Inside { chi2: square, dof: crate::count(dof), share })
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        let scaled = |factor: f64| move || Some(self.with_run(|n| factor * n));
        vec![
            Proposal::new("follow the path once more at twice the force", scaled(2.0)),
            Proposal::new("follow the path once more at half the force", scaled(0.5)),
        ]
    }
}
