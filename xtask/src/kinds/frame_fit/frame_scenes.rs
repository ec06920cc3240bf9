//! Small surveys in which every effect of the catalogue is accepted at least once.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::vector::rotate;

/// Ids with subjects that have a formula of their own.
pub(crate) const EFFECTS: &[&str] = &[
    "shift",
    "rotation",
    "reflection",
    "scale",
    "anisotropic-scale",
    "shear",
    "bad-point",
    "drift",
    "drift [settling]",
    "session-shift",
    "sag",
    "temperature",
    "lens-distortion",
    "perspective",
    "polynomial-distortion [degree 3]",
    "polynomial-distortion [degree 5]",
    "sub-assembly",
    "covariate:",
];

/// Noise of one coordinate, mm: far below every effect here.
const NOISE_MM: f64 = 0.001;

/// One survey.
struct Scene {
    name: &'static str,
    planar: bool,
    transform: &'static str,
    points: usize,
    /// Header of the columns beside the points, with a comma before each.
    columns: &'static str,
    /// Cells of those columns.
    cells: fn(&Place) -> String,
    /// What the first frame's instrument reads, from where it should be, mm.
    deform: fn(&Place) -> [f64; 3],
    mirrored: bool,
}

/// One point and the circumstances of its reading.
struct Place {
    index: usize,
    share: f64,
    warm_c: f64,
    humid_pct: f64,
    at: [f64; 3],
}

const PLAIN: Scene = Scene {
    name: "",
    planar: false,
    transform: "rigid",
    points: 28,
    columns: "",
    cells: |_| String::new(),
    deform: |_| [0.0; 3],
    mirrored: false,
};

/// Name and files of every scene.
pub(crate) fn scenes() -> Vec<(&'static str, Vec<(&'static str, String)>)> {
    all().iter().map(|scene| (scene.name, files(scene))).collect()
}

#[expect(clippy::too_many_lines, reason = "a table: one entry per effect")]
fn all() -> Vec<Scene> {
    vec![
        Scene { name: "shift", transform: "none", deform: |_| [0.04, -0.03, 0.05], ..PLAIN },
        Scene {
            name: "rotation",
            transform: "none",
            deform: |p| [-2e-4 * p.at[1], 2e-4 * p.at[0], 0.0],
            ..PLAIN
        },
        Scene { name: "reflection", planar: true, mirrored: true, ..PLAIN },
        Scene { name: "scale", deform: |p| p.at.map(|v| 9e-5 * v), ..PLAIN },
        Scene {
            name: "scale-of-one-frame",
            transform: "none",
            deform: |p| p.at.map(|v| 9e-5 * v),
            ..PLAIN
        },
        Scene {
            name: "anisotropic-scale",
            deform: |p| [1e-4 * p.at[0], -8e-5 * p.at[1], 3e-5 * p.at[2]],
            ..PLAIN
        },
        Scene { name: "shear", deform: |p| [2e-4 * p.at[1] - 1e-4 * p.at[2], 0.0, 0.0], ..PLAIN },
        Scene {
            name: "scale-and-bad-point",
            deform: |p| {
                let off = if p.index == 4 { 0.3 } else { 0.0 };
                [9e-5 * p.at[0], 9e-5 * p.at[1] + off, 9e-5 * p.at[2]]
            },
            ..PLAIN
        },
        Scene {
            name: "session",
            columns: ",time_s",
            cells: |p| format!(",{}", 500.0 + time_s(p)),
            deform: |p| if p.index < 11 { [0.0; 3] } else { [0.03, -0.04, 0.02] },
            ..PLAIN
        },
        Scene {
            name: "drift-by-order",
            deform: |p| [0.06 * p.share, -0.05 * p.share, 0.02 * p.share],
            ..PLAIN
        },
        Scene {
            name: "settling",
            deform: |p| {
                let come = 1.0 - (-p.share / 0.1).exp();
                [0.03 * come, -0.05 * come, 0.02 * come]
            },
            ..PLAIN
        },
        Scene {
            name: "drift-by-time",
            columns: ",time_s",
            cells: |p| format!(",{}", 500.0 + time_s(p)),
            deform: |p| [1.5e-5 * time_s(p), 0.0, -1e-5 * time_s(p)],
            ..PLAIN
        },
        Scene {
            name: "sag",
            deform: |p| [0.0, 0.0, -6e-7 * p.at[0] * p.at[0] + 1e-7 * p.at[0] * p.at[1]],
            ..PLAIN
        },
        Scene {
            name: "temperature-and-shear",
            columns: ",air_c",
            cells: |p| format!(",{}", p.warm_c),
            deform: |p| {
                let growth = p.at.map(|v| 2.3e-5 * (p.warm_c - 20.0) * v);
                [growth[0] + 2e-4 * p.at[1], growth[1], growth[2]]
            },
            ..PLAIN
        },
        Scene {
            name: "humidity",
            columns: ",humidity_pct",
            cells: |p| format!(",{}", p.humid_pct),
            deform: |p| [0.0, 0.0, 0.004 * (p.humid_pct - 50.0)],
            ..PLAIN
        },
        Scene {
            name: "lens-distortion",
            planar: true,
            transform: "similarity",
            points: 40,
            deform: |p| {
                let square = p.at[0].powi(2) + p.at[1].powi(2);
                [2e-8 * p.at[0] * square, 2e-8 * p.at[1] * square, 0.0]
            },
            ..PLAIN
        },
        Scene {
            name: "perspective",
            planar: true,
            points: 40,
            deform: |p| {
                let along = 4e-6 * p.at[0] - 3e-6 * p.at[1];
                [along * p.at[0], along * p.at[1], 0.0]
            },
            ..PLAIN
        },
        Scene {
            name: "cubic-image",
            planar: true,
            transform: "similarity",
            points: 60,
            deform: |p| {
                let [x, y] = [p.at[0] / 200.0, p.at[1] / 200.0];
                [0.2 * x * x * y - 0.1 * y.powi(3), 0.15 * x.powi(3) + 0.1 * x * y, 0.0]
            },
            ..PLAIN
        },
        Scene {
            name: "quintic-image-of-another-scale",
            planar: true,
            points: 120,
            deform: |p| {
                let [x, y] = [p.at[0] / 200.0, p.at[1] / 200.0];
                [
                    0.2 * x * x * y.powi(3) - 0.1 * y.powi(4) + 3e-4 * p.at[0],
                    0.15 * x.powi(5) + 0.1 * x.powi(3) * y + 3e-4 * p.at[1],
                    0.0,
                ]
            },
            ..PLAIN
        },
        Scene {
            name: "sub-assembly",
            points: 36,
            columns: ",body",
            cells: |p| [",frame", ",arm", ",frame"][p.index % 3].to_owned(),
            deform: |p| {
                if p.index % 3 == 1 {
                    [0.1 - 3e-4 * p.at[1], 3e-4 * p.at[0], -0.05]
                } else {
                    [0.0; 3]
                }
            },
            ..PLAIN
        },
    ]
}

fn time_s(place: &Place) -> f64 {
    40.0 * f64::from(u16::try_from(place.index).expect("few points"))
}

fn files(scene: &Scene) -> Vec<(&'static str, String)> {
    let case = format!(
        "kind = \"frame-fit\"\n[model]\ntransform = \"{}\"\n[noise]\npoint_mm = {NOISE_MM}\n",
        scene.transform
    );
    vec![("case.toml", case), ("pairs.csv", pairs(scene))]
}

fn pairs(scene: &Scene) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let axes = if scene.planar { &["x", "y"][..] } else { &["x", "y", "z"][..] };
    let mut text = "point".to_owned();
    for side in ["from", "to"] {
        for axis in axes {
            let _ = write!(text, ",{side}_{axis}_mm");
        }
    }
    let _ = writeln!(text, ",use{}", scene.columns);
    let mut uniform = |half: f64| rng.random_range(-half..half);
    for index in 0..scene.points {
        let number = |i: usize| f64::from(u16::try_from(i).expect("few points"));
        // Not about the origin, so that a point of reference matters.
        let at = [150.0 + uniform(200.0), 60.0 + uniform(200.0), 40.0 + uniform(150.0)];
        let place = Place {
            index,
            share: number(index) / number(scene.points - 1),
            warm_c: 22.0 + uniform(4.0),
            humid_pct: 50.0 + uniform(12.0),
            at: if scene.planar { [at[0], at[1], 0.0] } else { at },
        };
        let moved = (scene.deform)(&place);
        let read: [f64; 3] =
            std::array::from_fn(|k| place.at[k] + moved[k] + NOISE_MM * normal(&mut uniform));
        let to = second_frame(scene, read);
        let _ = write!(text, "P{index:03}");
        for value in place.at[..axes.len()].iter().chain(&to[..axes.len()]) {
            let _ = write!(text, ",{value}");
        }
        let usage = if index % 5 == 3 { "check" } else { "fit" };
        let _ = writeln!(text, ",{usage}{}", (scene.cells)(&place));
    }
    text
}

fn second_frame(scene: &Scene, read: [f64; 3]) -> [f64; 3] {
    if scene.transform == "none" {
        return read;
    }
    let read = if scene.mirrored { [read[0], -read[1], read[2]] } else { read };
    let axis = if scene.planar { [0.0, 0.0, 1.0] } else { [0.36, -0.48, 0.8] };
    let turned = rotate(axis, 0.7, read);
    let z_mm = if scene.planar { 0.0 } else { 90.0 };
    [turned[0] + 800.0, turned[1] - 500.0, turned[2] + z_mm]
}

/// Sum of uniform numbers, near enough to a normal one.
fn normal(uniform: &mut impl FnMut(f64) -> f64) -> f64 {
    (0..12).map(|_| uniform(0.5)).sum::<f64>()
}
