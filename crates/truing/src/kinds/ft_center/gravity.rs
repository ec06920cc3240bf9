use std::sync::Arc;

use ft_center::{
    GravityCalibration, GravityModel, GravityOptions, Noise, StaticPose, calibrate_gravity,
};
use geometry::Wrench;
use model_discrepancy::{Closure, Covariate, Model};
use nalgebra::{Unit, Vector3, Vector6};
use serde::Serialize;

use super::displacements::recorded;
use super::wrench::wrenches;
use super::{CenterEstimate, FrameEstimate, GRAVITY, ModelSettings, Settings, error, unused};
use crate::Error;
use crate::case::{
    Columns, Document, Finite, Folder, Location, NumberColumn, Problem, group_names,
};
use crate::estimates::{Estimated, Estimates};
use crate::kinds::orientation::{LENGTH_TOL, orientations};
use crate::kinds::{Fitted, Measured, Observation, Prepared, Reading, Words, empirical_conditions};
use crate::regrouped::Regrouped;
use crate::report::Fact;
use crate::suspect::Yardstick;
use crate::text_table::TextTable;

const KNOWN: &[&str] =
    &["pose", "qw", "qx", "qy", "qz", "fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];

/// What static poses are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GravityEstimates {
    /// Always `None`: poses do not place the sensor.
    pub frame: Option<FrameEstimate>,
    /// Always empty.
    pub centers: Vec<CenterEstimate>,
    /// What the sensor reads under no load.
    pub bias: WrenchEstimate,
    /// Weight of the tool beyond the sensor.
    pub weight_n: f64,
    /// Standard uncertainty of it.
    pub std_weight_n: f64,
    /// Centre of gravity of the tool, sensor frame.
    pub center_of_gravity_mm: [f64; 3],
    /// Standard uncertainty of it.
    pub std_center_of_gravity_mm: [f64; 3],
    /// Root mean square of `line_miss_mm` over the poses.
    pub line_miss_rms_mm: f64,
    /// When bias, weight and centre of gravity hold, and what they leave to the corrections.
    pub conditions: Vec<String>,
    /// One per pose.
    pub poses: Vec<LineMiss>,
}

/// A wrench with its standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "force and moment components in the sensor's axes, as named")]
pub struct WrenchEstimate {
    pub fx_n: f64,
    pub fy_n: f64,
    pub fz_n: f64,
    pub mx_nmm: f64,
    pub my_nmm: f64,
    pub mz_nmm: f64,
    pub std_fx_n: f64,
    pub std_fy_n: f64,
    pub std_fz_n: f64,
    pub std_mx_nmm: f64,
    pub std_my_nmm: f64,
    pub std_mz_nmm: f64,
}

/// One pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineMiss {
    /// Name of the pose.
    pub pose: String,
    /// Distance of the weight's line of action from the centre of gravity.
    pub line_miss_mm: f64,
    /// What accepted effects add to the wrench of the weight: the force.
    pub correction_n: [f64; 3],
    /// And the moment.
    pub correction_nmm: [f64; 3],
    /// Force read − (bias + weight + correction).
    pub residual_n: [f64; 3],
    /// Moment read − (bias + weight + correction).
    pub residual_nmm: [f64; 3],
}

impl GravityEstimates {
    fn of(
        calibration: &GravityCalibration,
        poses: &[StaticPose],
        gravity: &Unit<Vector3<f64>>,
        conditions: Vec<String>,
    ) -> Self {
        let bias = calibration.bias.to_vector();
        let std = calibration.covariance.diagonal().map(f64::sqrt);
        let center = calibration.center_of_gravity_mm;
        let misses = &calibration.line_miss_mm;
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let mean_square = misses.iter().map(|m| m * m).sum::<f64>() / misses.len() as f64;
        Self {
            frame: None,
            centers: Vec::new(),
            bias: WrenchEstimate {
                fx_n: bias[0],
                fy_n: bias[1],
                fz_n: bias[2],
                mx_nmm: bias[3],
                my_nmm: bias[4],
                mz_nmm: bias[5],
                std_fx_n: std[0],
                std_fy_n: std[1],
                std_fz_n: std[2],
                std_mx_nmm: std[3],
                std_my_nmm: std[4],
                std_mz_nmm: std[5],
            },
            weight_n: calibration.weight_n,
            std_weight_n: std[6],
            center_of_gravity_mm: [center.x, center.y, center.z],
            std_center_of_gravity_mm: [std[7], std[8], std[9]],
            line_miss_rms_mm: mean_square.sqrt(),
            conditions,
            poses: (poses.iter().zip(misses).zip(&calibration.residuals))
                .map(|((pose, miss), residual)| {
                    let down = pose.base_from_sensor.inverse() * gravity.into_inner();
                    let weight = Wrench::of_force(down * calibration.weight_n, &center);
                    let correction = pose.wrench - calibration.bias - weight - *residual;
                    LineMiss {
                        pose: pose.name.clone(),
                        line_miss_mm: *miss,
                        correction_n: correction.force_n.into(),
                        correction_nmm: correction.torque_nmm.into(),
                        residual_n: residual.force_n.into(),
                        residual_nmm: residual.torque_nmm.into(),
                    }
                })
                .collect(),
        }
    }

    pub(crate) fn parameters(&self) -> Vec<Estimated> {
        let b = &self.bias;
        let [x, y, z] = self.center_of_gravity_mm;
        let [std_x, std_y, std_z] = self.std_center_of_gravity_mm;
        let all = [
            ("bias fx", "N", b.fx_n, b.std_fx_n),
            ("bias fy", "N", b.fy_n, b.std_fy_n),
            ("bias fz", "N", b.fz_n, b.std_fz_n),
            ("bias mx", "N·mm", b.mx_nmm, b.std_mx_nmm),
            ("bias my", "N·mm", b.my_nmm, b.std_my_nmm),
            ("bias mz", "N·mm", b.mz_nmm, b.std_mz_nmm),
            ("weight", "N", self.weight_n, self.std_weight_n),
            ("centre of gravity x", "mm", x, std_x),
            ("centre of gravity y", "mm", y, std_y),
            ("centre of gravity z", "mm", z, std_z),
        ];
        let mut all: Vec<Estimated> =
            all.map(|(name, unit, value, std)| Estimated::new(name, unit, value, Some(std))).into();
        all.push(Estimated::new(
            "line of action misses by (rms)",
            "mm",
            self.line_miss_rms_mm,
            None,
        ));
        all
    }

    pub(crate) fn table(&self) -> TextTable {
        let columns = ["pose", "line miss mm"];
        let mut table = TextTable::new("line of action past the centre of gravity", &columns);
        for p in &self.poses {
            table.push(vec![p.pose.clone().into(), p.line_miss_mm.into()]);
        }
        table
    }
}

#[derive(Clone, Debug)]
pub(super) struct GravityCase {
    file: Location,
    pub(super) poses: Vec<StaticPose>,
    options: GravityOptions,
    covariates: Vec<NumberColumn>,
    groups: Option<Vec<String>>,
    group_noun: String,
}

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let table = folder.table(GRAVITY, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let names = columns.ids("pose")?;
    let orientations = orientations(&table, &mut columns)?;
    let wrenches = wrenches(&mut columns)?;
    let poses = (names.into_iter().zip(orientations).zip(wrenches))
        .map(|((name, base_from_sensor), wrench)| StaticPose {
            name: name.to_owned(),
            base_from_sensor,
            wrench,
        })
        .collect();
    let extras = columns.rest()?;
    let mut warnings = unused(
        &[
            ("[contact] z0_mm", settings.contact.z0_mm.is_some()),
            ("[contact] min_fz_n", settings.contact.min_fz_n.is_some()),
            ("[contact] spin_hz", settings.contact.spin_hz.is_some()),
            ("[model] handedness", settings.model.handedness.is_some()),
            ("[noise] displacement_mm", settings.noise.displacement_mm.is_some()),
        ],
        GRAVITY,
    );
    let noise: Option<Noise> = settings.noise.of_sensor(document, &mut warnings)?;
    warnings.extend(extras.warnings);
    let group = settings.closure.group.as_ref();
    let measured = GravityCase {
        file: table.at_file(),
        poses,
        options: GravityOptions { noise, gravity: direction(document, &settings.model)? },
        covariates: extras.covariates,
        groups: group_names(group, &table, document)?,
        group_noun: group.map_or_else(|| "pose".to_owned(), |g| g.get_ref().clone()),
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: &[GRAVITY],
    })
}

fn direction(document: &Document, settings: &ModelSettings) -> Result<Unit<Vector3<f64>>, Error> {
    let Some([x, y, z]) = settings.gravity else { return Ok(-Vector3::z_axis()) };
    let (Finite(x), Finite(y), Finite(z)) = (x, y, z);
    Unit::try_new(Vector3::new(x, y, z), LENGTH_TOL).ok_or_else(|| {
        let message = "`[model] gravity` must not be the zero vector; it points down in the base";
        Error::case(document.at_file(), Problem::WrongValue { message: message.to_owned() })
    })
}

fn residual(wrench: &Wrench) -> Vec<f64> {
    wrench.to_vector().iter().copied().collect()
}

impl Measured for GravityCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let calibration = calibrate_gravity(&self.poses, &self.options)
            .map_err(|e| error(self.file.clone(), e))?;
        let observations = (calibration.residuals.iter())
            .map(|wrench| Observation { residual: residual(wrench), fitted: true })
            .collect();
        Ok(Fitted {
            observations,
            unit: "N",
            degrees_of_freedom: calibration.degrees_of_freedom,
            chi2_per_dof: self.options.noise.and_then(|noise| chi2_per_dof(&calibration, noise)),
            estimates: Estimates::Gravity(GravityEstimates::of(
                &calibration,
                &self.poses,
                &self.options.gravity,
                Vec::new(),
            )),
            warnings: Vec::new(),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let recorded: Vec<Covariate> = recorded(&self.covariates, |c| c.values.clone()).collect();
        let concrete = GravityModel::new(&self.poses, &self.options, &recorded)
            .map_err(|e| error(self.file.clone(), e))?;
        let mut covariates = concrete.covariates();
        covariates.extend(recorded);
        let concrete = Arc::new(concrete);
        let mut model: Arc<dyn Model + Send> = Arc::<GravityModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            model = Arc::new(Regrouped::new(model, groups));
        }
        let estimates = Box::new(move |closure: &Closure| {
            let calibration = concrete.calibration(&closure.state, &closure.covariance);
            let mut conditions = concrete.conditions(&closure.state);
            conditions.extend(empirical_conditions(closure));
            let gravity = &self.options.gravity;
            Estimates::Gravity(GravityEstimates::of(
                &with_empirical(calibration, closure),
                &self.poses,
                gravity,
                conditions,
            ))
        });
        Ok(Prepared { model, covariates, estimates })
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        super::suspects::gravity_yardstick(self, fitted)
    }

    fn words(&self) -> Words {
        let noise = self.options.noise.map_or_else(
            || "estimated from the residual".to_owned(),
            |n| format!("{} N, {} N·mm per reading", n.force_n, n.moment_nmm),
        );
        Words {
            declared: vec![
                "Wrench = bias + weight W·g with moment r × W·g, g the direction of gravity in \
                 sensor axes; bias, W and r are estimated."
                    .to_owned(),
            ],
            residual: "read − predicted force",
            components: &["x", "y", "z"],
            group_noun: self.group_noun.clone(),
            measured: vec![Fact { name: "standard uncertainty".to_owned(), value: noise }],
            places: None,
        }
    }
}

/// The residuals with the empirical corrections taken off too.
fn with_empirical(mut calibration: GravityCalibration, closure: &Closure) -> GravityCalibration {
    for (pose, residual) in calibration.residuals.iter_mut().enumerate() {
        let after = &closure.residuals_after[6 * pose..6 * (pose + 1)];
        *residual = Wrench::from_vector(&Vector6::from_column_slice(after));
    }
    calibration
}

fn chi2_per_dof(calibration: &GravityCalibration, noise: Noise) -> Option<f64> {
    let whitened = |w: &Wrench| {
        w.force_n.norm_squared() / noise.force_n.powi(2)
            + w.torque_nmm.norm_squared() / noise.moment_nmm.powi(2)
    };
    let chi2: f64 = calibration.residuals.iter().map(whitened).sum();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let dof = calibration.degrees_of_freedom as f64;
    (dof > 0.0).then(|| chi2 / dof)
}
