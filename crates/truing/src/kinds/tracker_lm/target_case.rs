use std::sync::{Arc, OnceLock};

use model_discrepancy::{Closure, Covariate, Model, Quantity};
use nalgebra::{Point3, Vector3};
use tracker_lm::{
    AxisModel, HoldOut, TargetCalibration, TargetModel, TargetNoise, TargetOptions, TargetRecords,
    TargetSurvey, TrackerError, calibrate_targets,
};
use truing_report::Fact;

use super::estimates::TrackerLmEstimates;
use super::measured::reversal;
use super::plan::{Sight, Surveyed, offer};
use super::plan_settings::TracerPlanSettings;
use super::settings::{TARGETS, error};
use crate::Error;
use crate::case::Location;
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::measured::{About, Fitted, Measured, Observation, Prepared, Words};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

/// A `tracker-lm` case of points, as read.
#[derive(Clone, Debug)]
pub(super) struct TargetCase {
    pub(super) file: Location,
    /// Line of each reading.
    pub(super) lines: Vec<usize>,
    pub(super) survey: TargetSurvey,
    pub(super) options: TargetOptions,
    pub(super) records: TargetRecords,
    pub(super) hold_out: HoldOut,
    /// One name per reading.
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_noun: Option<String>,
    /// From the machine's zero to that of the survey.
    pub(super) away_mm: Vector3<f64>,
    pub(super) has_direction: bool,
    pub(super) plan: TracerPlanSettings,
    pub(super) solved: OnceLock<TargetCalibration>,
}

/// Components along the beam and across it, or of the station's frame.
const COMPONENTS: [&[&str]; 2] = [&["beam", "across", "across again"], &["x", "y", "z"]];
/// Distance over its own standard uncertainty beyond which a reading is named.
const OUTLIER: f64 = 5.0;
/// Readings named at most.
const MOST_NAMED: usize = 5;

impl TargetCase {
    fn solved(&self) -> Result<&TargetCalibration, Error> {
        if let Some(solved) = self.solved.get() {
            return Ok(solved);
        }
        let solved = calibrate_targets(&self.survey, &self.options).map_err(|e| self.error(e))?;
        Ok(self.solved.get_or_init(|| solved))
    }

    fn error(&self, source: TrackerError) -> Error {
        let at = match source {
            TrackerError::DuplicateRange { range, .. }
            | TrackerError::UnknownIndex { range, .. } => self.lines.get(range),
            _ => None,
        };
        let file = self.file.clone();
        error(at.map_or(file.clone(), |line| file.line(*line)), source)
    }

    fn is_polar(&self) -> bool {
        matches!(self.options.noise, TargetNoise::Polar { .. })
    }

    /// Readings that stand out.
    fn warnings(&self, found: &TargetCalibration) -> Vec<String> {
        let score = |n: usize| -> f64 {
            let (residual, sigma) = (found.residuals_mm[n], found.sigmas_mm[n]);
            let own = found.redundancy[n].map(|r| r.max(f64::EPSILON).sqrt());
            residual.component_div(&sigma.component_mul(&own)).amax()
        };
        let mut far: Vec<(f64, usize)> = (0..self.survey.targets.len())
            .map(|n| (score(n), n))
            .filter(|(score, _)| *score > OUTLIER)
            .collect();
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        let name = |&(score, n): &(f64, usize)| {
            let t = &self.survey.targets[n];
            format!(
                "line {}: mount {} at step {} as station {} saw it is off by {score:.1} times its \
                 uncertainty",
                self.lines[n],
                self.survey.mounts[t.mount].name,
                self.survey.steps[t.step].name,
                self.survey.stations[t.station].name,
            )
        };
        let mut warnings: Vec<String> = far.iter().take(MOST_NAMED).map(name).collect();
        if far.len() > MOST_NAMED {
            warnings
                .push(format!("{} further readings stand out likewise", far.len() - MOST_NAMED));
        }
        warnings
    }
}

impl TargetCase {
    fn estimates(
        &self,
        found: &TargetCalibration,
        reversal: Option<[f64; 6]>,
    ) -> Arc<dyn Estimates> {
        let near = TrackerLmEstimates::of_targets(&self.survey, found, reversal);
        Arc::new(near.in_order(self.options.order).moved(self.away_mm))
    }

    fn prepared(&self, model: TargetModel) -> Prepared<'_> {
        let concrete = Arc::new(model);
        let mut covariates = concrete.coordinates();
        if let Some(values) = &self.records.time_s {
            covariates.push(Covariate::recorded("time_s", Quantity::Time, values.clone()));
        }
        covariates.extend(self.records.covariates.iter().cloned());
        let mut model: Arc<dyn Model + Send> = Arc::<TargetModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            model = Arc::new(Regrouped::new(model, groups));
        }
        let solved = Arc::clone(&concrete);
        let estimates = Box::new(move |closure: &Closure| {
            let found =
                solved.calibration_with(&closure.solution().amplitudes()).map(|(found, _)| found);
            let found = found.as_ref().unwrap_or(solved.calibration());
            let reversal = reversal(&*solved, closure);
            self.estimates(found, reversal)
        });
        let about: About<'_> = Box::new(move |found| {
            Ok(concrete.about_found(&found.amplitudes()).map(|there| self.prepared(there)))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }
}

impl Measured for TargetCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let found = self.solved()?;
        let observation =
            |r: &Vector3<f64>| Observation { residual: vec![r.x, r.y, r.z], fitted: true };
        Ok(Fitted {
            observations: found.residuals_mm.iter().map(observation).collect(),
            unit: "mm",
            degrees_of_freedom: found.degrees_of_freedom,
            chi2_per_dof: found.point_mm.is_none().then_some(found.variance_factor),
            warnings: self.warnings(found),
            estimates: self.estimates(found, None),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let Self { survey, records, hold_out, options, .. } = self;
        let model = TargetModel::new(survey.clone(), records, *hold_out, options);
        Ok(self.prepared(model.map_err(|e| self.error(e))?))
    }

    fn prepare_planned(&self, n_measured: usize) -> Result<Prepared<'_>, Error> {
        let Self { survey, records, hold_out, options, .. } = self;
        let survey = survey.clone();
        let model = TargetModel::with_planned(survey, records, *hold_out, options, n_measured);
        Ok(self.prepared(model.map_err(|e| self.error(e))?))
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        let (survey, found) = (&self.survey, self.solved()?);
        let places = (found.stations.iter())
            .map(|station| Point3::from(station.machine_from_station.translation.vector));
        let surveyed = Surveyed {
            table: TARGETS,
            axis: &survey.axis,
            steps: &survey.steps,
            stations: survey.stations.iter().map(|s| s.name.as_str()).zip(places).collect(),
            mounts: &found.mounts,
            mount_names: survey.mounts.iter().map(|m| m.name.as_str()).collect(),
            errors: &found.axis_errors,
            seen: survey.targets.iter().map(|target| (target.station, target.mount)).collect(),
            sight: Sight::Point(&found.stations),
            away_mm: self.away_mm,
            has_direction: self.has_direction,
            order: self.options.order,
            carried: None,
        };
        Ok(Some(offer(&self.plan, &surveyed)))
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        super::suspects::target_yardstick(&self.survey, fitted)
    }

    fn repeats_places(&self) -> bool {
        self.options.axis != AxisModel::Free && self.hold_out == HoldOut::Step
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let survey = &self.survey;
        let noise = match self.options.noise {
            TargetNoise::Estimated => "estimated".to_owned(),
            TargetNoise::Point { point_mm } => format!("{point_mm} mm"),
            TargetNoise::Polar { range_mm, angle_rad } => {
                format!("{range_mm} mm along the beam, {angle_rad} rad across it")
            }
        };
        let bundle = match self.options.axis {
            AxisModel::Free => {
                "Bundle: poses of the stations, reflectors on a rigid body and six errors of the \
                 axis at every angle, relative to the first one."
            }
            AxisModel::Fixed => {
                "Bundle: poses of the stations, reflectors on a rigid body, and a perfect axis where \
                 it is declared."
            }
            AxisModel::Located => {
                "Bundle: poses of the stations, reflectors on a rigid body, and a perfect axis whose \
                 location is fitted."
            }
        };
        let declared = [bundle, "Frame: the rigid fit of all reflectors to their nominal places."];
        Words {
            declared: declared.map(str::to_owned).to_vec(),
            residual: "predicted − measured point",
            components: COMPONENTS[usize::from(!self.is_polar())],
            group_noun: self.group_noun.clone().unwrap_or_else(|| "step".to_owned()),
            measured: vec![
                fact("axis", survey.axis.letter.letter().to_string()),
                fact("stations", survey.stations.len().to_string()),
                fact("reflectors", survey.mounts.len().to_string()),
                fact("noise of a reading", noise),
            ],
            places: None,
        }
    }
}
