//! The declared model of a survey of points, as the loop sees it.

use std::collections::HashSet;

use least_squares::BorderedPoint;
use model_discrepancy::{
    Covariate, Declared, Inside, LinearModel, Model, Proposal, Quantity, State, resolution_of,
};
use nalgebra::{DMatrix, DVector, Vector6};

use super::base::base;
use super::bundle::{Added, Bundle};
use super::calibrate::{Placed, fitted};
use super::catalogue::{Entry, Scene, catalogue};
use super::faults::{Fitted, Found, found};
use super::layout::{layout, places};
use super::records::TargetRecords;
use super::rows::Rows;
use super::sight::Sight;
use super::{HoldOut, TargetCalibration, TargetOptions, TargetSurvey};
use crate::curves::{Curves, Shape};
use crate::frame::Frame;
use crate::missing::axis_effects::{AxisEffect, axis_effects};
use crate::missing::course::Course;
use crate::missing::found::NEAR_MM;
use crate::missing::looked_through::beside;
use crate::missing::orders::Orders;
use crate::missing::stops::Stops;
use crate::recorded::elapsed;
use crate::{AxisModel, TrackerError};

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
    found: Found,
    linear: LinearModel,
    /// By effect and amplitude: three components per reading, mm.
    columns: Vec<Vec<Vec<f64>>>,
    /// Harmonics of the motion errors of a perfect axis in the catalogue.
    orders: Orders,
    /// Uncertainty of the frame that a perfect axis is in.
    frame: Option<Frame>,
    /// What every effect does to a perfect axis; `None` of those that are not on it.
    shapes: Vec<Option<Vec<Shape>>>,
}

/// The solution about which a model is linear.
struct Solved {
    /// Of the declared model.
    calibration: TargetCalibration,
    /// With what the amplitudes of the axis' own effects do as the errors of every angle.
    point: BorderedPoint,
    /// Amplitudes of the axis' own effects; empty where they are zero.
    of_axis: Vec<f64>,
}

/// What a model about one solution leaves to that about another.
struct Choices {
    /// Faults and courses in the catalogue.
    found: Found,
    /// Harmonics of motion errors in it; `None` for the usual ones.
    orders: Option<Orders>,
    /// Readings and components that rows are tied to; `None` leaves it to the geometry.
    tied: Option<HashSet<(usize, usize)>>,
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
        records.check(&survey)?;
        Self::with(survey, records.clone(), hold_out, options, None)
    }

    /// The same of a survey of which only the first `n_measured` readings were taken, and the rest are planned:
    /// how stands move, where another session begins, what slipped and what is far off is looked for in
    /// those alone, and the rest are taken to go on so.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], for the whole and for what was measured.
    pub fn with_planned(
        survey: TargetSurvey,
        records: &TargetRecords,
        hold_out: HoldOut,
        options: &TargetOptions,
        n_measured: usize,
    ) -> Result<Self, TrackerError> {
        records.check(&survey)?;
        let first = survey.first(n_measured);
        let of_first = records.of_first(n_measured, first.mounts.len());
        let measured = Self::with(first, of_first, hold_out, options, None)?;
        let mut found = measured.found;
        found.courses.resize(survey.stations.len(), Course::STEADY);
        Self::with(survey, records.clone(), hold_out, options, Some(found))
    }

    /// With faults and courses that were looked for before, where given.
    fn with(
        survey: TargetSurvey,
        records: TargetRecords,
        hold_out: HoldOut,
        options: &TargetOptions,
        known: Option<Found>,
    ) -> Result<Self, TrackerError> {
        let Placed { options, frame } = Placed::of(&survey, options)?;
        let is_perfect = options.axis != AxisModel::Free;
        let own = || Choices::of_perfect_axis(&survey, &records, hold_out, &options);
        let own = is_perfect.then(own).flatten();
        let choices = match known {
            None => own,
            Some(found) => {
                let orders = own.and_then(|choices| choices.orders);
                Some(Choices { found, orders, tied: None })
            }
        };
        let mut solved = solved(&survey, &options)?;
        if options.axis == AxisModel::Located {
            let added = Added { frame, ..Added::default() };
            solved.calibration = fitted(&survey, &options, &added)?.0;
        }
        let model = Self::about(survey, records, hold_out, options, solved, choices.as_ref())?;
        Ok(Self { frame, ..model })
    }

    /// The model about a point, with the choices of another model, where given.
    fn about(
        survey: TargetSurvey,
        records: TargetRecords,
        hold_out: HoldOut,
        options: TargetOptions,
        solved: Solved,
        choices: Option<&Choices>,
    ) -> Result<Self, TrackerError> {
        let Solved { calibration, point, of_axis } = solved;
        let sigma_mm = calibration.point_mm.unwrap_or(1.0);
        let bundle = Bundle::new(&survey, &options, sigma_mm, Added::default())?;
        let sights: Vec<Sight> =
            (0..survey.targets.len()).map(|n| bundle.sight_at(n, &point)).collect();
        let tied = choices.and_then(|choices| choices.tied.as_ref());
        let rows = Rows::new(&bundle, &sights, hold_out, tied)?;
        let (base, by_base) = base(&bundle, &point, hold_out);
        let jacobian = rows.columns(base.len(), |n, c, p| by_base(&sights[n], n, c, p));
        let angles_rad = bundle.angles_rad();
        let visits: Vec<usize> = bundle.angles.iter().map(|a| a.steps.len()).collect();
        let stops = Stops { axis: &survey.axis, angles_rad: &angles_rad, visits: &visits };
        let orders = choices.and_then(|choices| choices.orders.clone());
        let orders = orders.unwrap_or_else(|| Orders::usual(&stops));
        let axis_effects = axis_effects(options.axis, &stops, &orders);
        let (of_angles, taken_off) = curves_about(&stops, &axis_effects, &of_axis);
        let residual_mm = |n: usize, c: usize| {
            let off = taken_off[bundle.angle_of_step[survey.targets[n].step]];
            sights[n].residual_mm[c] - (sights[n].by_error.row(c) * off)[0]
        };
        let residual = rows.columns(1, |n, c, _| residual_mm(n, c)).column(0).into_owned();
        let layout = layout(&survey, &rows, hold_out, &options, calibration.point_mm.is_none());
        let (basis, left) = beside(rows.sigma_mm.iter().copied(), &jacobian, &residual);
        let time = elapsed(survey.targets.len(), records.time_s.as_deref());
        let find = || {
            found(&Fitted {
                survey: &survey,
                sights: &sights,
                rows: &rows,
                basis: &basis,
                residual: &left,
                hold_out,
                time: &time,
            })
        };
        let found = choices.map_or_else(find, |choices| choices.found.clone());
        let one_body = vec![String::new(); survey.mounts.len()];
        let scene = Scene {
            survey: &survey,
            sights: &sights,
            time: &time,
            timed: records.time_s.is_some(),
            covariates: &records.covariates,
            is_perfect: options.axis != AxisModel::Free,
            bodies: if records.bodies.is_empty() { &one_body } else { &records.bodies },
        };
        let mut entries = catalogue(&scene, &found);
        let mut shapes = vec![None; entries.len()];
        let mut first = 0;
        for AxisEffect { effect, shapes: own } in axis_effects {
            let column = |p: usize| {
                let of = |n: usize| {
                    let k = bundle.angle_of_step[survey.targets[n].step];
                    <[f64; 3]>::from(sights[n].by_error * of_angles[k][first + p])
                };
                (0..survey.targets.len()).flat_map(of).collect()
            };
            entries.push(Entry { effect, columns: (0..own.len()).map(column).collect() });
            first += own.len();
            shapes.push(Some(own));
        }
        let tangents = entries.iter().map(|e| tangent(&rows, &basis, e)).collect();
        drop(by_base);
        let (effects, columns) = entries.into_iter().map(|e| (e.effect, e.columns)).unzip();
        let declared = Declared {
            places: Some(places(&bundle, hold_out)),
            projected: rows.projected(),
            resolution: resolution_of(survey.targets.iter().flat_map(|t| t.at_mm.iter().copied())),
            ..Declared::new(layout, base, effects)
        };
        let extended = Vec::new();
        let linear = LinearModel { declared, residual, base: jacobian, tangents, extended };
        Ok(Self {
            survey,
            records,
            hold_out,
            options,
            calibration,
            point,
            found,
            linear,
            columns,
            orders,
            frame: None,
            shapes,
        })
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
        let (_, mut point) = fitted(&self.survey, &self.options, &self.added(active)).ok()?;
        let amplitudes = self.amplitudes(active, &point);
        point.shared.truncate(self.point.shared.len());
        let sigma_mm = self.calibration.point_mm.unwrap_or(1.0);
        let bundle = Bundle::new(&self.survey, &self.options, sigma_mm, Added::default()).ok()?;
        let of_axis = self.amplitudes_of_axis(active, &amplitudes);
        if self.options.axis != AxisModel::Free {
            let shapes: Vec<Shape> = self.shapes.iter().flatten().flatten().cloned().collect();
            let curves = Curves::new(&self.survey.axis, &bundle.angles_rad(), shapes);
            for (k, block) in point.blocks.chunks_exact_mut(6).enumerate() {
                block.copy_from_slice(curves.error(k, &of_axis).as_slice());
            }
        }
        let away = |n: usize| {
            let [there, here] = [&point, &self.point].map(|at| bundle.sight_at(n, at).predicted_mm);
            (there - here).norm()
        };
        if (0..self.survey.targets.len()).map(away).fold(0.0, f64::max) < NEAR_MM {
            return None;
        }
        let (survey, records) = (self.survey.clone(), self.records.clone());
        let solved = Solved { calibration: self.calibration.clone(), point, of_axis };
        let (hold_out, options) = (self.hold_out, self.options);
        let rows = self.declared().layout.rows.iter();
        let tied = Some(rows.map(|row| (row.observation, row.component)).collect());
        let (found, orders) = (self.found.clone(), Some(self.orders.clone()));
        let choices = Choices { found, orders, tied };
        let about = Self::about(survey, records, hold_out, options, solved, Some(&choices));
        let about = about.ok().filter(|about| about.declared().layout == self.declared().layout)?;
        Some(Self { frame: self.frame, ..about })
    }

    /// What is fitted beside the declared model: effects on the axis first.
    fn added(&self, active: &[(usize, usize)]) -> Added {
        let mut added = Added { frame: self.frame, ..Added::default() };
        for &(effect, p) in active {
            match &self.shapes[effect] {
                Some(shapes) => added.shapes.push(shapes[p].clone()),
                None => added.extras.push(self.columns[effect][p].clone()),
            }
        }
        added
    }

    /// Amplitudes of the active effects at the point of their fit, in their own order.
    fn amplitudes(&self, active: &[(usize, usize)], point: &BorderedPoint) -> Vec<f64> {
        let last = &point.shared[point.shared.len() - active.len()..];
        let is_of_axis = |effect: usize| self.shapes[effect].is_some();
        let n_of_axis = active.iter().filter(|(effect, _)| is_of_axis(*effect)).count();
        let (mut of_axis, mut others) = (last[..n_of_axis].iter(), last[n_of_axis..].iter());
        let amplitude = |&(effect, _): &(usize, usize)| {
            let next = if is_of_axis(effect) { of_axis.next() } else { others.next() };
            next.copied().unwrap_or(0.0)
        };
        active.iter().map(amplitude).collect()
    }

    /// Amplitudes of all effects on the axis, those that are not active being zero.
    fn amplitudes_of_axis(&self, active: &[(usize, usize)], amplitudes: &[f64]) -> Vec<f64> {
        let value = |effect: usize, p: usize| {
            let at = active.iter().position(|a| *a == (effect, p));
            at.map_or(0.0, |i| amplitudes[i])
        };
        let all = self.shapes.iter().enumerate();
        let all = all.filter_map(|(effect, shapes)| Some((effect, shapes.as_ref()?.len())));
        all.flat_map(|(effect, n)| (0..n).map(move |p| (effect, p)))
            .map(|(effect, p)| value(effect, p))
            .collect()
    }

    /// Harmonics of the motion errors that the residual shows.
    fn orders_shown(&self) -> Result<Orders, TrackerError> {
        let bundle = Bundle::new(&self.survey, &self.options, 1.0, Added::default())?;
        let angles_rad = bundle.angles_rad();
        let visits: Vec<usize> = bundle.angles.iter().map(|a| a.steps.len()).collect();
        let stops = Stops { axis: &self.survey.axis, angles_rad: &angles_rad, visits: &visits };
        let sights: Vec<Sight> =
            (0..self.survey.targets.len()).map(|n| bundle.sight_at(n, &self.point)).collect();
        let rows = Rows::new(&bundle, &sights, self.hold_out, None)?;
        let (basis, left) =
            beside(rows.sigma_mm.iter().copied(), &self.linear.base, &self.linear.residual);
        Ok(Orders::shown(&stops, &basis, &left, |shapes| {
            let curves = Curves::new(&self.survey.axis, &angles_rad, shapes.to_vec());
            let zero = vec![0.0; curves.len()];
            let at: Vec<_> = (0..angles_rad.len()).map(|k| curves.at(k, &zero).slopes).collect();
            let mut columns = rows.columns(curves.len(), |n, c, p| {
                let k = bundle.angle_of_step[self.survey.targets[n].step];
                (sights[n].by_error.row(c) * at[k][p])[0]
            });
            for (mut row, sigma) in columns.row_iter_mut().zip(&rows.sigma_mm) {
                row /= *sigma;
            }
            columns
        }))
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
        vec![Covariate::coordinate("angle_deg", Quantity::Angle, values)]
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
        let (calibration, point) = fitted(&self.survey, &self.options, &self.added(active))?;
        let amplitudes = self.amplitudes(active, &point);
        Ok((calibration, amplitudes))
    }
}

impl Choices {
    /// Of a model that takes the axis for perfect: faults and courses as the residual of free errors shows them,
    /// orders as that about the axis' place does. `None` where the readings do not determine these.
    fn of_perfect_axis(
        survey: &TargetSurvey,
        records: &TargetRecords,
        hold_out: HoldOut,
        options: &TargetOptions,
    ) -> Option<Self> {
        let about = |axis: AxisModel| {
            let options = TargetOptions { axis, ..*options };
            let solved = solved(survey, &options).ok()?;
            let records = records.clone();
            TargetModel::about(survey.clone(), records, hold_out, options, solved, None).ok()
        };
        let located = about(AxisModel::Located)?;
        let orders = located.orders_shown().ok()?;
        let TargetModel { found, .. } = about(AxisModel::Free).unwrap_or(located);
        Some(Self { found, orders: Some(orders), tied: None })
    }
}

fn solved(survey: &TargetSurvey, options: &TargetOptions) -> Result<Solved, TrackerError> {
    let (calibration, point) = fitted(survey, options, &Added::default())?;
    Ok(Solved { calibration, point, of_axis: Vec::new() })
}

/// What effects on the axis do about their amplitudes: slopes by angle and amplitude, and the errors
/// of every angle that the amplitudes make as far as rows are linear.
fn curves_about(
    stops: &Stops<'_>,
    effects: &[AxisEffect],
    amplitudes: &[f64],
) -> (Vec<Vec<Vector6<f64>>>, Vec<Vector6<f64>>) {
    let shapes = effects.iter().flat_map(|e| e.shapes.iter().cloned()).collect();
    let curves = Curves::new(stops.axis, stops.angles_rad, shapes);
    let mut amplitudes = amplitudes.to_vec();
    amplitudes.resize(curves.len(), 0.0);
    let at = |k: usize| {
        let slopes = curves.at(k, &amplitudes).slopes;
        let linear: Vector6<f64> =
            slopes.iter().zip(&amplitudes).map(|(slope, a)| slope * *a).sum();
        (slopes, linear)
    };
    (0..stops.angles_rad.len()).map(at).unzip()
}

/// Share of an amplitude's column that must be left beside the model and the units that are held out:
/// errors of a design and what rows leave out by being linear are as large, a mm on a metre.
const NOTHING_LEFT: f64 = 1e-3;
/// The same of an effect that follows a recorded column: only rounding is less.
const NOTHING_LEFT_DRIVEN: f64 = 1e-9;

/// Columns of an effect as reduced rows; zero where nothing is left of them beside the base parameters,
/// whose whitened columns `basis` spans, and what the units that are held out have of their own.
fn tangent(rows: &Rows, basis: &DMatrix<f64>, entry: &Entry) -> DMatrix<f64> {
    let columns = &entry.columns;
    let mut reduced = rows.columns(columns.len(), |n, c, p| columns[p][3 * n + c]);
    let least = if entry.effect.driver.is_some() { NOTHING_LEFT_DRIVEN } else { NOTHING_LEFT };
    for (mut left, whole) in reduced.column_iter_mut().zip(columns) {
        let whitened = DVector::from_fn(left.len(), |i, _| left[i] / rows.sigma_mm[i]);
        let beside = &whitened - basis * basis.tr_mul(&whitened);
        if beside.norm() <= least * rows.whitened_norm(whole) {
            left.fill(0.0);
        }
    }
    reduced
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

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}
