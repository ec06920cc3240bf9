//! The declared model, as the loop sees it.

mod discrepancy;

use std::collections::HashSet;

use least_squares::{BorderedPoint, BorderedProblem};
use model_discrepancy::{
    Covariate, Declared, Layout, LinearModel, Model, Parameter, Quantity, resolution_of,
};
use nalgebra::{DMatrix, Point3};

use crate::calibrate::Placed;
use crate::curves::Curves;
use crate::frame::Frame;
use crate::gauge::StationChart;
use crate::joint::Joint;
use crate::missing::change::Offered;
use crate::missing::changes::{Fitted, changes};
use crate::missing::course::Course;
use crate::missing::courses::{Courses, courses};
use crate::missing::effects::{Entry, Scene, approaches, catalogue};
use crate::missing::layout::{at_steps, layout, locks, places};
use crate::missing::looked_through::beside;
use crate::missing::moves::Moves;
use crate::missing::of_axis::OfAxis;
use crate::missing::orders::Orders;
use crate::missing::reduction::Reduction;
use crate::missing::sights::{Sight, sights, without};
use crate::missing::solved::{Solved, solved};
use crate::missing::stops::Stops;
use crate::network::Network;
use crate::recorded::{self, elapsed};
use crate::{AxisModel, Calibration, Options, Survey, TrackerError};

/// The joint bundle of a survey about its solution, and the effects that it leaves out.
///
/// Base parameters are changes of stations, dead paths and reflectors from the solution; the six
/// errors of every angle are taken out of the rows (an orthogonal transformation, angle by
/// angle, that leaves the noise white), so that a step that is left out is predicted from the
/// others and from what its own ranges say of its own errors. Each row is tied to one range; six
/// ranges of an angle have none. Rows are linear in parameters and amplitudes: what is left of them
/// beyond is below a nanometre for changes under 30 µm. [`Self::about_found`] gives the model anew
/// about what a loop has found, where that is further away.
///
/// The formulation asked for does not matter here: rigid body, six errors per angle.
#[derive(Clone, Debug)]
pub struct TrackerModel {
    pub(crate) survey: Survey,
    pub(crate) options: Options,
    pub(crate) recorded: Recorded,
    pub(crate) solved: Solved,
    pub(crate) sights: Vec<Sight>,
    pub(crate) changes: Vec<Offered>,
    pub(crate) courses: Courses,
    /// How many harmonics every motion error of a perfect axis is offered with.
    pub(crate) orders: Orders,
    /// What effects on a perfect axis do at every angle: first what the declared model fits.
    pub(crate) curves: Curves,
    /// Uncertainty of the frame that the place of a perfect axis is off in.
    pub(crate) frame: Option<Frame>,
    /// Of every effect, the first of these that is its own.
    pub(crate) curve_of: Vec<Option<usize>>,
    linear: LinearModel,
    /// Columns of every effect, range by range, mm.
    pub(crate) columns: Vec<DMatrix<f64>>,
    /// What every effect moves, where it is of the geometry.
    pub(crate) moves: Vec<Option<Moves>>,
    /// Residual of every range where parameters and amplitudes are zero.
    pub(crate) residuals_mm: Vec<f64>,
}

/// What was recorded beside the ranges, one value each.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    pub(crate) time_s: Option<Vec<f64>>,
    pub(crate) covariates: Vec<Covariate>,
}

impl Recorded {
    /// That there is one finite value for each of `needed` ranges.
    fn check(&self, needed: usize) -> Result<(), TrackerError> {
        recorded::check(self.time_s.as_deref(), &self.covariates, needed)
    }

    /// Beside the first ranges.
    fn first(&self, n: usize) -> Self {
        let mut first = self.clone();
        recorded::truncate(&mut first.time_s, &mut first.covariates, n);
        first
    }
}

/// What a model about one solution leaves to that about another.
#[derive(Clone, Debug)]
pub(crate) struct Choices {
    /// Changes in the catalogue.
    pub(crate) changes: Vec<Offered>,
    /// How stands move in it.
    pub(crate) courses: Courses,
    /// How many harmonics its motion errors have; `None` for the usual ones.
    pub(crate) orders: Option<Orders>,
    /// Ranges that rows are tied to; `None` leaves it to the geometry.
    pub(crate) tied: Option<HashSet<usize>>,
}

impl TrackerModel {
    /// Calibrates a survey and builds the model about the result.
    ///
    /// `time_s` holds the time of every range, where it was recorded; `covariates` what else was
    /// recorded, one value per range. Columns ending in `_c` are temperatures.
    ///
    /// # Errors
    ///
    /// As [`calibrate`](crate::calibrate).
    pub fn new(
        survey: Survey,
        time_s: Option<Vec<f64>>,
        covariates: Vec<Covariate>,
        options: &Options,
    ) -> Result<Self, TrackerError> {
        let recorded = Recorded { time_s, covariates };
        recorded.check(survey.ranges.len())?;
        Self::with(survey, options, recorded, None)
    }

    /// The same of a survey of which only the first `n_measured` ranges were read, and the rest are planned:
    /// how stands move, where another session begins and what has changed is looked for in those alone,
    /// and the rest are taken to go on so.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], for the whole and for what was measured.
    pub fn with_planned(
        survey: Survey,
        time_s: Option<Vec<f64>>,
        covariates: Vec<Covariate>,
        options: &Options,
        n_measured: usize,
    ) -> Result<Self, TrackerError> {
        let recorded = Recorded { time_s, covariates };
        recorded.check(survey.ranges.len())?;
        let measured =
            Self::with(survey.first(n_measured), options, recorded.first(n_measured), None)?;
        let TrackerModel { changes, mut courses, .. } = measured;
        courses.of_station.resize(survey.stations.len(), Course::STEADY);
        Self::with(survey, options, recorded, Some((changes, courses)))
    }

    /// With changes and courses that were looked for before, where given.
    fn with(
        survey: Survey,
        options: &Options,
        recorded: Recorded,
        known: Option<(Vec<Offered>, Courses)>,
    ) -> Result<Self, TrackerError> {
        let Placed { options, frame, is_off } = Placed::of(&survey, options)?;
        let solved = solved(&survey, &options)?;
        let is_perfect = options.axis != AxisModel::Free;
        let own = || {
            let choices = Choices::of_perfect_axis(&survey, &options, &recorded);
            choices.map(|mut choices| {
                choices.orders.iter_mut().for_each(|orders| orders.location = is_off);
                choices
            })
        };
        let own = is_perfect.then(own).flatten();
        let choices = match known {
            None => own,
            Some((changes, courses)) => {
                let orders = own.and_then(|choices| choices.orders);
                Some(Choices { changes, courses, orders, tied: None })
            }
        };
        let model = Self::about(survey, options, recorded, solved, choices.as_ref())?;
        Ok(Self { frame, ..model })
    }

    /// The model about a known solution, with the choices of another model, where given.
    pub(crate) fn about(
        survey: Survey,
        options: Options,
        recorded: Recorded,
        solved: Solved,
        choices: Option<&Choices>,
    ) -> Result<Self, TrackerError> {
        let network = Network::new(&survey, &options)?;
        let nominal: Vec<Point3<f64>> = survey.stations.iter().map(|s| s.nominal_mm).collect();
        let chart = StationChart::new(&nominal, &options)?;
        let point = &solved.point;
        let sigma_mm = solved.calibration.displacement_mm;
        let joint = Joint::new(&network, &chart, sigma_mm).shifted(solved.shifts.clone());
        let sights = sights(&joint, point);
        let reduction =
            Reduction::new(&joint, &sights, choices.and_then(|choices| choices.tied.as_ref()))?;
        let with_prior = |rows: &DMatrix<f64>, prior: &DMatrix<f64>| {
            DMatrix::from_fn(rows.nrows() + prior.nrows(), rows.ncols(), |i, j| {
                if i < rows.nrows() { rows[(i, j)] } else { prior[(i - rows.nrows(), j)] }
            })
        };
        let (prior_residual, prior_jacobian) = prior_rows(&chart, point);
        let jacobian = with_prior(&reduction.by_shared(&joint, point, sigma_mm), &prior_jacobian);
        let angles_rad = network.angles_rad();
        let visits: Vec<usize> = network.angles.iter().map(|a| a.steps.len()).collect();
        let stops = Stops { axis: &survey.axis, angles_rad: &angles_rad, visits: &visits };
        let orders = choices.and_then(|choices| choices.orders.clone());
        let orders = orders.unwrap_or_else(|| Orders::usual(&stops));
        let of_axis = OfAxis::new(&joint, &stops, &orders, &solved);
        let mut residuals_mm = without(&solved.shifts, &sights);
        of_axis.taken_off(&network, &sights, &mut residuals_mm);
        let residual = with_prior(
            &reduction.columns(&DMatrix::from_column_slice(residuals_mm.len(), 1, &residuals_mm)),
            &prior_residual,
        );
        let residual = residual.column(0).into_owned();
        let layout = layout(&network, &reduction, &chart, sigma_mm, &options);
        let time = elapsed(survey.ranges.len(), recorded.time_s.as_deref());
        let (changes, courses) = choices.map_or_else(
            || {
                let (basis, residual) = beside(sigmas(&layout), &jacobian, &residual);
                let fitted = Fitted {
                    network: &network,
                    sights: &sights,
                    reduction: &reduction,
                    basis: &basis,
                    residual: &residual,
                    sigma_mm,
                };
                let (changes, clearest) = changes(&fitted);
                (changes, courses(&fitted, &time, clearest))
            },
            |choices| (choices.changes.clone(), choices.courses.clone()),
        );
        let approaches = approaches(&survey.steps);
        let dead_path_of: Vec<usize> =
            survey.ranges.iter().map(|range| network.dead_path_of(range)).collect();
        let scene = Scene {
            survey: &survey,
            sights: &sights,
            time: &time,
            timed: recorded.time_s.is_some(),
            covariates: &recorded.covariates,
            approaches: &approaches,
            is_perfect: options.axis != AxisModel::Free,
            dead_path_of: &dead_path_of,
            courses: &courses,
        };
        let mut entries = catalogue(&scene, &changes);
        let curve_of = of_axis.curve_of(entries.len());
        entries.extend(of_axis.entries(&network, &sights));
        let tangents = tangents(&entries, &reduction, layout.rows.len());
        let base = base(&joint);
        let records = locks(&survey, layout.observations.len());
        let (mut effects, mut columns, mut moves) = (Vec::new(), Vec::new(), Vec::new());
        for entry in entries {
            effects.push(entry.effect);
            columns.push(entry.columns);
            moves.push(entry.moves);
        }
        let declared = Declared {
            places: Some(places(&network, layout.observations.len())),
            records: Some(records),
            cells: vec![at_steps(&survey, layout.observations.len())],
            projected: reduction.projected(),
            resolution: resolution_of(survey.ranges.iter().map(|r| r.displacement_mm)),
            ..Declared::new(layout, base, effects)
        };
        let extended = Vec::new();
        let linear = LinearModel { declared, residual, base: jacobian, tangents, extended };
        Ok(Self {
            survey,
            options,
            recorded,
            solved,
            sights,
            changes,
            courses,
            orders,
            curves: of_axis.curves,
            curve_of,
            frame: None,
            linear,
            columns,
            moves,
            residuals_mm,
        })
    }

    pub(crate) fn choices(&self) -> Choices {
        let rows = self.declared().layout.rows.iter().map(|row| row.observation);
        let tied = rows.filter(|&range| range < self.survey.ranges.len()).collect();
        let (changes, courses) = (self.changes.clone(), self.courses.clone());
        Choices { changes, courses, orders: Some(self.orders.clone()), tied: Some(tied) }
    }

    /// The declared model's calibration.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        &self.solved.calibration
    }

    /// Where the ranges were measured, as covariates: `angle_deg`, and of two axes `second_angle_deg`.
    ///
    /// The last value of a covariate belongs to the prior knowledge of the stations.
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let steps = self.survey.steps.iter().map(|step| step.angle_rad).collect();
        let second =
            self.survey.second.as_ref().map(|s| ("second_angle_deg", s.angles_rad.clone()));
        let coordinate = |(name, of_step): (&str, Vec<f64>)| {
            let values = self.survey.ranges.iter().map(|r| of_step[r.step].to_degrees());
            self.padded(&Covariate::coordinate(name, Quantity::Angle, values.collect()))
        };
        [("angle_deg", steps)].into_iter().chain(second).map(coordinate).collect()
    }

    /// A covariate of the ranges with the value that the layout's last observation needs.
    #[must_use]
    pub fn padded(&self, covariate: &Covariate) -> Covariate {
        let mut padded = covariate.clone();
        if self.declared().layout.observations.len() > covariate.values.len() {
            padded.values.push(covariate.values.first().copied().unwrap_or(0.0));
        }
        padded
    }
}

impl Choices {
    /// Of a model that takes the axis for perfect: changes and courses as the residual of free errors
    /// shows them, orders as that about the axis' place does. What is missing of the axis would hide
    /// either. `None` where the readings do not determine these.
    fn of_perfect_axis(survey: &Survey, options: &Options, recorded: &Recorded) -> Option<Self> {
        let about = |axis: AxisModel| {
            let options = Options { axis, ..*options };
            let solved = solved(survey, &options).ok()?;
            TrackerModel::about(survey.clone(), options, recorded.clone(), solved, None).ok()
        };
        let located = about(AxisModel::Located)?;
        let orders = located.orders_shown().ok()?;
        let TrackerModel { changes, courses, .. } = about(AxisModel::Free).unwrap_or(located);
        Some(Self { changes, courses, orders: Some(orders), tied: None })
    }
}

impl TrackerModel {
    /// Harmonics of the motion errors that the residual shows.
    fn orders_shown(&self) -> Result<Orders, TrackerError> {
        let network = Network::new(&self.survey, &self.options)?;
        let angles_rad = network.angles_rad();
        let visits: Vec<usize> = network.angles.iter().map(|a| a.steps.len()).collect();
        let stops = Stops { axis: &self.survey.axis, angles_rad: &angles_rad, visits: &visits };
        let (layout, sigma_mm) = (&self.declared().layout, self.solved.calibration.displacement_mm);
        let (basis, left) = beside(sigmas(layout), &self.linear.base, &self.linear.residual);
        let n_rows = layout.rows.len();
        Ok(Orders::shown(&stops, &basis, &left, |shapes| {
            let curves = Curves::new(&self.survey.axis, &angles_rad, shapes.to_vec());
            let zero = vec![0.0; curves.len()];
            let at: Vec<_> = (0..angles_rad.len()).map(|k| curves.at(k, &zero).slopes).collect();
            let mut columns = DMatrix::zeros(n_rows, curves.len());
            for (i, row) in layout.rows.iter().enumerate() {
                let Some(range) = self.survey.ranges.get(row.observation) else { continue };
                for (j, slope) in at[network.angle_of_step[range.step]].iter().enumerate() {
                    let sight = &self.sights[row.observation];
                    columns[(i, j)] = sight.by_error.dot(slope) / sigma_mm;
                }
            }
            columns
        }))
    }
}

/// Columns of the rows, of which the last are of no range: all effects' at once, a product of matrices.
fn tangents(entries: &[Entry], reduction: &Reduction, n_rows: usize) -> Vec<DMatrix<f64>> {
    let columns: Vec<_> = entries.iter().flat_map(|e| e.columns.column_iter()).collect();
    let all = reduction.columns(&DMatrix::from_columns(&columns));
    let mut first = 0;
    let of = |entry: &Entry| {
        let width = entry.columns.ncols();
        let own = all.columns(first, width).into_owned();
        first += width;
        own.resize_vertically(n_rows, 0.0)
    };
    entries.iter().map(of).collect()
}

fn sigmas(layout: &Layout) -> impl Iterator<Item = f64> {
    layout.rows.iter().map(|row| row.sigma)
}

/// Rows that say how well the stations are known, mm.
fn prior_rows(chart: &StationChart, point: &BorderedPoint) -> (DMatrix<f64>, DMatrix<f64>) {
    let shared = point.shared.len();
    let n = chart.prior_mm.map_or(0, |_| chart.dim());
    (
        DMatrix::from_fn(n, 1, |i, _| point.shared[i]),
        DMatrix::from_fn(n, shared, |i, j| f64::from(u8::from(i == j))),
    )
}

fn base(joint: &Joint<'_>) -> Vec<Parameter> {
    let parameter = |index: usize| {
        let name = joint.shared_name(index);
        let name = name.trim_end_matches(" (mm)").to_owned();
        Parameter { name, unit: "mm".to_owned(), report_factor: 1.0 }
    };
    (0..joint.shared_dim()).map(parameter).collect()
}
