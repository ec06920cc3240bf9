use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand};
use nalgebra::Isometry3;
use truing::{ColumnMap, Detail, Export, PlanBudget, ProbeLogKind};

use super::monitor::Live;
use super::number::{budget, chord, decimals, not_negative, pair, positive, triple};
use super::register::{Register, pose};

/// Solves measured cases of precision machines, and finds what their declared model is missing.
///
/// Exit codes: 0 solved, 2 the input is unusable (one message says why), 3 solvable in form but
/// not determined by the data (the message names the free direction).
#[derive(Debug, Parser)]
#[command(version, about, after_help = kinds_in_words())]
pub(crate) struct Arguments {
    /// Threads to use at most; results do not depend on it
    #[arg(
        long,
        global = true,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..)
    )]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) settings: Settings,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What holds for every command.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Leave times out of JSON: two runs then print the same bytes
    #[arg(long, global = true)]
    pub(crate) no_timing: bool,
    /// Read files that case.toml names outside of the case folder
    #[arg(long, global = true)]
    pub(crate) allow_outside: bool,
    #[command(flatten)]
    pub(crate) shown: Shown,
}

/// How much of an answer is shown.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Shown {
    /// Show every step, test and table in full
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Show the result in a few lines, and neither progress nor notes
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

impl Shown {
    pub(crate) fn detail(self) -> Detail {
        match (self.quiet, self.verbose) {
            (true, _) => Detail::Headline,
            (_, true) => Detail::Full,
            _ => Detail::Summary,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit the declared model of a case
    Solve(Solving),
    /// Fit it, find what it is missing, and judge the error before and after on unseen data
    Loop(Closing),
    /// Validate a case and say what it can and cannot determine
    Check {
        /// Case folder
        case: PathBuf,
        /// Print one JSON object and nothing else
        #[arg(long)]
        json: bool,
    },
    /// Choose what to measure next: to tell confounded effects apart, to make an effect visible, or
    /// to know a quantity better
    Plan(Next),
    /// Compare a head's contact with its commanded path, live, and report when it leaves that path
    Monitor(Live),
    /// Find where one cloud or mesh lies on another
    Register(Register),
    /// Move a G-code program to where the part of a pose-icp case lies
    Correct {
        /// Case folder of kind pose-icp
        case: PathBuf,
        /// Program with G0 to G3, absolute or incremental
        program: PathBuf,
        /// Pose that the program was written for: six numbers "x,y,z mm, alpha,beta,gamma deg";
        /// default: the program is in coordinates of the workpiece
        #[arg(long, value_name = "POSE", value_parser = pose, allow_hyphen_values = true)]
        planned: Option<Isometry3<f64>>,
        /// Pose and errors of the machine's axes that the loop found on this case: the output of
        /// `truing loop CASE --json`
        #[arg(long, value_name = "FILE.json")]
        answer: Option<PathBuf>,
        /// Arcs become chords that stay this close to them
        #[arg(long, value_name = "MM", default_value_t = 1e-3, value_parser = chord)]
        chord: f64,
        /// Decimals of the coordinates written
        #[arg(long, value_name = "N", default_value_t = 4, value_parser = decimals)]
        decimals: usize,
        /// File to write; default: standard output
        #[arg(long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Find the pose of an asphere by ITLICP, the method of document [D], and by the exact method
    Itlicp(Sampling),
    /// Compute how deep the part of a pose-icp case presses into a polishing tool along a program,
    /// with its uncertainty: Δh = H − h
    Depth {
        /// Case folder of kind pose-icp with a `[tool]`
        case: PathBuf,
        /// Program whose positions are those of the tool's lowest point
        program: PathBuf,
        /// Pose that the program was written for: six numbers "x,y,z mm, alpha,beta,gamma deg";
        /// default: the program is in coordinates of the workpiece
        #[arg(long, value_name = "POSE", value_parser = pose, allow_hyphen_values = true)]
        planned: Option<Isometry3<f64>>,
        /// Print one JSON object and nothing else
        #[arg(long)]
        json: bool,
    },
    /// Write guide points of a probe-comp case: where a ball is sent along z, where its centre and its
    /// contact will be on the part as drawn [E]
    Guide(Guiding),
    /// Link pages written by `--report` from one page, with a table of all of them
    Index {
        /// Page to write
        #[arg(long, value_name = "FILE.html")]
        output: PathBuf,
        /// Differences from what is recorded, as JSON: a list of findings for the name of each page
        #[arg(long, value_name = "FILE.json")]
        findings: Option<PathBuf>,
        /// Pages of single cases, in the order to show them
        #[arg(value_name = "PAGE.html", required = true)]
        pages: Vec<PathBuf>,
    },
    /// What to set a machine to, from numbers alone
    Design {
        #[command(subcommand)]
        what: Design,
    },
    /// Make a case of what another program wrote
    Import {
        #[command(subcommand)]
        what: Import,
    },
    /// Write a small commented case to start from
    #[command(after_help = kinds_in_words())]
    Init {
        /// Kind of case, one of those below
        kind: String,
        /// Folder to write it to; default: the kind's name
        #[arg(value_name = "DIR")]
        folder: Option<PathBuf>,
    },
    /// Print what completes the words of this program in a shell
    Completions {
        /// Shell to complete in
        shell: clap_complete::Shell,
    },
    /// Print the manual page of the program or of one of its commands, in roff
    Man {
        /// One of the commands; default: the program
        command: Option<String>,
    },
}

/// Every kind of case that `init` writes, with what it is for, one a line.
fn kinds_in_words() -> String {
    let lines = truing::examples().map(|(name, summary)| format!("  {name:<18} {summary}"));
    format!("Kinds:\n{}", lines.collect::<Vec<_>>().join("\n"))
}

#[derive(Debug, Subcommand)]
pub(crate) enum Import {
    /// A table of measurements from any program, as a table of a case
    Table {
        /// The table: cells separated by commas, semicolons or tabs, headings in the first row
        file: PathBuf,
        /// Kind of the case
        #[arg(long)]
        kind: String,
        /// Table of that kind, such as ranges.csv; default: the usual one
        #[arg(long, value_name = "NAME")]
        table: Option<String>,
        /// Which column becomes which, where headings do not tell: "their column=our column[unit]"
        #[arg(long, value_name = "MAP")]
        map: Vec<ColumnMap>,
        /// Folder to write the case to; a table is added to a case that is there; default: the
        /// table on standard output
        #[arg(long, value_name = "CASE")]
        out: Option<PathBuf>,
    },
    /// A face of a part out of a STEP file (.step, .stp), as the surface of a case; without --out the
    /// faces are listed
    Step {
        /// The file
        file: PathBuf,
        /// Number of the face in the list; needed where there are several
        #[arg(long, value_name = "N")]
        face: Option<usize>,
        /// Kind of the case: how far the part is off, or where it lies
        #[arg(long, value_enum, default_value_t = TouchKind::ProbeComp)]
        kind: TouchKind,
        /// Radius of the ball, mm
        #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = positive)]
        tip_radius: f64,
        /// Folder to write the case to; control points are added to a case that is there
        #[arg(long, value_name = "CASE")]
        out: Option<PathBuf>,
    },
    /// Touches out of a LinuxCNC probe log (PROBEOPEN), as a case or in the rows of a plan
    ProbeLog {
        /// The log: nine numbers a line, X Y Z A B C U V W
        log: PathBuf,
        /// Folder that `truing plan --out` wrote: what the log holds is written into its empty rows
        #[arg(long, value_name = "FOLDER", conflicts_with_all = ["kind", "feed", "tip_radius", "out"])]
        plan: Option<PathBuf>,
        /// Kind of the case: how far the part is off, or where it lies
        #[arg(long, value_enum, default_value_t = TouchKind::ProbeComp)]
        kind: TouchKind,
        /// Feed of the touches, mm/min, if all had the same: adds the column that shows a latency
        #[arg(long, value_name = "MM_PER_MIN", value_parser = positive)]
        feed: Option<f64>,
        /// Radius of the ball, mm
        #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = positive)]
        tip_radius: f64,
        /// The log is in inches
        #[arg(long)]
        inch: bool,
        /// Folder to write the case to; default: the table on standard output
        #[arg(long, value_name = "CASE")]
        out: Option<PathBuf>,
    },
}

/// Kinds of cases that are made of touches.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum TouchKind {
    ProbeComp,
    PoseIcp,
}

impl From<TouchKind> for ProbeLogKind {
    fn from(kind: TouchKind) -> Self {
        match kind {
            TouchKind::ProbeComp => Self::ProbeComp,
            TouchKind::PoseIcp => Self::PoseIcp,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Design {
    /// Stability, margins, steady error and response of a force loop by position impedance
    Force(ForceCard),
    /// Radius of the circle on which three touches measure a normal, from noise and curvature [E]
    MicroPlane(MicroPlaneCard),
}

#[derive(Args, Debug)]
pub(crate) struct MicroPlaneCard {
    /// Radius of the ball
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = positive)]
    pub(crate) tip_radius: f64,
    /// Standard uncertainty of a touch along the normal
    #[arg(long, value_name = "MM", default_value_t = 1e-3, value_parser = positive)]
    pub(crate) noise: f64,
    /// Principal curvatures of the part, 1/mm, hollow positive: "0.02,0" for a hollow cylinder of 50 mm
    #[arg(long, value_name = "K1,K2", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) curvatures: [f64; 2],
    /// Smallest and largest radius that the machine can go to, mm
    #[arg(long, value_name = "FROM,TO", default_value = "0.05,0.5", value_parser = pair)]
    pub(crate) range: [f64; 2],
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

/// Where guide points are asked for, and where they are written.
#[derive(Args, Debug)]
pub(crate) struct Guiding {
    /// Case folder of kind probe-comp
    pub(crate) case: PathBuf,
    /// Above the touches of the case; default: a lattice over the part, by `[plan]`
    #[arg(long)]
    pub(crate) touched: bool,
    /// Above the touches of a plan: what `truing plan CASE --json` printed
    #[arg(long, value_name = "FILE.json", conflicts_with = "touched")]
    pub(crate) plan: Option<PathBuf>,
    /// Also write all of it as a table
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: Option<PathBuf>,
    /// Also write the rows of touches.csv to be filled in, with `guide_x_mm` and `guide_y_mm`
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) touches: Option<PathBuf>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

/// ITLICP as document [D] has it.
#[derive(Args, Debug)]
pub(crate) struct Sampling {
    /// Case folder of kind pose-icp with an asphere
    pub(crate) case: PathBuf,
    /// Spacing of the model's points at the first level
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = positive)]
    pub(crate) coarse: f64,
    /// Spacing at the second level
    #[arg(long, value_name = "MM", default_value_t = 1e-3, value_parser = positive)]
    pub(crate) fine: f64,
    /// Spacings of the first level that the second samples around each touch: 1 (c = 1) or 2 (c = 4)
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) patch: u8,
    /// It ends when every touch is nearer than this to a point of the model
    #[arg(long, value_name = "MM", default_value_t = 7e-3, value_parser = positive)]
    pub(crate) tolerance: f64,
    /// The whole aperture at this spacing in one level, in place of two
    #[arg(long, value_name = "MM", conflicts_with_all = ["coarse", "fine", "patch"], value_parser = positive)]
    pub(crate) classical: Option<f64>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct ForceCard {
    /// Softest and stiffest contact, N/mm
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1..=2, default_value = "10,10000", value_parser = positive)]
    pub(crate) contact: Vec<f64>,
    /// Mass M, kg; with --damping, else the recommended ones are taken
    #[arg(long, value_name = "KG", requires = "damping", value_parser = positive)]
    pub(crate) mass: Option<f64>,
    /// Damping D, N·s/mm
    #[arg(long, value_name = "NS_PER_MM", requires = "mass", value_parser = positive)]
    pub(crate) damping: Option<f64>,
    /// Stiffness K, N/mm
    #[arg(long, value_name = "N_PER_MM", requires = "mass", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) stiffness: f64,
    /// Sampling interval, s
    #[arg(long, value_name = "S", default_value_t = 1e-3, value_parser = positive)]
    pub(crate) interval: f64,
    /// Time from a sample to the moment when its command begins to act, s
    #[arg(long, value_name = "S", default_value_t = 1e-3, value_parser = not_negative)]
    pub(crate) delay: f64,
    /// Time constant with which the legs follow their command, s
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) lag: f64,
    /// Settling time wanted, s
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = positive)]
    pub(crate) settling: f64,
    /// Count the correction from the programmed path instead of from where the tool stands
    #[arg(long)]
    pub(crate) absolute: bool,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
    /// Also write a self-contained HTML page with the stable region as a picture
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct Next {
    /// Case folder
    pub(crate) case: PathBuf,
    /// Output of `truing loop CASE --json`; without it the loop is run first
    #[arg(long, value_name = "FILE.json")]
    pub(crate) answer: Option<PathBuf>,
    /// rivals, unobservable, all, or names of effects and quantities separated by commas; default:
    /// rivals if there are any, else what is not observable
    #[arg(long = "for", value_name = "AIM")]
    pub(crate) aim: Option<String>,
    /// Measurements to make at most, as 12, or minutes, as 30min; default: as many as were made
    #[arg(long, value_name = "N", value_parser = budget)]
    pub(crate) budget: Option<PlanBudget>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder to write the plan to: the case with rows to fill in, and the probing program where
    /// a machine runs one
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct Closing {
    #[command(flatten)]
    pub(crate) run: Run,
    /// Declare the effects that the loop found on another case, with the sizes found there: the
    /// output of `truing loop OTHER --json`
    #[arg(long, value_name = "FILE.json")]
    pub(crate) carry: Option<PathBuf>,
    /// Also simulate the data N times with their declared noise, and report how the results scatter
    /// (JCGM 101)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=10_000_000))]
    pub(crate) monte_carlo: Option<u32>,
}

#[derive(Args, Debug)]
pub(crate) struct Run {
    /// Case folder: `case.toml` and its tables; for `loop` also a folder whose `machine.toml` lists
    /// cases that were measured on one machine
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
    /// Also write the errors of a rotary axis as a plain table in the layout of Heidenhain's: to be
    /// read, no control imports it as a compensation
    #[arg(long, value_name = "FILE.tab")]
    pub(crate) heidenhain: Option<PathBuf>,
    /// Also write what the errors of a rotary axis do to a point that turns with it, such as the tip of a
    /// tool, as CSV: the first-order map and the exact displacement
    #[arg(long, value_name = "FILE.csv", requires = "point")]
    pub(crate) point_errors: Option<PathBuf>,
    /// That point, mm, in the frame of the reflectors' places: "x,y,z"
    #[arg(long, value_name = "X,Y,Z", requires = "point_errors", value_parser = triple, allow_hyphen_values = true)]
    pub(crate) point: Option<[f64; 3]>,
    /// Largest rotation of a rotary axis that is written as a correction; default: 1 degree
    #[arg(long, value_name = "DEG")]
    pub(crate) max_correction: Option<f64>,
    /// Also write a self-contained HTML report
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
}

/// A case to be solved.
#[derive(Args, Debug)]
pub(crate) struct Solving {
    #[command(flatten)]
    pub(crate) run: Run,
    /// Also simulate the data N times with their declared noise, and report how the results scatter
    /// (JCGM 101)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=10_000_000))]
    pub(crate) monte_carlo: Option<u32>,
}

impl Run {
    /// Files of estimates that are asked for.
    pub(crate) fn exports(&self) -> impl Iterator<Item = (&Path, Export)> {
        let point = self.point.map(Export::PointErrors);
        let all = [
            (&self.errors, Some(Export::Csv)),
            (&self.compensation, Some(Export::LinuxCnc)),
            (&self.heidenhain, Some(Export::Heidenhain)),
            (&self.point_errors, point),
        ];
        all.into_iter().filter_map(|(path, format)| Some((path.as_deref()?, format?)))
    }

    /// All files that are asked for.
    pub(crate) fn outputs(&self) -> Vec<&Path> {
        self.exports().map(|(path, _)| path).chain(self.report.as_deref()).collect()
    }
}
