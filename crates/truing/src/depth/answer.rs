use serde::Serialize;

use crate::Header;

/// Answer of `truing depth`; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Depth {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// The tool, as the case says it.
    pub tool: PolishingTool,
    /// Points of the program at which the part presses into the film.
    pub points: usize,
    /// Points in feed beside the part.
    pub beside_the_part: usize,
    /// Points in feed at which the film does not reach the part.
    pub above_the_film: usize,
    /// Depths where the program runs as written; `None` where it is in coordinates of the workpiece.
    pub as_written: Option<DepthRange>,
    /// Depths once it is corrected for where the part lies.
    pub corrected: Option<DepthRange>,
    /// The largest standard uncertainty of a corrected depth.
    pub std_mm: Option<f64>,
    /// Whether all are within the tolerance; `None` without uncertainties.
    pub within: Option<Within>,
    /// What the uncertainty means for the removal; `None` without `removal_exponent`.
    pub removal: Option<Removal>,
    /// Every depth.
    pub depths: Vec<DepthAt>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// A polishing tool with a film of a height that its lowest point carries.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PolishingTool {
    /// Height H of the film below the tool's lowest point, before it meets the part.
    pub film_mm: f64,
    /// Depth that is asked for; `None`: the planned one, point by point.
    pub depth_mm: Option<f64>,
    /// How far a depth may be from that, either way.
    pub tolerance_mm: f64,
    /// Standard uncertainty of the height of the film.
    pub std_film_mm: f64,
    /// Standard uncertainty of the radius of the ball that touched the part.
    pub std_tip_mm: f64,
    /// Standard uncertainty of the machine's positioning along the part's normal.
    pub std_axis_mm: f64,
    /// Standard uncertainty of the part's form at one place, along its normal: of the map that was measured
    /// of it, or of the drawing.
    pub std_form_mm: f64,
    /// Power of the depth with which the removal goes.
    pub removal_exponent: Option<f64>,
}

/// The least, the mean and the largest depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRange {
    /// The least.
    pub least_mm: f64,
    /// The mean.
    pub mean_mm: f64,
    /// The largest.
    pub largest_mm: f64,
}

/// Conformity with the tolerance (JCGM 106).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Within {
    /// Probability that is asked of every point.
    pub required: f64,
    /// The least probability of any.
    pub probability: f64,
    /// Line of the program where that is.
    pub line: usize,
    /// `pass`, `fail` (it is as improbable as that) or `undecided`.
    pub decision: &'static str,
}

/// What the uncertainty of the depth means for the removal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Removal {
    /// Power of the depth with which it goes.
    pub exponent: f64,
    /// Largest standard uncertainty of the removal, as a ratio.
    pub largest_std_ratio: f64,
}

/// The depth at one point of the corrected program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthAt {
    /// Line of the program, from 1.
    pub line: usize,
    /// Lowest point of the tool, machine frame.
    pub x_mm: f64,
    /// As `x_mm`.
    pub y_mm: f64,
    /// As `x_mm`.
    pub z_mm: f64,
    /// Δh = H − h.
    pub depth_mm: f64,
    /// The same where the program runs as written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_written_mm: Option<f64>,
    /// Standard uncertainty of `depth_mm`.
    pub std_mm: Option<f64>,
    /// Its part from the pose of the part.
    pub std_pose_mm: Option<f64>,
    /// Its part from the radius of the ball.
    pub std_tip_mm: f64,
}

impl DepthRange {
    pub(super) fn of(depths_mm: &[f64]) -> Option<Self> {
        if depths_mm.is_empty() {
            return None;
        }
        Some(Self {
            least_mm: depths_mm.iter().copied().fold(f64::INFINITY, f64::min),
            mean_mm: depths_mm.iter().sum::<f64>() / crate::count::count(depths_mm.len()),
            largest_mm: depths_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}
