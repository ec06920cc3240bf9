//! The declared model, as the loop sees it.

mod discrepancy;

use std::collections::HashSet;

use least_squares::{BorderedPoint, BorderedProblem};
use model_discrepancy::{
    Covariate, Declared, Group, Layout, LinearModel, Model, Origin, Parameter, Role, Row,
    resolution_of,
};
use nalgebra::{DMatrix, DVector, Point3};

use crate::calibrate::fitted_joint;
use crate::gauge::StationChart;
use crate::joint::Joint;
use crate::missing::change::Offered;
use crate::missing::changes::{Fitted, changes};
use crate::missing::course::{Courses, courses};
use crate::missing::effects::{Entry, Scene, approaches, catalogue};
use crate::missing::moves::Moves;
use crate::missing::reduction::{Reduction, one_column};
use crate::missing::sights::{Sight, sights, without};
use crate::network::Network;
use crate::shift::Shift;
use crate::{Calibration, Options, Survey, TrackerError};

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
    linear: LinearModel,
    /// Columns of every effect, range by range, mm.
    pub(crate) columns: Vec<Vec<Vec<f64>>>,
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

/// The solution about which the model is linear.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// Of the declared model.
    pub(crate) calibration: Calibration,
    /// `[stations, dead paths, reflectors]`, and the errors of every angle.
    pub(crate) point: BorderedPoint,
    /// What effects that are part of the solution move, range by range; empty where there are none.
    pub(crate) shifts: Vec<Shift>,
}

/// What a model about one solution leaves to that about another.
#[derive(Clone, Debug)]
pub(crate) struct Choices {
    /// Changes in the catalogue.
    pub(crate) changes: Vec<Offered>,
    /// How stands move in it.
    pub(crate) courses: Courses,
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
        let n = survey.ranges.len();
        let times = time_s.iter().map(Vec::as_slice);
        for values in times.chain(covariates.iter().map(|c| c.values.as_slice())) {
            if values.len() != n || values.iter().any(|v| !v.is_finite()) {
                return Err(TrackerError::InvalidCovariate { needed: n });
            }
        }
        let (calibration, point) = fitted_joint(&survey, options)?;
        let solved = Solved { calibration, point, shifts: Vec::new() };
        Self::about(survey, *options, Recorded { time_s, covariates }, solved, None)
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
        let residuals_mm = without(&solved.shifts, &sights);
        let residual = with_prior(&reduction.columns(&one_column(&residuals_mm)), &prior_residual);
        let residual = residual.column(0).into_owned();
        let layout = layout(&network, &reduction, &chart, sigma_mm, &options);
        let time = elapsed(survey.ranges.len(), recorded.time_s.as_deref());
        let (changes, courses) = choices.map_or_else(
            || {
                let (basis, residual) = whitened(&layout, &residual, &jacobian);
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
        let scene = Scene {
            survey: &survey,
            sights: &sights,
            time: &time,
            timed: recorded.time_s.is_some(),
            covariates: &recorded.covariates,
            approaches: &approaches,
            dead_path_of: &network.dead_path_of,
            courses: &courses,
        };
        let entries = catalogue(&scene, &changes);
        let none =
            |entry: &Entry| DMatrix::zeros(prior_jacobian.nrows(), entry.effect.parameters.len());
        let tangents =
            entries.iter().map(|e| with_prior(&reduction.columns(&e.columns), &none(e))).collect();
        let base = base(&joint);
        let records = locks(&survey, layout.observations.len());
        let (mut effects, mut columns, mut moves) = (Vec::new(), Vec::new(), Vec::new());
        for entry in entries {
            effects.push(entry.effect);
            columns.push(entry.columns);
            moves.push(entry.moves);
        }
        let declared = Declared {
            // None repeats another: a row combines readings of several angles once what ties them is
            // taken out.
            places: Some((0..layout.observations.len()).collect()),
            records: Some(records),
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
        Choices { changes, courses, tied: Some(tied) }
    }

    /// The declared model's calibration.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        &self.solved.calibration
    }

    /// Where the ranges were measured, as covariates: `angle_deg`.
    ///
    /// The last value of a covariate belongs to the prior knowledge of the stations.
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let angle = |r: &crate::Range| self.survey.steps[r.step].angle_rad.to_degrees();
        let values = self.survey.ranges.iter().map(angle).collect();
        vec![self.padded(&Covariate {
            name: "angle_deg".to_owned(),
            values,
            origin: Origin::Coordinate,
        })]
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

/// Station and mount of every range as one number; what is known beforehand is apart.
fn locks(survey: &Survey, n_observations: usize) -> Vec<usize> {
    let n_mounts = survey.mounts.len();
    let mut locks: Vec<usize> =
        survey.ranges.iter().map(|r| r.station * n_mounts + r.mount).collect();
    locks.resize(n_observations, survey.stations.len() * n_mounts);
    locks
}

/// Time of every one of `n` readings: from the first one on as recorded, else the share of the run.
pub(crate) fn elapsed(n: usize, time_s: Option<&[f64]>) -> Vec<f64> {
    if let Some(time_s) = time_s {
        let first = time_s.iter().copied().fold(f64::INFINITY, f64::min);
        return time_s.iter().map(|t| t - first).collect();
    }
    (0..n).map(|index| count(index) / count(n.saturating_sub(1).max(1))).collect()
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

/// Orthonormal basis of the shared parameters' columns, whitened, and the residual without what it
/// explains.
fn whitened(
    layout: &Layout,
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
) -> (DMatrix<f64>, DVector<f64>) {
    let mut whitened = jacobian.clone();
    let mut residual = residual.clone();
    for (i, row) in layout.rows.iter().enumerate() {
        whitened.row_mut(i).unscale_mut(row.sigma);
        residual[i] /= row.sigma;
    }
    for mut column in whitened.column_iter_mut() {
        let length = column.norm().max(f64::MIN_POSITIVE);
        column.unscale_mut(length);
    }
    let basis = whitened.qr().q();
    let along = basis.tr_mul(&residual);
    residual -= &basis * along;
    (basis, residual)
}

/// One observation per range, and one for what is known of the stations beforehand.
fn layout(
    network: &Network<'_>,
    reduction: &Reduction,
    chart: &StationChart,
    sigma_mm: f64,
    options: &Options,
) -> Layout {
    let survey = network.survey;
    let mut groups: Vec<Group> =
        survey.steps.iter().map(|s| Group { name: s.name.clone(), role: Role::Fit }).collect();
    let mut observations: Vec<usize> = survey.ranges.iter().map(|r| r.step).collect();
    let mut rows: Vec<Row> = (reduction.range_of_row.iter())
        .map(|&range| Row { observation: range, component: 0, sigma: sigma_mm, reported: true })
        .collect();
    if let Some(sigma) = chart.prior_mm {
        observations.push(groups.len());
        groups.push(Group { name: "nominal stations".to_owned(), role: Role::Prior });
        let observation = survey.ranges.len();
        let prior = Row { observation, component: 0, sigma, reported: false };
        rows.extend(std::iter::repeat_n(prior, chart.dim()));
    }
    Layout {
        rows,
        observations,
        groups,
        unit: "mm".to_owned(),
        sigma_declared: options.noise.displacement_mm.is_some(),
    }
}

fn base(joint: &Joint<'_>) -> Vec<Parameter> {
    let parameter = |index: usize| {
        let name = joint.shared_name(index);
        let name = name.trim_end_matches(" (mm)").to_owned();
        Parameter { name, unit: "mm".to_owned(), report_factor: 1.0 }
    };
    (0..joint.shared_dim()).map(parameter).collect()
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn count(n: usize) -> f64 {
    n as f64
}
