//! Runs along a programmed path: force read beside force asked for, without a head.

use std::sync::Arc;

use force_impedance::{ForceImpedanceError, PathModel, PathOptions, PathSample};
use model_discrepancy::{Closure, Model};
use truing_report::{Curve, CurvePlot, Fact};

use super::ContactForceEstimate;
use super::path_estimates::{PathCell, PathError, PathForceEstimates};
use super::settings::{PATH, Settings};
use crate::Error;
use crate::case::{Columns, Document, Folder, Location, NumberColumn, Positive, group_names};
use crate::count::count;
use crate::estimates::Estimates;
use crate::measured::{
    Fitted, Measured, Observation, Prepared, Reading, Words, empirical_conditions,
};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

const KNOWN: &[&str] = &["run", "time_s", "path_mm", "force_n", "reference_n"];

#[derive(Clone, Debug)]
pub(super) struct PathCase {
    file: Location,
    /// Line of each reading.
    lines: Vec<usize>,
    pub(super) samples: Vec<PathSample>,
    options: PathOptions,
    covariates: Vec<NumberColumn>,
    groups: Option<Vec<String>>,
    group_noun: String,
}

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let table = folder.table(PATH, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let names = columns.texts("run")?;
    let (time_s, path_mm) = (columns.numbers("time_s")?, columns.numbers("path_mm")?);
    let (force_n, reference_n) = (columns.numbers("force_n")?, columns.numbers("reference_n")?);
    let mut runs: Vec<String> = Vec::new();
    let samples = (0..table.n_rows())
        .map(|row| {
            if row == 0 || names[row] != names[row - 1] {
                runs.push(names[row].to_owned());
            }
            PathSample {
                time_s: time_s[row],
                path_mm: path_mm[row],
                force_n: force_n[row],
                reference_n: reference_n[row],
                run: runs.len() - 1,
            }
        })
        .collect();
    let extras = columns.rest(&settings.closure.columns)?;
    let sigma_n = settings.noise.force_n.map(|Positive(sigma)| sigma);
    let mut warnings = Vec::new();
    if sigma_n.is_none() {
        let unknown =
            "no `[noise] force_n`: the standard uncertainty is estimated from the residual";
        warnings.push(unknown.to_owned());
    }
    let unused = [
        ("[head]", settings.head.is_some()),
        ("[impedance]", settings.impedance.is_some()),
        ("[model] force", settings.model.force.is_some()),
    ];
    let set = unused.iter().filter(|(_, is_set)| *is_set);
    warnings.extend(set.map(|(key, _)| format!("`{key}` is not used with {PATH}")));
    warnings.extend(extras.warnings);
    let group = settings.closure.group.as_ref();
    let measured = PathCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        samples,
        options: PathOptions { sigma_n, runs },
        covariates: extras.covariates,
        groups: group_names(group, &table, document)?,
        group_noun: group.map_or_else(|| "run".to_owned(), |g| g.get_ref().clone()),
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: vec![PATH],
    })
}

impl PathCase {
    fn model(&self) -> Result<PathModel, Error> {
        PathModel::new(&self.samples, &self.options).map_err(|source| {
            let line = match source {
                ForceImpedanceError::Sample { index, .. }
                | ForceImpedanceError::TimeNotIncreasing { index, .. } => self.lines.get(index),
                _ => None,
            };
            let at = line.map_or_else(|| self.file.clone(), |line| self.file.clone().line(*line));
            Error::ForceImpedance { at: Box::new(at), source: Box::new(source) }
        })
    }

    /// Estimates with a correction taken off the readings of each cell.
    fn estimates(
        &self,
        model: &PathModel,
        correction_n: Option<&[f64]>,
        conditions: Vec<String>,
    ) -> Arc<dyn Estimates> {
        let mut errors = Vec::new();
        let mut forces = Vec::new();
        for (cell, members) in model.samples().enumerate() {
            let off_n = correction_n.map_or(0.0, |c| c[cell]);
            for &i in members {
                errors.push(self.samples[i].force_n - self.samples[i].reference_n - off_n);
                forces.push(self.samples[i].force_n);
            }
        }
        let n = count(errors.len());
        let contact_force = ContactForceEstimate {
            rms_error_n: Some((errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt()),
            max_error_n: Some(errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()))),
            mean_n: forces.iter().sum::<f64>() / n,
            min_n: forces.iter().copied().fold(f64::INFINITY, f64::min),
            max_n: forces.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        };
        let none = vec![0.0; model.samples().count()];
        let corrections_n = correction_n.unwrap_or(&none);
        let at = |([path_mm, error_n], [_, correction_n]): ([f64; 2], [f64; 2])| PathError {
            path_mm,
            error_n: error_n - correction_n,
            correction_n,
        };
        let profile = model.profile().into_iter().zip(model.profile_of(corrections_n));
        Arc::new(PathForceEstimates {
            contact_force,
            samples: errors.len(),
            samples_left_out: self.samples.len() - errors.len(),
            runs: self.options.runs.len(),
            path: profile.map(at).collect(),
            conditions,
            cells: correction_n.map_or_else(Vec::new, |c| self.cells(model, c)),
        })
    }

    fn cells(&self, model: &PathModel, corrections_n: &[f64]) -> Vec<PathCell> {
        let of = |value: fn(&PathSample) -> f64| {
            model.averaged(&self.samples.iter().map(value).collect::<Vec<_>>())
        };
        let (path_mm, error_n) = (of(|s| s.path_mm), of(|s| s.force_n - s.reference_n));
        (model.samples().enumerate())
            .map(|(cell, of)| PathCell {
                run: self.options.runs[self.samples[of[0]].run].clone(),
                path_mm: path_mm[cell],
                error_n: error_n[cell],
                correction_n: corrections_n[cell],
                residual_n: error_n[cell] - corrections_n[cell],
            })
            .collect()
    }
}

impl Measured for PathCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let model = self.model()?;
        let state = model_discrepancy::State::start(&model);
        let residuals = model.residuals(&state);
        let observations: Vec<Observation> =
            (residuals.iter()).map(|r| Observation { residual: vec![*r], fitted: true }).collect();
        let layout = &model.declared().layout;
        let whitened = |(r, row): (&f64, &model_discrepancy::Row)| (r / row.sigma).powi(2);
        let chi2: f64 = residuals.iter().zip(&layout.rows).map(whitened).sum();
        // Declared noise is that of a reading: their scatter inside the cells counts as well.
        let chi2 = chi2 + model.inside(&state).map_or(0.0, |inside| inside.chi2);
        let readings = model.samples().map(<[usize]>::len).sum::<usize>();
        let left_out = self.samples.len() - readings;
        let [from_mm, to_mm] = model.stretch_mm();
        let warnings = (left_out > 0)
            .then(|| {
                format!(
                    "{left_out} readings are outside {from_mm} to {to_mm} mm, the part of the \
                     path that every run covers, and are left out"
                )
            })
            .into_iter();
        Ok(Fitted {
            degrees_of_freedom: if layout.sigma_declared { readings } else { observations.len() },
            chi2_per_dof: layout.sigma_declared.then(|| chi2 / count(readings)),
            observations,
            unit: "N",
            estimates: self.estimates(&model, None, Vec::new()),
            warnings: warnings.collect(),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let concrete = self.model()?;
        let mut covariates = concrete.covariates();
        covariates.extend(self.covariates.iter().map(|c| c.with(concrete.averaged(&c.values))));
        let concrete = Arc::new(concrete);
        let mut model: Arc<dyn Model + Send> = Arc::<PathModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            let names: Vec<String> = concrete.samples().map(|of| groups[of[0]].clone()).collect();
            model = Arc::new(Regrouped::new(model, &names));
        }
        let estimates = Box::new(move |closure: &Closure| {
            let both = closure.residuals_before.iter().zip(&closure.residuals_after);
            let correction_n: Vec<f64> = both.map(|(before, after)| before - after).collect();
            self.estimates(&concrete, Some(&correction_n), empirical_conditions(closure))
        });
        Ok(Prepared { model, covariates, estimates, about: None })
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        super::suspects::path_yardstick(&self.samples)
    }

    fn words(&self) -> Words {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let noise = self.options.sigma_n.map_or_else(
            || "estimated from the residual".to_owned(),
            |sigma| format!("{sigma} N per reading"),
        );
        Words {
            declared: vec![
                "The force is the one asked for; nothing is estimated. The loop judges means over \
                 equal cells of the path that all runs have in common."
                    .to_owned(),
            ],
            residual: "force read − force asked for",
            components: &[],
            group_noun: self.group_noun.clone(),
            measured: vec![
                fact("runs", self.options.runs.len().to_string()),
                fact("readings", self.samples.len().to_string()),
                fact("standard uncertainty", noise),
            ],
            places: None,
        }
    }

    fn curves(&self) -> Vec<CurvePlot> {
        let Ok(model) = self.model() else { return Vec::new() };
        let curve = |name: String, points: Vec<[f64; 2]>| Curve {
            name,
            points,
            half_widths: Vec::new(),
            joined: true,
        };
        let path_mm = model.averaged(&self.samples.iter().map(|s| s.path_mm).collect::<Vec<_>>());
        let error = |s: &PathSample| s.force_n - s.reference_n;
        let error_n = model.averaged(&self.samples.iter().map(error).collect::<Vec<_>>());
        let run_of: Vec<usize> = model.samples().map(|of| self.samples[of[0]].run).collect();
        let of_run = |(run, name): (usize, &String)| {
            let cells = (0..run_of.len()).filter(|&i| run_of[i] == run);
            curve(name.clone(), cells.map(|i| [path_mm[i], error_n[i]]).collect())
        };
        let mut curves: Vec<Curve> = self.options.runs.iter().enumerate().map(of_run).collect();
        curves.push(curve("mean".to_owned(), model.profile()));
        vec![CurvePlot {
            title: "Force error along the path".to_owned(),
            caption: "Force read − force asked for, each run averaged over cells of the path, and \
                      the mean of all runs."
                .to_owned(),
            x_title: "path, mm".to_owned(),
            y_title: "force error, N".to_owned(),
            curves,
        }]
    }
}
