//! ATI Axia80: a force/torque sensor with a tool of unknown weight, held still in 100 poses.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, ensure};

use super::readings::rows;
use super::{Case, Set};

/// Poses of one block, which share what drifts slowly.
const BLOCK: usize = 5;

pub(super) const BY_POSE: Set = Set {
    name: "ati-gravity",
    source: SOURCE,
    licence: "none stated",
    place: PLACE,
    reference: REFERENCE,
    left_out: "pose",
    convert: |folder| convert(folder, ""),
};

pub(super) const BY_BLOCK: Set = Set {
    name: "ati-gravity-blocks",
    source: SOURCE,
    licence: "none stated",
    place: PLACE,
    reference: REFERENCE,
    left_out: "block of five poses",
    convert: |folder| convert(folder, "\n[loop]\ngroup = \"block\"\n"),
};

const SOURCE: &str = "github.com/leledeyuan00/Gravity-Compensation-F-T-sensor, commit 139efe1841f9, \
                      datas/, no licence stated";
const PLACE: &str = "ft_gravity_ati";
/// Of one axis; the loop's figures are of the vector, √3 times as large.
const REFERENCE: &str = "0.293 N per axis, 0.068 after drift of the zero";

fn convert(folder: &Path, grouping: &str) -> Result<Vec<Case>> {
    let poses = rows(&folder.join("recorded_messages_pose_100.txt"))?;
    let wrenches = rows(&folder.join("recorded_messages_wrench_100.txt"))?;
    ensure!(poses.len() == wrenches.len(), "{} poses, {} wrenches", poses.len(), wrenches.len());
    let mut table = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm,block\n".to_owned();
    for (i, (pose, wrench)) in poses.iter().zip(&wrenches).enumerate() {
        ensure!(pose.len() == 7 && wrench.len() == 6, "row {}: unexpected columns", i + 1);
        let q = unit([pose[6], pose[3], pose[4], pose[5]]);
        // Published in the robot's base frame; the sensor read them in its own.
        let force = turned_back(q, [wrench[0], wrench[1], wrench[2]]);
        let moment = turned_back(q, [wrench[3], wrench[4], wrench[5]]).map(|m| 1000.0 * m);
        let numbers: Vec<String> =
            q.iter().chain(&force).chain(&moment).map(|v| format!("{v:.8}")).collect();
        // A string takes every character.
        let _ = writeln!(table, "{i},{},B{}", numbers.join(","), i / BLOCK);
    }
    let notes = vec![
        format!(
            "{} poses; wrenches turned back from the base frame into the sensor's",
            poses.len()
        ),
        "no time stamps: the row counts as time".to_owned(),
    ];
    Ok(vec![Case {
        name: "poses".to_owned(),
        settings: format!("kind = \"ft-center\"\n{grouping}"),
        tables: vec![("gravity.csv", table)],
        notes,
        carry: None,
    }])
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    q.map(|v| v / norm)
}

/// `Rᵀ·v` for the rotation of the quaternion `[w, x, y, z]`.
fn turned_back([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    std::array::from_fn(|k| rows[0][k] * v[0] + rows[1][k] * v[1] + rows[2][k] * v[2])
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use crate::generators::noise::gaussian;
    use crate::generators::vector::orthonormal;

    /// Error on unseen poses with a drift that goes on evenly, and that breaks off at pose 49.5, N.
    const WITHOUT_N: f64 = 0.275;
    const WITH_N: f64 = 0.061;
    const POSES: usize = 100;
    /// Poses before and after an interruption at least.
    const MARGIN: usize = 8;

    /// Square of what is left of `values` beside the columns.
    fn left(values: &[f64], columns: &[Vec<f64>]) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let explained: f64 = orthonormal(columns).iter().map(|d| dot(d, values).powi(2)).sum();
        dot(values, values) - explained
    }

    /// A hundred poses without time stamps cannot tell whether a drift that looks interrupted paused and
    /// jumped, or its rate changed by chance: of zeros whose rate wanders, a third look interrupted somewhere by as large a
    /// share of the variance as the recording's.
    #[test]
    fn a_wandering_drift_looks_as_interrupted() {
        let share = 1.0 - (WITH_N / WITHOUT_N).powi(2);
        let number = |i: usize| f64::from(u32::try_from(i).expect("a hundred"));
        let ones = vec![1.0; POSES];
        let along: Vec<f64> = (0..POSES).map(|i| number(i) / number(POSES) - 0.5).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(49);
        let (runs, mut as_interrupted) = (200, 0);
        for _ in 0..runs {
            let (mut rate, mut zero) = (0.0, 0.0);
            let zeros: Vec<f64> = (0..POSES)
                .map(|_| {
                    rate += gaussian(&mut rng);
                    zero += rate;
                    zero
                })
                .collect();
            let straight = left(&zeros, &[ones.clone(), along.clone()]);
            let at = |k: usize| {
                let after = |of: &[f64]| -> Vec<f64> {
                    of.iter().enumerate().map(|(i, v)| if i < k { 0.0 } else { *v }).collect()
                };
                left(&zeros, &[ones.clone(), along.clone(), after(&ones), after(&along)])
            };
            let best = (MARGIN..POSES - MARGIN).map(at).fold(f64::INFINITY, f64::min);
            as_interrupted += usize::from(1.0 - best / straight >= share);
        }
        assert!(as_interrupted > runs / 5, "{as_interrupted} of {runs}");
    }
}
