//! A frame and the centres of presses, displacements, and the weight of a free-hanging tool.

use serde_json::Value;

use crate::generators::vector::{add, cross, norm, scale};
use crate::handback::Left;
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{accepted, amplitude, begun, close, numbers, settled, step, subjects};
use crate::kinds::ft_center::gravity_scenes::{self, turned};
use crate::kinds::ft_center::press::{Fault, Session, simulate};
use crate::kinds::ft_center::press_tables::{case_toml, presses_csv, wrench_csv};

/// Digits that two ways to a centre may differ by, over the largest coordinate.
const CENTRE: f64 = 1e-11;

#[test]
fn frame_centres_displacements_and_weight_leave_the_error_that_is_printed() {
    for folder in Folder::committed("ft-center") {
        let json = close(&folder);
        let left = if folder.has("presses.csv") {
            presses(&folder, &json)
        } else if folder.has("displacements.csv") {
            displacements(&folder, &json)
        } else {
            poses(&folder, &json)
        };
        left.assert_is(&folder.name(), &json);
    }
}

/// Every fault is so large that something is accepted for it, by its own name or that of a rival.
#[test]
fn every_error_of_sensor_and_machine_is_taken_off_by_its_formula() {
    let faults = [
        Fault::Bias([0.0, 0.0, 0.0, 40.0, -30.0, 0.0]),
        Fault::Bias([0.0, 0.0, 1.5, 0.0, 0.0, 0.0]),
        Fault::BiasDrift([0.0, 0.0, 0.0, 60.0, 40.0, 0.0]),
        Fault::BiasDrift([0.0, 0.0, 2.0, 0.0, 0.0, 0.0]),
        Fault::BiasSettles([0.0, 0.0, 0.0, 60.0, 40.0, 0.0]),
        Fault::MomentGain(0.05),
        Fault::ForceGain(0.05),
        Fault::Crosstalk(3, 4, 0.05),
        Fault::Crosstalk(2, 3, 0.002),
        Fault::Crosstalk(3, 0, 5.0),
        Fault::ContactHeight(4.0),
        Fault::PlatformTilt([0.08, -0.05]),
        Fault::LoadShift([0.01, -0.01]),
        Fault::Slip(0.5),
        Fault::Compliance(0.05),
        Fault::FrameScale(0.01),
    ];
    for (seed, fault) in (610..).zip(faults) {
        let loads_n = vec![20.0, 60.0, 40.0];
        let session = Session { n_frame: 30, drag: 0.3, loads_n, fault, ..Session::new(seed) };
        let recorded = simulate(&session);
        let files = [
            ("case.toml", case_toml(&session, &recorded)),
            ("presses.csv", presses_csv(&recorded)),
            ("wrench.csv", wrench_csv(&recorded)),
        ];
        let folder = Folder::written(&format!("ft-center/{seed}"), &files);
        let json = close(&folder);
        let found = accepted(&json);
        assert!(!found.is_empty(), "{fault:?}");
        let settles = found.iter().any(|effect| effect == "bias-drift [moment, settling]");
        assert_eq!(settles, matches!(fault, Fault::BiasSettles(_)), "{found:?}");
        presses(&folder, &json).assert_is(&format!("{fault:?}"), &json);
    }
}

#[test]
fn every_error_of_a_sensor_that_carries_a_tool_is_taken_off_by_its_formula() {
    let mut missing: Vec<&str> = gravity_scenes::EFFECTS.to_vec();
    for (name, files) in gravity_scenes::scenes() {
        let folder = Folder::written(&format!("ft-center/{name}"), &files);
        let json = close(&folder);
        poses(&folder, &json).assert_is(&folder.name(), &json);
        let found = accepted(&json);
        missing.retain(|effect| !found.iter().any(|f| f == effect));
        // Nobody is told that a weight is true which an axis with a gain of its own has read.
        let conditions = json["estimates"]["conditions"].to_string();
        let of_gains = found.iter().any(|f| f == "force-gain" || f == "moment-gain");
        assert!(!of_gains || conditions.contains("no gain among the parameters"), "{conditions}");
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key}"))
}

/// The mean wrench of every press as read, freed of the sensor's errors, through the frame, less
/// what the machine's effects move the head by.
fn presses(folder: &Folder, json: &Value) -> Left {
    let document = folder.document();
    let z0_mm = document["contact"]["z0_mm"].as_float().expect("z0");
    let table = folder.table("presses.csv");
    let at = [table.numbers("machine_x_mm"), table.numbers("machine_y_mm")];
    let names = table.texts("press").to_vec();
    let frame = &json["estimates"]["frame"];
    let centers = json["estimates"]["centers"].as_array().expect("centres");
    let elapsed = elapsed(folder, centers.len());
    let mut left = Left::default();
    for (i, center) in centers.iter().enumerate() {
        let zeros = ["mx", "my"].map(|name| moment_moved(json, &names, name, (i, elapsed[i])));
        let read = &center["mean_wrench"];
        let moments = [number(read, "mx_nmm") - zeros[0], number(read, "my_nmm") - zeros[1]];
        let sensor = sensor_centre(json, (read, moments), elapsed[i], z0_mm);
        let commanded = [at[0][i], at[1][i]];
        let machine = machine_place(frame, sensor);
        let size = sensor.iter().chain(&commanded).fold(100.0, |m: f64, v| m.max(v.abs()));
        left.scale = left.scale.max(size);
        for (k, axis) in ["x", "y"].iter().enumerate() {
            let printed = number(center, &format!("{axis}_mm"));
            assert!((sensor[k] - printed).abs() < CENTRE * size, "{}: {i} {axis}", folder.name());
            let printed = number(center, &format!("machine_{axis}_mm"));
            assert!(
                (machine[k] - printed).abs() < CENTRE * size,
                "{}: press {i}: {} and printed {printed}",
                folder.name(),
                machine[k]
            );
        }
        let residual: Vec<f64> = (["x", "y"].iter().enumerate())
            .map(|(k, axis)| {
                machine[k] - commanded[k] - number(center, &format!("correction_{axis}_mm"))
            })
            .collect();
        match center["use"].as_str() {
            Some("frame") => left.fitted.push(residual),
            Some("check") => left.checked.push(residual),
            _ => {}
        }
    }
    left
}

/// Share of the session at the middle of each press' record, or its number where records overlap.
fn elapsed(folder: &Folder, presses: usize) -> Vec<f64> {
    let names = folder.table("presses.csv").texts("press").to_vec();
    let wrench = folder.table("wrench.csv");
    let (of, time_s) = (wrench.texts("press"), wrench.numbers("time_s"));
    let spans: Vec<[f64; 2]> = (names.iter())
        .map(|name| {
            let own: Vec<f64> =
                (0..of.len()).filter(|&i| of[i] == *name).map(|i| time_s[i]).collect();
            [own[0], own[own.len() - 1]]
        })
        .collect();
    let follow = spans.windows(2).all(|w| w[0][1] < w[1][0]);
    let place = |i: usize| {
        if follow { 0.5 * (spans[i][0] + spans[i][1]) } else { crate::handback::as_f64(i) }
    };
    let (first, last) = (place(0), place(presses - 1));
    (0..presses).map(|i| (place(i) - first) / (last - first)).collect()
}

/// Amplitude in the units of the formula; zero where the effect was not accepted.
fn of(json: &Value, id: &str, subject: Option<&str>, name: &str, factor: f64) -> f64 {
    step(json, id, subject).map_or(0.0, |s| amplitude(s, name) * factor)
}

/// Centre of pressure in the sensor frame, by the formulas of `docs/ft-center.md`.
fn sensor_centre(
    json: &Value,
    (read, moments): (&Value, [f64; 2]),
    elapsed: f64,
    z0_mm: f64,
) -> [f64; 2] {
    let a = |id: &str, subject: Option<&str>, name: &str, factor: f64| {
        of(json, id, subject, name, factor)
    };
    let moment = Some("moment");
    let force = Some("normal force");
    let gain = a("moment-gain", None, "gain error", 1e-6);
    let unequal = a("moment-gain", Some("mx against my"), "gain error", 1e-6);
    let [mut mx, mut my] = moments;
    mx -= a("sensor-bias", moment, "mx", 1.0) + a("bias-drift", moment, "mx", 1.0) * elapsed;
    my -= a("sensor-bias", moment, "my", 1.0) + a("bias-drift", moment, "my", 1.0) * elapsed;
    let mut fz = number(read, "fz_n")
        - a("sensor-bias", force, "fz", 1.0)
        - a("bias-drift", force, "fz", 1.0) * elapsed;
    mx /= 1.0 + gain + unequal;
    my /= 1.0 + gain - unequal;
    fz /= 1.0 + a("force-gain", None, "gain error", 1e-6);
    let share = a("crosstalk", Some("mx and my"), "share", 1e-6);
    (mx, my) =
        ((mx - share * my) / (1.0 - share * share), (my - share * mx) / (1.0 - share * share));
    let into_fz = Some("moments into fz");
    fz -= a("crosstalk", into_fz, "of mx", 1e-3) * mx + a("crosstalk", into_fz, "of my", 1e-3) * my;
    let (fx, fy) = (number(read, "fx_n"), number(read, "fy_n"));
    let into_moment = Some("fz into moments");
    let lateral = Some("lateral forces into moments");
    mx -= a("crosstalk", into_moment, "into mx", 1.0) * fz
        + a("crosstalk", lateral, "fx into mx", 1.0) * fx
        + a("crosstalk", lateral, "fy into mx", 1.0) * fy;
    my -= a("crosstalk", into_moment, "into my", 1.0) * fz
        + a("crosstalk", lateral, "fx into my", 1.0) * fx
        + a("crosstalk", lateral, "fy into my", 1.0) * fy;
    let height = z0_mm + a("contact-height", None, "height error", 1.0);
    let slope = [
        a("platform-tilt", None, "slope along x", 1e-3),
        a("platform-tilt", None, "slope along y", 1e-3),
    ];
    // (Fz − f sᵀ) (x, y) = (h Fx − My, Mx + h Fy), f the force across, s the slope.
    let matrix = [[fz - fx * slope[0], -fx * slope[1]], [-fy * slope[0], fz - fy * slope[1]]];
    let right = [height * fx - my, mx + height * fy];
    let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    let along = a("slip", Some("round guide"), "along the friction", 1e-3)
        / fx.hypot(fy).max(1e-300)
        + a("slip", Some("friction over load"), "per ratio", 1.0) / number(read, "fz_n").abs()
        + a("lateral-compliance", None, "compliance", 1e-3);
    [
        (right[0] * matrix[1][1] - matrix[0][1] * right[1]) / determinant
            - a("slip", None, "x", 1e-3) * fx.signum()
            - along * fx,
        (matrix[0][0] * right[1] - matrix[1][0] * right[0]) / determinant
            - a("slip", None, "y", 1e-3) * fy.signum()
            - along * fy,
    ]
}

/// How far the zero of a moment has moved at a press, to rest or for a session.
fn moment_moved(json: &Value, names: &[String], name: &str, (press, elapsed): (usize, f64)) -> f64 {
    let to_rest = subjects(json, "bias-drift").into_iter().map(|(subject, step)| match subject {
        "moment, settling" | "moment, settling to zero" => {
            amplitude(step, name) * settled(step, elapsed, false, 2)
        }
        _ => 0.0,
    });
    let sessions = begun(json, ("session-shift", "moment, "), names, press).into_iter();
    to_rest.sum::<f64>() + sessions.map(|step| amplitude(step, name)).sum::<f64>()
}

/// Where a point of the sensor is in the machine: in true lengths from the point of reference, where
/// the machine's own scale is wrong.
fn machine_place(frame: &Value, sensor: [f64; 2]) -> [f64; 2] {
    let angle = number(frame, "angle_deg").to_radians();
    let scale = number(frame, "scale");
    let mirror = if frame["handedness"] == "opposed" { -1.0 } else { 1.0 };
    let arm = [sensor[0] - number(frame, "tx_mm"), sensor[1] - number(frame, "ty_mm")];
    let back = [
        angle.cos() * arm[0] + angle.sin() * arm[1],
        mirror * (-angle.sin() * arm[0] + angle.cos() * arm[1]),
    ];
    let reference = numbers(&frame["reference_mm"]);
    std::array::from_fn(|k| back[k] - (scale - 1.0) * reference[k])
}

fn displacements(folder: &Folder, json: &Value) -> Left {
    let table = folder.table("displacements.csv");
    let (commanded, solved) = (table.numbers("commanded_mm"), table.numbers("solved_mm"));
    let points = json["estimates"]["points"].as_array().expect("points");
    let mut left = Left { scale: 10.0, ..Left::default() };
    for (i, point) in points.iter().enumerate() {
        let residual = solved[i] - number(point, "correction_mm") - commanded[i];
        let formula = solved[i] - displacement_read(json, commanded[i]);
        let empirical = json["steps"]
            .as_array()
            .expect("steps")
            .iter()
            .any(|s| s["effect"].as_str().is_some_and(|e| e.starts_with("covariate:")));
        assert!(
            empirical || (residual - formula).abs() < CENTRE * 10.0,
            "{}: row {i}: {residual:e} and {formula:e}",
            folder.name()
        );
        left.fitted.push(vec![residual]);
    }
    left
}

/// What the sensor reads of a displacement, by the formula of `docs/ft-center.md`.
fn displacement_read(json: &Value, commanded_mm: f64) -> f64 {
    let a = |id: &str, subject: Option<&str>, name: &str, factor: f64| {
        of(json, id, subject, name, factor)
    };
    let moved = commanded_mm * (1.0 + a("frame-scale", None, "scale error", 0.01));
    let moment = moved * (1.0 + a("moment-gain", None, "gain error", 0.01));
    let force = 1.0
        + a("force-gain", None, "gain error", 0.01)
        + a("sensor-bias", Some("normal force"), "bias over load", 0.01);
    moment / force
        + a("sensor-bias", Some("moment"), "bias over load", 1.0)
        + a("datum-offset", None, "offset", 1.0)
}

/// Wrench read − (bias + weight along gravity + correction) of every pose; the corrections are
/// those of the effects printed.
fn poses(folder: &Folder, json: &Value) -> Left {
    let table = folder.table("gravity.csv");
    let estimates = &json["estimates"];
    let weight_n = number(estimates, "weight_n");
    let center = triple(&estimates["center_of_gravity_mm"]);
    let q: Vec<Vec<f64>> = ["qw", "qx", "qy", "qz"].iter().map(|c| table.numbers(c)).collect();
    let mut left = Left { scale: weight_n, ..Left::default() };
    let poses = estimates["poses"].as_array().expect("poses");
    for (i, pose) in poses.iter().enumerate() {
        let length = q.iter().map(|c| c[i] * c[i]).sum::<f64>().sqrt();
        let [w, x, y, z] = std::array::from_fn(|k| q[k][i] / length);
        let axis = norm(&[x, y, z]);
        let back =
            if axis > 0.0 { scale(-2.0 * axis.atan2(w) / axis, [x, y, z]) } else { [0.0; 3] };
        let down = turned(back, [0.0, 0.0, -1.0]);
        let load = scale(weight_n, down);
        let (force, moment) = (triple(&pose["correction_n"]), triple(&pose["correction_nmm"]));
        let share = crate::handback::as_f64(i) / crate::handback::as_f64(poses.len() - 1);
        let [of_force, of_moment] = read_of(json, &table, i, share, (back, weight_n, center));
        let expected =
            [add(of_force, scale(-1.0, load)), add(of_moment, scale(-1.0, cross(center, load)))];
        let reach = weight_n * norm(&center).max(1.0);
        for (printed, expected) in [force, moment].iter().zip(expected) {
            let off = norm(&add(*printed, scale(-1.0, expected)));
            assert!(off < CENTRE * reach, "{}: pose {i}: {printed:?}, {expected:?}", folder.name());
        }
        let residual = (["fx_n", "fy_n", "fz_n"].iter().enumerate()).map(|(k, name)| {
            let bias = number(&estimates["bias"], name);
            table.numbers(name)[i] - bias - load[k] - force[k]
        });
        left.fitted.push(residual.collect());
    }
    left
}

/// What the sensor reads of the weight at one pose, `back` the rotation from base to sensor, by the
/// formulas of `docs/ft-center.md`.
fn read_of(
    json: &Value,
    table: &Table,
    row: usize,
    share: f64,
    (back, weight_n, center): ([f64; 3], f64, [f64; 3]),
) -> [[f64; 3]; 2] {
    let a = |id: &str, subject: Option<&str>, name: &str, factor: f64| {
        of(json, id, subject, name, factor)
    };
    let axes = ["x", "y", "z"];
    let gravity = [0.0, 0.0, -1.0];
    let first = cross(gravity, [1.0, 0.0, 0.0]);
    let second = cross(gravity, first);
    let tilt = add(
        scale(a("platform-tilt", None, "about axis 1", 1e-3), first),
        scale(a("platform-tilt", None, "about axis 2", 1e-3), second),
    );
    let mount = axes.map(|k| -a("mount-rotation", None, &format!("about {k}"), 1e-3));
    let load = scale(weight_n, turned(mount, turned(back, turned(tilt, gravity))));
    let arm = cross(center, load);
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    let into = Some("forces into moments");
    for (k, axis) in axes.iter().enumerate() {
        let [f, m] = ["f", "m"].map(|kind| format!("{kind}{axis}"));
        force[k] += load[k] * (1.0 + a("force-gain", None, &f, 0.01))
            + zero_moved(json, table, "force", &f, share);
        moment[k] += arm[k] * (1.0 + a("moment-gain", None, &m, 0.01))
            + a("crosstalk", into, &format!("m{axis} of f{axis}"), 1.0) * load[k]
            + zero_moved(json, table, "moment", &m, share);
        for column in table.ending("_c") {
            let excess_k = table.numbers(&column)[row] - 20.0;
            force[k] += a("temperature", None, &f, 1.0) * excess_k;
            moment[k] += a("temperature", None, &m, 1.0) * excess_k;
        }
    }
    for (i, k) in [(0, 1), (0, 2), (1, 2)] {
        let both = format!("f{} and f{}", axes[i], axes[k]);
        let size = a("crosstalk", Some("forces"), &both, 0.01);
        force[i] += size * load[k];
        force[k] += size * load[i];
        for (of, into) in [(i, k), (k, i)] {
            let subject = format!("f{} into f{}", axes[of], axes[into]);
            force[into] += a("crosstalk", Some(&subject), "share", 0.01) * load[of];
        }
        let size = a("crosstalk", into, &format!("{} and {}", axes[i], axes[k]), 1.0);
        moment[i] += size * load[k];
        moment[k] += size * load[i];
    }
    [force, moment]
}

/// How far the zero of a channel has moved at a share of the series: evenly, to rest, or with a break
/// midway between the two poses that its words name.
fn zero_moved(json: &Value, table: &Table, channels: &str, name: &str, share: f64) -> f64 {
    let moved = subjects(json, "bias-drift").into_iter().map(|(subject, step)| {
        let Some(course) = subject.strip_prefix(channels) else { return 0.0 };
        let size = amplitude(step, name);
        match course {
            "" => size * share,
            ", settling" | ", settling to zero" => size * settled(step, share, false, 2),
            ", interrupted" => {
                let words = step["description"].as_str().expect("words");
                let poses = words.split("between poses ").nth(1).and_then(|w| w.split(',').next());
                let last = poses.and_then(|p| p.split(" and ").next()).expect("two poses");
                let names = table.texts("pose");
                let last = names.iter().position(|n| n == last).expect("a pose of the table");
                let number = crate::handback::as_f64;
                let since = share - (number(last) + 0.5) / number(names.len() - 1);
                let after = amplitude(step, &format!("{name} jump"))
                    + amplitude(step, &format!("{name} rate change")) * since;
                size * share + if since > 0.0 { after } else { 0.0 }
            }
            other => panic!("a drift {other}"),
        }
    });
    moved.sum()
}

fn triple(list: &Value) -> [f64; 3] {
    numbers(list).try_into().expect("three numbers")
}
