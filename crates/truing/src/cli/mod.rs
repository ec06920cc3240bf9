//! Arguments in; text, JSON, reports and exit codes out.

mod answer;
mod arguments;
mod monitor;
mod number;
mod output;
mod register;
mod spinner;
mod step;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use nalgebra::Isometry3;
use pose_icp::{Patch, ProgramOptions, SampledMethod, SampledOptions};
use truing::force_impedance::{ImpedanceParameters, ReferenceMode};
use truing::model_discrepancy::Progress;
use truing::report::render_index;
use truing::{
    Case, Error, ForceDesignInput, GuideSource, InputFile, Layout, MachineProblem, MicroPlaneInput,
    OutputFile, PlanOptions, ProbeLogSettings, ReadOptions, StepImport, TableImport, check,
    close_loop, close_loop_drawn, close_machine, correct, depth, design_force, design_micro_plane,
    force_report, guides, import_planned_log, import_probe_log, import_table, is_machine, itlicp,
    loop_report, machine_report, plan, plausible, read_case_with, read_findings, read_learnt,
    read_machine, read_page, refuse_overlap, solve, solve_drawn, solve_report, write_files,
    write_imported, write_plan,
};

use answer::{Answer, Estimated};
use arguments::{
    Arguments, Closing, Command, Design, ForceCard, Guiding, Import, MicroPlaneCard, Next, Run,
    Sampling, Settings, Solving,
};
use monitor::monitor;
use register::Register;
use spinner::Spinner;

/// Runs the command that the process was started with.
pub(crate) fn run() -> ExitCode {
    let arguments = Arguments::parse();
    output::survive_size_limit();
    let result =
        limit_threads(arguments.threads).and_then(|()| obey(arguments.command, arguments.settings));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::error(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

fn obey(command: Command, settings: Settings) -> Result<(), Error> {
    match command {
        Command::Solve(Solving { run, monte_carlo }) => {
            let solved = |case: &Case| match monte_carlo {
                Some(draws) => solve_drawn(case, draws as usize),
                None => solve(case),
            };
            answer((&run, settings), "solving", Ok, solved, solve_report)
        }
        Command::Loop(closing) if is_machine(&closing.run.case) => machine(&closing, settings),
        Command::Loop(Closing { run, carry, monte_carlo }) => {
            let carrying = |case: Case| match &carry {
                Some(path) => case.carrying(read_learnt(path)?),
                None => Ok(case),
            };
            let closed = |case: &Case| match monte_carlo {
                Some(draws) => close_loop_drawn(case, draws as usize),
                None => close_loop(case),
            };
            answer((&run, settings), "closing the loop", carrying, closed, loop_report)
        }
        Command::Check { case, json } => checked(&case, json, settings),
        Command::Plan(next) => planned(&next, settings),
        Command::Monitor(live) => monitor(&live, &read(&live.case, settings)?),
        Command::Register(command) => registered(&command, settings),
        Command::Correct { case, program, planned, answer, chord, decimals, output } => {
            let options = ProgramOptions { chord_mm: chord, decimals };
            let planned = planned.unwrap_or_else(Isometry3::identity);
            let case = read(&case, settings)?;
            let answer = answer.as_deref();
            correct_program(&case, &program, &planned, &options, answer, output.as_deref())
        }
        Command::Itlicp(command) => sampled(&command, settings),
        Command::Depth { case, program, planned, json } => {
            print(depth(&read(&case, settings)?, &program, planned.as_ref())?, json, settings)
        }
        Command::Guide(guiding) => guided(&guiding, settings),
        Command::Index { output, findings, pages } => index(&output, findings.as_deref(), &pages),
        Command::Design { what: Design::Force(card) } => design(&card),
        Command::Design { what: Design::MicroPlane(card) } => micro_plane(&card),
        Command::Import {
            what: Import::ProbeLog { log, plan, kind, feed, tip_radius, inch, out },
        } => {
            let unit_mm = if inch { MM_PER_INCH } else { 1.0 };
            if let Some(plan) = plan {
                return planned_log(&log, &plan, unit_mm);
            }
            let settings = ProbeLogSettings {
                kind: kind.into(),
                feed_mm_per_min: feed,
                tip_radius_mm: tip_radius,
                unit_mm,
            };
            probe_log(&log, &settings, out.as_deref())
        }
        Command::Import { what: Import::Step { file, face, kind, tip_radius, out } } => {
            let import = StepImport { face, kind: kind.into(), tip_radius_mm: tip_radius };
            match out {
                Some(folder) => step::imported(&file, &import, &folder),
                None => step::listed(&file, face),
            }
        }
        Command::Import { what: Import::Table { file, kind, table, map, out } } => {
            foreign_table(&file, &TableImport { kind, table, map }, out.as_deref())
        }
        Command::Init { kind, folder } => init(&kind, folder.as_deref()),
        Command::Completions { shell } => completions(shell),
        Command::Man { command } => manual_page(command.as_deref()),
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

fn read(case: &Path, settings: Settings) -> Result<Case, Error> {
    read_case_with(case, ReadOptions { allow_outside: settings.allow_outside })
}

fn answer<A: Estimated>(
    (run, settings): (&Run, Settings),
    doing: &'static str,
    declare: impl Fn(Case) -> Result<Case, Error>,
    compute: impl Fn(&Case) -> Result<A, Error>,
    report: impl Fn(&Case, &A) -> Result<String, Error>,
) -> Result<(), Error> {
    let progress = Progress::default();
    let spinner = Spinner::start(doing, settings.shown.quiet, &progress);
    let case = declare(read(&run.case, settings)?)?.watched(&progress);
    refuse_overlap(&run.outputs(), &paths(case.inputs()))?;
    let answer = compute(&case)?;
    let mut files = Vec::new();
    for (path, format) in run.exports() {
        plausible(answer.estimates(), run.max_correction)?;
        let kind = answer.kind();
        let content = answer.estimates().export(format).ok_or(Error::NothingToExport { kind })?;
        files.push(OutputFile { path: path.to_owned(), content });
        if let Some((letter, content)) = answer.estimates().export_of_second(format) {
            let path = of_axis(path, letter);
            refuse_overlap(&[&path], &paths(case.inputs()))?;
            files.push(OutputFile { path, content });
        }
    }
    if let Some(path) = &run.report {
        files.push(OutputFile { path: path.clone(), content: report(&case, &answer)? });
    }
    write_files(&files)?;
    drop(spinner);
    print(answer, run.json, settings)
}

/// `errors.csv` of a second axis B is `errors-B.csv`.
fn of_axis(path: &Path, letter: char) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{letter}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

fn sampled(command: &Sampling, settings: Settings) -> Result<(), Error> {
    let Sampling { coarse, fine, patch, tolerance, classical, .. } = *command;
    let patch = if patch == 1 { Patch::OneSpacing } else { Patch::TwoSpacings };
    let method = match classical {
        Some(spacing_mm) => SampledMethod::Classical { spacing_mm },
        None => SampledMethod::TwoLevel { coarse_mm: coarse, fine_mm: fine, patch },
    };
    let options = SampledOptions { method, tolerance_mm: tolerance, ..SampledOptions::default() };
    let spinner = Spinner::start("sampling", settings.shown.quiet, &Progress::default());
    let answer = itlicp(&read(&command.case, settings)?, &options)?;
    drop(spinner);
    print(answer, command.json, settings)
}

fn micro_plane(card: &MicroPlaneCard) -> Result<(), Error> {
    let input = MicroPlaneInput {
        tip_radius_mm: card.tip_radius,
        noise_mm: card.noise,
        curvatures_per_mm: card.curvatures,
        range_mm: card.range,
    };
    let design = design_micro_plane(&input)
        .map_err(|source| Error::DesignProbe { source: Box::new(source) })?;
    if card.json { output::json(&design) } else { output::text(&design) }
}

/// The loop on the cases of a machine.
fn machine(closing: &Closing, settings: Settings) -> Result<(), Error> {
    let run = &closing.run;
    let of_one_case = [
        ("--carry", closing.carry.is_some()),
        ("--monte-carlo", closing.monte_carlo.is_some()),
        ("--errors", run.errors.is_some()),
        ("--compensation", run.compensation.is_some()),
        ("--heidenhain", run.heidenhain.is_some()),
        ("--point-errors", run.point_errors.is_some()),
    ];
    if let Some((option, _)) = of_one_case.into_iter().find(|(_, given)| *given) {
        let problem = Box::new(MachineProblem::OneCaseOnly { option });
        return Err(Error::Machine { path: run.case.clone(), problem });
    }
    let spinner = Spinner::start("closing the loops", settings.shown.quiet, &Progress::default());
    let options = ReadOptions { allow_outside: settings.allow_outside };
    let answer = close_machine(&read_machine(&run.case, options)?)?;
    if let Some(path) = &run.report {
        write_files(&[OutputFile { path: path.clone(), content: machine_report(&answer) }])?;
    }
    drop(spinner);
    print(answer, run.json, settings)
}

fn paths(inputs: &[InputFile]) -> Vec<&Path> {
    inputs.iter().map(|input| input.path.as_path()).collect()
}

fn checked(path: &Path, json: bool, settings: Settings) -> Result<(), Error> {
    let spinner = Spinner::start("checking", settings.shown.quiet, &Progress::default());
    let answer = check(&read(path, settings)?)?;
    drop(spinner);
    print(answer, json, settings)
}

fn planned(next: &Next, settings: Settings) -> Result<(), Error> {
    let progress = Progress::default();
    let spinner = Spinner::start("planning", settings.shown.quiet, &progress);
    let options =
        PlanOptions { answer: next.answer.clone(), aim: next.aim.clone(), budget: next.budget };
    let mut answer = plan(&read(&next.case, settings)?.watched(&progress), &options)?;
    let written = match &next.out {
        Some(folder) => write_plan(&answer, folder)?,
        None => Vec::new(),
    };
    let program = written.iter().find(|path| path.extension() == Some("ngc".as_ref()));
    answer.program = program.map(|path| path.display().to_string());
    drop(spinner);
    let listed: Vec<String> = written.iter().map(|f| format!("wrote {}", f.display())).collect();
    let is_text = !next.json;
    print(answer, next.json, settings)?;
    for line in listed.iter().filter(|_| is_text) {
        output::text(&format_args!("{line}\n"))?;
    }
    Ok(())
}

fn guided(guiding: &Guiding, settings: Settings) -> Result<(), Error> {
    let source = match &guiding.plan {
        Some(plan) => GuideSource::Plan(plan.clone()),
        None if guiding.touched => GuideSource::Touches,
        None => GuideSource::Lattice,
    };
    let case = read(&guiding.case, settings)?;
    let answer = guides(&case, &source)?;
    let tables = [(&guiding.out, answer.csv()), (&guiding.touches, answer.touches_csv())];
    let files: Vec<OutputFile> = (tables.into_iter())
        .filter_map(|(path, content)| Some(OutputFile { path: path.clone()?, content }))
        .collect();
    let outputs: Vec<&Path> = files.iter().map(|file| file.path.as_path()).collect();
    let plan = guiding.plan.as_deref();
    refuse_overlap(&outputs, &[&paths(case.inputs())[..], plan.as_slice()].concat())?;
    write_files(&files)?;
    print(answer, guiding.json, settings)?;
    for file in files.iter().filter(|_| !guiding.json) {
        output::text(&format_args!("wrote {}\n", file.path.display()))?;
    }
    Ok(())
}

fn registered(command: &Register, settings: Settings) -> Result<(), Error> {
    let spinner = Spinner::start("registering", settings.shown.quiet, &Progress::default());
    let answer = truing::register(&command.source, &command.target, &command.settings())?;
    drop(spinner);
    let (converged, iterations) = (answer.converged, answer.iterations);
    print(answer, command.json, settings)?;
    if converged { Ok(()) } else { Err(Error::NotSettled { iterations }) }
}

fn print(mut answer: impl Answer, json: bool, settings: Settings) -> Result<(), Error> {
    if settings.no_timing {
        answer.forget_timing();
    }
    if json {
        return output::json(&answer);
    }
    let layout = Layout { detail: settings.shown.detail(), columns: output::columns() };
    output::answer(&answer.text(layout))?;
    if !settings.shown.quiet {
        output::notes(answer.notes());
    }
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
        let content = force_report(&input, &answer);
        write_files(&[OutputFile { path: path.clone(), content }])?;
    }
    if card.json { output::json(&answer) } else { output::text(&answer) }
}

fn correct_program(
    case: &Case,
    program: &Path,
    planned: &Isometry3<f64>,
    options: &ProgramOptions,
    answer: Option<&Path>,
    output: Option<&Path>,
) -> Result<(), Error> {
    let mut inputs = paths(case.inputs());
    inputs.push(program);
    inputs.extend(answer);
    refuse_overlap(&output.into_iter().collect::<Vec<_>>(), &inputs)?;
    let corrected = correct(case, program, planned, options, answer)?;
    match output {
        Some(path) => {
            let (path, content) = (path.to_owned(), corrected.program);
            write_files(&[OutputFile { path, content }])?;
        }
        None => output::text(&corrected.program)?,
    }
    output::notes(case.notes());
    output::warnings(&corrected.warnings);
    Ok(())
}

fn index(path: &Path, findings: Option<&Path>, pages: &[PathBuf]) -> Result<(), Error> {
    refuse_overlap(&[path], &pages.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let findings = findings.map(read_findings).transpose()?.unwrap_or_default();
    let entry = |page: &PathBuf| {
        let mut entry = read_page(page)?;
        let name = page.file_name().unwrap_or_default().to_string_lossy();
        entry.link = link(path, page);
        entry.findings = findings.get(&*name).cloned();
        Ok(entry)
    };
    let entries: Vec<_> = pages.iter().map(entry).collect::<Result<_, Error>>()?;
    let introduction = "Error of each case's declared model, and of the model with what the loop \
                        added, on data that the fit never saw.";
    let content = render_index("Truing: all cases", introduction, &entries);
    write_files(&[OutputFile { path: path.to_owned(), content }])
}

/// Address of a page from the index: its name where both lie in one folder, else its full path.
fn link(index: &Path, page: &Path) -> String {
    let name = page.file_name().filter(|_| page.parent() == index.parent());
    let target = name.map_or_else(|| std::path::absolute(page), |name| Ok(name.into()));
    let target = target.unwrap_or_else(|_| page.to_owned()).to_string_lossy().replace('\\', "/");
    // What an address gives a meaning of its own.
    target.replace('%', "%25").replace('#', "%23").replace('?', "%3F").replace(' ', "%20")
}

const MM_PER_INCH: f64 = 25.4;

fn probe_log(log: &Path, settings: &ProbeLogSettings, out: Option<&Path>) -> Result<(), Error> {
    let imported = import_probe_log(log, settings)?;
    let Some(folder) = out else {
        let table = imported.files.iter().find(|(name, _)| *name != "case.toml");
        return output::text(&table.map_or("", |(_, text)| text));
    };
    let files = write_imported(&imported.files, folder)?;
    let listed: Vec<String> = files.iter().map(|f| format!("  {}", f.display())).collect();
    let (n, listed, folder) = (imported.n_touches, listed.join("\n"), folder.display());
    output::text(&format_args!(
        "{n} touches, wrote\n{listed}\nnext: write the surface into {folder}/case.toml, then truing \
         solve {folder}\n"
    ))
}

fn planned_log(log: &Path, plan: &Path, unit_mm: f64) -> Result<(), Error> {
    let (table, n) = import_planned_log(log, plan, unit_mm)?;
    refuse_overlap(&[&table.path], &[log])?;
    let (path, folder) = (table.path.display().to_string(), plan.display());
    write_files(&[table])?;
    output::text(&format_args!("{n} touches, written into {path}\nnext: truing loop {folder}\n"))
}

fn foreign_table(file: &Path, import: &TableImport, out: Option<&Path>) -> Result<(), Error> {
    let imported = import_table(file, import)?;
    let Some(folder) = out else {
        output::text(&imported.table.1)?;
        output::notes(&imported.notes);
        return Ok(());
    };
    let mut files = vec![imported.table];
    if !folder.join(imported.case.0).exists() {
        files.insert(0, imported.case);
    }
    let written = write_imported(&files, folder)?;
    let listed: Vec<String> = written.iter().map(|f| format!("  {}", f.display())).collect();
    let (n, listed, folder) = (imported.n_rows, listed.join("\n"), folder.display());
    output::text(&format_args!(
        "{n} rows, wrote\n{listed}\nnext: write what is known of the measurement into \
         {folder}/case.toml, then truing check {folder}\n"
    ))?;
    output::notes(&imported.notes);
    Ok(())
}

fn completions(shell: clap_complete::Shell) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "truing", &mut script);
    output::text(&String::from_utf8_lossy(&script))
}

fn manual_page(of: Option<&str>) -> Result<(), Error> {
    let mut program = Arguments::command();
    program.build();
    let found = of.map_or(Some(&program), |name| program.find_subcommand(name)).cloned();
    let Some(command) = found else {
        let known = program.get_subcommands().map(clap::Command::get_name);
        let known = known.filter(|name| *name != "help").collect::<Vec<_>>().join(", ");
        let message = format!("no command {:?}; the commands are {known}", of.unwrap_or_default());
        program.error(clap::error::ErrorKind::InvalidValue, message).exit()
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command)
        .render(&mut page)
        .map_err(|e| Error::NotWritten { path: "standard output".into(), reason: e.kind() })?;
    output::text(&String::from_utf8_lossy(&page))
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
