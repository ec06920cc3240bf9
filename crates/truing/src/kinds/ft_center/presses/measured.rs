use std::sync::{Arc, OnceLock};

use ft_center::{
    Contact, FtCenterError, Handedness, HandednessSource, LocateOptions, Located, OrbitOptions,
    Press, PressModel, PressRole, SavedFrame, SolvedPress, locate, locate_in, solve_presses,
};
use geometry::PlanarMap;
use model_discrepancy::{Closure, Covariate, Model};
use truing_report::Fact;

use super::estimates::{FtCenterEstimates, Setting};
use super::repeatability::RepeatabilityEstimate;
use super::saved::{far_from, nothing_fitted};
use crate::Error;
use crate::case::{Location, NumberColumn};
use crate::count::count;
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::kinds::ft_center::plan::{Pressed, presses as offered_presses};
use crate::kinds::ft_center::plan_settings::SensorPlanSettings;
use crate::kinds::ft_center::settings::{ToleranceSettings, error};
use crate::measured::{
    About, Fitted, Measured, Observation, Places, Prepared, Words, empirical_conditions,
};
use crate::monitor::LiveFrame;
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

/// A case of presses as read.
#[derive(Clone, Debug)]
pub(in crate::kinds::ft_center) struct PressCase {
    pub(super) presses_file: Location,
    pub(super) wrench_file: Location,
    /// Lines of the samples, per press.
    pub(super) lines: Vec<Vec<usize>>,
    pub(in crate::kinds::ft_center) presses: Vec<Press>,
    pub(super) contact: Contact,
    pub(super) orbit: OrbitOptions,
    pub(super) options: LocateOptions,
    /// The frame where it was found before.
    pub(super) saved: Option<SavedFrame>,
    pub(super) tolerance: ToleranceSettings,
    pub(super) plan: SensorPlanSettings,
    pub(super) document: Location,
    /// One value per press.
    pub(super) covariates: Vec<NumberColumn>,
    /// One name per press.
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_noun: String,
    pub(super) solved: OnceLock<Vec<SolvedPress>>,
}

impl PressCase {
    /// The records, reduced once: they are the long part of the work.
    fn solved(&self) -> Result<&[SolvedPress], Error> {
        if let Some(solved) = self.solved.get() {
            return Ok(solved);
        }
        let solved = solve_presses(&self.presses, &self.contact, &self.orbit)
            .map_err(|e| self.record_error(e))?;
        Ok(self.solved.get_or_init(|| solved))
    }

    fn located(&self, presses: &[SolvedPress]) -> Result<Located, Error> {
        let located = match &self.saved {
            Some(saved) => locate_in(saved, presses, &self.contact, self.options.noise),
            None => locate(presses, &self.contact, &self.options),
        };
        located.map_err(|e| error(self.presses_file.clone(), e))
    }

    fn setting(&self) -> Setting {
        Setting { z0_mm: self.contact.z0_mm, tolerance: self.tolerance }
    }

    /// Presses at known positions: the observations.
    fn known(&self) -> impl Iterator<Item = &Press> {
        self.presses.iter().filter(|p| p.role != PressRole::Locate)
    }

    /// Puts what is wrong with a record to its line of the table.
    fn record_error(&self, source: FtCenterError) -> Error {
        let mut at = self.wrench_file.clone();
        if let FtCenterError::Press { name, source } = &source {
            let press = self.presses.iter().position(|p| p.name == *name);
            let lines = press.map(|press| &self.lines[press]);
            let index = match **source {
                FtCenterError::TimeNotIncreasing { index, .. }
                | FtCenterError::NotFinite { index } => index,
                _ => 0,
            };
            if let Some(line) = lines.and_then(|lines| lines.get(index)) {
                at = at.line(*line);
            }
        }
        error(at, source)
    }
}

impl PressCase {
    fn warnings(&self, located: &Located, presses: &[SolvedPress]) -> Vec<String> {
        let Some(saved) = &self.saved else { return warnings(located, presses) };
        let commanded = presses.iter().map(|p| (p.name.clone(), p.machine_mm));
        let mut all = far_from(saved, commanded);
        let found = located.centers.iter().map(|c| (c.press.clone(), c.machine_mm));
        for doubt in far_from(saved, found) {
            if !all.contains(&doubt) {
                all.push(doubt);
            }
        }
        all
    }

    fn prepared<'c>(
        &'c self,
        model: PressModel,
        presses: &'c [SolvedPress],
        covariates: Vec<Covariate>,
    ) -> Prepared<'c> {
        let groups: Option<Vec<String>> = self
            .groups
            .as_ref()
            .map(|groups| model.observed().iter().map(|press| groups[*press].clone()).collect());
        let concrete = Arc::new(model);
        let at = Arc::clone(&concrete);
        let mut model: Arc<dyn Model + Send> = Arc::<PressModel>::clone(&concrete);
        if let Some(groups) = &groups {
            model = Arc::new(Regrouped::new(model, groups));
        }
        let estimates = Box::new(move |closure: &Closure| -> Arc<dyn Estimates> {
            let mut located = concrete.located(closure);
            located.conditions.extend(empirical_conditions(closure));
            Arc::new(FtCenterEstimates::of(&located, presses, self.setting()))
        });
        let along = covariates.clone();
        let about: About<'_> = Box::new(move |found| {
            let there = at.about_found(&found.state);
            Ok(there.map(|there| self.prepared(there, presses, along.clone())))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }
}

impl Measured for PressCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let presses = self.solved()?;
        let located = self.located(presses)?;
        let observations: Vec<Observation> = (located.centers.iter())
            .filter(|c| c.role != PressRole::Locate)
            .map(|c| Observation {
                residual: vec![c.offset_mm.x, c.offset_mm.y],
                fitted: c.role == PressRole::Frame,
            })
            .collect();
        let frame = &located.frame;
        let estimates = FtCenterEstimates::of(&located, presses, self.setting());
        let mut warnings = self.warnings(&located, presses);
        let held = estimates.repeatability.iter().filter(|found| found.conformity.is_some());
        warnings.extend(held.map(RepeatabilityEstimate::sentence));
        let fitted = self.saved.is_none();
        let redundant = fitted && frame.degrees_of_freedom > 0 && self.options.noise.is_some();
        let chi2_per_dof = if redundant {
            let model = PressModel::new(presses, &self.contact, &self.options, &[])
                .map_err(|e| error(self.presses_file.clone(), e))?;
            Some(declared_chi2(&model, &observations) / count(frame.degrees_of_freedom))
        } else {
            None
        };
        Ok(Fitted {
            observations,
            unit: "mm",
            degrees_of_freedom: if fitted { frame.degrees_of_freedom } else { 0 },
            chi2_per_dof,
            warnings,
            estimates: Arc::new(estimates),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        if self.saved.is_some() {
            return Err(nothing_fitted(self.presses_file.clone()));
        }
        let presses = self.solved()?;
        let known: Vec<usize> =
            (0..presses.len()).filter(|press| presses[*press].role != PressRole::Locate).collect();
        let recorded: Vec<Covariate> = (self.covariates.iter())
            .map(|c| c.with(known.iter().map(|press| c.values[*press]).collect()))
            .collect();
        let concrete = PressModel::new(presses, &self.contact, &self.options, &recorded)
            .map_err(|e| error(self.presses_file.clone(), e))?;
        let mut covariates = concrete.covariates();
        covariates.extend(recorded);
        Ok(self.prepared(concrete, presses, covariates))
    }

    fn rows(&self) -> Option<Vec<usize>> {
        let is_known = |&press: &usize| self.presses[press].role != PressRole::Locate;
        Some((0..self.presses.len()).filter(is_known).collect())
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        if self.saved.is_some() {
            return Ok(None);
        }
        let solved = self.solved()?;
        let located = self.located(solved)?;
        let ends = |i: usize| solved[i].orbit.span_s;
        let pressed = Pressed {
            presses: &self.presses,
            solved,
            located: &located,
            contact: &self.contact,
            times: (1..solved.len()).all(|i| ends(i - 1)[1] < ends(i)[0]),
        };
        offered_presses((&self.plan, &self.document), &pressed).map(Some)
    }

    fn live(&self) -> Result<Option<LiveFrame>, Error> {
        let located = self.located(self.solved()?)?;
        let (frame, commanded) = (&located.frame, &located.commanded);
        let there = frame.sensor_from_machine().linear * commanded.scale;
        let Some(linear) = there.try_inverse() else { return Ok(None) };
        let translation_mm = frame.pivot_mm.coords - linear * commanded.image_mm.coords;
        Ok(Some(LiveFrame {
            machine_from_sensor: PlanarMap { linear, translation_mm },
            z0_mm: self.contact.z0_mm,
            min_fz_n: self.contact.min_fz_n,
        }))
    }

    fn known_before(&self) -> Option<usize> {
        self.saved.map(|saved| saved.degrees_of_freedom)
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        crate::kinds::ft_center::suspects::press_yardstick(&self.presses)
    }

    fn words(&self) -> Words {
        let noise = self.options.noise.map_or_else(
            || "estimated from the records".to_owned(),
            |n| format!("{} N, {} N·mm per reading", n.force_n, n.moment_nmm),
        );
        let samples: usize = self.presses.iter().map(|p| p.record.len()).sum();
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        Words {
            declared: vec![
                "Centre of pressure in the contact plane: x = (z0 Fx − My)/Fz, y = (Mx + z0 \
                 Fy)/Fz; the answer of a press is the centre of its orbit."
                    .to_owned(),
                if self.saved.is_some() {
                    "Sensor = planar map of machine, found before and given by `[frame] from`."
                } else {
                    "Sensor = planar rigid map of machine; its angle and translation are estimated \
                     from the presses at known positions."
                }
                .to_owned(),
            ],
            residual: "solved − expected centre, machine frame",
            components: &["x", "y"],
            group_noun: self.group_noun.clone(),
            measured: vec![
                fact("presses", self.presses.len().to_string()),
                fact("samples", samples.to_string()),
                fact("contact plane z0", format!("{} mm", self.contact.z0_mm)),
                fact("standard uncertainty", noise),
            ],
            places: Some(Places {
                x_title: "machine x, mm",
                y_title: "machine y, mm",
                at: self.known().map(|p| [p.machine_mm.x, p.machine_mm.y]).collect(),
                names: self.known().map(|p| p.name.clone()).collect(),
                facets: Vec::new(),
            }),
        }
    }
}

/// χ² of the frame presses with the declared noise of their records alone: how well the head
/// seats, which the covariances contain, is what it must show.
fn declared_chi2(model: &PressModel, observations: &[Observation]) -> f64 {
    let layout = &model.declared().layout;
    let fitted = layout.rows.iter().filter(|r| r.reported && observations[r.observation].fitted);
    fitted.map(|r| (observations[r.observation].residual[r.component] / r.sigma).powi(2)).sum()
}

fn warnings(located: &Located, presses: &[SolvedPress]) -> Vec<String> {
    let mut warnings = Vec::new();
    let frame = &located.frame;
    match (frame.handedness_source, frame.handedness) {
        (HandednessSource::Assumed, _) => warnings.push(
            "the frame presses do not tell whether the sensor's z opposes the machine's; \
             taken to agree: press off the line, or set `[model] handedness`"
                .to_owned(),
        ),
        (HandednessSource::Measured, Handedness::Opposed) => warnings.push(format!(
            "the sensor's z opposes the machine's: the planar map is a reflection (a proper \
             rotation misses by {:.3} mm rms)",
            frame.other_handedness_rms_mm
        )),
        _ => {}
    }
    let of_records = presses.iter().map(|p| 0.5 * p.orbit.covariance_mm2.trace()).sum::<f64>()
        / count(presses.len());
    if located.seat_mm.powi(2) > of_records {
        warnings.push(format!(
            "presses scatter by {:.4} mm along each axis beyond the noise of their records: \
             the head repeats its place no better, or an effect is missing; every uncertainty \
             includes this scatter",
            located.seat_mm
        ));
    }
    warnings
}
