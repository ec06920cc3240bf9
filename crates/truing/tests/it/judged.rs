//! What `solve`, `check` and `loop` say of data that do not fit what was declared.

use serde_json::Value;

use crate::command::Case;

fn chi2(residual: &Value) -> (f64, f64, f64) {
    let interval = &residual["chi2_interval"];
    let number = |value: &Value| value.as_f64().expect("a number where noise is declared");
    (number(&residual["chi2_per_dof"]), number(&interval[0]), number(&interval[1]))
}

fn warned(answer: &Value, words: &str) -> bool {
    let warnings = answer["warnings"].as_array().unwrap();
    warnings.iter().any(|w| w.as_str().unwrap().contains(words))
}

#[test]
fn every_command_says_where_chi_squared_should_lie() {
    let case = Case::example("frame-fit");
    for command in ["solve", "check", "loop"] {
        let answer = case.json(command);
        let (value, low, high) = chi2(&answer["residual"]);
        assert!(low < 1.0 && 1.0 < high && value > 0.0, "{command}: {value} {low} {high}");
    }
}

#[test]
fn noise_declared_far_too_small_is_a_warning_in_every_command() {
    let case = Case::example("frame-fit");
    case.replace("case.toml", "point_mm = 0.01", "point_mm = 0.00001");
    for command in ["solve", "check", "loop"] {
        let answer = case.json(command);
        let (value, _, high) = chi2(&answer["residual"]);
        assert!(value > high, "{command}");
        assert!(warned(&answer, "times as much as the declared noise"), "{command}");
    }
    assert_ne!(case.json("loop")["verdict"], "nothing-missing");
}

/// A table of displacements with a profile of 20 µm over nine places, five times there and back.
fn repeated_profile() -> Case {
    let mut table = String::from("point,commanded_mm,solved_mm,cycle\n");
    // Sums of digits of a fixed sequence: noise of a micrometre or two.
    let mut state = 12345_u64;
    for cycle in 0..5 {
        for step in 0..18_u32 {
            let place = if step < 9 { step } else { 17 - step };
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888);
            let noise_mm = f64::from(u8::try_from((state >> 40) % 5).unwrap()) * 1e-3 - 2e-3;
            let at_mm = 5.0 * f64::from(place);
            let error_mm =
                [0.02, -0.01, 0.03, 0.0, -0.02, 0.01, -0.03, 0.02, -0.01][place as usize];
            table += &format!("p{cycle}_{step},{at_mm},{},c{cycle}\n", at_mm + error_mm + noise_mm);
        }
    }
    let toml = "kind = \"ft-center\"\n[loop]\ngroup = \"cycle\"\n";
    Case::new(&[("case.toml", toml), ("displacements.csv", &table)])
}

#[test]
fn a_profile_that_repeats_is_neither_noise_nor_nothing() {
    let case = repeated_profile();
    for command in ["solve", "check"] {
        let answer = case.json(command);
        let test = &answer["lack_of_fit"];
        assert_eq!(test["levels"], 9, "{command}: {test}");
        assert!(test["p_value"].as_f64().unwrap() < 1e-9, "{command}: {test}");
        assert!(warned(&answer, "lack of fit"), "{command}");
    }
    // The loop corrects it place by place, as a profile of the axis.
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "explained");
    assert_eq!(answer["steps"][0]["effect"], "profile");
    let [before, after] =
        ["before", "after"].map(|model| answer[model]["held_out_rms"].as_f64().unwrap());
    assert!(after < 0.2 * before, "{before} {after}");
}

#[test]
fn a_letter_that_does_not_fit_the_direction_names_the_one_that_does() {
    let case = Case::example("tracker-lm");
    case.replace("case.toml", "letter = \"B\"", "letter = \"C\"");
    let message = case.message("solve", 2);
    assert!(message.contains("write `letter = \"B\"`"), "{message}");
}

#[test]
fn a_reversed_axis_is_not_compensated() {
    let case = Case::example("tracker-lm");
    let toml = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let line = toml.lines().find(|l| l.trim_start().starts_with("direction")).unwrap();
    let numbers = line.split(['[', ']']).nth(1).unwrap();
    let reversed: Vec<String> =
        numbers.split(',').map(|n| format!("{}", -n.trim().parse::<f64>().unwrap())).collect();
    case.replace("case.toml", line, &format!("direction = [{}]", reversed.join(", ")));
    let file = case.file("axis.comp");
    let folder = case.path().to_str().unwrap().to_owned();
    let ended =
        crate::command::truing(&["solve", &folder, "--compensation", file.to_str().unwrap()]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("turns against `[axis] direction`"), "{}", ended.stderr);
    assert!(!file.exists(), "nothing is written");
    assert!(warned(&case.json("solve"), "turns against `[axis] direction`"));
}
