//! `[frame] from`: the frame calibrated once, heads located later; repeatability and its tolerance.

use std::fs;

use serde_json::Value;

use crate::command::{Case, truing};

/// What the example's press 11 is off by, as its table says, and four standard uncertainties of it.
const OFF_MM: [f64; 2] = [0.42, -0.27];
const OFF_TOL_MM: f64 = 0.08;

/// The press to be located alone, and the answer of the whole example beside it.
fn later_head(command: &str) -> (Case, Value) {
    let whole = Case::example("ft-center");
    let answer = whole.json(command);
    let case = Case::example("ft-center");
    case.write("solved.json", answer.to_string());
    let only = |name: &str| {
        let text = fs::read_to_string(case.file(name)).unwrap();
        let keep = |line: &&str| {
            line.starts_with("press,") || line.starts_with("11,") || line.starts_with('#')
        };
        let kept: Vec<&str> = text.lines().filter(keep).collect();
        case.write(name, kept.join("\n") + "\n");
    };
    only("presses.csv");
    only("wrench.csv");
    case.replace("case.toml", "[model]\n", "[frame]\nfrom = \"solved.json\"\n[model]\n");
    (case, answer)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_later_head_is_located_from_one_press() {
    let (case, answer) = later_head("solve");
    let later = case.json("solve");
    let center = &later["estimates"]["centers"][0];
    for (key, off) in [("offset_x_mm", OFF_MM[0]), ("offset_y_mm", OFF_MM[1])] {
        assert!((number(&center[key]) - off).abs() < OFF_TOL_MM, "{center}");
    }
    let joint = &answer["estimates"]["centers"][10];
    let std = |c: &Value| number(&c["std_x_mm"]);
    // The same record, seat and frame; how far the record's noise is slow is pooled over one.
    assert!((0.5..2.0).contains(&(std(center) / std(joint))), "{center} {joint}");
    assert_eq!(
        later["estimates"]["frame"]["covariance"],
        answer["estimates"]["frame"]["covariance"]
    );
    assert_eq!(
        (later["residual"]["n"].as_u64(), &later["residual"]["rms"]),
        (Some(0), &Value::Null)
    );
    assert_eq!(
        later["interval"]["degrees_of_freedom"],
        answer["estimates"]["frame"]["degrees_of_freedom"]
    );
    let inputs = later["inputs"].as_array().unwrap();
    assert!(inputs.iter().any(|i| i["file"] == "solved.json"), "{inputs:?}");
}

/// The example's sensor reads Fz too small, which the loop finds and takes off: a later wrench still
/// has it.
#[test]
fn a_frame_of_corrected_wrenches_is_refused() {
    let (case, answer) = later_head("loop");
    assert_eq!(answer["steps"][0]["effect"], "force-gain");
    let told = case.message("solve", 2);
    assert!(
        told.contains("is of a loop that found `force-gain`, which its frame counts"),
        "{told}"
    );
}

#[test]
fn the_frame_stands_in_for_ten_presses_and_no_other() {
    let (case, answer) = later_head("solve");
    let told = |case: &Case| {
        let message = case.message("solve", 2);
        message.replace(&format!("{}/", case.path().display()), "")
    };
    let with = |key: &[&str], value: Value, said: &str| {
        let mut other = answer.clone();
        let place = key.iter().fold(&mut other, |at, key| &mut at[*key]);
        *place = value;
        case.write("solved.json", other.to_string());
        let message = told(&case);
        assert!(message.starts_with("case.toml, line ") && message.contains(said), "{message}");
    };
    let frame = |key| ["estimates", "frame", key];
    with(&["kind"], "pose-icp".into(), "is an answer of kind `pose-icp`; expected one of kind");
    with(&["residual", "unit"], "in".into(), "has residuals in `in`; expected mm");
    with(&["verdict"], "input-wrong".into(), "found its input wrong");
    with(&["estimates", "frame"], Value::Null, "has no frame");
    with(&frame("z0_mm"), 41.0.into(), "was found with z0_mm = 41, and the case says 42");
    with(&frame("covariance"), Value::Null, "is no answer with a frame to use again");
    let no_covariance =
        serde_json::json!([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]]);
    with(&frame("covariance"), no_covariance, "leaves its angle free");
    case.write("solved.json", "{");
    assert!(told(&case).contains("is not JSON"));
    case.write("solved.json", answer.to_string());
    case.replace("case.toml", "# handedness = \"same\"", "handedness = \"opposed\"");
    assert!(told(&case).contains("has handedness `same`, and the case says `opposed`"));
    case.replace("case.toml", "handedness = \"opposed\"", "handedness = \"same\"");
    case.replace("presses.csv", ",locate", ",frame");
    assert!(told(&case).contains("press 11 is of use = frame, and the frame is taken from"));
    case.replace("presses.csv", ",frame", ",locate");
    // The position in inches.
    case.replace("presses.csv", "150.000,110.000", "5.906,4.331");
    let doubted = case.json("solve")["warnings"].to_string();
    assert!(
        doubted.contains("press `11` is 178.9 mm from the middle of the calibration"),
        "{doubted}"
    );
    assert!(case.message("loop", 2).contains("nothing is fitted here"));
}

#[test]
fn a_frame_outside_of_the_folder_has_to_be_allowed() {
    let (case, _) = later_head("solve");
    let outside = Case::new(&[("solved.json", "")]);
    fs::rename(case.file("solved.json"), outside.file("solved.json")).unwrap();
    let path = outside.file("solved.json");
    case.replace("case.toml", "solved.json", path.to_str().unwrap());
    assert!(case.message("solve", 2).contains("is outside of the case folder"));
    let allowed = truing(&["solve", case.path().to_str().unwrap(), "--json", "--allow-outside"]);
    assert_eq!(allowed.code, 0, "{}", allowed.stderr);
}

#[test]
fn repeated_presses_are_held_against_their_tolerance() {
    let case = Case::example("ft-center");
    assert_eq!(case.json("solve")["estimates"]["repeatability"], Value::Null);
    // Presses 6 and 10 are told to be of one place: what is between them is no repeatability, and
    // far beyond a tenth of a millimetre.
    case.replace("presses.csv", "160.000,120.000,check", "165.000,110.000,check");
    let toml = fs::read_to_string(case.file("case.toml")).unwrap();
    let held = |tolerance_mm: &str| {
        case.write("case.toml", format!("{toml}[tolerance]\nrepeatability_mm = {tolerance_mm}\n"));
        case.json("solve")["estimates"]["repeatability"].clone()
    };
    let found = held("0.1");
    assert_eq!(
        (found["places"].as_u64(), found["degrees_of_freedom"].as_u64()),
        (Some(1), Some(1))
    );
    let (std, four) = (number(&found["std_y_mm"]), number(&found["y_mm"]));
    // 10 mm apart along y: s = 10/√2 within a millimetre.
    assert!((std - 50.0_f64.sqrt()).abs() < 0.7 && (four - 4.0 * std).abs() < 1e-12, "{found}");
    assert_eq!(found["conformity"]["decision"], "fail");
    let wide = held("1000");
    assert_eq!(wide["conformity"]["decision"], "pass", "{wide}");
    let between = held("28");
    assert_eq!(between["conformity"]["decision"], "undecided", "{between}");
    let ended = case.run("solve");
    assert!(ended.stderr.contains("undecided") || ended.stdout.contains("undecided"));
    case.write("case.toml", format!("{toml}[tolerance]\nconformance = 1\n"));
    assert!(case.message("solve", 2).contains("expected a probability above 0.5 and below 1"));
}
