//! `MUKCa`: a ball on a robot's flange, seated by hand in two cups 50 mm apart.
//!
//! Two mistakes of the people who measured are in the data, and stay there: eight poses of one
//! placement carry the name of the wrong cup, and that placement stood one hole of the grid further
//! than its note says.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::readings::rows;
use super::{Case, Set};

const MM_PER_M: f64 = 1000.0;
/// Between the cups, by their drawing.
const APART_MM: f64 = 50.0;
/// Play of a printed cup.
const PLAY_MM: f64 = 0.1;
/// Poses of `frontleft` that its recorder filed under the second cup while the ball was in the
/// first: they lie 1 to 3 mm from the one and 50 mm from the other.
const WRONG_CUP: (&str, usize) = ("frontleft", 8);

/// Placements with the hole that their notes name: along the base's x and y, mm.
const PLACEMENTS: [(&str, [f64; 2]); 6] = [
    ("frontcenter", [150.0, 0.0]),
    ("frontleft", [150.0, -175.0]),
    ("frontright", [150.0, 175.0]),
    ("backcenter", [0.0, 0.0]),
    ("backleft", [0.0, -175.0]),
    ("backright", [0.0, 175.0]),
];

pub(super) const SET: Set = Set {
    name: "ball-in-cups",
    source: "github.com/platonics-delft/kinematics_calibration, commit 05a05ab4cbbe, data/panda_3, MIT",
    licence: "MIT, © 2024 platonics; fixtures/licences/kinematics-calibration.txt",
    place: "ball_in_cups/panda_3",
    reference: "one placement 15.0 mm, cups 40.2 mm apart; 2.6 mm and 50.8 mm once eight rows are moved",
    left_out: "pose; cup",
    convert,
};

/// A pose of the flange: cup, position in mm, quaternion `[w, x, y, z]`.
struct Pose {
    cup: usize,
    position_mm: [f64; 3],
    quaternion: [f64; 4],
}

fn convert(folder: &Path) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    let mut grid = "point,placement,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
    let mut notes = Vec::new();
    for (placement, hole_mm) in PLACEMENTS {
        let mut poses = read(&folder.join(placement))?;
        if placement == WRONG_CUP.0 || placement == "frontcenter" {
            cases.push(one_placement(placement, &poses));
        }
        if placement == WRONG_CUP.0 {
            let filed = poses.iter_mut().filter(|pose| pose.cup == 1);
            filed.take(WRONG_CUP.1).for_each(|pose| pose.cup = 0);
            notes.push(format!(
                "the first {} poses of {placement} under cup 1 counted with cup 0",
                WRONG_CUP.1
            ));
        }
        for (cup, [x, y, _]) in cups_mm(&poses)?.into_iter().enumerate() {
            let along = hole_mm[1] + if cup == 0 { 0.0 } else { APART_MM };
            // A string takes every character.
            let _ = writeln!(
                grid,
                "{placement}-{cup},{placement},{},{along},{x:.3},{y:.3}",
                hole_mm[0]
            );
        }
    }
    notes.push(
        "from: the holes that the notes name, on a grid of 25 mm; to: cups in the base of the robot, \
         by a least-squares tip and two cups per placement"
            .to_owned(),
    );
    cases.push(Case {
        name: "grid".to_owned(),
        settings: "kind = \"frame-fit\"\n".to_owned(),
        tables: vec![("pairs.csv", grid)],
        notes,
        carry: None,
    });
    Ok(cases)
}

/// Poses of one placement under the names that they were filed under.
fn one_placement(placement: &str, poses: &[Pose]) -> Case {
    let mut table = "pose,place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned();
    let mut counts = [0; 2];
    for Pose { cup, position_mm, quaternion } in poses {
        counts[*cup] += 1;
        let numbers = position_mm.iter().map(|v| format!("{v:.6}"));
        let numbers: Vec<String> =
            numbers.chain(quaternion.iter().map(|v| format!("{v:.9}"))).collect();
        // A string takes every character.
        let _ = writeln!(table, "{cup}-{},cup {cup},{}", counts[*cup], numbers.join(","));
    }
    Case {
        name: placement.to_owned(),
        settings: "kind = \"frame-fit\"\n".to_owned(),
        tables: vec![
            ("poses.csv", table),
            (
                "distances.csv",
                format!("from,to,distance_mm,std_mm\ncup 0,cup 1,{APART_MM},{PLAY_MM}\n"),
            ),
        ],
        notes: vec![
            format!("{} and {} poses; m to mm; quaternions as published", counts[0], counts[1]),
            "cups 50 mm apart by their drawing; 0.1 mm for the play of a printed cup".to_owned(),
        ],
        carry: None,
    }
}

fn read(folder: &Path) -> Result<Vec<Pose>> {
    let mut poses = Vec::new();
    for cup in 0..2 {
        let path = folder.join(format!("hole_{cup}_pose.csv"));
        for (index, row) in rows(&path)?.into_iter().enumerate() {
            ensure!(row.len() == 7, "{}:{}: seven numbers expected", path.display(), index + 1);
            poses.push(Pose {
                cup,
                position_mm: [row[0], row[1], row[2]].map(|v| MM_PER_M * v),
                quaternion: [row[3], row[4], row[5], row[6]],
            });
        }
    }
    Ok(poses)
}

/// Cups of one placement by least squares: `p + R·t = c`, nine unknowns.
fn cups_mm(poses: &[Pose]) -> Result<[[f64; 3]; 2]> {
    const UNKNOWNS: usize = 9;
    let mut normal = [[0.0; UNKNOWNS + 1]; UNKNOWNS];
    for pose in poses {
        let rotation = matrix(pose.quaternion);
        for (axis, (of_tip, p)) in rotation.iter().zip(pose.position_mm).enumerate() {
            // R·t − c = −p.
            let mut row = [0.0; UNKNOWNS + 1];
            row[..3].copy_from_slice(of_tip);
            row[3 + 3 * pose.cup + axis] = -1.0;
            row[UNKNOWNS] = -p;
            for (line, left) in normal.iter_mut().zip(row) {
                line.iter_mut().zip(row).for_each(|(cell, right)| *cell += left * right);
            }
        }
    }
    let x = solved(normal).context("the poses do not determine the tip")?;
    Ok([[x[3], x[4], x[5]], [x[6], x[7], x[8]]])
}

/// Gauss's elimination with row exchange; the last column is the right-hand side.
fn solved<const N: usize, const M: usize>(mut rows: [[f64; M]; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let largest =
            |a: &usize, b: &usize| rows[*a][column].abs().total_cmp(&rows[*b][column].abs());
        let pivot = (column..N).max_by(largest)?;
        rows.swap(column, pivot);
        if rows[column][column].abs() < f64::EPSILON {
            return None;
        }
        for other in (0..N).filter(|other| *other != column) {
            let factor = rows[other][column] / rows[column][column];
            let pivot_row = rows[column];
            for (cell, above) in rows[other].iter_mut().zip(pivot_row).skip(column) {
                *cell -= factor * above;
            }
        }
    }
    Some(std::array::from_fn(|i| rows[i][M - 1] / rows[i][i]))
}

fn matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_poses_give_the_cups_back() {
        let tip = [1.0, -2.0, 33.0];
        let cups = [[600.0, -25.0, 15.0], [600.0, 25.0, 16.0]];
        let poses: Vec<Pose> = (0..20)
            .map(|i| {
                let (a, b) = (0.4 * f64::from(i).sin(), 0.3 * (1.7 * f64::from(i)).cos());
                let w = (1.0 - a * a - b * b).sqrt();
                let rotation = matrix([w, a, b, 0.0]);
                let cup = usize::from(i % 2 == 1);
                let position_mm = std::array::from_fn(|k| {
                    cups[cup][k] - (0..3).map(|j| rotation[k][j] * tip[j]).sum::<f64>()
                });
                Pose { cup, position_mm, quaternion: [w, a, b, 0.0] }
            })
            .collect();
        for (found, cup) in cups_mm(&poses).unwrap().into_iter().zip(cups) {
            for (f, c) in found.into_iter().zip(cup) {
                // 1e3 mm · 2⁻⁵² · the condition of tilts of 0.3 rad.
                assert!((f - c).abs() < 1e-9);
            }
        }
    }
}
