//! Reruns everything: tests, fixtures, published figures, benchmarks.
//!
//! One file per command. Nothing here links the crates under test: `truing` is run as a process,
//! and the generators are written from the physics alone.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "tasks speak to people")]

mod bench;
mod blunders;
mod ci;
mod coverage;
mod expectation;
mod fixtures;
mod fuzz;
mod generators;
#[cfg(test)]
mod handback;
mod kinds;
mod linuxcnc;
mod loop_speed;
mod markdown;
mod measured;
mod next_measurement;
mod page;
mod peers;
mod power;
mod program;
mod realtime;
mod repro;
mod schema;
mod shared_cause;
mod shell;
mod site;
mod smallest_size;
mod stability;
mod test;
mod tidy;
mod web;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Reruns everything: tests, fixtures, published figures, benchmarks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solves every fixture, compares with what is recorded beside it, writes `target/repro`.
    Repro,
    /// Runs every test, doc test and example of the workspace.
    Test,
    /// Regenerates `fixtures/` from its seeds.
    Fixtures(fixtures::Arguments),
    /// Runs the readers of foreign files under libFuzzer, where there is a nightly compiler.
    Fuzz(fuzz::Arguments),
    /// Closes the loop on public measured data sets, where they have been fetched.
    Measured(measured::Arguments),
    /// Measures speed (criterion), solver suites, or the statistics of the loop.
    Bench(bench::Arguments),
    /// Runs every check; the first failure stops.
    Ci(ci::Arguments),
    /// Runs plans, corrected programs and the force controller on a LinuxCNC with simulated axes.
    Linuxcnc(linuxcnc::Arguments),
    /// Checks that force-impedance builds without `std` and cannot panic while it controls.
    Realtime,
    /// Writes the documentation as a site, with mdBook and rustdoc, to `target/site/html`.
    Site,
    /// Compiles the program for WASI and puts it behind a static page, in `target/web`.
    Web,
    /// Checks the rules of the house that the compiler does not.
    Tidy(tidy::Arguments),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Repro => repro::run(),
        Command::Test => test::run(),
        Command::Fixtures(arguments) => fixtures::run(&arguments),
        Command::Fuzz(arguments) => fuzz::run(&arguments),
        Command::Measured(arguments) => measured::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Ci(arguments) => ci::run(&arguments),
        Command::Linuxcnc(arguments) => linuxcnc::run(&arguments),
        Command::Realtime => realtime::run(),
        Command::Site => site::run(),
        Command::Web => web::run(),
        Command::Tidy(arguments) => tidy::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
