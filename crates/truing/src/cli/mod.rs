//! Arguments in; text, JSON, reports and exit codes out.

mod arguments;
mod output;
mod register;
mod spinner;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use nalgebra::Isometry3;
use pose_icp::ProgramOptions;
use serde::Serialize;
use truing::force_impedance::{ImpedanceParameters, ReferenceMode};
use truing::report::{IndexEntry, render_index};
use truing::{
    Case, Error, Estimates, Export, ForceDesignInput, ProbeLogSettings, check, close_loop, correct,
    design_force, force_report, import_probe_log, loop_report, read_case, read_learnt, solve,
    solve_report, write_imported,
};

use arguments::{Arguments, Closing, Command, Design, ForceCard, Import, Run};
use register::Register;
use spinner::Spinner;

/// Runs the command that the process was started with.
pub(crate) fn run() -> ExitCode {
    let arguments = Arguments::parse();
    let result = limit_threads(arguments.threads).and_then(|()| obey(arguments.command));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::error(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

fn obey(command: Command) -> Result<(), Error> {
    match command {
        Command::Solve(run) => answer(&run, "solving", Ok, solve, solve_report),
        Command::Loop(Closing { run, carry }) => {
            let carrying = |case: Case| match &carry {
                Some(path) => case.carrying(read_learnt(path)?),
                None => Ok(case),
            };
            answer(&run, "closing the loop", carrying, close_loop, loop_report)
        }
        Command::Check { case, json } => checked(&case, json),
        Command::Register(command) => registered(&command),
        Command::Correct { case, program, planned, chord, decimals, output } => {
            let options = ProgramOptions { chord_mm: chord, decimals };
            let planned = planned.unwrap_or_else(Isometry3::identity);
            correct_program(&case, &program, &planned, &options, output.as_deref())
        }
        Command::Index { output, pages } => index(&output, &pages),
        Command::Design { what: Design::Force(card) } => design(&card),
        Command::Import { what: Import::ProbeLog { log, feed, tip_radius, inch, out } } => {
            let settings = ProbeLogSettings {
                feed_mm_per_min: feed,
                tip_radius_mm: tip_radius,
                unit_mm: if inch { MM_PER_INCH } else { 1.0 },
            };
            probe_log(&log, &settings, out.as_deref())
        }
        Command::Init { kind, folder } => init(&kind, folder.as_deref()),
    }
}

/// Bounds the threads of every command; more than the machine has are of no use.
fn limit_threads(threads: Option<u16>) -> Result<(), Error> {
    let Some(threads) = threads else { return Ok(()) };
    let available = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    rayon::ThreadPoolBuilder::new()
        .num_threads(available.min(threads.into()))
        .build_global()
        .map_err(|_| Error::NoThreads)
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

impl Answer for truing::Registered {
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
    declare: impl Fn(Case) -> Result<Case, Error>,
    compute: impl Fn(&Case) -> Result<A, Error>,
    report: impl Fn(&Case, &A) -> Result<String, Error>,
) -> Result<(), Error> {
    let spinner = Spinner::start(doing);
    let case = declare(read_case(&run.case)?)?;
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

fn registered(command: &Register) -> Result<(), Error> {
    let spinner = Spinner::start("registering");
    let answer = truing::register(&command.source, &command.target, &command.settings())?;
    drop(spinner);
    print(&answer, command.json)?;
    if answer.converged { Ok(()) } else { Err(Error::NotSettled { iterations: answer.iterations }) }
}

fn print(answer: &impl Answer, json: bool) -> Result<(), Error> {
    if json {
        return output::json(answer);
    }
    output::text(answer)?;
    output::warnings(answer.warnings());
    Ok(())
}

fn design(card: &ForceCard) -> Result<(), Error> {
    let [softest, stiffest] = match card.contact[..] {
        [from, to, ..] => [from, to],
        [one] => [one, one],
        [] => [f64::NAN; 2],
    };
    let parameters = |(mass_kg, damping_ns_per_mm)| ImpedanceParameters {
        mass_kg,
        damping_ns_per_mm,
        stiffness_n_per_mm: card.stiffness,
    };
    let input = ForceDesignInput {
        contact_n_per_mm: [softest, stiffest],
        parameters: card.mass.zip(card.damping).map(parameters),
        interval_s: card.interval,
        delay_s: card.delay,
        lag_s: card.lag,
        settling_s: card.settling,
        mode: if card.absolute { ReferenceMode::Absolute } else { ReferenceMode::Rebased },
    };
    let answer =
        design_force(&input).map_err(|source| Error::Design { source: Box::new(source) })?;
    if let Some(path) = &card.report {
        output::write_file(path, &force_report(&input, &answer))?;
    }
    if card.json { output::json(&answer) } else { output::text(&answer) }
}

fn correct_program(
    case: &Path,
    program: &Path,
    planned: &Isometry3<f64>,
    options: &ProgramOptions,
    output: Option<&Path>,
) -> Result<(), Error> {
    let corrected = correct(&read_case(case)?, program, planned, options)?;
    match output {
        Some(path) => output::write_file(path, &corrected.program)?,
        None => output::text(&corrected.program)?,
    }
    output::warnings(&corrected.warnings);
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

const MM_PER_INCH: f64 = 25.4;

fn probe_log(log: &Path, settings: &ProbeLogSettings, out: Option<&Path>) -> Result<(), Error> {
    let imported = import_probe_log(log, settings)?;
    let Some(folder) = out else {
        let table = imported.files.iter().find(|(name, _)| *name == "touches.csv");
        return output::text(&table.map_or("", |(_, text)| text));
    };
    let files = write_imported(&imported, folder)?;
    let listed: Vec<String> = files.iter().map(|f| format!("  {}", f.display())).collect();
    let (n, listed, folder) = (imported.n_touches, listed.join("\n"), folder.display());
    output::text(&format_args!(
        "{n} touches, wrote\n{listed}\nnext: write the surface into {folder}/case.toml, then truing \
         solve {folder}\n"
    ))
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
