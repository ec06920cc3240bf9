use std::path::{Path, PathBuf};

use force_impedance::ForceImpedanceError;
use frame_fit::{FrameFitError, Transform};
use ft_center::FtCenterError;
use model_discrepancy::LoopError;
use pose_icp::{PoseError, ProgramError, RegisterError};
use probe_comp::ProbeError;
use tracker_lm::TrackerError;

use crate::implausible::ImplausibleResult;
use crate::{
    CarryProblem, FileProblem, ImportProblem, Location, MachineProblem, PlanProblem, Problem,
    RowProblem, ShapeProblem, StepProblem, Suspect,
};

/// Why a command could not do what it was asked for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The case is unusable as it stands.
    #[error("{at}: {problem}")]
    Case {
        /// Where.
        at: Box<Location>,
        /// What, and what to do.
        problem: Box<Problem>,
    },
    /// No transform can be had from the points.
    #[error("{at}: {source}{}", left_free(source))]
    FrameFit {
        /// The table.
        at: Box<Location>,
        /// Why.
        source: FrameFitError,
    },
    /// No centre can be had from the wrenches.
    #[error("{at}: {source}{}", frame_left_free(source))]
    FtCenter {
        /// The table, and the line where one is to blame.
        at: Box<Location>,
        /// Why.
        source: Box<FtCenterError>,
    },
    /// No pose can be had from the points.
    #[error("{at}: {source}")]
    PoseIcp {
        /// The table, and the line where one is to blame.
        at: Box<Location>,
        /// Why.
        source: Box<PoseError>,
    },
    /// No contacts can be had from the touches.
    #[error("{at}: {source}")]
    ProbeComp {
        /// The table, and the line where one is to blame.
        at: Box<Location>,
        /// Why.
        source: Box<ProbeError>,
    },
    /// No contact force can be had from the log.
    #[error("{at}: {source}")]
    ForceImpedance {
        /// The table, and the line where one is to blame.
        at: Box<Location>,
        /// Why.
        source: Box<ForceImpedanceError>,
    },
    /// No design can be made of the numbers.
    #[error("{source}")]
    Design {
        /// Why.
        source: Box<ForceImpedanceError>,
    },
    /// No micro-plane can be designed from the numbers.
    #[error("{source}")]
    DesignProbe {
        /// Why.
        source: Box<ProbeError>,
    },
    /// The axis cannot be calibrated.
    #[error("{at}: {source}")]
    TrackerLm {
        /// The table, and the line where one is to blame.
        at: Box<Location>,
        /// Why.
        source: Box<TrackerError>,
    },
    /// A kind of case that has nothing to export.
    #[error("a case of kind `{kind}` has no such file to write: only `tracker-lm` has")]
    NothingToExport {
        /// The kind.
        kind: &'static str,
    },
    /// A deliverable that no machine needs: something before it is wrong.
    #[error("{problem}")]
    Implausible {
        /// What is too large, what fits the data, and how to allow it.
        problem: Box<ImplausibleResult>,
    },
    /// Effects cannot be carried from another case.
    #[error("{}: {problem}", path.display())]
    Carry {
        /// File that the effects are carried from.
        path: PathBuf,
        /// What, and what to do.
        problem: Box<CarryProblem>,
    },
    /// The loop cannot be closed.
    #[error("{at}: {source}")]
    Loop {
        /// The case.
        at: Box<Location>,
        /// Why.
        source: LoopError,
    },
    /// A file of points or triangles is unusable.
    #[error("{}: {problem}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// What, and where in it.
        problem: ShapeProblem,
    },
    /// One cloud or mesh cannot be registered onto another.
    #[error("{}: {source}", path.display())]
    Register {
        /// The file that is to blame, or the source.
        path: PathBuf,
        /// Why.
        source: Box<RegisterError>,
    },
    /// A case without a frame to monitor a contact in.
    #[error(
        "a case of kind {kind} has no frame to monitor a contact in; give one of kind ft-center with \
         presses"
    )]
    NothingToMonitor {
        /// Kind of the case.
        kind: &'static str,
    },
    /// The stream of a monitor cannot be had.
    #[error("the stream cannot be read: {reason}")]
    Stream {
        /// What the system says.
        reason: std::io::ErrorKind,
    },
    /// A line of a stream is no row.
    #[error("stream, line {line}: {problem}")]
    StreamRow {
        /// From 1.
        line: usize,
        /// What is wrong with it.
        problem: RowProblem,
    },
    /// A registration was printed that had not come to rest.
    #[error(
        "not converged after {iterations} passes: what is printed is not an answer; start closer, \
         or allow more passes"
    )]
    NotSettled {
        /// Passes made.
        iterations: usize,
    },
    /// The system gives no threads.
    #[error("cannot start the threads asked for; ask for fewer by --threads")]
    NoThreads,
    /// A case that cannot be solved because its input is wrong.
    #[error("{source}; the input looks wrong: {}", suspect.description)]
    Input {
        /// Why it cannot be solved.
        source: Box<Error>,
        /// What is wrong, and what to change.
        suspect: Box<Suspect>,
    },
    /// A case without a pose to correct a program by.
    #[error("a case of kind {kind} has no pose of a part; give one of kind pose-icp")]
    NoPose {
        /// Kind of the case.
        kind: &'static str,
    },
    /// A program cannot be corrected.
    #[error("{}: {source}", path.display())]
    Program {
        /// The program.
        path: PathBuf,
        /// Why, with the line.
        source: Box<ProgramError>,
    },
    /// No kind of that name to write an example of.
    #[error(
        "unknown kind `{found}`{}; the kinds are {}",
        nearest.map_or_else(String::new, |n| format!("; did you mean `{n}`?")),
        expected.join(", ")
    )]
    UnknownKind {
        /// The kind asked for.
        found: String,
        /// The kind that was probably meant.
        nearest: Option<&'static str>,
        /// Kinds that there are.
        expected: Vec<&'static str>,
    },
    /// A file that was given cannot be read.
    #[error("{}: {problem}", path.display())]
    NotRead {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: FileProblem,
    },
    /// A file to write that the run reads.
    #[error(
        "{} is an input of this run{}; write to another file",
        path.display(),
        also_called(path, input)
    )]
    OutputIsInput {
        /// The output.
        path: PathBuf,
        /// The input by the name that it is read by.
        input: PathBuf,
    },
    /// Two files to write that are one.
    #[error("{} and {} are the same file; give each output a file of its own", other.display(), path.display())]
    OutputTwice {
        /// The second.
        path: PathBuf,
        /// The first.
        other: PathBuf,
    },
    /// A program that was corrected before.
    #[error(
        "{}, line {line}: the program was corrected already, and would be moved twice; correct the \
         original",
        path.display()
    )]
    AlreadyCorrected {
        /// The program.
        path: PathBuf,
        /// Line of the mark, from 1.
        line: usize,
    },
    /// A file that an index should gather is not a page of this program.
    #[error("{}: {source}", path.display())]
    Page {
        /// The file.
        path: PathBuf,
        /// Why.
        source: truing_report::ReadPageError,
    },
    /// A foreign table does not become one of a case.
    #[error("{}: {problem}", path.display())]
    Import {
        /// The table.
        path: PathBuf,
        /// Why.
        problem: Box<ImportProblem>,
    },
    /// No face of a STEP file becomes the part of a case.
    #[error("{}: {problem}", path.display())]
    Step {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: Box<StepProblem>,
    },
    /// A part that the method of document \[D\] cannot sample.
    #[error(
        "ITLICP samples a rotationally symmetric asphere as it is drawn; this part is none, or has a `[surface.form]`"
    )]
    NoAsphere,
    /// A case of which no guide point can be given.
    #[error(
        "no guide point: a case of kind `{kind}` has no place that a ball touches moving along z; guide \
         points are those of `probe-comp`, in the region that `[plan]` declares"
    )]
    NoGuides {
        /// Kind of the case.
        kind: &'static str,
    },
    /// A file that is no plan of touches.
    #[error("{}: not what `truing plan --json` prints for touches: {reason}", path.display())]
    NotAPlan {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A case that names no polishing tool.
    #[error(
        "{}: no `[tool]`: give it `film_mm`, the height of the film below the tool's lowest point",
        path.join("case.toml").display()
    )]
    NoTool {
        /// The case.
        path: PathBuf,
    },
    /// A program that never polishes the part.
    #[error(
        "{}: no move in feed polishes the part: {beside} of them end beside it and {above} above the          film; is the program in the coordinates that --planned says?",
        path.display()
    )]
    NoDepth {
        /// The program.
        path: PathBuf,
        /// Points beside the part.
        beside: usize,
        /// Points above the film.
        above: usize,
    },
    /// Cases cannot be taken together.
    #[error("{}: {problem}", path.display())]
    Machine {
        /// The file that lists them.
        path: PathBuf,
        /// Why, and what to do.
        problem: Box<MachineProblem>,
    },
    /// No further measurement can be planned.
    #[error("{}: {problem}", path.display())]
    Plan {
        /// The case, or the answer of the loop.
        path: PathBuf,
        /// Why, and what to do.
        problem: Box<PlanProblem>,
    },
    /// A list of findings for an index that is not one.
    #[error("{}: {source}; it should hold a list of texts by the name of each page", path.display())]
    Findings {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A file that an example case would overwrite.
    #[error("{} exists already; choose another folder", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error("{} cannot be written: {reason}", path.display())]
    NotWritten {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: std::io::ErrorKind,
    },
}

impl Error {
    pub(crate) fn case(at: Location, problem: Problem) -> Self {
        Self::Case { at: Box::new(at), problem: Box::new(problem) }
    }

    pub(crate) fn not_read(path: &Path, problem: FileProblem) -> Self {
        Self::NotRead { path: path.to_owned(), problem }
    }

    pub(crate) fn plan(path: &Path, problem: PlanProblem) -> Self {
        Self::Plan { path: path.to_owned(), problem: Box::new(problem) }
    }

    pub(crate) fn machine(path: &Path, problem: MachineProblem) -> Self {
        Self::Machine { path: path.to_owned(), problem: Box::new(problem) }
    }

    pub(crate) fn carry(path: &Path, problem: CarryProblem) -> Self {
        Self::Carry { path: path.to_owned(), problem: Box::new(problem) }
    }

    /// Whether the input is usable in form but leaves something free that must be known.
    #[must_use]
    pub fn is_undetermined(&self) -> bool {
        match self {
            Self::FrameFit { source, .. } => !matches!(
                source,
                FrameFitError::InvalidPair { .. }
                    | FrameFitError::InvalidLoss { .. }
                    | FrameFitError::InvalidCovariate { .. }
            ),
            Self::FtCenter { source, .. } => matches!(
                **source,
                FtCenterError::TooFewFramePoints { .. }
                    | FtCenterError::CoincidentPoints { .. }
                    | FtCenterError::AngleFree { .. }
                    | FtCenterError::CollinearPoints { .. }
                    | FtCenterError::PosesNotEnough { .. }
            ),
            Self::PoseIcp { source, .. } => matches!(
                **source,
                PoseError::TooFewTouches { .. }
                    | PoseError::Undetermined { .. }
                    | PoseError::NotConverged { .. }
            ),
            Self::ProbeComp { source, .. } => {
                matches!(
                    **source,
                    ProbeError::NeighboursOnALine { .. } | ProbeError::NotQualified { .. }
                )
            }
            Self::ForceImpedance { source, .. } => {
                matches!(**source, ForceImpedanceError::LegsDoNotHold { .. })
            }
            Self::TrackerLm { source, .. } => matches!(
                **source,
                TrackerError::TooFewStations { .. }
                    | TrackerError::TooFewMounts { .. }
                    | TrackerError::TooFewRanges { .. }
                    | TrackerError::TooFewAtReference { .. }
                    | TrackerError::CollinearMounts { .. }
                    | TrackerError::CollinearStations
                    | TrackerError::AxisNotFound
                    | TrackerError::UndeterminedAngle { .. }
                    | TrackerError::AxisStands { .. }
                    | TrackerError::NoCommonPose { .. }
                    | TrackerError::Unobservable { .. }
                    | TrackerError::NotConverged { .. }
            ),
            Self::Loop { source, .. } => matches!(
                source,
                LoopError::Unobservable { .. }
                    | LoopError::NotConverged { .. }
                    | LoopError::Stalled { .. }
                    | LoopError::TooFewGroups { .. }
            ),
            Self::Register { source, .. } => matches!(
                **source,
                RegisterError::Undetermined { .. } | RegisterError::TooFewPoints { .. }
            ),
            Self::NotSettled { .. } => true,
            Self::Input { source, .. } => source.is_undetermined(),
            Self::Case { .. }
            | Self::NothingToMonitor { .. }
            | Self::Stream { .. }
            | Self::StreamRow { .. }
            | Self::Carry { .. }
            | Self::Design { .. }
            | Self::DesignProbe { .. }
            | Self::NoPose { .. }
            | Self::Program { .. }
            | Self::Shape { .. }
            | Self::NoThreads
            | Self::UnknownKind { .. }
            | Self::Implausible { .. }
            | Self::NothingToExport { .. }
            | Self::NotRead { .. }
            | Self::Import { .. }
            | Self::Step { .. }
            | Self::OutputIsInput { .. }
            | Self::OutputTwice { .. }
            | Self::AlreadyCorrected { .. }
            | Self::Page { .. }
            | Self::Machine { .. }
            | Self::NoAsphere
            | Self::NoGuides { .. }
            | Self::NotAPlan { .. }
            | Self::NoTool { .. }
            | Self::NoDepth { .. }
            | Self::Plan { .. }
            | Self::Findings { .. }
            | Self::Exists { .. }
            | Self::NotWritten { .. } => false,
        }
    }

    /// Whether a search for the answer came to no end, or readings in another unit are so uncertain that there
    /// is none.
    pub(crate) fn is_unsettled(&self) -> bool {
        match self {
            Self::FtCenter { source, .. } => matches!(**source, FtCenterError::AngleFree { .. }),
            Self::PoseIcp { source, .. } => matches!(**source, PoseError::NotConverged { .. }),
            Self::TrackerLm { source, .. } => matches!(**source, TrackerError::NotConverged { .. }),
            _ => false,
        }
    }

    /// Row of the touch that is to blame, where one is.
    pub(crate) fn touch(&self) -> Option<usize> {
        match self {
            Self::ProbeComp { source, .. } => source.touch(),
            Self::PoseIcp { source, .. } => source.touch(),
            _ => None,
        }
    }

    /// Exit code of the command line: 3 where the data do not determine the answer, else 2.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        if self.is_undetermined() { 3 } else { 2 }
    }
}

/// The other name of a file, where it has one.
fn also_called(path: &Path, input: &Path) -> String {
    if path == input { String::new() } else { format!(", as {}", input.display()) }
}

/// What too few points leave free, which the count alone does not say.
fn left_free(error: &FrameFitError) -> &'static str {
    match error {
        FrameFitError::TooFewPoints { got: 0, .. } => "; the whole transform is free",
        FrameFitError::TooFewPoints { transform: Transform::Affine, .. } => {
            "; stretch and shear off the points are free"
        }
        FrameFitError::TooFewPoints { got: 1, .. } => "; the rotation about the one point is free",
        FrameFitError::TooFewPoints { .. } => {
            "; the rotation about the line through the points is free"
        }
        _ => "",
    }
}

/// What too few presses leave free.
fn frame_left_free(error: &FtCenterError) -> &'static str {
    match error {
        FtCenterError::TooFewFramePoints { got: 0, .. } => "; the whole frame is free",
        FtCenterError::TooFewFramePoints { .. } => "; the frame's angle is free",
        _ => "",
    }
}
