#![doc = include_str!("../README.md")]

mod carry;
mod case;
mod checked;
mod closed;
mod conformity;
mod count;
mod depth;
mod design;
mod drawn;
mod error;
mod estimated;
mod estimates;
mod file;
mod form;
mod found_pose;
mod guide;
mod header;
mod implausible;
mod import;
mod interval_width;
mod itlicp;
mod kind;
mod kinds;
mod layout;
mod machine;
mod measured;
mod monitor;
mod monte_carlo;
mod noise_test;
mod odd_check;
mod page;
mod plan;
mod plausible;
mod program;
mod read;
mod refit;
mod register;
mod regrouped;
mod residual;
mod settled;
mod shape;
mod solved;
mod step;
mod suspect;
mod text;
mod text_table;
mod uncertain;

pub use force_impedance;
pub use frame_fit;
pub use ft_center;
pub use geometry;
pub use least_squares;
pub use model_discrepancy;
pub use pose_icp;
pub use probe_comp;
pub use tracker_lm;
pub use truing_report as report;

pub use carry::{CarriedEffect, CarryProblem, Learnt, read_learnt};
pub use case::{Location, Problem, Provenance, ReadOptions, quantity_of};
pub use checked::{Checked, Counts, Detectable, Determined, HiddenEffect, ObservableEffect, check};
pub use closed::{
    Carried, Closed, JudgedRms, LoopNotObservable, LoopRemaining, LoopStability, LoopStep,
    LoopTiming, close_loop, close_loop_drawn,
};
pub use conformity::LimitDecision;
pub use depth::{Depth, DepthAt, DepthRange, PolishingTool, Removal, Within, depth};
pub use design::{
    ContactDesign, ForceDesign, ForceDesignInput, MicroPlane, MicroPlaneInput, StableRegion,
    design_force, design_micro_plane, force_report,
};
pub use error::Error;
pub use estimated::{Estimated, Export, LoopParameter};
pub use estimates::Estimates;
pub use file::{FileProblem, InputFile, OutputFile, refuse_overlap, write_files};
pub use guide::{Guide, GuideSource, Guides, guides};
pub use header::{Header, Program};
pub use implausible::ImplausibleResult;
pub use import::{
    ColumnMap, ImportProblem, ImportedFace, ImportedTable, ImportedTouches, ProbeLogKind,
    ProbeLogSettings, StepImport, TableImport, import_planned_log, import_probe_log, import_step,
    import_table, write_imported,
};
pub use interval_width::IntervalWidth;
pub use itlicp::{Itlicp, ItlicpLevel, ItlicpPoint, ItlicpTiming, PoseBeside, itlicp};
pub use kinds::{
    AffineEstimate, AxesRelationEstimate, AxisCorrection, AxisErrorEstimate, AxisEstimate,
    AxisFigureEstimate, AxisLocationEstimate, AxisRunEstimate, AxisTargetEstimate, CenterEstimate,
    Conformity, ContactForceEstimate, DisplacementEstimates, DisplacementResidual,
    DistanceResidual, ForceBlock, ForceImpedanceEstimates, FrameEstimate, FrameFitEstimates,
    FtCenterEstimates, GravityEstimates, HeightCheck, ImpedanceEstimate, LineMiss, LobeEstimate,
    MeanWrench, MeasuredNormalEstimate, MountEstimate, PathCell, PathError, PathForceEstimates,
    PlaceEstimate, PlannedContactEstimate, PointResidual, PoseEstimate, PoseIcpEstimates,
    PoseIntervals, PoseNumbers, PoseResidual, PositionResidual, PositioningEstimates,
    PositioningFigures, ProbeCompEstimates, ProbingCheckEstimate, QualificationEstimate,
    RepeatabilityEstimate, ScaleEstimate, SecondAxisEstimate, StationEstimate, TipEstimates,
    TouchEstimate, TouchResidual, TrackerLmEstimates, TransformStd, WrenchEstimate, examples,
    kinds, write_example,
};
pub use layout::{Detail, Layout};
pub use machine::{
    Agreement, CaseOfMachine, ClosedMachine, Machine, MachineProblem, StepByCase, StepInCase,
    close_machine, is_machine, machine_report, read_machine,
};
pub use monitor::{
    PathEvent, PathMonitor, PathMonitorOptions, PathSummary, RowProblem, StreamRow, StreamTable,
    What,
};
pub use monte_carlo::{DrawnParameter, MonteCarlo, monte_carlo};
pub use noise_test::Repeats;
pub use page::{loop_report, read_findings, read_page, solve_report};
pub use plan::{
    PlanBudget, PlanClass, PlanFigure, PlanOptions, PlanProblem, Planned, PlannedMeasurement,
    PlannedTouchPlace, Prediction, plan, write_plan,
};
pub use plausible::plausible;
pub use program::{Corrected, correct};
pub use read::{Case, read_case, read_case_with};
pub use register::{RegisterSettings, RegisterTiming, Registered, register};
pub use residual::Residual;
pub use shape::{Shape, ShapeProblem, read_shape};
pub use solved::{SolveTiming, Solved, solve, solve_drawn};
pub use step::{StepFace, StepFaces, StepNet, StepProblem, StepSurface, read_step};
pub use suspect::Suspect;
pub use text_table::TextTable;

/// The examples of the repository's first page, so that they are compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct FirstPage;

/// Runs the listing of the page on models of one's own.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/own-model.md")]
struct OwnModel;

/// Runs the listings of the page on adding effects, surfaces and kinds.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/adding.md")]
struct Adding;
