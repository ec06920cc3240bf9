//! How deep a part presses into the film of a polishing tool along a program: document \[D\],
//! Δh = H − h.

mod answer;
mod text;

use std::path::Path;

use nalgebra::{Isometry3, Point3};
use pose_icp::{Part, PoseFit, ProgramOptions, ProgramPoint, TipSide, gap_at, program_points};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::file::{InputFile, MAX_BYTES, read_text};
use crate::{Case, Error, Header};

pub use answer::{Depth, DepthAt, DepthRange, PolishingTool, Removal, Within};

/// The part as it lies under a polishing tool.
pub(crate) struct Polished {
    pub(crate) part: Part,
    pub(crate) side: TipSide,
    pub(crate) fit: PoseFit,
    /// The same found with a ball that is larger by the uncertainty of its radius.
    pub(crate) with_larger_tip: Option<PoseFit>,
    pub(crate) tool: Option<PolishingTool>,
}

/// Probability with which a depth must be within the tolerance to pass (JCGM 106).
const REQUIRED: f64 = 0.95;

/// The depth at every point that a program, written for the part at `planned` (workpiece to machine),
/// feeds to once it is corrected for where the part was found to lie, with its uncertainty.
///
/// The program leads the lowest point of the tool. Points beside the part, and those at which the
/// film does not reach it, are counted and left out.
///
/// # Errors
///
/// As [`solve`](crate::solve); [`Error::NoTool`] for a case without `[tool]`, [`Error::NoPose`] for
/// another kind, [`Error::NotRead`], [`Error::Program`] with the line that cannot be read,
/// [`Error::NoDepth`] for a program that never polishes the part.
pub fn depth(
    case: &Case,
    program: &Path,
    planned: Option<&Isometry3<f64>>,
) -> Result<Depth, Error> {
    let polished = case.measured.polished()?.ok_or(Error::NoPose { kind: case.kind })?;
    let tool = polished.tool.ok_or_else(|| Error::NoTool { path: case.path.clone() })?;
    let text =
        read_text(program, MAX_BYTES).map_err(|problem| Error::not_read(program, problem))?;
    let points = program_points(&text, &ProgramOptions::default())
        .map_err(|source| Error::Program { path: program.to_owned(), source: Box::new(source) })?;
    let Along { at, beside, above } = polished.along(&points, planned, &tool);
    if at.is_empty() {
        return Err(Error::NoDepth { path: program.to_owned(), beside, above });
    }
    let written: Vec<f64> = at.iter().filter_map(|at| at.as_written_mm).collect();
    let depths: Vec<f64> = at.iter().map(|at| at.depth_mm).collect();
    let std_mm = at.iter().map(|at| at.std_mm).reduce(|a, b| Some(a?.max(b?))).flatten();
    let mut header = Header::of("truing/depth/1", case);
    header.inputs.push(InputFile::given(program, text.as_bytes()));
    let mut warnings = case.warnings.clone();
    if std_mm.is_none() {
        warnings.push(String::from(
            "no depth has an uncertainty: the noise is not declared and no touch is redundant",
        ));
    }
    Ok(Depth {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header,
        tool,
        points: at.len(),
        beside_the_part: beside,
        above_the_film: above,
        as_written: DepthRange::of(&written),
        corrected: DepthRange::of(&depths),
        std_mm,
        within: within(&tool, &at),
        removal: removal(&tool, &at),
        depths: at,
        warnings,
    })
}

/// Points of a program, by where they are.
#[derive(Default)]
struct Along {
    at: Vec<DepthAt>,
    beside: usize,
    above: usize,
}

impl Polished {
    /// The depth at every point that a program feeds to.
    fn along(
        &self,
        points: &[ProgramPoint],
        planned: Option<&Isometry3<f64>>,
        tool: &PolishingTool,
    ) -> Along {
        let planned_at = planned.copied().unwrap_or_else(Isometry3::identity);
        let found = self.fit.machine_from_workpiece;
        let mut along = Along::default();
        for point in points.iter().filter(|point| point.in_feed) {
            let corrected_mm = found * planned_at.inverse_transform_point(&point.point_mm);
            let gap = gap_at(&self.part, &self.fit, self.side, &corrected_mm);
            let Some(gap) = gap.ok().filter(|gap| gap.inside_aperture) else {
                along.beside += 1;
                continue;
            };
            let depth_mm = tool.film_mm - gap.gap_mm;
            if depth_mm <= 0.0 {
                along.above += 1;
                continue;
            }
            let as_written_mm = planned
                .and_then(|_| gap_at(&self.part, &self.fit, self.side, &point.point_mm).ok())
                .map(|gap| tool.film_mm - gap.gap_mm);
            let std_pose_mm = gap.sigma_mm;
            let std_tip_mm = self.by_tip_mm(&corrected_mm, gap.gap_mm);
            let apart = [tool.std_axis_mm, tool.std_film_mm, tool.std_form_mm, std_tip_mm];
            let fixed: f64 = apart.iter().map(|std_mm| std_mm * std_mm).sum();
            along.at.push(DepthAt {
                line: point.line,
                x_mm: corrected_mm.x,
                y_mm: corrected_mm.y,
                z_mm: corrected_mm.z,
                depth_mm,
                as_written_mm,
                std_mm: std_pose_mm.map(|pose| (pose * pose + fixed).sqrt()),
                std_pose_mm,
                std_tip_mm,
            });
        }
        along
    }

    /// Standard uncertainty of a gap from that of the ball's radius, which all touches share.
    fn by_tip_mm(&self, point_mm: &Point3<f64>, gap_mm: f64) -> f64 {
        let Some(fit) = &self.with_larger_tip else { return 0.0 };
        let gap = gap_at(&self.part, fit, self.side, point_mm);
        gap.map_or(0.0, |gap| (gap.gap_mm - gap_mm).abs())
    }
}

/// Whether every depth is within the tolerance of the one asked for, or of the planned one.
fn within(tool: &PolishingTool, at: &[DepthAt]) -> Option<Within> {
    let normal = Normal::standard();
    let probability = |at: &DepthAt| {
        let off = tool.depth_mm.map_or(0.0, |asked| at.depth_mm - asked);
        let std = at.std_mm?.max(f64::MIN_POSITIVE);
        let below = |limit: f64| normal.cdf((limit - off) / std);
        Some(below(tool.tolerance_mm) - below(-tool.tolerance_mm))
    };
    let all = at.iter().map(|at| Some((probability(at)?, at.line))).collect::<Option<Vec<_>>>()?;
    let (probability, line) = all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let decision = if probability >= REQUIRED {
        "pass"
    } else if probability <= 1.0 - REQUIRED {
        "fail"
    } else {
        "undecided"
    };
    Some(Within { required: REQUIRED, probability, line, decision })
}

/// By how much the removal varies, where it goes with a power of the depth.
fn removal(tool: &PolishingTool, at: &[DepthAt]) -> Option<Removal> {
    let exponent = tool.removal_exponent?;
    let share = |at: &DepthAt| Some(exponent * at.std_mm? / at.depth_mm);
    let largest = at.iter().filter_map(share).fold(0.0, f64::max);
    Some(Removal { exponent, largest_std_ratio: largest })
}
