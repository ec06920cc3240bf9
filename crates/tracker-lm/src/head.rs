//! Poses of a head with two rotary axes: each turns while the other one stands.

use crate::network::{Angle, SAME_ANGLE_RAD};
use crate::{RotaryAxis, SecondAxis, Survey, TrackerError};

/// Angles of both axes from the one on where both stand, the angle of each step, and where each
/// axis stands.
type HeadAngles = (Vec<Angle>, Vec<usize>, [f64; 2]);

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
    let mut angles = vec![Angle { axis: 0, angle_rad: stand[0], steps: Vec::new() }];
    let mut angle_of_step = Vec::with_capacity(needed);
    for (step, pose) in poses.iter().enumerate() {
        let turned = [0, 1].into_iter().find(|&axis| !same(pose[axis], stand[axis]));
        let known = match turned {
            None => Some(0),
            Some(axis) => {
                let is_same = |a: &Angle| a.axis == axis && same(a.angle_rad, pose[axis]);
                angles.iter().skip(1).position(is_same).map(|at| at + 1)
            }
        };
        let at = known.unwrap_or(angles.len());
        if at == angles.len() {
            let axis = turned.unwrap_or(0);
            angles.push(Angle { axis, angle_rad: pose[axis], steps: Vec::new() });
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
fn common_pose(survey: &Survey, poses: &[[f64; 2]]) -> Result<[f64; 2], TrackerError> {
    let strays = |of: &[f64; 2]| {
        let is_stray = |pose: &&[f64; 2]| !same(pose[0], of[0]) && !same(pose[1], of[1]);
        poses.iter().filter(is_stray).count()
    };
    let Some(best) = poses.iter().min_by_key(|pose| strays(pose)) else {
        return Err(TrackerError::SecondAngles { needed: 0, got: 0 });
    };
    if strays(best) == 0 {
        return Ok(*best);
    }
    let all = poses.iter().flat_map(|a| poses.iter().map(|b| [a[0], b[1]]));
    let [first_deg, second_deg] = match all.into_iter().find(|pose| strays(pose) == 0) {
        Some(missing) => missing.map(f64::to_degrees),
        None => {
            let [first_deg, second_deg] = best.map(f64::to_degrees);
            let stray = poses.iter().position(|p| !same(p[0], best[0]) && !same(p[1], best[1]));
            let step = survey.steps[stray.unwrap_or(0)].name.clone();
            return Err(TrackerError::BothAxesTurned { step, first_deg, second_deg });
        }
    };
    Err(TrackerError::NoCommonPose { first_deg, second_deg })
}
