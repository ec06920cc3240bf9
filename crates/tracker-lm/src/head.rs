//! Poses of a head with two rotary axes: each turns while the other one stands.

use crate::angle_steps::{AngleSteps, SAME_ANGLE_RAD};
use crate::{RotaryAxis, SecondAxis, Survey, TrackerError};

/// Angles of both axes from the one on where both stand, the angle of each step, and where each
/// axis stands.
type HeadAngles = (Vec<AngleSteps>, Vec<usize>, [f64; 2]);

pub(crate) fn head_angles(
    survey: &Survey,
    second: &SecondAxis,
) -> Result<HeadAngles, TrackerError> {
    let needed = survey.steps.len();
    if second.angles_rad.len() != needed {
        return Err(TrackerError::SecondAngles { needed, got: second.angles_rad.len() });
    }
    let pairs = survey.steps.iter().zip(&second.angles_rad);
    let poses: Vec<[f64; 2]> = pairs.map(|(step, angle)| [step.angle_rad, *angle]).collect();
    for (axis, letter) in [letter(&survey.axis), letter(&second.axis)].into_iter().enumerate() {
        if poses.iter().all(|pose| same(pose[axis], poses[0][axis])) {
            return Err(TrackerError::AxisStands {
                letter,
                angle_deg: poses[0][axis].to_degrees(),
            });
        }
    }
    let stand = common_pose(survey, &poses)?;
    let mut angles = vec![AngleSteps { axis: 0, angle_rad: stand[0], steps: Vec::new() }];
    let mut angle_of_step = Vec::with_capacity(needed);
    for (step, pose) in poses.iter().enumerate() {
        let turned = [0, 1].into_iter().find(|&axis| !same(pose[axis], stand[axis]));
        let known = match turned {
            None => Some(0),
            Some(axis) => {
                let is_same = |a: &AngleSteps| a.axis == axis && same(a.angle_rad, pose[axis]);
                angles.iter().skip(1).position(is_same).map(|at| at + 1)
            }
        };
        let at = known.unwrap_or(angles.len());
        if at == angles.len() {
            let axis = turned.unwrap_or(0);
            angles.push(AngleSteps { axis, angle_rad: pose[axis], steps: Vec::new() });
        }
        angles[at].steps.push(step);
        angle_of_step.push(at);
    }
    Ok((angles, angle_of_step, stand))
}

fn letter(axis: &RotaryAxis) -> char {
    axis.letter.letter()
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_ANGLE_RAD
}

/// The pose with which every other shares an angle.
///
/// Either the first axis stands there where it is at the first step, or the second one does; the first
/// step at which that one is elsewhere says where the other one stands.
fn common_pose(survey: &Survey, poses: &[[f64; 2]]) -> Result<[f64; 2], TrackerError> {
    let is_stray = |pose: &[f64; 2], of: &[f64; 2]| (0..2).all(|i| !same(pose[i], of[i]));
    let stray = |of: &[f64; 2]| poses.iter().position(|pose| is_stray(pose, of));
    let candidate = |axis: usize| {
        let mut stand = poses[0];
        let elsewhere = poses.iter().find(|pose| !same(pose[axis], stand[axis]))?;
        stand[1 - axis] = elsewhere[1 - axis];
        Some(stand)
    };
    let candidates: Vec<[f64; 2]> = [0, 1].into_iter().filter_map(candidate).collect();
    let sound = candidates.iter().filter(|of| stray(of).is_none());
    let is_measured = |of: &[f64; 2]| poses.iter().any(|pose| (0..2).all(|i| same(pose[i], of[i])));
    if let Some(stand) = sound.clone().find(|of| is_measured(of)) {
        return Ok(*stand);
    }
    if let Some(missing) = sound.clone().next() {
        let [first_deg, second_deg] = missing.map(f64::to_degrees);
        return Err(TrackerError::NoCommonPose { first_deg, second_deg });
    }
    let strays = |of: &[f64; 2]| poses.iter().filter(|pose| is_stray(pose, of)).count();
    let of = candidates.iter().min_by_key(|of| strays(of)).unwrap_or(&poses[0]);
    let [first_deg, second_deg] = of.map(f64::to_degrees);
    let step = survey.steps[stray(of).unwrap_or(0)].name.clone();
    Err(TrackerError::BothAxesTurned { step, first_deg, second_deg })
}
