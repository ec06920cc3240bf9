//! `truing loop CASE --carry FILE`: what one session showed of a part, declared for the next.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};

use crate::command::{Case, Ended, truing};

const NOISE_MM: f64 = 1e-3;
/// Saddle of the real part at 50 mm from its axis: cos and sin.
const BEND_MM: [f64; 2] = [0.009, -0.006];
/// What the noise of some forty touches leaves of an amplitude: four of its standard deviations,
/// each σ over the root of the touches times the mean of ρ² cos 2θ.
const AMPLITUDE_UM: f64 = 2.0;
/// The held-out error over the noise, less one: an eighth for five parameters from forty touches, and
/// four of its standard deviations, 1/√80.
const NOISE_SHARE: f64 = 0.58;

const BOWL: &str = "kind = \"pose-icp\"\n[surface]\nshape = \"polynomial\"\nunit_mm = 50.0\n\
    terms = [[2, 0, 12.5], [0, 2, 12.5]]\n[pose]\nknown = [\"gamma\"]\n\
    [noise]\npoint_mm = 0.001\n";

/// Where the part lies in a session: d, and rotations about x and y.
struct Session {
    at_mm: [f64; 3],
    tilts_rad: [f64; 2],
    seed: u64,
}

const FIRST: Session = Session { at_mm: [3.0, -2.0, 1.0], tilts_rad: [2e-3, -1e-3], seed: 5 };
const SECOND: Session = Session { at_mm: [-1.0, 4.0, -2.0], tilts_rad: [-1e-3, 3e-3], seed: 6 };

fn touches(session: &Session) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(session.seed);
    let mut text = "point,x_mm,y_mm,z_mm\n".to_owned();
    let [(sa, ca), (sb, cb)] = session.tilts_rad.map(f64::sin_cos);
    // In an order that does not run outwards: 23 and 40 have no common factor.
    for i in (0..40).map(|i| f64::from(i * 23 % 40)) {
        let radius = 48.0 * ((i + 0.5) / 40.0).sqrt();
        let (sin, cos) = (2.399_963 * i).sin_cos();
        let [x, y] = [radius * cos, radius * sin];
        let (u, v) = (x / 50.0, y / 50.0);
        let z = 12.5 * (u * u + v * v) + BEND_MM[0] * (u * u - v * v) + BEND_MM[1] * 2.0 * u * v;
        let (y, z) = (ca * y - sa * z, sa * y + ca * z);
        let turned = [cb * x + sb * z, y, cb * z - sb * x];
        let read: [f64; 3] = std::array::from_fn(|k| {
            let unit: f64 = StandardNormal.sample(&mut rng);
            turned[k] + session.at_mm[k] + NOISE_MM * unit
        });
        text += &format!("P{i},{:.6},{:.6},{:.6}\n", read[0], read[1], read[2]);
    }
    text
}

fn case(session: &Session) -> Case {
    Case::new(&[("case.toml", BOWL), ("points.csv", &touches(session))])
}

fn carried(case: &Case, file: &str, more: &[&str]) -> Ended {
    let path = case.file(file);
    let arguments = ["loop", case.path().to_str().unwrap(), "--carry", path.to_str().unwrap()];
    truing(&[&arguments[..], more].concat())
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} of {value}"))
}

#[test]
fn what_one_session_shows_is_declared_for_the_next() {
    let learnt = case(&FIRST).json("loop");
    assert_eq!(learnt["steps"].as_array().map(Vec::len), Some(1), "{}", learnt["steps"]);
    assert_eq!(learnt["steps"][0]["effect"], "astigmatism");
    let next = case(&SECOND);
    next.write("learnt.json", learnt.to_string());
    let report = next.file("report.html");
    let ended = carried(&next, "learnt.json", &["--json", "--report", report.to_str().unwrap()]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    for (k, bend_mm) in BEND_MM.iter().enumerate() {
        let um = number(&answer, &format!("/carried/effects/0/parameters/{k}/value"));
        assert!((um - 1e3 * bend_mm).abs() < AMPLITUDE_UM, "{um} µm");
    }
    let without = number(&answer, "/carried/without/held_out_rms");
    let with = number(&answer, "/carried/with/held_out_rms");
    assert!(without > 3.0 * NOISE_MM, "{without}");
    assert!((with / NOISE_MM - 1.0).abs() < NOISE_SHARE, "{with}");
    assert_eq!(answer["carried"]["with"], answer["before"]);
    // Nothing is left to be found, and the pose is that of this session.
    assert_eq!(answer["steps"], json!([]));
    assert_eq!(answer["verdict"], "nothing-missing");
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        let found = number(&answer, &format!("/estimates/pose/{axis}_mm"));
        let std = number(&answer, &format!("/estimates/pose/std_{axis}_mm"));
        assert!((found - SECOND.at_mm[k]).abs() < 5.0 * std, "{axis}: {found} ± {std}");
    }
    let page = std::fs::read_to_string(report).unwrap();
    assert!(page.contains("carried from") && page.contains("without what was carried"));
    let text = carried(&next, "learnt.json", &[]).stdout;
    for expected in ["carried from", "astigmatism, cos = ", "without the carried"] {
        assert!(text.contains(expected), "{text}");
    }
}

/// Any kind whose effects have parameters: here the scale between two frames.
#[test]
fn a_scale_is_carried_between_frames() {
    let table = |shift_mm: f64| {
        let mut text = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
        // Off by ±1 µm in a pattern that no scale has.
        let pattern = [1.0, -1.0, -1.0, 1.0, -1.0, 1.0].into_iter().cycle();
        for (i, sign) in (0..12).zip(pattern) {
            let [x, y] = [100.0 * f64::from(i % 4), 150.0 * f64::from(i / 4)];
            let off = 1e-3 * sign;
            let to = [x, y].map(|v| v * (1.0 + 2e-4) + shift_mm + off);
            text += &format!("Q{i},{x},{y},{:.6},{:.6}\n", to[0], to[1]);
        }
        text
    };
    let settings = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.001\n";
    let learnt = Case::new(&[("case.toml", settings), ("pairs.csv", &table(2.0))]).json("loop");
    assert_eq!(learnt["steps"][0]["effect"], "scale", "{}", learnt["steps"]);
    let next = Case::new(&[("case.toml", settings), ("pairs.csv", &table(-7.0))]);
    next.write("learnt.json", learnt.to_string());
    let ended = carried(&next, "learnt.json", &["--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    let without = number(&answer, "/carried/without/held_out_rms");
    let with = number(&answer, "/carried/with/held_out_rms");
    assert!(with < 0.1 * without, "{without} -> {with}");
}

fn step(effect: &str, parameters: &Value) -> Value {
    json!({ "effect": effect, "parameters": parameters })
}

fn cos(value: &Value, unit: &str) -> Value {
    json!([{ "name": "cos", "value": value, "unit": unit, "std": 0.3 }])
}

/// The one message on carrying a file of that content.
fn refused(content: &str) -> String {
    let next = case(&SECOND);
    next.write("learnt.json", content);
    let ended = carried(&next, "learnt.json", &["--json"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
    let message = ended.one_message();
    assert!(message.contains("learnt.json: "), "{message}");
    message
}

fn refused_steps(kind: &str, steps: &Value) -> String {
    refused(&json!({ "kind": kind, "steps": steps }).to_string())
}

#[test]
fn files_that_are_no_answer_of_the_loop() {
    for (content, expected) in [
        ("", "is not JSON: EOF while parsing"),
        (
            "{ \"kind\": \"pose-icp\",\n \"steps\": [",
            "is not JSON: EOF while parsing a list at line 2",
        ),
        ("kind,steps\n", "is not JSON: expected value at line 1 column 1"),
        ("{}", "is not an answer of the loop: missing field `kind`"),
        ("{ \"kind\": \"pose-icp\" }", "is not an answer of the loop: missing field `steps`"),
        ("[1, 2]", "is not an answer of the loop"),
    ] {
        let message = refused(content);
        assert!(message.contains(expected), "{message}");
    }
    let next = case(&SECOND);
    let ended = carried(&next, "nowhere.json", &[]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("nowhere.json: cannot be read: entity not found"));
}

#[test]
fn effects_of_another_case() {
    let says = |kind: &str, steps: Value, expected: &str| {
        let message = refused_steps(kind, &steps);
        assert!(message.contains(expected), "{message}");
    };
    let good = || step("astigmatism", &cos(&json!(9.0), "µm"));
    says(
        "frame-fit",
        json!([good()]),
        "was learnt on a case of kind `frame-fit`, and this one is of kind pose-icp",
    );
    says(
        "pose-icp",
        json!([step("astigmatismus", &cos(&json!(9.0), "µm"))]),
        "the effect `astigmatismus` is not one of this kind; there are `astigmatism`, `axis-scale`",
    );
    says(
        "pose-icp",
        json!([step("astigmatism", &cos(&json!(9.0), "mm"))]),
        "`astigmatism`, parameter `cos`: expected a value in µm, found one in `mm`",
    );
    says(
        "pose-icp",
        json!([step("trefoil", &json!([{ "name": "tan", "value": 1.0, "unit": "µm" }]))]),
        "`trefoil` has no parameter `tan`; it has `cos`, `sin`",
    );
    says(
        "pose-icp",
        json!([step("astigmatism", &cos(&Value::Null, "µm"))]),
        "`astigmatism`, parameter `cos`: the value is not a finite number",
    );
    says("pose-icp", json!([good(), good()]), "the effect `astigmatism` is there twice");
    says("pose-icp", json!([]), "holds no effect to carry: the loop had added nothing");
    let bad = json!({ "effect": "bad-point", "subject": "P3", "parameters": [] });
    says("pose-icp", json!([bad]), "`bad-point` [`P3`], which is about one reading");
    says(
        "pose-icp",
        json!([step("covariate:air_c", &json!([]))]),
        "the empirical correction along `air_c`, whose cause is not known",
    );
    says("pose-icp", json!([step("drift", &json!([]))]), "belongs to the course of that session");
    let mut other = good();
    other["description"] = "the part is bent like a saddle; height at 60.0 mm from the axis".into();
    says("pose-icp", json!([other]), "height at 60.0 mm from the axis» there, «the part is bent");
}

#[test]
fn what_stays_behind_is_said() {
    let next = case(&SECOND);
    let steps = json!([
        step("astigmatism", &cos(&json!(9.0), "µm")),
        step("covariate:part_x_mm", &json!([])),
        json!({ "effect": "bad-point", "subject": "elsewhere", "parameters": [] }),
    ]);
    next.write("learnt.json", json!({ "kind": "pose-icp", "steps": steps }).to_string());
    let ended = carried(&next, "learnt.json", &[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for expected in [
        "not carried: the empirical correction along `part_x_mm`",
        "not carried: `bad-point` [`elsewhere`], which this case does not have",
    ] {
        assert!(ended.stderr.contains(expected), "{}", ended.stderr);
    }
}
