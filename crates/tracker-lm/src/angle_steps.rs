//! Steps that stop at the same angle.

use crate::Step;

/// Steps nearer to each other than this are at the same angle: 10 nm on a metre.
pub(crate) const SAME_ANGLE_RAD: f64 = 1e-8;

/// Stops at one angle.
#[derive(Clone, Debug)]
pub(crate) struct AngleSteps {
    /// Which axis turned: 0, or 1 the second of two.
    pub(crate) axis: usize,
    pub(crate) angle_rad: f64,
    pub(crate) steps: Vec<usize>,
}

/// Steps by angle, in the order in which each angle first comes, and the angle of each step.
pub(crate) fn angles(steps: &[Step]) -> (Vec<AngleSteps>, Vec<usize>) {
    let mut by_angle: Vec<usize> = (0..steps.len()).collect();
    by_angle.sort_by(|&a, &b| steps[a].angle_rad.total_cmp(&steps[b].angle_rad).then(a.cmp(&b)));
    let mut angles: Vec<AngleSteps> = Vec::new();
    for step in by_angle {
        let angle_rad = steps[step].angle_rad;
        match angles.last_mut() {
            Some(last) if angle_rad - last.angle_rad <= SAME_ANGLE_RAD => last.steps.push(step),
            _ => angles.push(AngleSteps { axis: 0, angle_rad, steps: vec![step] }),
        }
    }
    for angle in &mut angles {
        angle.steps.sort_unstable();
    }
    angles.sort_by_key(|a| a.steps[0]);
    let mut angle_of_step = vec![0; steps.len()];
    for (a, angle) in angles.iter().enumerate() {
        for &step in &angle.steps {
            angle_of_step[step] = a;
        }
    }
    (angles, angle_of_step)
}
