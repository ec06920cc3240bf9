use std::sync::Arc;

use ft_center::{
    AxisMotion, AxisReading, AxisRun, FtCenterError, axis_coordinates, positioning_model,
};
use model_discrepancy::{Closure, Covariate, LinearModel, Model, Shown};
use truing_report::Fact;

use super::axis_run::AxisRunEstimate;
use super::estimates::{PositionResidual, PositioningEstimates};
use super::figures::PositioningFigures;
use super::plan::{AxisPlanSettings, AxisTable};
use crate::Error;
use crate::case::{Location, NumberColumn};
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::measured::{
    About, Fitted, Measured, Observation, Prepared, Words, empirical_conditions,
};
use crate::regrouped::Regrouped;
use crate::suspect::{Yardstick, spread_of_places};

/// Misfit of a position over the travel that no machine makes.
const GROSS: f64 = 0.02;
/// The same beyond which targets and positions have nothing to do with each other.
const UNMATCHED: f64 = 0.4;
/// The same beyond which an error of its own at every target, which takes all of it away, is none of an
/// axis: 50 mm in a metre.
const BEYOND_PHYSICS: f64 = 0.05;
const ARCSEC_PER_DEG: f64 = 3600.0;

#[derive(Clone, Debug)]
pub(super) struct PositioningCase {
    pub(super) file: Location,
    pub(super) readings: Vec<AxisReading>,
    pub(super) motion: AxisMotion,
    pub(super) sigma: Option<f64>,
    pub(super) lead: Option<f64>,
    /// Standard uncertainty of the length standard over the length, where declared.
    pub(super) length_ratio: Option<f64>,
    /// Which cycle each reading is of, where it was recorded.
    pub(super) cycles: Option<Vec<usize>>,
    pub(super) covariates: Vec<NumberColumn>,
    pub(super) groups: Vec<String>,
    pub(super) group_noun: String,
    pub(super) plan: AxisPlanSettings,
    pub(super) of_table: AxisTable,
}

impl PositioningCase {
    fn error(&self, source: FtCenterError) -> Error {
        Error::FtCenter { at: Box::new(self.file.clone()), source: Box::new(source) }
    }

    fn estimates(&self, residuals: Option<&[f64]>, conditions: Vec<String>) -> Arc<dyn Estimates> {
        let of = |(i, r): (usize, &AxisReading)| {
            let residual = residuals.map_or(r.deviation, |residuals| residuals[i]);
            PositionResidual {
                point: r.name.clone(),
                target: r.target,
                deviation: r.deviation,
                correction: r.deviation - residual,
                residual,
            }
        };
        let run = AxisRunEstimate::of(&self.readings, self.motion, self.length_ratio, residuals);
        let mut conditions = conditions;
        if self.length_ratio.is_none() {
            conditions.push(
                "the uncertainties of the figures come from the scatter of the cycles alone: the \
                 length standard is not declared (`[noise] length_ppm` or `angle_arcsec`)"
                    .to_owned(),
            );
        }
        let readings = self.readings.iter().enumerate().map(of).collect();
        let positioning = PositioningFigures::of(&run);
        Arc::new(PositioningEstimates { run, positioning, conditions, readings })
    }

    fn recorded(&self) -> Vec<Covariate> {
        let of = |c: &NumberColumn| c.covariate();
        self.covariates.iter().map(of).collect()
    }

    fn run<'r>(&'r self, covariates: &'r [Covariate]) -> AxisRun<'r> {
        AxisRun {
            readings: &self.readings,
            motion: self.motion,
            lead: self.lead,
            cycles: self.cycles.as_deref(),
            covariates,
        }
    }

    fn prepared(&self, shown: Shown) -> Result<Prepared<'_>, Error> {
        let recorded = self.recorded();
        let run = self.run(&recorded);
        let model = positioning_model(&run, &shown, self.sigma).map_err(|e| self.error(e))?;
        let mut covariates = axis_coordinates(&run, target_column(self.motion));
        covariates.extend(recorded.iter().cloned());
        let concrete = Arc::new(model);
        let model: Arc<dyn Model + Send> = Arc::<LinearModel>::clone(&concrete);
        let model: Arc<dyn Model + Send> = Arc::new(Regrouped::new(model, &self.groups));
        let estimates = Box::new(move |closure: &Closure| {
            self.estimates(Some(&closure.residuals_after), empirical_conditions(closure))
        });
        let about: About<'_> = Box::new(move |found| {
            let there = self.run(&recorded).shown_beside(&shown, &*concrete, &found.state);
            (there != shown).then(|| self.prepared(there)).transpose()
        });
        Ok(Prepared { model, covariates, estimates, about: Some(about) })
    }
}

impl Measured for PositioningCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let deviations: Vec<f64> = self.readings.iter().map(|r| r.deviation).collect();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = deviations.len() as f64;
        let chi2 = |sigma: f64| deviations.iter().map(|d| (d / sigma).powi(2)).sum::<f64>() / n;
        let observations =
            deviations.iter().map(|d| Observation { residual: vec![*d], fitted: true }).collect();
        Ok(Fitted {
            estimates: self.estimates(None, Vec::new()),
            observations,
            unit: self.motion.deviation_unit(),
            degrees_of_freedom: deviations.len(),
            chi2_per_dof: self.sigma.map(chi2),
            warnings: Vec::new(),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let shown = self.run(&self.recorded()).shown();
        self.prepared(shown)
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        Ok(Some(self.plan.offer(&self.of_table, &self.readings)))
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        let targets: Vec<[f64; 1]> = self.readings.iter().map(|r| [r.target]).collect();
        let per_target = match self.motion {
            AxisMotion::Linear => 1.0,
            AxisMotion::Rotary => ARCSEC_PER_DEG,
        };
        let spread = per_target * spread_of_places(targets.iter().map(<[f64; 1]>::as_slice));
        Yardstick {
            spread,
            taken_up: 0.0,
            gross: GROSS,
            unmatched: UNMATCHED,
            beyond_physics: BEYOND_PHYSICS,
        }
    }

    fn words(&self) -> Words {
        let unit = self.motion.deviation_unit();
        let sigma = self
            .sigma
            .map_or_else(|| "estimated from the residual".to_owned(), |s| format!("{s} {unit}"));
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        Words {
            declared: vec!["actual = target; nothing is estimated.".to_owned()],
            residual: "actual − target",
            components: &[],
            group_noun: self.group_noun.clone(),
            measured: vec![
                fact("readings", self.readings.len().to_string()),
                fact("standard uncertainty", sigma),
            ],
            places: None,
        }
    }
}

fn target_column(motion: AxisMotion) -> &'static str {
    match motion {
        AxisMotion::Linear => "target_mm",
        AxisMotion::Rotary => "target_deg",
    }
}
