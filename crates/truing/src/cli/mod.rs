//! Arguments in; text, JSON, reports and exit codes out.

mod arguments;
mod output;
mod spinner;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;
use truing::{Case, Error, check, close_loop, loop_report, read_case, solve, solve_report};

use arguments::{Arguments, Command, Run};
use spinner::Spinner;

/// Runs the command that the process was started with.
pub(crate) fn run() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Solve(run) => answer(&run, "solving", solve, solve_report),
        Command::Loop(run) => answer(&run, "closing the loop", close_loop, loop_report),
        Command::Check { case, json } => checked(&case, json),
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

fn answer<A: Answer>(
    run: &Run,
    doing: &'static str,
    compute: impl Fn(&Case) -> Result<A, Error>,
    report: impl Fn(&Case, &A) -> Result<String, Error>,
) -> Result<(), Error> {
    let spinner = Spinner::start(doing);
    let case = read_case(&run.case)?;
    let answer = compute(&case)?;
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

fn init(kind: &str, folder: Option<&Path>) -> Result<(), Error> {
    let folder = folder.unwrap_or(Path::new(kind));
    let files = truing::write_example(kind, folder)?;
    let listed = files.iter().map(|f| format!("  {}\n", f.display())).collect::<String>();
    let folder = folder.display();
    output::text(&format_args!(
        "wrote\n{listed}next: truing solve {folder}, truing loop {folder}\n"
    ))
}
