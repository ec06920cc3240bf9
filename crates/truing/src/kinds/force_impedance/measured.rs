use std::sync::Arc;

use force_impedance::{
    Discretisation, ForceFormula, ForceImpedanceError, Head, Impedance, ImpedanceParameters,
    LogModel, LogOptions, LogSample, LoggedForce, solve_log,
};
use model_discrepancy::{Closure, Covariate, Model};
use truing_report::{Curve, CurvePlot, Fact};

use super::estimates::{
    ContactForceEstimate, ForceBlock, ForceImpedanceEstimates, ImpedanceEstimate,
};
use super::plan::{self, Logged};
use super::plan_settings::HeadPlanSettings;
use crate::Error;
use crate::case::{Location, NumberColumn};
use crate::count::count;
use crate::estimates::Estimates;
use crate::kinds::Offer;
use crate::measured::{
    About, Fitted, Measured, Observation, Prepared, Words, empirical_conditions,
};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

/// A mean disagreement of the lengths is told when it is this many times its scatter.
const CLEAR_DISAGREEMENT: f64 = 3.0;
/// Below this a disagreement moves no force by a digit that anyone reads.
const LEAST_DISAGREEMENT_MM: f64 = 1e-3;

/// A log as read.
#[derive(Clone, Debug)]
pub(super) struct LogCase {
    pub(super) file: Location,
    /// Line of each sample.
    pub(super) lines: Vec<usize>,
    pub(super) head: Head,
    pub(super) impedance: Option<ImpedanceParameters>,
    pub(super) samples: Vec<LogSample>,
    pub(super) options: LogOptions,
    /// Name of the segment of each sample, where no column has it.
    pub(super) unnamed: Option<Vec<String>>,
    pub(super) plan: HeadPlanSettings,
    /// One value per sample.
    pub(super) covariates: Vec<NumberColumn>,
    /// One name per sample.
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_noun: String,
}

impl LogCase {
    fn solved(&self) -> Result<Vec<LoggedForce>, Error> {
        solve_log(&self.head, &self.samples, self.options.formula).map_err(|e| self.error(e))
    }

    /// Puts what is wrong with a sample to its line of the table.
    fn error(&self, source: ForceImpedanceError) -> Error {
        let line = match source {
            ForceImpedanceError::Sample { index, .. }
            | ForceImpedanceError::TimeNotIncreasing { index, .. } => self.lines.get(index),
            _ => None,
        };
        let at = line.map_or_else(|| self.file.clone(), |line| self.file.clone().line(*line));
        Error::ForceImpedance { at: Box::new(at), source: Box::new(source) }
    }

    /// Estimates with `corrections_n`, one per sample, taken off the force.
    fn estimates(
        &self,
        solved: &[LoggedForce],
        residuals_n: Option<&[f64]>,
        corrections_n: &[f64],
        (conditions, blocks): (Vec<String>, Vec<ForceBlock>),
    ) -> Arc<dyn Estimates> {
        let n = count(solved.len());
        let rms =
            |values: &mut dyn Iterator<Item = f64>| (values.map(|v| v * v).sum::<f64>() / n).sqrt();
        let normal = || {
            let off = corrections_n.iter().copied().chain(std::iter::repeat(0.0));
            solved.iter().zip(off).map(|(s, off_n)| s.normal_n - off_n)
        };
        let ratios: Vec<f64> = (solved.iter().zip(normal()).filter(|(_, n)| *n > 0.0))
            .map(|(s, normal_n)| s.tangential_n / normal_n)
            .collect();
        let contact_force = ContactForceEstimate {
            rms_error_n: residuals_n.map(|r| rms(&mut r.iter().copied())),
            max_error_n: residuals_n.map(|r| r.iter().fold(0.0, |m: f64, v| m.max(v.abs()))),
            mean_n: normal().sum::<f64>() / n,
            min_n: normal().fold(f64::INFINITY, f64::min),
            max_n: normal().fold(f64::NEG_INFINITY, f64::max),
        };
        Arc::new(ForceImpedanceEstimates {
            contact_force,
            samples: solved.len(),
            friction_ratio: (!ratios.is_empty())
                .then(|| ratios.iter().sum::<f64>() / count(ratios.len())),
            preload_min_n: solved.iter().map(|s| s.preload_n).fold(f64::INFINITY, f64::min),
            consistency_mean_mm: solved.iter().map(|s| s.consistency_mm).sum::<f64>() / n,
            consistency_rms_mm: rms(&mut solved.iter().map(|s| s.consistency_mm)),
            impedance: self.impedance.map(|p| impedance(&p, self.interval_s())),
            conditions,
            blocks,
        })
    }

    /// Median time between samples.
    fn interval_s(&self) -> f64 {
        let mut steps: Vec<f64> = (self.samples.windows(2))
            .filter(|pair| pair[0].segment == pair[1].segment)
            .map(|pair| pair[1].time_s - pair[0].time_s)
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN)
    }

    fn warnings(&self, solved: &[LoggedForce]) -> Vec<String> {
        let mut warnings = Vec::new();
        let n = count(solved.len());
        let mean = solved.iter().map(|s| s.consistency_mm).sum::<f64>() / n;
        let scatter = solved.iter().map(|s| (s.consistency_mm - mean).powi(2)).sum::<f64>() / n;
        if mean.abs() > LEAST_DISAGREEMENT_MM && mean.abs() > CLEAR_DISAGREEMENT * scatter.sqrt() {
            warnings.push(format!(
                "the four lengths disagree by {:.1} µm on average: a length sensor has a zero \
                 error of {:.1} µm or more",
                mean * 1e3,
                mean.abs() * 3f64.sqrt() * 1e3
            ));
        }
        if let Some(loose) = solved.iter().position(|s| s.preload_n <= 0.0) {
            warnings.push(format!(
                "line {}: the legs are not braced against each other, their joints have play",
                self.lines[loose]
            ));
        }
        if let Some(e) = self
            .impedance
            .and_then(|p| Impedance::new(p, self.interval_s(), Discretisation::ExactHold).err())
        {
            warnings.push(format!("[impedance]: {e}"));
        }
        warnings
    }
}

fn impedance(p: &ImpedanceParameters, interval_s: f64) -> ImpedanceEstimate {
    let (m, d, k) = (p.mass_kg / 1e3, p.damping_ns_per_mm, p.stiffness_n_per_mm);
    ImpedanceEstimate {
        interval_s,
        time_constant_s: m / d,
        natural_hz: (k > 0.0).then(|| (k / m).sqrt() / std::f64::consts::TAU),
        damping_ratio: (k > 0.0).then(|| d / (2.0 * (k * m).sqrt())),
    }
}

impl LogCase {
    fn prepared(&self, model: LogModel, covariates: Vec<Covariate>) -> Prepared<'_> {
        let concrete = Arc::new(model);
        let at = Arc::clone(&concrete);
        let mut model: Arc<dyn Model + Send> = Arc::<LogModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            let names: Vec<String> =
                concrete.samples().map(|samples| groups[samples.start].clone()).collect();
            model = Arc::new(Regrouped::new(model, &names));
        }
        let estimates = Box::new(move |closure: &Closure| {
            let residuals_n = corrected(&concrete, closure);
            let mut conditions = concrete.conditions(&closure.state);
            conditions.extend(empirical_conditions(closure));
            let blocks = blocks(&concrete, closure);
            let corrections_n: Vec<f64> = (blocks.iter())
                .flat_map(|b| std::iter::repeat_n(b.correction_n, b.samples))
                .collect();
            let solved = concrete.solved();
            let residuals_n = residuals_n.as_deref();
            self.estimates(solved, residuals_n, &corrections_n, (conditions, blocks))
        });
        let along = covariates.clone();
        let about: About<'_> = Box::new(move |found| {
            let there = at.about_found(&found.state);
            Ok(there.map(|there| self.prepared(there, along.clone())))
        });
        Prepared { model, covariates, estimates, about: Some(about) }
    }
}

impl Measured for LogCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let solved = self.solved()?;
        let forces: Option<Vec<f64>> = solved.iter().map(|s| s.residual_n).collect();
        let residual = |s: &LoggedForce| s.residual_n.unwrap_or(s.consistency_mm);
        let observations = (solved.iter())
            .map(|s| Observation { residual: vec![residual(s)], fitted: true })
            .collect();
        let chi2_per_dof = forces.as_ref().and_then(|forces| {
            let sigma_n = self.options.sigma_n?;
            let whitened = |(r, s): (&f64, &LoggedForce)| (r / (sigma_n * s.noise_gain)).powi(2);
            Some(forces.iter().zip(&solved).map(whitened).sum::<f64>() / count(forces.len()))
        });
        Ok(Fitted {
            estimates: self.estimates(&solved, forces.as_deref(), &[], (Vec::new(), Vec::new())),
            observations,
            unit: if forces.is_some() { "N" } else { "mm" },
            degrees_of_freedom: solved.len(),
            chi2_per_dof,
            warnings: self.warnings(&solved),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let recorded: Vec<Covariate> =
            (self.covariates.iter()).map(NumberColumn::covariate).collect();
        let concrete = LogModel::new(&self.head, &self.samples, &self.options, &recorded)
            .map_err(|e| self.error(e))?;
        let mut covariates = concrete.covariates(&self.samples);
        covariates.extend(
            recorded
                .iter()
                .map(|c| Covariate { values: concrete.averaged(&c.values), ..c.clone() }),
        );
        Ok(self.prepared(concrete, covariates))
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        let logged = Logged {
            head: &self.head,
            formula: self.options.formula,
            samples: &self.samples,
            solved: &self.solved()?,
            segments: self.unnamed.clone(),
        };
        Ok(Some(plan::offer(&self.plan, &logged)))
    }

    fn rows(&self) -> Option<Vec<usize>> {
        Some(LogModel::ranges(&self.samples).into_iter().map(|samples| samples.start).collect())
    }

    fn yardstick(&self, fitted: &Fitted) -> Yardstick {
        super::suspects::log_yardstick(&self.samples, fitted)
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let noise = self.options.sigma_n.map_or_else(
            || "estimated from the residual".to_owned(),
            |sigma| format!("{sigma} N per force reading"),
        );
        let formula = match self.options.formula {
            ForceFormula::FullBalance => {
                "Contact force from four load cells: balance along the tool's axis and of the two \
                 moments across it about the joint, friction and the declared weight included."
            }
            ForceFormula::Published => {
                "Contact force as published: Σ F_i cos γ_i + F4 over the cosine between normal \
                 and axis, without friction and weight."
            }
        };
        let has_reference = self.samples.iter().all(|s| s.reference_n.is_some());
        Words {
            declared: vec![
                formula.to_owned(),
                "Nothing is estimated; the loop judges means over short blocks of samples."
                    .to_owned(),
            ],
            residual: if has_reference {
                "normal force from the legs − reference"
            } else {
                "disagreement of the four lengths"
            },
            components: &[],
            group_noun: self.group_noun.clone(),
            measured: vec![
                fact("samples", self.samples.len().to_string()),
                fact("sampling interval", format!("{:.6} s", self.interval_s())),
                fact("standard uncertainty", noise),
            ],
            places: None,
        }
    }

    fn curves(&self) -> Vec<CurvePlot> {
        let Ok(solved) = self.solved() else { return Vec::new() };
        let runs_on = self.samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let x = |i: usize| if runs_on { self.samples[i].time_s } else { count(i) };
        let curve = |name: &str, y: &dyn Fn(usize) -> Option<f64>| Curve {
            name: name.to_owned(),
            points: (0..solved.len()).filter_map(|i| Some([x(i), y(i)?])).collect(),
            half_widths: Vec::new(),
            joined: true,
        };
        let x_title = if runs_on { "time, s" } else { "sample" };
        let straight = self.head.start_tip_mm().coords;
        let forces = [
            curve("from the legs", &|i| Some(solved[i].normal_n)),
            curve("reference", &|i| self.samples[i].reference_n),
            curve("friction", &|i| Some(solved[i].tangential_n)),
        ];
        vec![
            CurvePlot {
                title: "Contact force".to_owned(),
                caption: "Normal force from the legs and as the reference read it, and the \
                          friction across it."
                    .to_owned(),
                x_title: x_title.to_owned(),
                y_title: "force, N".to_owned(),
                curves: forces.into_iter().filter(|c| !c.points.is_empty()).collect(),
            },
            CurvePlot {
                title: "Correction".to_owned(),
                caption: "How far the tool stood off its programmed point along the outward \
                          normal; negative is into the workpiece."
                    .to_owned(),
                x_title: x_title.to_owned(),
                y_title: "correction, mm".to_owned(),
                curves: vec![curve("correction", &|i| {
                    Some((solved[i].tip_mm - straight).dot(&self.samples[i].normal))
                })],
            },
        ]
    }
}

/// Residual of each sample with what was added to its block taken off.
fn corrected(model: &LogModel, closure: &Closure) -> Option<Vec<f64>> {
    let mut residuals: Vec<f64> =
        model.solved().iter().map(|s| s.residual_n).collect::<Option<_>>()?;
    let blocks = closure.residuals_after.iter().zip(&closure.residuals_before);
    for (samples, (after, before)) in model.samples().zip(blocks) {
        residuals[samples].iter_mut().for_each(|r| *r += after - before);
    }
    Some(residuals)
}

/// What the loop leaves of every block; an empirical correction is one of the force.
fn blocks(model: &LogModel, closure: &Closure) -> Vec<ForceBlock> {
    let mut corrections_n = model.force_corrections_n(&closure.state);
    if model.declared().layout.unit == "N" {
        for empirical in &closure.empirical {
            // A correction is what is predicted, and lowers the residual.
            for (correction, added) in corrections_n.iter_mut().zip(empirical.added().iter()) {
                *correction -= added;
            }
        }
    }
    let forces_n = model.forces_n();
    (model.samples().enumerate())
        .map(|(i, samples)| ForceBlock {
            first_sample: samples.start,
            samples: samples.len(),
            force_n: forces_n[i],
            correction_n: corrections_n[i],
            residual: closure.residuals_after[i],
        })
        .collect()
}
