use std::sync::Arc;

use ft_center::{AxisMotion, AxisReading, AxisRun, Displacement, DisplacementModel};
use model_discrepancy::{Closure, Covariate, Model, Quantity, Shown};
use truing_report::Fact;

use super::displacement_estimates::{DisplacementEstimates, DisplacementResidual};
use super::settings::{DISPLACEMENTS, Settings, error, unused};
use crate::Error;
use crate::case::{Columns, Document, Folder, Location, NumberColumn, Positive, group_names};
use crate::estimates::Estimates;
use crate::kinds::positioning::{
    AxisPlanSettings, AxisTable, approaches, has_directions, names_of, one_axis,
};
use crate::kinds::{AxisRunEstimate, Offer, PositioningFigures};
use crate::measured::{
    About, Fitted, Measured, Observation, Prepared, Reading, Words, empirical_conditions,
};
use crate::regrouped::Regrouped;
use crate::suspect::Yardstick;

const KNOWN: &[&str] = &["point", "commanded_mm", "solved_mm", "direction"];

#[derive(Clone, Debug)]
pub(super) struct DisplacementCase {
    file: Location,
    pub(super) rows: Vec<Displacement>,
    /// The same as a run over targets.
    readings: Vec<AxisReading>,
    sigma_mm: Option<f64>,
    covariates: Vec<NumberColumn>,
    groups: Option<Vec<String>>,
    group_noun: String,
    plan: AxisPlanSettings,
    of_table: AxisTable,
}

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let table = folder.table(DISPLACEMENTS, KNOWN)?;
    one_axis(&table)?;
    let mut columns = Columns::new(&table, KNOWN);
    let names = columns.texts("point")?;
    let commanded_mm = columns.numbers("commanded_mm")?;
    let solved_mm = columns.numbers("solved_mm")?;
    let lines: Vec<usize> = (0..table.n_rows()).map(|row| table.line(row)).collect();
    let given: Vec<String> = names.into_iter().map(str::to_owned).collect();
    let names = names_of(&given, &lines);
    let approaches =
        if has_directions(&table) { approaches(&mut columns)? } else { vec![None; table.n_rows()] };
    let readings: Vec<AxisReading> = (names.iter().zip(approaches).enumerate())
        .map(|(row, (name, approach))| AxisReading {
            name: name.clone(),
            target: commanded_mm[row],
            deviation: solved_mm[row] - commanded_mm[row],
            approach,
        })
        .collect();
    let rows = (names.into_iter().zip(commanded_mm).zip(solved_mm))
        .map(|((point, commanded_mm), solved_mm)| Displacement { point, commanded_mm, solved_mm })
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
            ("[model] gravity", settings.model.gravity.is_some()),
            ("[noise] force_n", settings.noise.force_n.is_some()),
            ("[noise] moment_nmm", settings.noise.moment_nmm.is_some()),
        ],
        DISPLACEMENTS,
    );
    let sigma_mm = settings.noise.displacement_mm.map(|Positive(sigma)| sigma);
    if sigma_mm.is_none() {
        warnings.push(
            "no `[noise] displacement_mm`: the standard uncertainty is estimated from the residual"
                .to_owned(),
        );
    }
    warnings.extend(extras.warnings);
    let group = settings.closure.group.as_ref();
    let of_table = AxisTable {
        file: DISPLACEMENTS,
        target: "commanded_mm",
        reading: ("solved_mm", true),
        has_direction: has_directions(&table),
        has_cycle: false,
    };
    let measured = DisplacementCase {
        plan: settings.plan.of_axis(),
        of_table,
        file: table.at_file(),
        rows,
        readings,
        sigma_mm,
        covariates: extras.covariates,
        groups: group_names(group, &table, document)?,
        group_noun: group.map_or_else(|| "point".to_owned(), |g| g.get_ref().clone()),
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: vec![DISPLACEMENTS],
    })
}

impl DisplacementCase {
    /// The table as a run of an axis; `None` where no target repeats and none was approached both ways.
    fn run<'r>(&'r self, covariates: &'r [Covariate]) -> Option<AxisRun<'r>> {
        let motion = AxisMotion::Linear;
        let run =
            AxisRun { readings: &self.readings, motion, lead: None, cycles: None, covariates };
        run.is_a_run().then_some(run)
    }

    fn recorded(&self) -> Vec<Covariate> {
        recorded(&self.covariates, |c| c.values.clone()).collect()
    }

    fn prepared(&self, shown: Shown) -> Result<Prepared<'_>, Error> {
        let mut model = DisplacementModel::new(&self.rows, self.sigma_mm)
            .map_err(|e| error(self.file.clone(), e))?;
        let mut covariates = model.covariates();
        let recorded = self.recorded();
        if let Some(run) = self.run(&recorded) {
            model = model.with_axis(run.terms(&shown));
        }
        covariates.extend(self.directions());
        covariates.extend(recorded.iter().cloned());
        let concrete = Arc::new(model);
        let mut model: Arc<dyn Model + Send> = Arc::<DisplacementModel>::clone(&concrete);
        if let Some(groups) = &self.groups {
            model = Arc::new(Regrouped::new(model, groups));
        }
        let estimates = Box::new(move |closure: &Closure| {
            self.estimates(Some(&closure.residuals_after), empirical_conditions(closure))
        });
        let about: About<'_> = Box::new(move |found| {
            let Some(run) = self.run(&recorded) else { return Ok(None) };
            let there = run.shown_beside(&shown, &*concrete, &found.state);
            (there != shown).then(|| self.prepared(there)).transpose()
        });
        Ok(Prepared { model, covariates, estimates, about: Some(about) })
    }

    /// Which way the axis came, where every row says so.
    fn directions(&self) -> Option<Covariate> {
        let signs = self.readings.iter().map(|r| Some(r.approach?.sign()));
        let values = signs.collect::<Option<Vec<f64>>>()?;
        Some(Covariate::recorded("direction", Quantity::Other, values))
    }

    fn estimates(&self, freed: Option<&[f64]>, conditions: Vec<String>) -> Arc<dyn Estimates> {
        let residual =
            |i: usize| freed.map_or(self.readings[i].deviation, |residuals| residuals[i]);
        let run =
            (self.run(&[])).map(|run| AxisRunEstimate::of(run.readings, run.motion, None, freed));
        let points = (self.rows.iter().enumerate())
            .map(|(i, row)| DisplacementResidual {
                point: row.point.clone(),
                commanded_mm: row.commanded_mm,
                solved_mm: row.solved_mm,
                correction_mm: row.solved_mm - row.commanded_mm - residual(i),
                corrected_mm: row.commanded_mm + residual(i),
                residual_mm: residual(i),
            })
            .collect();
        Arc::new(DisplacementEstimates {
            positioning: run.as_ref().map(PositioningFigures::of),
            frame: None,
            centers: Vec::new(),
            conditions,
            run,
            points,
        })
    }
}

impl Measured for DisplacementCase {
    fn fit(&self) -> Result<Fitted, Error> {
        let residuals: Vec<f64> =
            self.rows.iter().map(|row| row.solved_mm - row.commanded_mm).collect();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = residuals.len() as f64;
        let chi2_per_dof = self
            .sigma_mm
            .map(|sigma_mm| residuals.iter().map(|r| (r / sigma_mm).powi(2)).sum::<f64>() / n);
        let observations =
            (residuals.iter()).map(|r| Observation { residual: vec![*r], fitted: true }).collect();
        Ok(Fitted {
            estimates: self.estimates(None, Vec::new()),
            observations,
            unit: "mm",
            degrees_of_freedom: residuals.len(),
            chi2_per_dof,
            warnings: Vec::new(),
        })
    }

    fn prepare(&self) -> Result<Prepared<'_>, Error> {
        let recorded = self.recorded();
        let shown = self.run(&recorded).map_or_else(Shown::default, |run| run.shown());
        self.prepared(shown)
    }

    fn offer(&self) -> Result<Option<Offer>, Error> {
        Ok(Some(self.plan.offer(&self.of_table, &self.readings)))
    }

    fn yardstick(&self, _: &Fitted) -> Yardstick {
        super::suspects::displacement_yardstick(&self.rows)
    }

    fn words(&self) -> Words {
        let sigma = self
            .sigma_mm
            .map_or_else(|| "estimated from the residual".to_owned(), |s| format!("{s} mm"));
        Words {
            declared: vec!["solved = commanded; nothing is estimated.".to_owned()],
            residual: "solved − commanded",
            components: &[],
            group_noun: self.group_noun.clone(),
            measured: vec![Fact { name: "standard uncertainty".to_owned(), value: sigma }],
            places: None,
        }
    }
}

/// Columns recorded by the user as covariates of the loop.
pub(super) fn recorded<'c>(
    columns: &'c [NumberColumn],
    values: impl Fn(&NumberColumn) -> Vec<f64> + 'c,
) -> impl Iterator<Item = Covariate> + 'c {
    columns
        .iter()
        .map(move |column| Covariate::recorded(&column.name, column.quantity, values(column)))
}
