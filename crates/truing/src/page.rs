//! Reports: a case and its answer as the input of a page.

use std::collections::BTreeMap;
use std::path::Path;

use model_discrepancy::{Model, State};
use truing_report::{
    Arrow, Budget, BudgetResult, DeviationMap, Evidence, ExtraPlot, Fact, Form, IndexEntry,
    Mistake, ParameterRow, Published, ReportInput, Rms, VectorMap, render,
};

use crate::estimates::Estimates;
use crate::file::read_text;
use crate::form::filled;
use crate::measured::{Places, Prepared, Words};
use crate::monte_carlo::{DrawnParameter, MonteCarlo};
use crate::solved::Solved;
use crate::text_table::number;
use crate::{Carried, Case, Closed, Error, Suspect};

/// The report of a solved case: one self-contained HTML page.
///
/// # Errors
///
/// As [`solve`](crate::solve).
pub fn solve_report(case: &Case, solved: &Solved) -> Result<String, Error> {
    let prepared = case.measured.prepare()?;
    let residuals = declared_residuals(&*prepared.model, solved);
    let parameters = parameters(&*solved.estimates, None);
    let evidence = Evidence::Solved { residuals: &residuals };
    let own = solved.estimates.plots();
    let input = (&[][..], None);
    let budget = solved.monte_carlo.as_ref().map(budget);
    let form = filled(solved.estimates.form(), &solved.conformity, case.provenance.as_ref());
    let forms = (form.as_ref(), budget.as_ref());
    Ok(page(case, &prepared, (&parameters, evidence, own), input, forms, (&[], &solved.warnings)))
}

fn mistake(suspect: &Suspect) -> Mistake {
    let own = format!("{} [{}]", suspect.effect, suspect.subject);
    Mistake {
        names: [vec![own], suspect.indistinguishable_from.clone()].concat(),
        subject: suspect.subject.clone(),
        description: suspect.description.clone(),
    }
}

/// The report of a closed loop: one self-contained HTML page.
///
/// # Errors
///
/// As [`solve`](crate::solve).
pub fn loop_report(case: &Case, closed: &Closed) -> Result<String, Error> {
    let case = closed.corrected.as_deref().unwrap_or(case);
    let (prepared, matched) = case.prepare()?;
    let declared = case.measured.fit()?;
    let parameters = parameters(&*declared.estimates, Some(&*closed.estimates));
    let evidence = Evidence::Closed(&closed.closure);
    // The page shows the closure's own warnings by itself.
    let doubts = matched.map(|m| m.warnings).unwrap_or_default();
    let warnings: Vec<String> = (case.warnings.iter())
        .chain(&doubts)
        .chain(&declared.warnings)
        .chain(closed.estimates.conditions())
        .cloned()
        .collect();
    let own = closed.estimates.plots();
    let carried = closed.carried.as_ref().map(carried_words).unwrap_or_default();
    let mistakes: Vec<Mistake> = closed.suspects.iter().map(mistake).collect();
    let as_read = (!mistakes.is_empty()).then(|| {
        let number = |v: f64| v.is_finite().then_some(v);
        let before = &closed.before;
        Rms {
            train: number(before.train_rms),
            held_out: number(before.held_out_rms),
            held_out_std: number(before.held_out_std),
        }
    });
    let input = (&mistakes[..], as_read);
    let budget = closed.monte_carlo.as_ref().map(budget);
    let form = filled(closed.estimates.form(), &closed.conformity, case.provenance.as_ref());
    let forms = (form.as_ref(), budget.as_ref());
    Ok(page(case, &prepared, (&parameters, evidence, own), input, forms, (&carried, &warnings)))
}

/// What was taken over from another case, and what it is worth.
fn carried_words(carried: &Carried) -> Vec<String> {
    let mut words = carried.lines();
    let (without, with) = (&carried.without, &carried.with);
    words.push(format!(
        "Error on unseen data without what was carried {}, with it {} {}.",
        number(Some(without.held_out_rms)),
        number(Some(with.held_out_rms)),
        with.unit
    ));
    words
}

/// Residuals of the declared model; one without parameters is its own fit, whatever it averages.
fn declared_residuals(model: &dyn Model, solved: &Solved) -> Vec<f64> {
    if model.declared().base.is_empty() {
        let declared = State::start(model);
        return model.residuals(&declared).iter().copied().collect();
    }
    solved.residual_rows(model)
}

/// Largest page read: one of a thousand times the points of the largest that is known.
const MAX_PAGE_BYTES: u64 = 1 << 28;

/// Reads a page that `--report` wrote, for an index of many.
///
/// # Errors
///
/// [`Error::NotRead`], [`Error::Page`].
pub fn read_page(path: &Path) -> Result<IndexEntry, Error> {
    let text = read_text(path, MAX_PAGE_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    let link = path.to_string_lossy();
    IndexEntry::from_page(&text, link)
        .map_err(|source| Error::Page { path: path.to_owned(), source })
}

/// Reads what is not as recorded: a list of findings by the name of each page that was judged.
///
/// # Errors
///
/// [`Error::NotRead`], [`Error::Findings`].
pub fn read_findings(path: &Path) -> Result<BTreeMap<String, Vec<String>>, Error> {
    let text = read_text(path, MAX_PAGE_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    serde_json::from_str(&text).map_err(|source| Error::Findings { path: path.to_owned(), source })
}

/// What the draws say of every result, for the page.
fn budget(drawn: &MonteCarlo) -> Budget {
    let result = |p: &DrawnParameter| BudgetResult {
        name: p.name.clone(),
        unit: p.unit.clone(),
        value: p.value,
        linear_std: p.linear_std,
        std: p.std,
        interval_95: p.interval_95,
        by_source: p.by_source.clone(),
    };
    Budget {
        draws: drawn.draws - drawn.failed,
        failed: drawn.failed,
        sources: drawn.sources.clone(),
        results: drawn.parameters.iter().map(result).collect(),
    }
}

fn page(
    case: &Case,
    prepared: &Prepared<'_>,
    (parameters, evidence, mut plots): (&[ParameterRow], Evidence<'_>, Vec<ExtraPlot>),
    (mistakes, as_read): (&[Mistake], Option<Rms>),
    (form, budget): (Option<&Form>, Option<&Budget>),
    (carried, warnings): (&[String], &[String]),
) -> String {
    let Words { mut declared, residual, components, group_noun, measured, places } =
        case.measured.words();
    declared.extend_from_slice(carried);
    let components: Vec<String> = components.iter().map(|c| (*c).to_owned()).collect();
    plots.extend(places.map(|places| at_places(&*prepared.model, evidence, places)));
    plots.extend(case.measured.curves().into_iter().map(ExtraPlot::Curves));
    let provenance = case.provenance.clone().unwrap_or_default();
    let published = provenance.published.as_ref().map(|text| Published {
        text: text.clone(),
        source: provenance.source.clone().unwrap_or_default(),
        rms: None,
    });
    let name = case.path.canonicalize().ok();
    let name = name.as_ref().unwrap_or(&case.path).file_name().unwrap_or_default();
    let title = provenance.title.clone().unwrap_or_else(|| name.to_string_lossy().into_owned());
    let measured: Vec<Fact> = measured;
    render(&ReportInput {
        title: &title,
        kind: case.kind,
        source: provenance.source.as_deref(),
        mistakes,
        as_read,
        description: &[],
        measured: &measured,
        declared: &declared,
        parameters,
        layout: &prepared.model.declared().layout,
        components: &components,
        residual,
        group_noun: &group_noun,
        evidence,
        covariates: &prepared.covariates,
        plots: &plots,
        form,
        budget,
        published: published.as_ref(),
        story: provenance.story().as_ref(),
        simulated: provenance.is_simulated(),
        warnings,
    })
}

fn parameters(declared: &dyn Estimates, after: Option<&dyn Estimates>) -> Vec<ParameterRow> {
    let after = after.map(Estimates::parameters).unwrap_or_default();
    let row = |p: crate::estimated::Estimated| {
        let found = after.iter().find(|a| a.name == p.name);
        ParameterRow {
            after: found.and_then(|a| Some((a.value, a.std?))),
            name: p.name,
            unit: p.unit.to_owned(),
            value: p.value,
            std: p.std,
        }
    };
    declared.parameters().into_iter().map(row).collect()
}

/// The residual where it was measured: as colours where it is a deviation from a surface seen
/// from above, otherwise as arrows.
fn at_places(model: &dyn Model, evidence: Evidence<'_>, places: Places) -> ExtraPlot {
    let (before, after) = match evidence {
        Evidence::Solved { residuals } => (residuals, None),
        Evidence::Closed(closure) => {
            let after = (!closure.steps.is_empty()).then_some(&*closure.residuals_after);
            (&*closure.residuals_before, after)
        }
    };
    let is_scalar = model.declared().layout.rows.iter().all(|row| row.component == 0);
    if is_scalar && places.facets.is_empty() {
        let of = |residuals| deviations(model, residuals, &places);
        let (before, after) = (of(before), after.map(of).unwrap_or_default());
        return deviation_map(places, (before, after), &model.declared().layout.unit);
    }
    let of = |residuals| arrows(model, residuals, &places);
    let (before, after) = (of(before), after.map(of).unwrap_or_default());
    vector_map(places, (before, after), &model.declared().layout.unit)
}

fn deviation_map(places: Places, (before, after): (Vec<f64>, Vec<f64>), unit: &str) -> ExtraPlot {
    ExtraPlot::Deviations(DeviationMap {
        title: "Deviations at their places".to_owned(),
        caption: "Orange where the part is above its nominal surface, blue where it is below. \
                  Colours that gather are structure; noise changes from one point to the next."
            .to_owned(),
        x_title: places.x_title.to_owned(),
        y_title: places.y_title.to_owned(),
        unit: unit.to_owned(),
        at: places.at,
        names: places.names,
        before,
        after,
    })
}

fn vector_map(places: Places, (before, after): (Vec<Arrow>, Vec<Arrow>), unit: &str) -> ExtraPlot {
    let caption = if places.facets.is_empty() {
        "Arrows that turn, grow or point together are structure; noise points anywhere."
    } else {
        "The part as found, z enlarged; arrows stand on it along the residual, upwards (orange) where \
         the reading is above the surface, downwards (blue) where it is below. Arrows that go \
         together over a region are structure; noise changes from one to the next."
    };
    ExtraPlot::Vectors(VectorMap {
        title: "Residuals at their places".to_owned(),
        caption: caption.to_owned(),
        facets: places.facets,
        x_title: places.x_title.to_owned(),
        y_title: places.y_title.to_owned(),
        unit: unit.to_owned(),
        before,
        after,
    })
}

/// The residual of each observation.
fn deviations(model: &dyn Model, residuals: &[f64], places: &Places) -> Vec<f64> {
    let mut deviations = vec![f64::NAN; places.at.len()];
    for (row, residual) in model.declared().layout.rows.iter().zip(residuals) {
        if let Some(deviation) = deviations.get_mut(row.observation) {
            *deviation = *residual;
        }
    }
    deviations
}

/// Residual vectors, first two components, where they were measured; a residual without
/// components points upwards.
fn arrows(model: &dyn Model, residuals: &[f64], places: &Places) -> Vec<Arrow> {
    let arrow =
        |(at, name): (&[f64; 2], &String)| Arrow { at: *at, error: [0.0; 2], name: name.clone() };
    let mut arrows: Vec<Arrow> = places.at.iter().zip(&places.names).map(arrow).collect();
    let upwards = usize::from(model.declared().layout.rows.iter().all(|row| row.component == 0));
    for (row, residual) in model.declared().layout.rows.iter().zip(residuals) {
        if let Some(arrow) = arrows.get_mut(row.observation)
            && let Some(component) = arrow.error.get_mut(row.component + upwards)
        {
            *component = *residual;
        }
    }
    arrows
}
