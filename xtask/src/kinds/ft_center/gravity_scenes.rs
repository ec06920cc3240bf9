//! Poses of a tool that hangs free on its sensor, with every error of the sensor in turn.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::gaussian;
#[cfg(test)]
use crate::generators::vector::add;
use crate::generators::vector::{cross, norm, rotate, scale};

/// Ids with subjects.
#[cfg(test)]
pub(crate) const EFFECTS: &[&str] = &[
    "bias-drift [force]",
    "bias-drift [moment]",
    "bias-drift [force, settling]",
    "bias-drift [moment, interrupted]",
    "force-gain",
    "moment-gain",
    "crosstalk [forces]",
    "crosstalk [fx into fz]",
    "crosstalk [forces into moments]",
    "platform-tilt",
    "mount-rotation",
    "temperature",
];

/// Weight of the tool, N, and where it is, mm.
const WEIGHT_N: f64 = 25.0;
const CENTER_MM: [f64; 3] = [4.0, -3.0, 60.0];
const BIAS: [[f64; 3]; 2] = [[1.0, 2.0, 3.0], [10.0, 20.0, -5.0]];
/// Noise of a force, N, and of a moment, N·mm.
const NOISE: [f64; 2] = [0.01, 0.5];
const POSES: usize = 30;
/// Of the scenes.
#[cfg(test)]
const SEED: u64 = 31;

/// What a sensor reads of a force and its moment, at a share of the series and a temperature above
/// 20 °C.
type Reads = fn([[f64; 3]; 2], f64, f64) -> [[f64; 3]; 2];

struct Scene {
    #[cfg(test)]
    name: &'static str,
    reads: Reads,
    /// Rotation of gravity against the base, and of the sensor against its flange, rad.
    tilt: [f64; 3],
    mount: [f64; 3],
    warm: bool,
}

const SOUND: Scene = Scene {
    #[cfg(test)]
    name: "",
    reads: |load, _, _| load,
    tilt: [0.0; 3],
    mount: [0.0; 3],
    warm: false,
};

/// Cases by name.
#[cfg(test)]
pub(crate) fn scenes() -> Vec<(&'static str, Vec<(&'static str, String)>)> {
    let all = [
        Scene {
            name: "force-drift",
            reads: |[f, m], share, _| [add(f, [0.3 * share, 0.0, -0.2 * share]), m],
            ..SOUND
        },
        Scene {
            name: "moment-drift",
            reads: |[f, m], share, _| [f, add(m, [20.0 * share, 0.0, -10.0 * share])],
            ..SOUND
        },
        Scene {
            name: "force-settles",
            reads: |[f, m], share, _| {
                [add(f, scale(1.0 - (-share / 0.15).exp(), [0.3, 0.0, -0.4])), m]
            },
            ..SOUND
        },
        Scene {
            name: "moment-breaks-off",
            reads: |[f, m], share, _| {
                let after = f64::from(u8::from(share > 0.45));
                let slower = after * (share - 0.45);
                [f, add(m, [20.0 * share - 18.0 * slower, 12.0 * after, -6.0 * after])]
            },
            ..SOUND
        },
        Scene {
            name: "force-gain",
            reads: |[f, m], _, _| [[1.02 * f[0], f[1], 0.985 * f[2]], m],
            ..SOUND
        },
        Scene {
            name: "moment-gain",
            reads: |[f, m], _, _| [f, [1.03 * m[0], m[1], 0.97 * m[2]]],
            ..SOUND
        },
        Scene {
            name: "crosstalk",
            reads: |[f, m], _, _| [add(f, [0.01 * f[1], 0.01 * f[0], 0.0]), m],
            ..SOUND
        },
        Scene {
            name: "fx-into-fz",
            reads: |[f, m], _, _| [add(f, [0.0, 0.0, 0.02 * f[0]]), m],
            ..SOUND
        },
        Scene {
            name: "forces-into-moments",
            reads: |[f, m], _, _| [f, add(m, [0.8 * f[0], 0.5 * f[2], 0.5 * f[1]])],
            ..SOUND
        },
        Scene { name: "platform-tilt", tilt: [0.01, -0.006, 0.0], ..SOUND },
        Scene { name: "mount-rotation", mount: [0.01, 0.02, -0.01], ..SOUND },
        Scene {
            name: "temperature",
            reads: |[f, m], _, k| [add(f, [0.05 * k, 0.0, 0.0]), add(m, [0.0, -3.0 * k, 0.0])],
            warm: true,
            ..SOUND
        },
    ];
    all.iter().map(|scene| (scene.name, files(scene, SEED))).collect()
}

/// Rotation by a vector.
pub(crate) fn turned(by: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    let angle = norm(&by);
    if angle > 0.0 { rotate(scale(1.0 / angle, by), angle, v) } else { v }
}

/// Files of a case with a sound sensor.
pub(crate) fn sound(seed: u64) -> Vec<(&'static str, String)> {
    files(&SOUND, seed)
}

/// Files of a case in these poses; gravity is turned against the base by a vector, rad, and the sensor against its
/// flange by another.
pub(crate) fn turned_against(
    [tilt, mount]: [[f64; 3]; 2],
    poses: &[[f64; 4]],
    seed: u64,
) -> Vec<(&'static str, String)> {
    files_in(&Scene { tilt, mount, ..SOUND }, Some(poses), seed)
}

fn files(scene: &Scene, seed: u64) -> Vec<(&'static str, String)> {
    files_in(scene, None, seed)
}

/// In the poses given, or in any.
fn files_in(scene: &Scene, poses: Option<&[[f64; 4]]>, seed: u64) -> Vec<(&'static str, String)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n_poses = poses.map_or(POSES, <[_]>::len);
    let mut text = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm".to_owned();
    text.push_str(if scene.warm { ",body_c\n" } else { "\n" });
    for pose in 0..n_poses {
        let mut any = || -> [f64; 4] { std::array::from_fn(|_| gaussian(&mut rng)) };
        let q = poses.map_or_else(&mut any, |poses| poses[pose]);
        let q = q.map(|v| v / norm(&q));
        let by = rotation_vector(q);
        let gravity = turned(scene.tilt, [0.0, 0.0, -1.0]);
        let down = turned(scale(-1.0, scene.mount), turned(scale(-1.0, by), gravity));
        let force = scale(WEIGHT_N, down);
        let share = as_f64(pose) / as_f64(n_poses - 1);
        let excess_k = rng.random_range(-3.0..6.0);
        let read = (scene.reads)([force, cross(CENTER_MM, force)], share, excess_k);
        let _ = write!(text, "P{pose:02}");
        for value in q {
            let _ = write!(text, ",{value}");
        }
        for (kind, read) in read.into_iter().enumerate() {
            for (read, bias) in read.into_iter().zip(BIAS[kind]) {
                let _ = write!(text, ",{}", read + bias + NOISE[kind] * gaussian(&mut rng));
            }
        }
        let _ = if scene.warm { writeln!(text, ",{}", 20.0 + excess_k) } else { writeln!(text) };
    }
    let [force_n, moment_nmm] = NOISE;
    let case =
        format!("kind = \"ft-center\"\n[noise]\nforce_n = {force_n}\nmoment_nmm = {moment_nmm}\n");
    vec![("case.toml", case), ("gravity.csv", text)]
}

/// Of a unit quaternion, rad.
fn rotation_vector(q: [f64; 4]) -> [f64; 3] {
    let sin = norm(&q[1..]);
    let per_sin = if sin > 0.0 { 2.0 * sin.atan2(q[0]) / sin } else { 2.0 };
    std::array::from_fn(|k| per_sin * q[k + 1])
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn as_f64(n: usize) -> f64 {
    n as f64
}
