//! The calibration with accepted effects in the model.

use least_squares::BorderedProblem;
use model_discrepancy::{Closure, Solution, std_over_names};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SMatrix, Vector6};

use crate::axes::{LocationSums, location, relation, summed};
use crate::curves::Curves;
use crate::error_order::in_order;
use crate::gauge::StationChart;
use crate::joint::Joint;
use crate::location::AngleFit;
use crate::missing::reduction::answer;
use crate::network::Network;
use crate::perfect::{PerfectAxis, selected};
use crate::spread::dense_block;
use crate::{
    AxesRelation, AxisError, AxisLocation, AxisModel, Calibration, SecondCalibration, TrackerModel,
};

impl TrackerModel {
    /// The calibration with what the loop accepted in the model.
    ///
    /// Corrections along a covariate without a known cause are in the uncertainty of what the ranges
    /// share, and nowhere else. Returns `None` where the closure is not one of this model.
    ///
    /// Where a step has other names that explain the ranges as well, uncertainties reach to what
    /// these give.
    #[must_use]
    pub fn calibration_with(&self, closure: &Closure) -> Option<Calibration> {
        let Closure { covariance, variance_factor, .. } = closure;
        let found = self.calibration_by(&closure.solution(), covariance, *variance_factor)?;
        let named = closure.alternatives.iter().filter_map(|other| {
            let p = other.columns.len();
            self.calibration_by(other, &DMatrix::zeros(p, p), closure.variance_factor)
        });
        Some(widened(found, &named.collect::<Vec<_>>()))
    }

    fn calibration_by(
        &self,
        solution: &Solution,
        covariance: &DMatrix<f64>,
        variance_factor: f64,
    ) -> Option<Calibration> {
        let network = Network::new(&self.survey, &self.options).ok()?;
        let nominal: Vec<_> = self.survey.stations.iter().map(|s| s.nominal_mm).collect();
        let chart = StationChart::new(&nominal, &self.options).ok()?;
        let (moved, angles) = self.follow(&network, &chart, solution, variance_factor)?;
        let m = moved.len();
        if covariance.nrows() < m {
            return None;
        }
        let covariance = covariance.view((0, 0), (m, m)).into_owned();
        let mut found = self.put_together(&network, &chart, &angles, &moved, &covariance);
        if network.axis_model != AxisModel::Free {
            let joint = Joint::new(&network, &chart, 1.0);
            self.with_perfect_axis(&mut found, &joint, solution, &covariance);
        }
        Some(found)
    }

    /// `[shared, amplitudes]` as far as a solution moves them, and what every angle makes of it.
    pub(crate) fn follow(
        &self,
        network: &Network<'_>,
        chart: &StationChart,
        solution: &Solution,
        variance_factor: f64,
    ) -> Option<(DVector<f64>, Vec<AngleChange>)> {
        let (state, active) = (&solution.state, solution.amplitudes());
        let joint = Joint::new(network, chart, 1.0).shifted(self.solved.shifts.clone());
        let n = state.base.len();
        if state.amplitudes.len() != self.columns.len() || n != joint.shared_dim() {
            return None;
        }
        let mut moved = DVector::zeros(n + active.len());
        moved.rows_mut(0, n).copy_from(&state.base);
        for (i, &(effect, amplitude)) in active.iter().enumerate() {
            moved[n + i] = state.amplitudes[effect][amplitude];
        }
        let amplitudes = self.all_amplitudes(&joint, solution);
        let angles = (0..network.angles.len())
            .map(|k| {
                let mut angle = self.angle(&joint, k, &active, &moved, variance_factor)?;
                if network.axis_model != AxisModel::Free {
                    let motion: Vec<f64> = (amplitudes.iter().enumerate())
                        .map(|(i, a)| if i < joint.curves.len() { 0.0 } else { *a })
                        .collect();
                    angle.own_error = self.curves.error(k, &motion);
                }
                Some(angle)
            })
            .collect::<Option<Vec<_>>>()?;
        Some((moved, angles))
    }

    /// Amplitudes of all effects on the axis as a solution has them.
    pub(crate) fn amplitudes_of_axis(&self, solution: &Solution) -> Vec<f64> {
        let all = self.curve_of.iter().zip(&solution.state.amplitudes);
        all.filter(|(curve, _)| curve.is_some()).flat_map(|(_, a)| a.iter().copied()).collect()
    }

    /// Amplitudes of all curves as a solution has them: first what the declared model fits.
    fn all_amplitudes(&self, joint: &Joint<'_>, solution: &Solution) -> Vec<f64> {
        let fitted = joint.curve_start()..joint.shared_dim();
        let fitted = fitted.map(|i| self.solved.point.shared[i] + solution.state.base[i]);
        fitted.chain(self.amplitudes_of_axis(solution)).collect()
    }

    /// How the errors and residuals of an angle follow `[shared, amplitudes]`.
    fn angle(
        &self,
        joint: &Joint<'_>,
        k: usize,
        active: &[(usize, usize)],
        moved: &DVector<f64>,
        variance_factor: f64,
    ) -> Option<AngleChange> {
        let ranges: Vec<usize> = joint.ranges_of.at(k).iter().map(|&r| r as usize).collect();
        let shared = dense_block(joint, &self.solved.point, k).by_shared;
        let n = shared.ncols();
        let mut by_all = DMatrix::zeros(ranges.len(), moved.len());
        by_all.columns_mut(0, n).copy_from(&shared);
        for (i, &(effect, amplitude)) in active.iter().enumerate() {
            for (row, &range) in ranges.iter().enumerate() {
                by_all[(row, n + i)] = self.columns[effect][(range, amplitude)];
            }
        }
        let before = Vector6::from_column_slice(&self.solved.point.blocks[6 * k..6 * k + 6]);
        let mut residuals_mm = &by_all * moved;
        for (row, &range) in ranges.iter().enumerate() {
            residuals_mm[row] += self.residuals_mm[range];
        }
        if k == 0 || joint.network.axis_model != AxisModel::Free {
            let follows = DMatrix::zeros(6, moved.len());
            return Some(AngleChange {
                own_error: before,
                follows,
                own: DMatrix::zeros(6, 6),
                residuals_mm,
            });
        }
        let by_error: Vec<Vector6<f64>> = ranges.iter().map(|&r| self.sights[r].by_error).collect();
        let answer = answer(&by_error)?;
        let step = &answer * &residuals_mm;
        for (row, by_error) in by_error.iter().enumerate() {
            residuals_mm[row] += (by_error.transpose() * &step)[0];
        }
        let error = before + Vector6::from_iterator(step.iter().copied());
        let sigma2 = variance_factor * self.solved.calibration.displacement_mm.powi(2);
        let own = &answer * answer.transpose() * sigma2;
        Some(AngleChange { own_error: error, follows: answer * by_all, own, residuals_mm })
    }

    /// Replaces what a calibration says of the axis and what is on it by what a perfect axis with the
    /// amplitudes of a closure makes of it.
    fn with_perfect_axis(
        &self,
        found: &mut Calibration,
        joint: &Joint<'_>,
        solution: &Solution,
        covariance: &DMatrix<f64>,
    ) {
        let amplitudes = self.all_amplitudes(joint, solution);
        let n = joint.shared_dim();
        // Where each curve stands among the parameters of the closure, if it does.
        let mut parameter_of: Vec<Option<usize>> = vec![None; amplitudes.len()];
        for (i, at) in (joint.curve_start()..n).enumerate() {
            parameter_of[i] = Some(at);
        }
        for (i, (effect, parameter)) in solution.amplitudes().into_iter().enumerate() {
            if let Some(first) = self.curve_of[effect] {
                parameter_of[first + parameter] = Some(n + i);
            }
        }
        let known: Vec<usize> =
            (0..amplitudes.len()).filter(|&i| parameter_of[i].is_some()).collect();
        let parameters: Vec<usize> = known.iter().filter_map(|&i| parameter_of[i]).collect();
        let shapes = known.iter().map(|&i| self.curves.shapes[i].clone()).collect();
        let angles_rad = joint.network.angles_rad();
        let axis = &self.survey.axis;
        let perfect = PerfectAxis {
            axis,
            angles_rad: &angles_rad,
            curves: &Curves::new(axis, &angles_rad, shapes),
            amplitudes: &known.iter().map(|&i| amplitudes[i]).collect::<Vec<_>>(),
            covariance: selected(covariance, &parameters),
        };
        let perfect = match &self.frame {
            Some(frame) => perfect.in_frame(frame),
            None => perfect,
        };
        found.axis_errors = perfect.errors(self.options.order);
        found.motion = Some(perfect.motion(self.options.order));
        found.location = perfect.location();
        for (j, mount) in found.mounts.iter_mut().enumerate() {
            let at = joint.mount_start() + 3 * j;
            let with: Vec<usize> = (at..at + 3).chain(parameters.iter().copied()).collect();
            *mount = perfect.mount(&mount.position_mm.coords, &selected(covariance, &with));
        }
        let Some(frame) = &self.frame else { return };
        for mount in &mut found.mounts {
            mount.covariance_mm2 += frame.of_mount(axis, angles_rad[0], &mount.position_mm.coords);
        }
        for station in &mut found.stations {
            station.covariance_mm2 += frame.of_place(&(station.position_mm - axis.origin_mm));
        }
    }

    fn put_together(
        &self,
        network: &Network<'_>,
        chart: &StationChart,
        angles: &[AngleChange],
        moved: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> Calibration {
        let mut found = self.solved.calibration.clone();
        let shared: Vec<f64> =
            self.solved.point.shared.iter().zip(moved.iter()).map(|(at, step)| at + step).collect();
        let n = chart.dim();
        let of_stations =
            chart.basis() * covariance.view((0, 0), (n, n)) * chart.basis().transpose();
        for (i, station) in found.stations.iter_mut().enumerate() {
            station.position_mm = chart.position_mm(i, &shared).into();
            station.covariance_mm2 = of_stations.fixed_view::<3, 3>(3 * i, 3 * i).into_owned();
        }
        for (p, path) in found.dead_paths.iter_mut().enumerate() {
            path.length_mm = shared[n + p];
            path.sigma_mm = covariance[(n + p, n + p)].max(0.0).sqrt();
        }
        let mounts = n + found.dead_paths.len();
        for (j, mount) in found.mounts.iter_mut().enumerate() {
            let at = mounts + 3 * j;
            mount.position_mm = nalgebra::Point3::new(shared[at], shared[at + 1], shared[at + 2]);
            let own: Matrix3<f64> = covariance.fixed_view::<3, 3>(at, at).into_owned();
            mount.covariance_mm2 = own;
        }
        let errors_of = |axis: usize| -> Vec<AxisError> {
            let of = |(k, angle_rad): (usize, f64)| {
                let angle = &angles[k];
                let spread = &angle.follows * covariance * angle.follows.transpose() + &angle.own;
                let covariance = Matrix6::from_iterator(spread.iter().copied());
                let fixed = AxisError { angle_rad, error: angle.own_error, covariance };
                in_order(network.axis(axis), self.options.order, fixed)
            };
            network.angles_of(axis).map(of).collect()
        };
        found.axis_errors = errors_of(0);
        for (k, angle) in angles.iter().enumerate() {
            let steps = network.angles[k].steps.iter();
            let ranges = steps.flat_map(|&step| network.ranges_of_step.at(step));
            for (&range, residual) in ranges.zip(angle.residuals_mm.iter()) {
                found.residuals_mm[range as usize] = *residual;
            }
        }
        let sums = LocationSums::new(network);
        let summed = |fit: &AngleFit| {
            let angles = angles.iter().map(|a| (&a.own_error, &a.own, &a.follows));
            summed(fit, angles, covariance)
        };
        let of_axis = |axis: usize| {
            let fit = sums.of_axis[axis].as_ref()?;
            Some(location(network, axis, summed(fit)))
        };
        found.location = of_axis(0);
        found.second = (network.axis_count() > 1).then(|| SecondCalibration {
            axis_errors: errors_of(1),
            location: of_axis(1),
            relation: (sums.relation.as_ref()).and_then(|fit| relation(network, summed(fit))),
        });
        found
    }
}

/// The calibration with uncertainties that reach to those by other names.
fn widened(mut found: Calibration, others: &[Calibration]) -> Calibration {
    if others.is_empty() {
        return found;
    }
    let away = |of: &dyn Fn(&Calibration) -> f64, own: f64| -> Vec<f64> {
        others.iter().map(|other| of(other) - own).collect()
    };
    let stretch_errors = |errors: &mut [AxisError], of: &dyn Fn(&Calibration) -> &[AxisError]| {
        for (k, error) in errors.iter_mut().enumerate() {
            let at = error.error;
            stretch(&mut error.covariance, |i| away(&|o| of(o)[k].error[i], at[i]));
        }
    };
    stretch_errors(&mut found.axis_errors, &|o| &o.axis_errors);
    for (k, error) in found.motion.iter_mut().flatten().enumerate() {
        let at = error.error;
        stretch(&mut error.covariance, |i| {
            away(&|o| o.motion.as_ref().map_or(at[i], |m| m[k].error[i]), at[i])
        });
    }
    for (k, station) in found.stations.iter_mut().enumerate() {
        let at = station.position_mm;
        stretch(&mut station.covariance_mm2, |i| away(&|o| o.stations[k].position_mm[i], at[i]));
    }
    for (k, mount) in found.mounts.iter_mut().enumerate() {
        let at = mount.position_mm;
        stretch(&mut mount.covariance_mm2, |i| away(&|o| o.mounts[k].position_mm[i], at[i]));
    }
    let stretch_location =
        |location: &mut AxisLocation, of: &dyn Fn(&Calibration) -> Option<&AxisLocation>| {
            let at = location.errors;
            stretch(&mut location.covariance, |i| {
                away(&|o| of(o).map_or(at[i], |l| l.errors[i]), at[i])
            });
        };
    if let Some(location) = &mut found.location {
        stretch_location(location, &|o| o.location.as_ref());
    }
    if let Some(second) = &mut found.second {
        fn of(other: &Calibration) -> Option<&SecondCalibration> {
            other.second.as_ref()
        }
        stretch_errors(&mut second.axis_errors, &|o| of(o).map_or(&[], |s| &s.axis_errors));
        if let Some(location) = &mut second.location {
            stretch_location(location, &|o| of(o).and_then(|s| s.location.as_ref()));
        }
        if let Some(relation) = &mut second.relation {
            let both = |r: &AxesRelation| [r.offset_error_mm, r.rotation_error_rad];
            let at = both(relation);
            let errors = |o: &Calibration| Some(both(of(o)?.relation.as_ref()?));
            stretch(&mut relation.covariance, |i| {
                away(&|o| errors(o).map_or(at[i], |e| e[i]), at[i])
            });
        }
    }
    found
}

/// Scales rows and columns so that every standard uncertainty reaches what is `away`.
fn stretch<const N: usize>(covariance: &mut SMatrix<f64, N, N>, away: impl Fn(usize) -> Vec<f64>) {
    for i in 0..N {
        let std = covariance[(i, i)].max(0.0).sqrt();
        let wide = std_over_names(std, away(i).into_iter());
        if std > 0.0 && wide > std {
            covariance.row_mut(i).scale_mut(wide / std);
            covariance.column_mut(i).scale_mut(wide / std);
        }
    }
}

/// One angle with the effects in the model.
pub(crate) struct AngleChange {
    /// Errors of its own, fixed frame.
    pub(crate) own_error: Vector6<f64>,
    /// `∂ error / ∂ [shared, amplitudes]`.
    follows: DMatrix<f64>,
    /// Covariance with these fixed.
    own: DMatrix<f64>,
    residuals_mm: DVector<f64>,
}
