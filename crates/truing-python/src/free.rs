//! The direction that data leave free, where an error names one.

use std::fmt::Display;

use truing::Error;
use truing::force_impedance::ForceImpedanceError;
use truing::frame_fit::{FrameFitError, Transform};
use truing::ft_center::FtCenterError;
use truing::model_discrepancy::LoopError;
use truing::pose_icp::{PoseError, RegisterError, WeakMotion};
use truing::probe_comp::ProbeError;
use truing::tracker_lm::TrackerError;

/// What an error of the facade leaves free.
pub(crate) fn of(error: &Error) -> Option<String> {
    match error {
        Error::FrameFit { source, .. } => frame(source),
        Error::FtCenter { source, .. } => pressure(source),
        Error::PoseIcp { source, .. } => pose(source),
        Error::ProbeComp { source, .. } => probe(source),
        Error::ForceImpedance { source, .. } => force(source),
        Error::TrackerLm { source, .. } => tracker(source),
        Error::Loop { source, .. } => own(source),
        Error::Register { source, .. } => cloud(source),
        Error::Input { source, .. } => of(source),
        _ => None,
    }
}

fn frame(error: &FrameFitError) -> Option<String> {
    match error {
        FrameFitError::TooFewPoints { got: 0, .. } => Some("the whole transform".to_owned()),
        FrameFitError::TooFewPoints { transform: Transform::Affine, .. } => {
            Some("stretch and shear off the points".to_owned())
        }
        FrameFitError::TooFewPoints { got: 1, .. } => {
            Some("the rotation about the one point".to_owned())
        }
        FrameFitError::TooFewPoints { .. } => {
            Some("the rotation about the line through the points".to_owned())
        }
        FrameFitError::Degenerate { free, .. } => Some(free.to_string()),
        FrameFitError::TooNoisy { parameter, .. } => Some((*parameter).to_owned()),
        FrameFitError::Unobservable { directions } => Some(joined(directions)),
        FrameFitError::TipFree { direction: [x, y, z], .. } => {
            Some(format!("the tip along ({x:.3}, {y:.3}, {z:.3}) of the flange"))
        }
        _ => None,
    }
}

fn pressure(error: &FtCenterError) -> Option<String> {
    match error {
        FtCenterError::TooFewFramePoints { got: 0, .. } => Some("the whole frame".to_owned()),
        FtCenterError::TooFewFramePoints { .. }
        | FtCenterError::CoincidentPoints { .. }
        | FtCenterError::AngleFree { .. } => Some("the angle of the frame".to_owned()),
        FtCenterError::CollinearPoints { .. } => Some("the affine map across the line".to_owned()),
        FtCenterError::PosesNotEnough { parameter, .. } => Some((*parameter).to_owned()),
        _ => None,
    }
}

fn pose(error: &PoseError) -> Option<String> {
    let PoseError::Undetermined { directions } = error else { return None };
    let words = |motion: &WeakMotion| {
        let words: Vec<_> = motion.components.iter().map(|c| c.parameter.words()).collect();
        words.join(" against ")
    };
    Some(joined(&directions.iter().map(words).collect::<Vec<_>>()))
}

fn probe(error: &ProbeError) -> Option<String> {
    match error {
        ProbeError::NeighboursOnALine { .. } => {
            Some("the tilt about the line of the touches".to_owned())
        }
        ProbeError::NotQualified { free } if !free.is_empty() => Some(free.join(", ")),
        _ => None,
    }
}

fn force(error: &ForceImpedanceError) -> Option<String> {
    matches!(error, ForceImpedanceError::LegsDoNotHold { .. })
        .then(|| "a tilt of the head".to_owned())
}

fn tracker(error: &TrackerError) -> Option<String> {
    match error {
        TrackerError::TooFewStations { .. } => Some("the position of the stations".to_owned()),
        TrackerError::TooFewMounts { .. } => {
            Some("the rotation about the line through two reflectors".to_owned())
        }
        TrackerError::CollinearMounts { line: [x, y, z], .. } => {
            Some(format!("the rotation about ({x:.3}, {y:.3}, {z:.3})"))
        }
        TrackerError::CollinearStations => {
            Some("the rotation about the line of the stations".to_owned())
        }
        TrackerError::AxisNotFound => Some("a point on the axis".to_owned()),
        TrackerError::UndeterminedAngle { free, .. } => Some(free.join(", ")),
        TrackerError::Unobservable { directions } => Some(joined(directions)),
        _ => None,
    }
}

fn own(error: &LoopError) -> Option<String> {
    let LoopError::Unobservable { directions } = error else { return None };
    Some(joined(directions))
}

fn cloud(error: &RegisterError) -> Option<String> {
    let RegisterError::Undetermined { directions } = error else { return None };
    Some(joined(directions))
}

fn joined(parts: &[impl Display]) -> String {
    parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
}
