//! What is simulated, and what the answers should be.

use super::machines;
use super::situation::{Simulated, Situation, size_of_effect, truth};
use crate::kinds::force_impedance::polish::{self, Flaw, Run};
use crate::kinds::force_impedance::polish_tables;
use crate::kinds::frame_fit::survey::{self, Defect, Survey};
use crate::kinds::ft_center::press::{self, Fault, Role, Session};
use crate::kinds::ft_center::press_tables::{case_toml, presses_csv, wrench_csv};

/// All situations; effects are so large that the loop misses hardly one.
pub(crate) fn situations() -> Vec<Situation> {
    let frame = |name, effect, make| Situation { krate: "frame-fit", name, effect, make };
    let press = |name, effect, make| Situation { krate: "ft-center", name, effect, make };
    let log = |name, effect, make| Situation { krate: "force-impedance", name, effect, make };
    let mut all = vec![
        frame("nothing missing", None, |seed| of_survey(&Survey::new(seed))),
        frame("scale −60 ppm", Some("scale"), |seed| {
            of_survey(&Survey { defect: Defect::Scale(-60e-6), ..Survey::new(seed) })
        }),
        frame("axes of unequal scale", Some("anisotropic-scale"), |seed| {
            let defect = Defect::AxisScale([60e-6, -50e-6, 20e-6]);
            of_survey(&Survey { defect, ..Survey::new(seed) })
        }),
        frame("axes out of square", Some("shear"), |seed| {
            let defect = Defect::Squareness([90e-6, -60e-6, 0.0]);
            of_survey(&Survey { defect, ..Survey::new(seed) })
        }),
        frame("expansion with the air", Some("temperature"), |seed| {
            let defect = Defect::Expansion(150e-6);
            of_survey(&Survey { defect, record_air: true, ..Survey::new(seed) })
        }),
        frame("one bad point", Some("bad-point"), |seed| {
            let defect = Defect::BadPoint(8, [0.01, -0.02, 0.03]);
            of_survey(&Survey { defect, ..Survey::new(seed) })
        }),
        frame("a stand that sets, 40 µm", Some("drift"), |seed| {
            let defect = Defect::Settling([0.02, -0.01, 0.03], 0.1);
            of_survey(&Survey { defect, ..Survey::new(seed) })
        }),
        press("nothing missing", None, |seed| of_session(&located(seed, Fault::None))),
        press("moments biased", Some("sensor-bias"), |seed| {
            of_session(&located(seed, Fault::Bias([0.0, 0.0, 0.0, 12.0, -8.0, 0.0])))
        }),
        press("moments drift", Some("bias-drift"), |seed| {
            of_session(&located(seed, Fault::BiasDrift([0.0, 0.0, 0.0, 24.0, 16.0, 0.0])))
        }),
        press("platform thicker", Some("contact-height"), |seed| {
            let session = located(seed, Fault::ContactHeight(2.0));
            of_session(&Session { drag: 0.2, ..session })
        }),
        press("head gives way under load", Some("load-shift"), |seed| {
            of_session(&located(seed, Fault::LoadShift([4e-3, -3e-3])))
        }),
        log("zero of the axial cell", Some("leg-zero [force, axial]"), |seed| {
            of_run(seed, Flaw::CellZero(3, 0.6), 0.6)
        }),
        log("gain of the axial cell", Some("leg-gain"), |seed| {
            of_run(seed, Flaw::CellGain(3, 0.02), 2.0)
        }),
        log("head heavier than declared", Some("head-weight"), |seed| {
            of_run(seed, Flaw::Weight(1.5), 1.5)
        }),
        log("length of leg 1 off", Some("leg-zero"), |seed| {
            of_run(seed, Flaw::LengthZero(0, 0.5), 500.0)
        }),
    ];
    all.extend(machines::situations());
    all.extend([
        press("the pad slips in its guide, 0.3 mm", Some("slip"), |seed| {
            let session = Session { fault: Fault::Slip(0.3), ..Session::new(seed) };
            of_session(&Session { drag: 0.2, ..session })
        }),
        press("the head gives way to friction, 30 µm/N", Some("lateral-compliance"), |seed| {
            let session = Session { fault: Fault::Compliance(0.03), ..Session::new(seed) };
            of_session(&Session { drag: 0.2, drag_varies: true, ..session })
        }),
        press("spindle housing warms, 0.12 mm", Some("drift"), |seed| {
            let fault = Fault::SpindleGrowth([0.1, -0.06]);
            of_session(&Session { fault, ..Session::new(seed) })
        }),
        log("the reference warms up, 2 N", Some("force-drift"), |seed| {
            of_run(seed, Flaw::Warming(2.0), 2.0)
        }),
        machines::axis_off_its_place(),
    ]);
    all
}

fn of_survey(scene: &Survey) -> Simulated {
    let surveyed = survey::simulate(scene);
    let sound = surveyed.second_from_first;
    let strain = match scene.defect {
        Defect::Scale(s) => [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]],
        Defect::AxisScale(s) => [[s[0], 0.0, 0.0], [0.0, s[1], 0.0], [0.0, 0.0, s[2]]],
        Defect::Squareness(g) => [[0.0, g[0], g[1]], [0.0, 0.0, g[2]], [0.0; 3]],
        _ => [[0.0; 3]; 3],
    };
    let plus = |strain: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
        let one = |i: usize, k: usize| f64::from(u8::from(i == k));
        let entry =
            |i: usize, k: usize| (0..3).map(|j| sound[i][j] * (one(j, k) + strain[j][k])).sum();
        std::array::from_fn(|i| std::array::from_fn(|k| entry(i, k)))
    };
    let linear = plus(strain);
    // The rotation nearest to the identity and a small strain turns by its skew part; what is left
    // out is of second order, a thousandth of the uncertainty.
    let skew = |i: usize, k: usize| 0.5 * (strain[i][k] - strain[k][i]);
    let turned = plus(std::array::from_fn(|i| std::array::from_fn(|k| skew(i, k))));
    let mut truths = Vec::new();
    for i in 0..3 {
        let (value, std) =
            (format!("estimates.translation_mm.{i}"), format!("estimates.std.translation_mm.{i}"));
        truths.push(truth("translation", value, std, sound[i][3]));
        for (k, entry) in linear[i].iter().enumerate() {
            let (value, std) =
                (format!("estimates.matrix.{i}.{k}"), format!("estimates.std.matrix.{i}.{k}"));
            truths.push(truth("linear part", value, std, *entry));
        }
    }
    let angles =
        [turned[2][1].atan2(turned[2][2]), -turned[2][0].asin(), turned[1][0].atan2(turned[0][0])];
    for (i, angle) in angles.iter().enumerate() {
        let (value, std) =
            (format!("estimates.angles_deg.{i}"), format!("estimates.std.angles_deg.{i}"));
        truths.push(truth("angles", value, std, angle.to_degrees()));
    }
    if let Defect::Scale(s) = scene.defect {
        let (value, std) = ("estimates.scale".to_owned(), "estimates.std.scale".to_owned());
        truths.push(truth("scale", value, std, 1.0 + s));
    }
    let sizes: Vec<f64> = match scene.defect {
        Defect::Scale(s) => vec![s * 1e6],
        Defect::AxisScale(s) => s.map(|v| v * 1e6).to_vec(),
        Defect::Squareness(g) => g.map(|v| v * 1e6).to_vec(),
        Defect::Expansion(e) => vec![e * 1e6],
        _ => Vec::new(),
    };
    truths.extend(sizes.iter().enumerate().map(|(k, size)| size_of_effect(k, *size)));
    (vec![("case.toml", surveyed.case_toml), ("pairs.csv", surveyed.pairs_csv)], truths)
}

fn located(seed: u64, fault: Fault) -> Session {
    Session { n_locate: 3, head_offset_mm: [0.42, -0.27], fault, ..Session::new(seed) }
}

fn of_session(scene: &Session) -> Simulated {
    let recorded = press::simulate(scene);
    // The answer's frame is that of no load; the simulated head is where it should be at this one.
    let at_no_load = match scene.fault {
        Fault::LoadShift(per_n) => per_n.map(|shift| -shift * press::REFERENCE_LOAD_N),
        _ => [0.0; 2],
    };
    let origin = recorded.in_sensor(at_no_load);
    let of_frame =
        |key: &str| (format!("estimates.frame.{key}"), format!("estimates.frame.std_{key}"));
    let mut truths = Vec::new();
    for (key, value_mm) in [("tx_mm", origin[0]), ("ty_mm", origin[1])] {
        let (value, std) = of_frame(key);
        truths.push(truth("frame translation", value, std, value_mm));
    }
    let (value, std) = of_frame("angle_deg");
    truths.push(truth("frame angle", value, std, -recorded.sensor_rad.to_degrees()));
    let located = (0..recorded.presses.len()).filter(|&i| recorded.presses[i].role == Role::Locate);
    for i in located {
        for (axis, offset_mm) in ["x", "y"].iter().zip(scene.head_offset_mm) {
            let value = format!("estimates.centers.{i}.offset_{axis}_mm");
            let std = format!("estimates.centers.{i}.std_{axis}_mm");
            truths.push(truth("located offset", value, std, offset_mm));
        }
    }
    let sizes: Vec<f64> = match scene.fault {
        Fault::Bias(b) => vec![b[3], b[4]],
        // From the first press to the last, of all intervals one less than the simulator counts.
        Fault::BiasDrift(b) => {
            let n = f64::from(u16::try_from(recorded.presses.len()).expect("some dozens"));
            [b[3], b[4]].map(|total| total * (n - 1.0) / n).to_vec()
        }
        Fault::ContactHeight(mm) => vec![mm],
        Fault::LoadShift(shift) => shift.map(|v| v * 1e3).to_vec(),
        _ => Vec::new(),
    };
    truths.extend(sizes.iter().enumerate().map(|(k, size)| size_of_effect(k, *size)));
    let files = vec![
        ("case.toml", case_toml(scene, &recorded)),
        ("presses.csv", presses_csv(&recorded)),
        ("wrench.csv", wrench_csv(&recorded)),
    ];
    (files, truths)
}

fn of_run(seed: u64, flaw: Flaw, size: f64) -> Simulated {
    let scene = Run { flaw, ..Run::new(seed) };
    let samples = polish::simulate(&scene);
    let files = vec![
        ("case.toml", polish_tables::case_toml(&scene)),
        ("log.csv", polish_tables::log_csv(&scene, &samples)),
    ];
    (files, vec![size_of_effect(0, size)])
}
