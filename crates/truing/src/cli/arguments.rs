use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Solves measured cases of precision machines, and finds what their declared model is missing.
///
/// Exit codes: 0 solved, 2 the input is unusable (one message says why), 3 solvable in form but
/// not determined by the data (the message names the free direction).
#[derive(Debug, Parser)]
#[command(version, about)]
pub(crate) struct Arguments {
    /// Threads to use at most; results do not depend on it
    #[arg(
        long,
        global = true,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..)
    )]
    threads: Option<u16>,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit the declared model of a case
    Solve(Run),
    /// Fit it, find what it is missing, and judge the error before and after on unseen data
    Loop(Run),
    /// Validate a case and say what it can and cannot determine
    Check {
        /// Case folder
        case: PathBuf,
        /// Print one JSON object and nothing else
        #[arg(long)]
        json: bool,
    },
    /// Gather pages written by `--report` in one, with a table of all of them
    Index {
        /// Page to write
        #[arg(long, value_name = "FILE.html")]
        output: PathBuf,
        /// Pages of single cases, in the order to show them
        #[arg(value_name = "PAGE.html", required = true)]
        pages: Vec<PathBuf>,
    },
    /// Write a small commented case to start from
    Init {
        /// Kind of case
        kind: String,
        /// Folder to write it to; default: the kind's name
        #[arg(value_name = "DIR")]
        folder: Option<PathBuf>,
    },
}

#[derive(Args, Debug)]
pub(crate) struct Run {
    /// Case folder: `case.toml` and its tables
    pub(crate) case: PathBuf,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
    /// Also write the errors of a rotary axis as CSV, with the names of ISO 230
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) errors: Option<PathBuf>,
    /// Also write a compensation file for LinuxCNC (`COMP_FILE_TYPE = 0`)
    #[arg(long, value_name = "FILE.comp")]
    pub(crate) compensation: Option<PathBuf>,
    /// Also write the errors of a rotary axis as a table in the form of Heidenhain's
    #[arg(long, value_name = "FILE.tab")]
    pub(crate) heidenhain: Option<PathBuf>,
    /// Also write a self-contained HTML report
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}
