//! The declared model of a survey of points, as the loop sees it.

use std::collections::HashSet;

use least_squares::BorderedPoint;
use model_discrepancy::{
    Covariate, Declared, Group, Inside, Layout, LinearModel, Model, Origin, Parameter, Proposal,
    Role, Row, State, resolution_of,
};
use nalgebra::{DMatrix, DVector};

use super::bundle::Bundle;
use super::calibrate::fitted;
use super::catalogue::{Scene, catalogue};
use super::faults::{Fault, Fitted, faults};
use super::rows::Rows;
use super::sight::Sight;
use super::{HoldOut, TargetCalibration, TargetOptions, TargetSurvey};
use crate::TrackerError;
use crate::missing::found::NEAR_MM;
use crate::missing::model::elapsed;
use crate::network::angles;

/// What was recorded beside the readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetRecords {
    /// Time of every reading.
    pub time_s: Option<Vec<f64>>,
    /// One value per reading; those ending in `_c` are temperatures.
    pub covariates: Vec<Covariate>,
    /// The body that every mount is on; empty where all are on one.
    pub bodies: Vec<String>,
}

/// The bundle of a survey of points about its solution, and the effects that it leaves out.
///
/// What belongs to the units held out alone is taken out of the rows by an orthogonal
/// transformation that leaves the noise white: the six errors of every angle where steps are
/// held out, the places of the reflectors where these are. Rows are linear in parameters and
/// amplitudes.
#[derive(Clone, Debug)]
pub struct TargetModel {
    survey: TargetSurvey,
    records: TargetRecords,
    hold_out: HoldOut,
    options: TargetOptions,
    /// Of the declared model.
    calibration: TargetCalibration,
    /// About which rows are linear.
    point: BorderedPoint,
    faults: Vec<Fault>,
    linear: LinearModel,
    /// By effect and amplitude: three components per reading, mm.
    columns: Vec<Vec<Vec<f64>>>,
}

/// What a model about one solution leaves to that about another.
struct Choices {
    /// Faults in the catalogue.
    faults: Vec<Fault>,
    /// Readings and components that rows are tied to.
    tied: HashSet<(usize, usize)>,
}

impl TargetModel {
    /// Calibrates a survey and builds the model about the result.
    ///
    /// # Errors
    ///
    /// As [`calibrate_targets`](crate::calibrate_targets); [`TrackerError::InvalidCovariate`]
    /// where a record does not have one finite value per reading, or bodies are not one per
    /// mount.
    pub fn new(
        survey: TargetSurvey,
        records: &TargetRecords,
        hold_out: HoldOut,
        options: &TargetOptions,
    ) -> Result<Self, TrackerError> {
        check_records(&survey, records)?;
        let solved = fitted(&survey, options, &[])?;
        Self::about(survey, records.clone(), hold_out, *options, solved, None)
    }

    /// The model about a point, with the choices of another model, where given.
    fn about(
        survey: TargetSurvey,
        records: TargetRecords,
        hold_out: HoldOut,
        options: TargetOptions,
        (calibration, point): (TargetCalibration, BorderedPoint),
        choices: Option<&Choices>,
    ) -> Result<Self, TrackerError> {
        let sigma_mm = calibration.point_mm.unwrap_or(1.0);
        let bundle = Bundle::new(&survey, &options, sigma_mm, Vec::new())?;
        let sights: Vec<Sight> =
            (0..survey.targets.len()).map(|n| bundle.sight_at(n, &point)).collect();
        let tied = choices.map(|choices| &choices.tied);
        let rows = Rows::new(&bundle, &sights, hold_out, tied)?;
        let (base, by_base) = base(&bundle, hold_out);
        let jacobian = rows.columns(base.len(), |n, c, p| by_base(&sights[n], n, c, p));
        let residual = rows.columns(1, |n, c, _| sights[n].residual_mm[c]).column(0).into_owned();
        let layout = layout(&survey, &rows, hold_out, calibration.point_mm.is_none());
        let find = || {
            let (basis, left) = beside(&rows, &jacobian, &residual);
            faults(&Fitted {
                survey: &survey,
                sights: &sights,
                rows: &rows,
                basis: &basis,
                residual: &left,
                hold_out,
            })
        };
        let faults = choices.map_or_else(find, |choices| choices.faults.clone());
        let time = elapsed(survey.targets.len(), records.time_s.as_deref());
        let one_body = vec![String::new(); survey.mounts.len()];
        let scene = Scene {
            survey: &survey,
            sights: &sights,
            time: &time,
            timed: records.time_s.is_some(),
            covariates: &records.covariates,
            bodies: if records.bodies.is_empty() { &one_body } else { &records.bodies },
        };
        let entries = catalogue(&scene, &faults);
        let tangents = entries.iter().map(|e| tangent(&rows, &e.columns)).collect();
        drop(by_base);
        let (effects, columns) = entries.into_iter().map(|e| (e.effect, e.columns)).unzip();
        let declared = Declared {
            // None repeats another: a row combines readings of several angles once what ties them is
            // taken out.
            places: Some((0..layout.observations.len()).collect()),
            resolution: resolution_of(survey.targets.iter().flat_map(|t| t.at_mm.iter().copied())),
            ..Declared::new(layout, base, effects)
        };
        let extended = Vec::new();
        let linear = LinearModel { declared, residual, base: jacobian, tangents, extended };
        Ok(Self { survey, records, hold_out, options, calibration, point, faults, linear, columns })
    }

    /// The model about the calibration with amplitudes of effects among the unknowns; `None` where
    /// it is near that already, where nothing is, and where there is none.
    ///
    /// Columns are then those of what was found, and not of the declared solution.
    #[must_use]
    pub fn about_found(&self, active: &[(usize, usize)]) -> Option<Self> {
        if active.is_empty() {
            return None;
        }
        let (_, mut point) = fitted(&self.survey, &self.options, &self.extras(active)).ok()?;
        point.shared.truncate(self.point.shared.len());
        let sigma_mm = self.calibration.point_mm.unwrap_or(1.0);
        let bundle = Bundle::new(&self.survey, &self.options, sigma_mm, Vec::new()).ok()?;
        let away = |n: usize| {
            let [there, here] = [&point, &self.point].map(|at| bundle.sight_at(n, at).predicted_mm);
            (there - here).norm()
        };
        if (0..self.survey.targets.len()).map(away).fold(0.0, f64::max) < NEAR_MM {
            return None;
        }
        let (survey, records) = (self.survey.clone(), self.records.clone());
        let solved = (self.calibration.clone(), point);
        let (hold_out, options) = (self.hold_out, self.options);
        let rows = self.declared().layout.rows.iter();
        let tied = rows.map(|row| (row.observation, row.component)).collect();
        let choices = Choices { faults: self.faults.clone(), tied };
        let about = Self::about(survey, records, hold_out, options, solved, Some(&choices));
        about.ok().filter(|about| about.declared().layout == self.declared().layout)
    }

    fn extras(&self, active: &[(usize, usize)]) -> Vec<Vec<f64>> {
        active.iter().map(|&(effect, p)| self.columns[effect][p].clone()).collect()
    }

    /// The declared model's calibration.
    #[must_use]
    pub fn calibration(&self) -> &TargetCalibration {
        &self.calibration
    }

    /// Where the readings were taken, as covariates: `angle_deg`.
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        let angle = |step: usize| self.survey.steps[step].angle_rad.to_degrees();
        let values = self.survey.targets.iter().map(|t| angle(t.step)).collect();
        vec![Covariate { name: "angle_deg".to_owned(), values, origin: Origin::Coordinate }]
    }

    /// The calibration anew with amplitudes of effects, as indices of effect and parameter, among
    /// the unknowns; and what these come to.
    ///
    /// # Errors
    ///
    /// As [`calibrate_targets`](crate::calibrate_targets).
    pub fn calibration_with(
        &self,
        active: &[(usize, usize)],
    ) -> Result<(TargetCalibration, Vec<f64>), TrackerError> {
        let (calibration, point) = fitted(&self.survey, &self.options, &self.extras(active))?;
        let amplitudes = point.shared[point.shared.len() - active.len()..].to_vec();
        Ok((calibration, amplitudes))
    }
}

/// Share of an amplitude's column below which the rows hold nothing of it but rounding.
const NOTHING_LEFT: f64 = 1e-9;

/// Columns of an effect as reduced rows; zero where the units that are held out take all of it.
fn tangent(rows: &Rows, columns: &[Vec<f64>]) -> DMatrix<f64> {
    let mut reduced = rows.columns(columns.len(), |n, c, p| columns[p][3 * n + c]);
    for (mut left, whole) in reduced.column_iter_mut().zip(columns) {
        let length = whole.iter().map(|v| v * v).sum::<f64>().sqrt();
        if left.norm() <= NOTHING_LEFT * length {
            left.fill(0.0);
        }
    }
    reduced
}

fn check_records(survey: &TargetSurvey, records: &TargetRecords) -> Result<(), TrackerError> {
    let needed = survey.targets.len();
    let times = records.time_s.iter().map(Vec::as_slice);
    for values in times.chain(records.covariates.iter().map(|c| c.values.as_slice())) {
        if values.len() != needed || values.iter().any(|v| !v.is_finite()) {
            return Err(TrackerError::InvalidCovariate { needed });
        }
    }
    if !records.bodies.is_empty() && records.bodies.len() != survey.mounts.len() {
        return Err(TrackerError::InvalidCovariate { needed: survey.mounts.len() });
    }
    Ok(())
}

/// Derivative of a component of a reading by a base parameter.
type ByBase<'a> = Box<dyn Fn(&Sight, usize, usize, usize) -> f64 + 'a>;

/// Base parameters beside those that are taken out, and the derivatives by them.
///
/// Where reflectors are free, the first station holds the frame; else the fit of the reflectors.
fn base<'a>(bundle: &'a Bundle<'_>, hold_out: HoldOut) -> (Vec<Parameter>, ByBase<'a>) {
    use least_squares::BorderedProblem;
    let survey = bundle.survey;
    let named = |name: String| {
        let (name, unit) = name.rsplit_once(" (").unwrap_or((&name, "mm)"));
        let unit = unit.trim_end_matches(')');
        Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor: 1.0 }
    };
    let of_station = move |sight: &Sight, n: usize, c: usize, p: usize| {
        let is_own = survey.targets[n].station == p / 6;
        if is_own { sight.by_station[(c, p % 6)] } else { 0.0 }
    };
    match hold_out {
        HoldOut::Step => {
            let first = bundle.mount_start();
            let names = (0..bundle.extra_start()).map(|p| named(bundle.shared_name(p))).collect();
            let by_base: ByBase<'a> = Box::new(move |sight, n, c, p| {
                if p < first {
                    return of_station(sight, n, c, p);
                }
                let moves = bundle.chart.moves(survey.targets[n].mount);
                let way = moves.iter().find(|(q, _)| *q == p - first);
                way.map_or(0.0, |(_, way)| (sight.by_mount.row(c) * way)[0])
            });
            (names, by_base)
        }
        HoldOut::Mount => {
            let stations = bundle.mount_start() - 6;
            let n_errors = 6 * (bundle.angles.len() - 1);
            let station_names = (0..stations).map(|p| bundle.shared_name(p + 6));
            let error_names = (0..n_errors).map(|p| bundle.block_name(1 + p / 6, p % 6));
            let names = station_names.chain(error_names).map(named).collect();
            let by_base: ByBase<'a> = Box::new(move |sight, n, c, p| {
                if p < stations {
                    return of_station(sight, n, c, p + 6);
                }
                let p = p - stations;
                let is_own = bundle.angle_of_step[survey.targets[n].step] == 1 + p / 6;
                if is_own { sight.by_error[(c, p % 6)] } else { 0.0 }
            });
            (names, by_base)
        }
    }
}

/// Orthonormal basis of the base parameters' whitened columns, and the residual beside it.
fn beside(
    rows: &Rows,
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> (DMatrix<f64>, DVector<f64>) {
    let (mut whitened, mut residual) = (jacobian.clone(), residual.clone());
    for (i, sigma) in rows.sigma_mm.iter().enumerate() {
        whitened.row_mut(i).unscale_mut(*sigma);
        residual[i] /= sigma;
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

/// One observation per reading.
fn layout(survey: &TargetSurvey, rows: &Rows, hold_out: HoldOut, declared: bool) -> Layout {
    let group = |name: &String| Group { name: name.clone(), role: Role::Fit };
    let (groups, observations) = match hold_out {
        HoldOut::Step => {
            let mut groups: Vec<Group> = survey.steps.iter().map(|s| group(&s.name)).collect();
            // The first angle is where the errors are zero: met once, it says where the trackers
            // stand, and without it nothing does.
            if let Some([first]) = angles(&survey.steps).0.first().map(|a| &a.steps[..]) {
                groups[*first].role = Role::Prior;
            }
            (groups, survey.targets.iter().map(|t| t.step).collect())
        }
        HoldOut::Mount => (
            survey.mounts.iter().map(|m| group(&m.name)).collect(),
            survey.targets.iter().map(|t| t.mount).collect(),
        ),
    };
    let row = |(&(observation, component), &sigma): (&(usize, usize), &f64)| Row {
        observation,
        component,
        sigma,
        reported: true,
    };
    Layout {
        rows: rows.tied_to.iter().zip(&rows.sigma_mm).map(row).collect(),
        observations,
        groups,
        unit: "mm".to_owned(),
        sigma_declared: declared,
    }
}

impl Model for TargetModel {
    fn declared(&self) -> &Declared {
        &self.linear.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        self.linear.residuals(at)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.linear.base_jacobian(at)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.linear.tangent(at, effect)
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal> {
        Vec::new()
    }
}
