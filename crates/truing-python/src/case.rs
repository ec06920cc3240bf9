//! The commands on case folders, with the JSON and the text of the command line.

use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3};
use pyo3::prelude::*;
use serde::Serialize;
use truing::geometry::EulerAngles;
use truing::{
    Case, Error, Header, InputFile, Layout, OutputFile, PlanBudget, PlanOptions, ReadOptions,
    close_loop_drawn, loop_report, read_case_with, read_learnt, read_machine, refuse_overlap,
    solve_drawn, solve_report, write_files, write_plan,
};

use crate::refusal::Refusal;

/// JSON, text, notes and warnings of an answer.
type Answer = (String, String, Vec<String>, Vec<String>);

/// Fits the declared model of a case.
#[pyfunction]
#[pyo3(signature = (case, allow_outside, timing, report, monte_carlo))]
pub(crate) fn solve(
    py: Python<'_>,
    case: PathBuf,
    allow_outside: bool,
    timing: bool,
    report: Option<PathBuf>,
    monte_carlo: Option<usize>,
) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let case = read_case_with(&case, ReadOptions { allow_outside })?;
        refuse(report.as_deref(), &case)?;
        let mut answer = match monte_carlo {
            Some(draws) => solve_drawn(&case, draws)?,
            None => truing::solve(&case)?,
        };
        write(report, || solve_report(&case, &answer))?;
        answer.timing = answer.timing.filter(|_| timing);
        let text = answer.to_string();
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// Closes the loop on a case.
#[pyfunction]
#[pyo3(signature = (case, carry, allow_outside, timing, report, monte_carlo))]
pub(crate) fn close_loop(
    py: Python<'_>,
    case: PathBuf,
    carry: Option<PathBuf>,
    allow_outside: bool,
    timing: bool,
    report: Option<PathBuf>,
    monte_carlo: Option<usize>,
) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let mut case = read_case_with(&case, ReadOptions { allow_outside })?;
        if let Some(carry) = &carry {
            case = case.carrying(read_learnt(carry)?)?;
        }
        refuse(report.as_deref(), &case)?;
        let mut answer = match monte_carlo {
            Some(draws) => close_loop_drawn(&case, draws)?,
            None => truing::close_loop(&case)?,
        };
        write(report, || loop_report(&case, &answer))?;
        answer.timing = answer.timing.filter(|_| timing);
        let text = answer.to_string();
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// Says what a case can determine.
#[pyfunction]
#[pyo3(signature = (case, allow_outside))]
pub(crate) fn check(py: Python<'_>, case: PathBuf, allow_outside: bool) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let case = read_case_with(&case, ReadOptions { allow_outside })?;
        let answer = truing::check(&case)?;
        let text = answer.to_string();
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// Chooses what to measure next, and writes it to a folder.
#[pyfunction]
#[pyo3(signature = (case, answer, aim, budget, out, allow_outside))]
pub(crate) fn plan(
    py: Python<'_>,
    case: PathBuf,
    answer: Option<PathBuf>,
    aim: Option<String>,
    budget: (Option<usize>, Option<f64>),
    out: Option<PathBuf>,
    allow_outside: bool,
) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let case = read_case_with(&case, ReadOptions { allow_outside })?;
        let (measurements, minutes) = budget;
        let measurements = measurements.map(PlanBudget::Measurements);
        let budget = measurements.or(minutes.map(PlanBudget::Minutes));
        let answer = truing::plan(&case, &PlanOptions { answer, aim, budget })?;
        if let Some(folder) = &out {
            write_plan(&answer, folder)?;
        }
        let text = answer.text(Layout::default());
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// Closes the loop on the cases of one machine.
#[pyfunction]
#[pyo3(signature = (folder, allow_outside))]
pub(crate) fn close_machine(
    py: Python<'_>,
    folder: PathBuf,
    allow_outside: bool,
) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let machine = read_machine(&folder, ReadOptions { allow_outside })?;
        let answer = truing::close_machine(&machine)?;
        let text = answer.to_string();
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// How deep a part presses into a polishing tool along a program; `planned` is position in mm and
/// α, β, γ in degrees.
#[pyfunction]
#[pyo3(signature = (case, program, planned, allow_outside))]
pub(crate) fn depth(
    py: Python<'_>,
    case: PathBuf,
    program: PathBuf,
    planned: Option<[f64; 6]>,
    allow_outside: bool,
) -> Result<Answer, Refusal> {
    Ok(py.detach(|| {
        let case = read_case_with(&case, ReadOptions { allow_outside })?;
        let planned = planned.map(|[x, y, z, alpha, beta, gamma]| {
            let turned = EulerAngles {
                alpha_rad: alpha.to_radians(),
                beta_rad: beta.to_radians(),
                gamma_rad: gamma.to_radians(),
            };
            Isometry3::from_parts(Translation3::new(x, y, z), turned.to_rotation())
        });
        let answer = truing::depth(&case, &program, planned.as_ref())?;
        let text = answer.to_string();
        Ok::<_, Error>(shown(&answer, text, &answer.header, &answer.warnings))
    })?)
}

/// Writes a small case to start from; the files that it wrote.
#[pyfunction]
pub(crate) fn init(kind: &str, folder: PathBuf) -> Result<Vec<PathBuf>, Refusal> {
    Ok(truing::write_example(kind, &folder)?)
}

/// Kinds of cases, and what each is for.
#[pyfunction]
pub(crate) fn kinds() -> Vec<(&'static str, &'static str)> {
    truing::kinds().collect()
}

fn shown(answer: &impl Serialize, text: String, header: &Header, warnings: &[String]) -> Answer {
    let json = serde_json::to_string_pretty(answer).expect("plain data with text keys");
    (json, text, header.notes.clone(), warnings.to_vec())
}

/// A report must not overwrite what the run reads.
fn refuse(report: Option<&Path>, case: &Case) -> Result<(), Error> {
    let inputs: Vec<&Path> = case.inputs().iter().map(|i: &InputFile| i.path.as_path()).collect();
    refuse_overlap(&report.into_iter().collect::<Vec<_>>(), &inputs)
}

fn write(
    report: Option<PathBuf>,
    content: impl FnOnce() -> Result<String, Error>,
) -> Result<(), Error> {
    let Some(path) = report else { return Ok(()) };
    write_files(&[OutputFile { path, content: content()? }])
}
