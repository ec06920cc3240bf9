use std::sync::{Arc, OnceLock};

use model_discrepancy::{Closure, Covariate, Model, Quantity};
use nalgebra::Vector3;
use tracker_lm::{
    AxisModel, Calibration, DeadPath, Formulation, Gauge, Options, Survey, TrackerError,
    TrackerModel, calibrate,
};
use truing_report::Fact;

use super::estimates::{TrackerLmEstimates, stand};
use super::plan::{Carried, Sight, Surveyed, offer};
use super::plan_settings::TracerPlanSettings;
use super::settings::{RANGES, error};
use crate::Error;
use crate::case::{Location, NumberColumn};
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::measured::{About, Fitted, Measured, Observation, Prepared, Words};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

/// A `tracker-lm` case as read.
#[derive(Clone, Debug)]
pub(super) struct TrackerCase {
    pub(super) file: Location,
    /// Line of each range.
    pub(super) lines: Vec<usize>,
    pub(super) survey: Survey,
    pub(super) options: Options,
    pub(super) time_s: Option<Vec<f64>>,
    pub(super) covariates: Vec<NumberColumn>,
    /// One name per range.
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_noun: Option<String>,
    /// From the machine's zero to that of the survey.
    pub(super) away_mm: Vector3<f64>,
    /// Whether the table says which way the axis came.
    pub(super) has_direction: bool,
    pub(super) plan: TracerPlanSettings,
    pub(super) solved: OnceLock<Calibration>,
}

/// Residual over its own standard uncertainty beyond which a range is named: over a thousand
/// ranges of a sound survey chance does it once in three hundred surveys.
const OUTLIER: f64 = 4.5;
/// Steps of the search for a change that is tried: with the right one a survey takes under 20, of few readings more.
const MOST_ITERATIONS: usize = 50;
/// Ranges named at most.
const MOST_NAMED: usize = 5;

impl TrackerCase {
    fn solved(&self) -> Result<&Calibration, Error> {
        if let Some(solved) = self.solved.get() {
            return Ok(solved);
        }
        let solved = calibrate(&self.survey, &self.options).map_err(|e| self.error(e))?;
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

    /// Ranges that stand out, and stations far from where they should be.
    fn warnings(&self, found: &Calibration) -> Vec<String> {
        let mut warnings = Vec::new();
        let score = |range: usize| {
            let share = found.redundancy[range].sqrt().max(f64::MIN_POSITIVE);
            found.residuals_mm[range].abs() / (found.displacement_mm * share)
        };
        let mut far: Vec<usize> = (0..found.residuals_mm.len())
            .filter(|&r| found.redundancy[r] > 1e-6 && score(r) > OUTLIER)
            .collect();
        far.sort_by(|&a, &b| score(b).total_cmp(&score(a)));
        for &range in far.iter().take(MOST_NAMED) {
            let r = &self.survey.ranges[range];
            warnings.push(format!(
                "line {}: the range from {} to {} at step {} is off by {:.1} times its \
                 uncertainty",
                self.lines[range],
                self.survey.stations[r.station].name,
                self.survey.mounts[r.mount].name,
                self.survey.steps[r.step].name,
                score(range),
            ));
        }
        if far.len() > MOST_NAMED {
            warnings.push(format!("{} further ranges stand out likewise", far.len() - MOST_NAMED));
        }
        warnings
    }
}

impl TrackerCase {
    fn estimates(&self, found: &Calibration, reversal: Option<[f64; 6]>) -> Arc<dyn Estimates> {
        let near = TrackerLmEstimates::of(&self.survey, found, reversal);
        Arc::new(near.in_order(self.options.order).moved(self.away_mm))
    }

    fn fitted(&self, found: &Calibration) -> Fitted {
        let observation = |r: &f64| Observation { residual: vec![*r], fitted: true };
        let declared = self.options.noise.displacement_mm.is_some();
        Fitted {
            observations: found.residuals_mm.iter().map(observation).collect(),
            unit: "mm",
            degrees_of_freedom: found.degrees_of_freedom,
            chi2_per_dof: declared.then_some(found.variance_factor),
            warnings: self.warnings(found),
            estimates: self.estimates(found, None),
        }
    }

    /// What was recorded beside the ranges and their times.
    fn conditions(&self) -> Vec<Covariate> {
        self.covariates.iter().map(NumberColumn::covariate).collect()
    }

    fn prepared(&self, model: TrackerModel) -> Prepared<'_> {
        let concrete = Arc::new(model);
        let recorded = recorded(self.time_s.as_ref(), &self.covariates);
        let mut covariates = concrete.coordinates();
        covariates.extend(recorded.iter().map(|c| concrete.padded(c)));
        let mut model: Arc<dyn Model + Send> = Arc::<TrackerModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            model = Arc::new(Regrouped::new(model, groups));
        }
        let solved = Arc::clone(&concrete);
        let estimates = Box::new(move |closure: &Closure| {
            let found = solved.calibration_with(closure);
            let found = found.as_ref().unwrap_or(solved.calibration());
            let reversal = reversal(&*solved, closure);
            self.estimates(found, reversal)
        });
        let about: About<'_> = Box::new(move |found| {
            Ok(concrete.about_found(found).map(|there| self.prepared(there)))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }
}

impl Measured for TrackerCase {
    fn fit(&self) -> Result<Fitted, Error> {
        Ok(self.fitted(self.solved()?))
    }

    fn fit_alone(&self) -> Result<Fitted, Error> {
        let options = Options { max_iterations: MOST_ITERATIONS, ..self.options };
        let found = calibrate(&self.survey, &options).map_err(|e| self.error(e))?;
        Ok(self.fitted(&found))
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let Self { survey, time_s, options, .. } = self;
        let model = TrackerModel::new(survey.clone(), time_s.clone(), self.conditions(), options);
        Ok(self.prepared(model.map_err(|e| self.error(e))?))
    }

    fn prepare_planned(&self, n_measured: usize) -> Result<Prepared<'_>, Error> {
        let (Self { survey, time_s, options, .. }, conditions) = (self, self.conditions());
        let (survey, time_s) = (survey.clone(), time_s.clone());
        let model = TrackerModel::with_planned(survey, time_s, conditions, options, n_measured);
        Ok(self.prepared(model.map_err(|e| self.error(e))?))
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        let (survey, found) = (&self.survey, self.solved()?);
        let carried = survey.second.as_ref().zip(found.second.as_ref()).and_then(|(s, second)| {
            let stand_rad = [stand(&found.axis_errors)?, stand(&second.axis_errors)?];
            let (axis, angles_rad) = (&s.axis, &s.angles_rad[..]);
            Some(Carried { axis, angles_rad, errors: &second.axis_errors, stand_rad })
        });
        if survey.second.is_some() && carried.is_none() {
            return Ok(None);
        }
        let places = found.stations.iter().map(|station| station.position_mm);
        let surveyed = Surveyed {
            table: RANGES,
            axis: &survey.axis,
            steps: &survey.steps,
            stations: survey.stations.iter().map(|s| s.name.as_str()).zip(places).collect(),
            mounts: &found.mounts,
            mount_names: survey.mounts.iter().map(|m| m.name.as_str()).collect(),
            errors: &found.axis_errors,
            seen: survey.ranges.iter().map(|range| (range.station, range.mount)).collect(),
            sight: Sight::Range(&found.dead_paths),
            away_mm: self.away_mm,
            has_direction: self.has_direction,
            order: self.options.order,
            carried,
        };
        Ok(Some(offer(&self.plan, &surveyed)))
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        super::suspects::range_yardstick(&self.survey, fitted)
    }

    fn repeats_places(&self) -> bool {
        self.options.axis != AxisModel::Free
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let survey = &self.survey;
        let noise = self.options.noise;
        let first = survey.axis.letter.letter();
        let axes = match &survey.second {
            None => first.to_string(),
            Some(second) => format!("{} on {first}", second.axis.letter.letter()),
        };
        let mm = |value: Option<f64>, otherwise: &str| {
            value.map_or_else(|| otherwise.to_owned(), |v| format!("{v} mm"))
        };
        Words {
            declared: self.declared(),
            residual: "|P − S| − (displacement + dead path)",
            components: &[],
            group_noun: self.group_noun.clone().unwrap_or_else(|| "step".to_owned()),
            measured: vec![
                fact("axis", axes),
                fact("stations", survey.stations.len().to_string()),
                fact("reflectors", survey.mounts.len().to_string()),
                fact("noise of a displacement", mm(noise.displacement_mm, "estimated")),
                fact("stations' nominal positions known to", mm(noise.station_mm, "not declared")),
            ],
            places: None,
        }
    }
}

impl TrackerCase {
    fn declared(&self) -> Vec<String> {
        let formulation = match self.options.formulation {
            Formulation::Joint if self.options.axis != AxisModel::Free => {
                "Joint bundle: stations, dead paths, reflectors on a rigid body, and a perfect axis \
                 where it is declared."
            }
            Formulation::Joint if self.survey.second.is_some() => {
                "Joint bundle: stations, dead paths, reflectors on a rigid body and six errors of \
                 both axes at every angle, relative to where each stands while the other turns."
            }
            Formulation::Joint => {
                "Joint bundle: stations, dead paths, reflectors on a rigid body and six errors of \
                 the axis at every angle, relative to the first one."
            }
            Formulation::FreePoints => {
                "Free target points with rows for the distances between reflectors; the six \
                 errors follow from the points, angle by angle. The loop works on the joint \
                 bundle."
            }
        };
        let dead_path = match self.options.dead_path {
            DeadPath::Lock => "One dead path per station and reflector.",
            DeadPath::Station => "One dead path per station.",
        };
        let gauge = match (self.options.gauge, self.options.noise.station_mm) {
            (Gauge::Stations, Some(_)) => {
                "Frame: the stations' nominal positions, with their uncertainty."
            }
            (Gauge::Shape, Some(_)) => {
                "Frame: the rigid fit of all stations, whose shape is known with their uncertainty."
            }
            (Gauge::Minimal, _) => "Frame: the first three stations.",
            _ => "Frame: the rigid fit of all stations to their nominal positions.",
        };
        [formulation, dead_path, gauge].map(str::to_owned).to_vec()
    }
}

/// Recorded columns, the time among them.
pub(super) fn recorded(time_s: Option<&Vec<f64>>, columns: &[NumberColumn]) -> Vec<Covariate> {
    let time = time_s.map(|values| Covariate::recorded("time_s", Quantity::Time, values.clone()));
    time.into_iter().chain(columns.iter().map(NumberColumn::covariate)).collect()
}

/// Difference of the six errors between the two ways, where backlash was accepted.
pub(super) fn reversal(model: &dyn Model, closure: &Closure) -> Option<[f64; 6]> {
    let effect = model.declared().effects.iter().position(|e| e.id == "backlash")?;
    let amplitudes = &closure.state.amplitudes[effect];
    let accepted = closure.steps.iter().any(|s| s.effect == "backlash");
    accepted.then(|| std::array::from_fn(|i| amplitudes[i]))
}
