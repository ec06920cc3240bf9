//! Static poses as a model for the loop.

use geometry::Wrench;
use model_discrepancy::{
    Course, Covariate, Declared, Effect, Group, Inside, Interruption, Layout, Model, Parameter,
    Proposal, Quantity, Role, Row, State, clearest_courses, clearest_interruption, resolution_of,
};
use nalgebra::{DMatrix, DVector, Point3, SMatrix, Unit, Vector3, Vector6};

use crate::gravity::line_miss;
use crate::missing::gravity_effects::{
    Channels, Down, ELAPSED, GRAVITY_EFFECTS, GravityEffect, GravityErrors, Predicted,
};
use crate::missing::parameter::parameter;
use crate::missing::press_design::REFERENCE_C;
use crate::{FtCenterError, GravityCalibration, GravityOptions, StaticPose, calibrate_gravity};

/// Noise under which no reading is believed, so that readings without any still have weights.
const FLOOR: f64 = 1e-9;

/// Static poses, their calibration, and what it leaves out.
///
/// Six rows per pose: reading − prediction. The three of the force are reported, in N; the three
/// of the moment take part in the fit and are not reported. Where noise is not declared, forces
/// and moments are weighed by what the declared model leaves of each.
#[derive(Clone, Debug)]
pub struct GravityModel {
    declared: Declared,
    effects: Vec<GravityEffect>,
    poses: Vec<StaticPose>,
    gravity: Unit<Vector3<f64>>,
    calibrated: GravityCalibration,
    /// What the zero follows: one per pose, the time elapsed and the temperatures from 20 °C first.
    drivers: Vec<Vec<f64>>,
}

impl GravityModel {
    /// Builds the model of a case of static poses, in the order measured.
    ///
    /// `covariates` have one value per pose; a column whose name ends in `_c` becomes a
    /// `temperature` effect.
    ///
    /// # Errors
    ///
    /// As [`calibrate_gravity`](crate::calibrate_gravity), and
    /// [`FtCenterError::CovariateLength`].
    pub fn new(
        poses: &[StaticPose],
        options: &GravityOptions,
        covariates: &[Covariate],
    ) -> Result<Self, FtCenterError> {
        let calibrated = calibrate_gravity(poses, options)?;
        if let Some(wrong) = covariates.iter().find(|c| c.values.len() != poses.len()) {
            let (got, needed) = (wrong.values.len(), poses.len());
            return Err(FtCenterError::CovariateLength { name: wrong.name.clone(), got, needed });
        }
        let warm: Vec<_> =
            covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
        let mut effects = GRAVITY_EFFECTS.to_vec();
        let mut described: Vec<_> = effects.iter().map(|e| e.described()).collect();
        for (column, covariate) in warm.iter().enumerate() {
            let of_column = ELAPSED + 1 + column;
            let effect = GravityEffect::Zero { of: Channels::All, first: of_column, drivers: 1 };
            let subject = (warm.len() > 1).then(|| covariate.name.clone());
            let driver = Some(covariate.name.clone());
            effects.push(effect);
            described.push(Effect { subject, driver, ..effect.described() });
        }
        let last = crate::count(poses.len().saturating_sub(1).max(1));
        let of_pose = |i: usize| {
            let warmth_k = warm.iter().map(|c| c.values[i] - REFERENCE_C);
            std::iter::once(crate::count(i) / last).chain(warmth_k).collect()
        };
        let model = Self {
            declared: Declared {
                start: start(&calibrated),
                resolution: resolution_of(
                    poses.iter().flat_map(|p| p.wrench.force_n.iter().copied()),
                ),
                ..Declared::new(layout(poses, options, &calibrated), base(), described)
            },
            effects,
            drivers: (0..poses.len()).map(of_pose).collect(),
            poses: poses.to_vec(),
            gravity: options.gravity,
            calibrated,
        };
        Ok(model.with_courses())
    }

    /// With the other courses of the drifts that the residual shows.
    fn with_courses(self) -> Self {
        let (elapsed, at) = (self.elapsed(), State::start(&self));
        self.drifts().into_iter().fold(self, |model, (of, drift)| {
            let courses = clearest_courses(&model, &at, drift, &elapsed, &model.down());
            let interruption = clearest_interruption(&model, &at, drift, &elapsed);
            let model = courses.iter().fold(model, |m, course| m.with_course(of, drift, course));
            interruption.iter().fold(model, |m, broken| m.with_interruption(of, drift, broken))
        })
    }

    fn with_course(self, of: Channels, drift: usize, course: &Course) -> Self {
        let elapsed = self.elapsed();
        let even = &self.declared.effects[drift].parameters[0];
        let reported = (even.unit.as_str(), even.report_factor);
        let effect = course.effect(&self, drift, &elapsed, "of the series", reported);
        self.with_zero(of, effect, &[course.come(&elapsed)])
    }

    fn with_interruption(self, of: Channels, drift: usize, interruption: &Interruption) -> Self {
        let elapsed = self.elapsed();
        let name = |i: usize| self.poses[i].name.as_str();
        let between = interruption.between(&elapsed);
        let place = between.map_or_else(String::new, |(last, next)| {
            format!("between poses {} and {}", name(last), name(next))
        });
        let effect = interruption.effect(&self.declared.effects[drift], &place);
        let courses = interruption.courses(&elapsed);
        self.with_zero(of, effect, &courses)
    }

    /// With an effect whose amplitudes, channel by channel, multiply each of some courses.
    fn with_zero(mut self, of: Channels, effect: Effect, courses: &[Vec<f64>]) -> Self {
        let first = self.drivers.first().map_or(0, Vec::len);
        self.effects.push(GravityEffect::Zero { of, first, drivers: courses.len() });
        self.declared.effects.push(effect);
        for (i, drivers) in self.drivers.iter_mut().enumerate() {
            drivers.extend(courses.iter().map(|course| course[i]));
        }
        self
    }

    /// The effects of a zero that goes on evenly.
    fn drifts(&self) -> Vec<(Channels, usize)> {
        let even = |(i, effect): (usize, &GravityEffect)| match effect {
            GravityEffect::Zero { of, first: ELAPSED, .. } => Some((*of, i)),
            _ => None,
        };
        self.effects.iter().enumerate().filter_map(even).collect()
    }

    /// Of each pose, from 0 at the first to 1 at the last.
    fn elapsed(&self) -> Vec<f64> {
        self.drivers.iter().map(|drivers| drivers[ELAPSED]).collect()
    }

    /// Direction of gravity in sensor axes, which is all the place that a pose has.
    fn down(&self) -> Vec<Option<Point3<f64>>> {
        let down = |p: &StaticPose| p.base_from_sensor.inverse() * self.gravity.into_inner();
        self.poses.iter().map(|p| Some(Point3::from(down(p)))).collect()
    }

    /// Direction of gravity in sensor axes, as covariates for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        let down = self.down();
        let column = |name: &str, axis: usize| {
            let along = down.iter().flatten().map(|d| d[axis]).collect();
            Covariate::coordinate(name, Quantity::Other, along)
        };
        vec![column("gravity_x", 0), column("gravity_y", 1), column("gravity_z", 2)]
    }

    /// Calibration with the effects in `at`.
    ///
    /// `covariance` is that of `[base, active amplitudes in catalogue order]`, as
    /// [`Closure::covariance`](model_discrepancy::Closure::covariance); a smaller matrix counts
    /// as zero. Lines of action are those of the readings with zero and effects taken off.
    #[must_use]
    pub fn calibration(&self, at: &State, covariance: &DMatrix<f64>) -> GravityCalibration {
        let arm: Vector3<f64> = at.base.fixed_rows::<3>(7).into_owned();
        let errors = self.errors(at);
        let rows = self.residuals(at);
        let residuals: Vec<_> = (0..self.poses.len())
            .map(|i| Wrench::from_vector(&rows.fixed_rows::<6>(6 * i).into_owned()))
            .collect();
        // What an ideal sensor would have read: the weight, and what nothing explains.
        let ideal = residuals.iter().enumerate().map(|(i, residual)| {
            let load = self.predicted(i, at, &errors).down.direction * at.base[6];
            *residual + Wrench::of_force(load, &Point3::from(arm))
        });
        let mut block = SMatrix::<f64, 10, 10>::zeros();
        if covariance.nrows() >= 10 && covariance.ncols() >= 10 {
            block.copy_from(&covariance.view((0, 0), (10, 10)));
        }
        let active = at.amplitudes.iter().flat_map(|a| a.iter()).filter(|a| **a != 0.0).count();
        GravityCalibration {
            bias: Wrench::from_vector(&at.base.fixed_rows::<6>(0).into_owned()),
            weight_n: at.base[6],
            center_of_gravity_mm: Point3::from(arm),
            covariance: block,
            line_miss_mm: ideal.map(|w| line_miss(w, &arm)).collect(),
            residuals,
            noise: self.calibrated.noise,
            degrees_of_freedom: (6 * self.poses.len()).saturating_sub(10 + active),
        }
    }

    /// When bias, weight and centre of gravity hold, and what they leave out: one sentence per
    /// effect of `at`.
    #[must_use]
    pub fn conditions(&self, at: &State) -> Vec<String> {
        let all = self.effects.iter().zip(&self.declared.effects).zip(&at.amplitudes);
        all.filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0))
            .map(|((effect, described), _)| effect.condition(described))
            .collect()
    }

    fn errors(&self, at: &State) -> GravityErrors {
        let drivers = self.drivers.first().map_or(0, Vec::len);
        let zero = vec![Vector6::zeros(); drivers];
        let mut errors = GravityErrors { zero, ..GravityErrors::default() };
        for (effect, amplitude) in self.effects.iter().zip(&at.amplitudes) {
            effect.apply(amplitude, &mut errors);
        }
        errors
    }

    fn predicted<'a>(
        &'a self,
        pose: usize,
        at: &State,
        errors: &'a GravityErrors,
    ) -> Predicted<'a> {
        Predicted {
            errors,
            down: Down::of(&self.poses[pose].base_from_sensor, &self.gravity, errors),
            weight_n: at.base[6],
            arm_mm: at.base.fixed_rows::<3>(7).into_owned(),
            drivers: &self.drivers[pose],
        }
    }
}

impl Model for GravityModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let errors = self.errors(at);
        let zero: Vector6<f64> = at.base.fixed_rows::<6>(0).into_owned();
        let mut rows = DVector::zeros(self.declared.layout.rows.len());
        for (i, pose) in self.poses.iter().enumerate() {
            let predicted = self.predicted(i, at, &errors).wrench() + zero;
            rows.fixed_rows_mut::<6>(6 * i).copy_from(&(pose.wrench.to_vector() - predicted));
        }
        rows
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let errors = self.errors(at);
        let mut jacobian = DMatrix::zeros(self.declared.layout.rows.len(), 10);
        for i in 0..self.poses.len() {
            let predicted = self.predicted(i, at, &errors);
            let mut block = jacobian.fixed_view_mut::<6, 10>(6 * i, 0);
            block.fixed_columns_mut::<6>(0).fill_diagonal(-1.0);
            block.set_column(6, &-predicted.by_load(predicted.down.direction));
            for axis in 0..3 {
                block.set_column(7 + axis, &-predicted.by_arm(axis));
            }
        }
        jacobian
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let errors = self.errors(at);
        let parameters = self.declared.effects[effect].parameters.len();
        let mut tangent = DMatrix::zeros(self.declared.layout.rows.len(), parameters);
        for i in 0..self.poses.len() {
            let predicted = self.predicted(i, at, &errors);
            let block = -predicted.derivative(self.effects[effect], &self.gravity);
            tangent.rows_mut(6 * i, 6).copy_from(&block);
        }
        tangent
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}

fn start(calibrated: &GravityCalibration) -> DVector<f64> {
    let bias = calibrated.bias.to_vector();
    let arm = calibrated.center_of_gravity_mm.coords;
    let weight_n = [calibrated.weight_n];
    DVector::from_iterator(10, bias.iter().chain(&weight_n).chain(arm.iter()).copied())
}

fn base() -> Vec<Parameter> {
    let forces = ["bias fx", "bias fy", "bias fz"].map(|name| parameter(name, "N", 1.0));
    let moments = ["bias mx", "bias my", "bias mz"].map(|name| parameter(name, "N·mm", 1.0));
    let arm = ["centre of gravity x", "centre of gravity y", "centre of gravity z"]
        .map(|name| parameter(name, "mm", 1.0));
    forces.into_iter().chain(moments).chain([parameter("weight", "N", 1.0)]).chain(arm).collect()
}

fn layout(poses: &[StaticPose], options: &GravityOptions, declared: &GravityCalibration) -> Layout {
    let noise = declared.noise;
    let row = |observation: usize, component: usize| Row {
        observation,
        component,
        sigma: if component < 3 { noise.force_n } else { noise.moment_nmm }.max(FLOOR),
        reported: component < 3,
    };
    Layout {
        rows: (0..poses.len())
            .flat_map(|o| (0..6).map(move |c| (o, c)))
            .map(|(o, c)| row(o, c))
            .collect(),
        observations: (0..poses.len()).collect(),
        groups: poses.iter().map(|p| Group { name: p.name.clone(), role: Role::Fit }).collect(),
        unit: "N".to_owned(),
        sigma_declared: options.noise.is_some(),
    }
}
