//! Presses in the machine frame once effects are part of the model.

use geometry::PlanarMap;
use model_discrepancy::{Model, Row, State, common_variance};
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2};

use crate::press_design::{PressPoint, Unpacked};
use crate::{Center, Handedness, Located, PressModel, PressRole, SensorFrame, SolvedPress};

impl PressModel {
    /// Frame and centres of all presses, those to be located too, with the effects in `at`.
    ///
    /// `covariance` is that of `[base, active amplitudes in catalogue order]`, as
    /// [`Closure::covariance`](model_discrepancy::Closure::covariance); amplitudes that are not
    /// zero count as active. A matrix of another shape counts as zero. `offset_mm` is what is left beyond frame and effects.
    #[must_use]
    pub fn located(&self, at: &State, covariance: &DMatrix<f64>) -> Located {
        let unpacked = self.design.unpack(at);
        let unknown = DMatrix::zeros(self.base.len(), self.base.len());
        let square = covariance.is_square() && covariance.ncols() >= self.base.len();
        let covariance = if square { covariance } else { &unknown };
        let active = self.active(at, covariance);
        let residuals = self.residuals(at);
        let seat_mm = self.seat(at, &residuals, &active).sqrt();
        let frame = self.frame_at(at, &unpacked, covariance, &residuals, seat_mm, active.len());
        let centers = (self.presses.iter().zip(&self.all_points))
            .map(|(press, point)| {
                let miss = self.design.residual(point, &unpacked, at);
                let of_model = self.offset_covariance(point, &unpacked, covariance, &active);
                let of_press = self.press_covariance(point, &unpacked, seat_mm);
                let of_press = of_press * frame.variance_factor;
                let covariance_mm2 = match press.role {
                    PressRole::Frame => of_press - of_model,
                    PressRole::Check | PressRole::Locate => of_press + of_model,
                };
                self.center(press, point, &unpacked, miss, covariance_mm2)
            })
            .collect();
        let degrees_of_freedom = crate::count(frame.degrees_of_freedom);
        Located { frame, centers, degrees_of_freedom, seat_mm }
    }

    /// Effect and parameter behind each column of `covariance` after the base; none where the
    /// columns do not match the amplitudes.
    fn active(&self, at: &State, covariance: &DMatrix<f64>) -> Vec<(usize, usize)> {
        let all = at.amplitudes.iter().enumerate();
        let active: Vec<_> = all
            .flat_map(|(e, a)| (0..a.len()).map(move |p| (e, p, a[p])))
            .filter(|(_, _, amplitude)| *amplitude != 0.0)
            .map(|(e, p, _)| (e, p))
            .collect();
        if covariance.ncols() == self.base.len() + active.len() { active } else { Vec::new() }
    }

    /// Variance of the seat along each axis, mm², as the loop estimates it.
    fn seat(&self, at: &State, residuals: &DVector<f64>, active: &[(usize, usize)]) -> f64 {
        let fitted: Vec<usize> = (self.observed().iter().enumerate())
            .filter(|(_, press)| self.presses[**press].role == PressRole::Frame)
            .flat_map(|(i, _)| [2 * i, 2 * i + 1])
            .collect();
        let rows: Vec<Row> = fitted.iter().map(|&row| self.layout.rows[row]).collect();
        let mut jacobian = self.base_jacobian(at);
        for &(effect, parameter) in active {
            let column = jacobian.ncols();
            jacobian = jacobian.insert_column(column, 0.0);
            jacobian.set_column(column, &self.tangent(at, effect).column(parameter));
        }
        common_variance(&rows, &residuals.select_rows(&fitted), &jacobian.select_rows(&fitted))
    }

    fn frame_at(
        &self,
        at: &State,
        unpacked: &Unpacked,
        covariance: &DMatrix<f64>,
        residuals: &DVector<f64>,
        seat_mm: f64,
        active: usize,
    ) -> SensorFrame {
        let reflected = self.design.handedness == Handedness::Opposed;
        let turned = PlanarMap::rigid(at.base[0], reflected, Vector2::zeros()).linear;
        let (mut residuals_mm, mut chi2) = (Vec::new(), 0.0);
        for (i, &press) in self.observed().iter().enumerate() {
            if self.presses[press].role == PressRole::Frame {
                let miss: Vector2<f64> = residuals.fixed_rows::<2>(2 * i).into_owned();
                let sigma = |k: usize| self.layout.rows[2 * i + k].sigma.hypot(seat_mm);
                chi2 += (miss.x / sigma(0)).powi(2) + (miss.y / sigma(1)).powi(2);
                residuals_mm.push(turned * miss);
            }
        }
        let degrees_of_freedom = (2 * residuals_mm.len()).saturating_sub(3 + active);
        SensorFrame {
            angle_rad: at.base[0],
            translation_mm: unpacked.center_mm() - turned * self.frame.pivot_mm.coords,
            covariance: covariance.fixed_view::<3, 3>(0, 0).into_owned(),
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

    fn center(
        &self,
        press: &SolvedPress,
        point: &PressPoint,
        at: &Unpacked,
        offset_mm: Vector2<f64>,
        covariance_mm2: Matrix2<f64>,
    ) -> Center {
        Center {
            press: press.name.clone(),
            role: press.role,
            sensor_mm: Point2::from(self.design.corrected(point, at).center_mm),
            machine_mm: press.machine_mm + offset_mm,
            offset_mm,
            covariance_mm2,
        }
    }

    /// Covariance of a centre by its record and its seat, machine frame.
    fn press_covariance(&self, point: &PressPoint, at: &Unpacked, seat_mm: f64) -> Matrix2<f64> {
        let seated = point.covariance_mm2 + Matrix2::identity() * seat_mm.powi(2);
        self.design.linear(at) * seated * self.design.linear(at).transpose()
    }

    /// Covariance of the residual of a press due to base and effects.
    fn offset_covariance(
        &self,
        point: &PressPoint,
        at: &Unpacked,
        covariance: &DMatrix<f64>,
        active: &[(usize, usize)],
    ) -> Matrix2<f64> {
        let base = self.design.base_jacobian(point, at);
        let mut jacobian = DMatrix::zeros(2, 3 + active.len());
        jacobian.columns_mut(0, 3).copy_from(&base);
        for (k, &(effect, parameter)) in active.iter().enumerate() {
            let tangent = self.design.tangent(point, at, effect);
            jacobian.set_column(3 + k, &tangent.column(parameter));
        }
        let used = covariance.view((0, 0), (jacobian.ncols(), jacobian.ncols()));
        let product = &jacobian * used * jacobian.transpose();
        product.fixed_view::<2, 2>(0, 0).into_owned()
    }
}
