use std::sync::Arc;

use ft_center::{
    GravityCalibration, GravityModel, GravityOptions, Noise, StaticPose, calibrate_gravity,
};
use geometry::Wrench;
use model_discrepancy::{Closure, Covariate, Model};
use nalgebra::{Unit, Vector3, Vector6};
use truing_report::Fact;

use super::displacements::recorded;
use super::gravity_estimates::GravityEstimates;
use super::plan::poses;
use super::plan_settings::SensorPlanSettings;
use super::settings::{GRAVITY, ModelSettings, Settings, error, unused};
use super::wrench::wrenches;
use crate::Error;
use crate::case::{
    Columns, Document, Finite, Folder, Location, NumberColumn, Problem, group_names,
};
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::kinds::orientation::{LENGTH_TOL, orientations};
use crate::measured::{
    Fitted, Measured, Observation, Prepared, Reading, Words, empirical_conditions,
};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

const KNOWN: &[&str] =
    &["pose", "qw", "qx", "qy", "qz", "fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];

#[derive(Clone, Debug)]
pub(super) struct GravityCase {
    file: Location,
    pub(super) poses: Vec<StaticPose>,
    options: GravityOptions,
    covariates: Vec<NumberColumn>,
    groups: Option<Vec<String>>,
    group_noun: String,
    plan: SensorPlanSettings,
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
    let extras = columns.rest(&settings.closure.columns)?;
    let mut warnings = unused(
        &[
            ("[frame] from", settings.frame.from.is_some()),
            ("[tolerance] repeatability_mm", settings.tolerance.repeatability_mm.is_some()),
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
        plan: settings.plan.clone(),
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
        tables: vec![GRAVITY],
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
            estimates: Arc::new(GravityEstimates::of(
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
        let estimates = Box::new(move |closure: &Closure| -> Arc<dyn Estimates> {
            let calibration = concrete.calibration(&closure.state, &closure.covariance);
            let mut conditions = concrete.conditions(&closure.state);
            conditions.extend(empirical_conditions(closure));
            let gravity = &self.options.gravity;
            Arc::new(GravityEstimates::of(
                &with_empirical(calibration, closure),
                &self.poses,
                gravity,
                conditions,
            ))
        });
        Ok(Prepared { model, covariates, estimates, about: None })
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        let found = calibrate_gravity(&self.poses, &self.options)
            .map_err(|e| error(self.file.clone(), e))?;
        Ok(Some(poses(&self.plan, &self.poses, (&found, &self.options.gravity))))
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        super::suspects::gravity_yardstick(&self.poses, fitted)
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
