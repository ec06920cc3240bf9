//! Arguments in; text, JSON, reports and exit codes out.

mod arguments;
mod output;
mod spinner;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;
use truing::report::{IndexEntry, render_index};
use truing::{
    Case, Error, Estimates, Export, check, close_loop, loop_report, read_case, solve, solve_report,
};

use arguments::{Arguments, Command, Run};
use spinner::Spinner;

/// Runs the command that the process was started with.
pub(crate) fn run() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Solve(run) => answer(&run, "solving", solve, solve_report),
        Command::Loop(run) => answer(&run, "closing the loop", close_loop, loop_report),
        Command::Check { case, json } => checked(&case, json),
        Command::Index { output, pages } => index(&output, &pages),
        Command::Init { kind, folder } => init(&kind, folder.as_deref()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::error(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

/// An answer that can be shown as text, as JSON, and as a page.
trait Answer: Serialize + std::fmt::Display {
    fn warnings(&self) -> &[String];
}

impl Answer for truing::Solved {
    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

impl Answer for truing::Closed {
    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

impl Answer for truing::Checked {
    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// An answer with estimates.
trait Estimated: Answer {
    fn kind(&self) -> &'static str;
    fn estimates(&self) -> &Estimates;
}

impl Estimated for truing::Solved {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn estimates(&self) -> &Estimates {
        &self.estimates
    }
}

impl Estimated for truing::Closed {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn estimates(&self) -> &Estimates {
        &self.estimates
    }
}

fn answer<A: Estimated>(
    run: &Run,
    doing: &'static str,
    compute: impl Fn(&Case) -> Result<A, Error>,
    report: impl Fn(&Case, &A) -> Result<String, Error>,
) -> Result<(), Error> {
    let spinner = Spinner::start(doing);
    let case = read_case(&run.case)?;
    let answer = compute(&case)?;
    for (path, format) in [
        (&run.errors, Export::Csv),
        (&run.compensation, Export::LinuxCnc),
        (&run.heidenhain, Export::Heidenhain),
    ] {
        if let Some(path) = path {
            let text = answer.estimates().export(format);
            let kind = answer.kind();
            output::write_file(path, &text.ok_or(Error::NothingToExport { kind })?)?;
        }
    }
    if let Some(path) = &run.report {
        output::write_file(path, &report(&case, &answer)?)?;
    }
    drop(spinner);
    print(&answer, run.json)
}

fn checked(path: &Path, json: bool) -> Result<(), Error> {
    let spinner = Spinner::start("checking");
    let answer = check(&read_case(path)?)?;
    drop(spinner);
    print(&answer, json)
}

fn print(answer: &impl Answer, json: bool) -> Result<(), Error> {
    if json {
        return output::json(answer);
    }
    output::text(answer)?;
    output::warnings(answer.warnings());
    Ok(())
}

fn index(path: &Path, pages: &[PathBuf]) -> Result<(), Error> {
    let entries: Vec<_> = pages.iter().map(|page| entry(page)).collect::<Result<_, _>>()?;
    let introduction = "Error of each case's declared model, and of the model with what the loop \
                        added, on data that the fit never saw.";
    output::write_file(path, &render_index("Truing: all cases", introduction, &entries))
}

fn entry(page: &Path) -> Result<IndexEntry, Error> {
    let text = std::fs::read_to_string(page)
        .map_err(|e| Error::NotRead { path: page.to_owned(), reason: e.kind() })?;
    IndexEntry::from_page(&text).map_err(|source| Error::Page { path: page.to_owned(), source })
}

fn init(kind: &str, folder: Option<&Path>) -> Result<(), Error> {
    let folder = folder.unwrap_or(Path::new(kind));
    let files = truing::write_example(kind, folder)?;
    let listed: Vec<String> = files.iter().map(|f| format!("  {}", f.display())).collect();
    let (listed, folder) = (listed.join("\n"), folder.display());
    output::text(&format_args!(
        "wrote\n{listed}\nnext: truing solve {folder}, truing loop {folder}\n"
    ))
}
