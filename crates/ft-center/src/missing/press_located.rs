//! Presses in the machine frame once effects are part of the model.

use geometry::PlanarMap;
use least_squares::between_variance;
use model_discrepancy::{Closure, Column, State};
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2};

use crate::locate::reach;
use crate::missing::press_design::{PressPoint, Unpacked};
use crate::{Center, CommandedFrame, Handedness, Located, PressModel, PressRole, SensorFrame};

impl PressModel {
    /// Frame and centres of all presses, those to be located too, as the loop leaves them.
    ///
    /// `correction_mm` is what effects of the machine, and empirical corrections, move the head
    /// by; `offset_mm` is what is left beyond them. An empirical correction is known where a press
    /// was observed: to a press that is located it adds nothing.
    #[must_use]
    pub fn located(&self, closure: &Closure) -> Located {
        let at = &closure.state;
        let unpacked = self.design.unpack(at);
        let residuals = DVector::from_column_slice(&closure.residuals_after);
        let seat_mm = self.seat(closure, &residuals).sqrt();
        let frame = self.frame_at(closure, &unpacked, &residuals, seat_mm);
        let centers = (self.presses.iter().zip(&self.all_points))
            .map(|(press, point)| {
                let miss = self.design.residual(point, &unpacked, at);
                let offset_mm = point
                    .observation
                    .map_or(miss, |o| residuals.fixed_rows::<2>(2 * o).into_owned());
                let of_machine = self.design.moved_by_machine(point, &unpacked, at);
                let of_model = self.offset_covariance(point, &unpacked, closure);
                let of_press = self.press_covariance(point, &unpacked, seat_mm);
                let of_press = of_press * frame.variance_factor;
                let covariance_mm2 = match press.role {
                    PressRole::Frame => of_press - of_model,
                    PressRole::Check | PressRole::Locate => of_press + of_model,
                };
                Center {
                    press: press.name.clone(),
                    role: press.role,
                    sensor_mm: Point2::from(self.design.corrected(point, &unpacked).center_mm),
                    machine_mm: press.machine_mm + of_machine + miss,
                    correction_mm: of_machine + miss - offset_mm,
                    offset_mm,
                    covariance_mm2,
                }
            })
            .collect();
        let degrees_of_freedom = crate::count(frame.degrees_of_freedom);
        let (scale, datum_mm) = (unpacked.machine().scale, unpacked.machine().datum_mm);
        let effects = &self.design.catalogue.effects;
        Located {
            commanded: CommandedFrame::of(&frame, closure, effects, scale, datum_mm),
            conditions: self.conditions(at),
            frame,
            centers,
            degrees_of_freedom,
            seat_mm,
            reach_mm: reach(
                self.presses.iter().filter(|p| p.role == PressRole::Frame).map(|p| p.machine_mm),
                &self.frame,
            ),
        }
    }

    fn conditions(&self, at: &State) -> Vec<String> {
        let all = self.design.catalogue.effects.iter().zip(&self.declared.effects);
        all.zip(&at.amplitudes)
            .filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0))
            .filter_map(|((effect, described), _)| effect.condition(described))
            .collect()
    }

    /// Variance of the seat along each axis, mm², as the loop estimates it.
    fn seat(&self, closure: &Closure, residuals: &DVector<f64>) -> f64 {
        let fitted: Vec<usize> = (self.observed().iter().enumerate())
            .filter(|(_, press)| self.presses[**press].role == PressRole::Frame)
            .flat_map(|(i, _)| [2 * i, 2 * i + 1])
            .collect();
        let rows = &self.declared.layout.rows;
        let sigma: Vec<f64> = fitted.iter().map(|&row| rows[row].sigma).collect();
        let unpacked = self.design.unpack(&closure.state);
        let mut jacobian = DMatrix::zeros(residuals.len(), closure.columns.len());
        for (observation, point) in self.points.iter().enumerate() {
            let block = self.offset_jacobian(point, Some(observation), &unpacked, closure);
            jacobian.rows_mut(2 * observation, 2).copy_from(&block);
        }
        let (residual, jacobian) = (residuals.select_rows(&fitted), jacobian.select_rows(&fitted));
        between_variance(&sigma, |kept| rows[fitted[kept]].reported, &residual, &jacobian)
    }

    fn frame_at(
        &self,
        closure: &Closure,
        unpacked: &Unpacked,
        residuals: &DVector<f64>,
        seat_mm: f64,
    ) -> SensorFrame {
        let at: &State = &closure.state;
        let reflected = self.design.handedness == Handedness::Opposed;
        let turned = PlanarMap::rigid(at.base[0], reflected, Vector2::zeros()).linear;
        let (mut residuals_mm, mut chi2) = (Vec::new(), 0.0);
        for (i, &press) in self.observed().iter().enumerate() {
            if self.presses[press].role == PressRole::Frame {
                let miss: Vector2<f64> = residuals.fixed_rows::<2>(2 * i).into_owned();
                let sigma = |k: usize| self.declared.layout.rows[2 * i + k].sigma.hypot(seat_mm);
                chi2 += (miss.x / sigma(0)).powi(2) + (miss.y / sigma(1)).powi(2);
                residuals_mm.push(turned * miss);
            }
        }
        let degrees_of_freedom = (2 * residuals_mm.len()).saturating_sub(closure.columns.len());
        SensorFrame {
            angle_rad: at.base[0],
            translation_mm: unpacked.center_mm() - turned * self.frame.pivot_mm.coords,
            covariance: closure.covariance.fixed_view::<3, 3>(0, 0).into_owned(),
            variance_factor: if degrees_of_freedom > 0 {
                chi2 / crate::count(degrees_of_freedom)
            } else {
                1.0
            },
            degrees_of_freedom,
            residuals_mm,
            ..self.frame.clone()
        }
    }

    /// Covariance of a centre by its record and its seat, machine frame.
    fn press_covariance(&self, point: &PressPoint, at: &Unpacked, seat_mm: f64) -> Matrix2<f64> {
        let seated = point.covariance_mm2 + Matrix2::identity() * seat_mm.powi(2);
        self.design.linear(at) * seated * self.design.linear(at).transpose()
    }

    /// Covariance of the residual of a press due to all that was estimated.
    fn offset_covariance(
        &self,
        point: &PressPoint,
        at: &Unpacked,
        closure: &Closure,
    ) -> Matrix2<f64> {
        let jacobian = self.offset_jacobian(point, point.observation, at, closure);
        let product = &jacobian * &closure.covariance * jacobian.transpose();
        product.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// Derivative of the residual of a press by what the columns of the covariance are about.
    fn offset_jacobian(
        &self,
        point: &PressPoint,
        observation: Option<usize>,
        at: &Unpacked,
        closure: &Closure,
    ) -> DMatrix<f64> {
        let base = self.design.base_jacobian(point, at);
        let mut jacobian = DMatrix::zeros(2, closure.columns.len());
        for (k, column) in closure.columns.iter().enumerate() {
            match *column {
                Column::Base(parameter) => jacobian.set_column(k, &base.column(parameter)),
                Column::Amplitude { effect, parameter } => {
                    let tangent = self.design.tangent(point, at, effect);
                    jacobian.set_column(k, &tangent.column(parameter));
                }
                Column::Empirical { correction, coefficient } => {
                    let added = closure.empirical[correction].columns.column(coefficient);
                    if let Some(o) = observation {
                        jacobian.set_column(k, &added.rows(2 * o, 2));
                    }
                }
                Column::Place { .. } => {}
            }
        }
        jacobian
    }
}
