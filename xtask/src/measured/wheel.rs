//! `SmartWheel`: the wrench at the hub of a wheelchair's wheel that turns, with nobody at the rim.
//!
//! Published in the frame of the hub, which does not turn; the sensor sits in the wheel and turns
//! with it, so its zero does, and the weight of rim and rubber does not.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::{Case, Set};

/// Readings per second as published.
const RATE_HZ: f64 = 240.0;
/// One reading in so many is kept: ten a second, some ten a turn.
const EVERY: usize = 24;
const FULL_TURN_DEG: f64 = 360.0;
const NMM_PER_NM: f64 = 1000.0;
/// Columns of the published table, counted from 0.
const ANGLE: usize = 3;
const FORCE: usize = 18;
const MOMENT: usize = 21;

pub(super) const SET: Set = Set {
    name: "wheel",
    source: "github.com/kineticstoolkit/kineticstoolkit_pushrimkinetics, commit 09ff0c17b9a2, \
             tutorial_data/, Apache-2.0",
    licence: "Apache-2.0, © 2020-2025 Felix Chenier; fixtures/licences/smartwheel.txt",
    place: "smartwheel_pushrim",
    reference: "zero of 5.7 N that turns with the wheel, weight of 6.3 N; 0.69, 0.61 and 0.78 N left",
    left_out: "turn of the wheel",
    convert,
};

fn convert(folder: &Path) -> Result<Vec<Case>> {
    let path = folder.join("pushrimkinetics_offsets_baseline.csv");
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut table = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm,time_s,turn\n".to_owned();
    let (mut turned_deg, mut last_deg): (f64, Option<f64>) = (0.0, None);
    let (mut n_readings, mut kept) = (0, 0);
    for (index, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |column: usize| -> Result<f64> {
            let cell = cells.get(column).copied().unwrap_or("");
            cell.parse().with_context(|| format!("{}:{}", path.display(), index + 1))
        };
        let triple = |from: usize| -> Result<[f64; 3]> {
            Ok([number(from)?, number(from + 1)?, number(from + 2)?])
        };
        let angle_deg = number(ANGLE)?;
        turned_deg += last_deg.map_or(0.0, |last| shortest_way_deg(angle_deg - last));
        last_deg = Some(angle_deg);
        n_readings += 1;
        if index % EVERY != 0 {
            continue;
        }
        kept += 1;
        let force_n = into_wheel(angle_deg, triple(FORCE)?);
        let moment_nmm = into_wheel(angle_deg, triple(MOMENT)?.map(|m| NMM_PER_NM * m));
        let base = base_from_wheel(angle_deg).map(|q| format!("{q:.8}")).join(",");
        let wrench: Vec<String> =
            force_n.iter().chain(&moment_nmm).map(|v| format!("{v:.4}")).collect();
        #[expect(clippy::cast_precision_loss, reason = "some thousand readings")]
        let time_s = index as f64 / RATE_HZ;
        let turn = (turned_deg / FULL_TURN_DEG).floor();
        // A string takes every character.
        let _ = writeln!(table, "{index},{base},{},{time_s:.4},T{turn:.0}", wrench.join(","));
    }
    ensure!(kept > 0, "{} is empty", path.display());
    Ok(vec![Case {
        name: "untouched".to_owned(),
        settings: "kind = \"ft-center\"\n\n[loop]\ngroup = \"turn\"\n".to_owned(),
        tables: vec![("gravity.csv", table)],
        notes: vec![
            format!("the run in which nobody touches the rim: {n_readings} readings at 240 Hz"),
            format!("one reading in {EVERY} is kept, {kept} of them; none is averaged"),
            "wrenches turned from the frame of the hub into that of the wheel, whose angle is \
             recorded beside them; N·m to N·mm; the base has z up"
                .to_owned(),
        ],
        carry: None,
    }])
}

fn shortest_way_deg(from_to_deg: f64) -> f64 {
    let half = FULL_TURN_DEG / 2.0;
    (from_to_deg + half).rem_euclid(FULL_TURN_DEG) - half
}

/// A vector of the hub's frame in that of the wheel, which has turned by −angle about z.
fn into_wheel(angle_deg: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

/// Quaternion `[w, x, y, z]` from the wheel's frame to a base with z up.
///
/// The hub's y is up: a quarter turn about x after the turn of the wheel about its axle.
fn base_from_wheel(angle_deg: f64) -> [f64; 4] {
    let (sin, cos) = (-0.5 * angle_deg.to_radians()).sin_cos();
    [cos, cos, -sin, sin].map(|v| FRAC_1_SQRT_2 * v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of a few operations on values of order one.
    const EXACT: f64 = 1e-12;

    #[test]
    fn a_force_that_turns_with_the_wheel_is_constant_in_its_frame() {
        for angle_deg in [0.0, 30.0, 200.0, 359.0] {
            let (sin, cos) = f64::to_radians(angle_deg).sin_cos();
            // As fitted to the published run: Fx and Fy follow −sin and −cos of the angle.
            let turned = into_wheel(angle_deg, [-5.75 * sin, -5.75 * cos, 0.0]);
            assert!(turned[0].abs() < EXACT && (turned[1] + 5.75).abs() < EXACT);
        }
    }

    #[test]
    fn up_is_up_wherever_the_wheel_stands() {
        for angle_deg in [0.0, 30.0, 200.0, 359.0] {
            let [x, y, z] = into_wheel(angle_deg, [0.0, 1.0, 0.0]);
            let [qw, qx, qy, qz] = base_from_wheel(angle_deg);
            let up = 2.0 * (qx * qz - qw * qy) * x
                + 2.0 * (qy * qz + qw * qx) * y
                + (1.0 - 2.0 * (qx * qx + qy * qy)) * z;
            assert!((up - 1.0).abs() < EXACT);
        }
    }

    #[test]
    fn the_way_from_one_angle_to_the_next_is_the_short_one() {
        assert!((shortest_way_deg(359.0 - 1.0) + 2.0).abs() < EXACT);
        assert!((shortest_way_deg(3.0) - 3.0).abs() < EXACT);
    }
}
