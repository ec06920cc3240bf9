//! What a recorded column holds: its name says it, or `[loop] columns`.

use std::fmt::Write as _;

use crate::command::Case;

/// Thirty points of a frame that grows by 12 ppm/K of `column`, which runs from 17 to 29.
fn grown(column: &str, setting: &str) -> Case {
    let mut table = format!("point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,{column}\n");
    let mut state = 1_u32;
    let mut noise = || {
        // Knuth's multiplier; the upper bits, within ± 0.0003 mm.
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 16) / 65_536.0 * 6e-4 - 3e-4
    };
    for i in 0..30_i32 {
        let [x, y, value] = [
            f64::from((i * 7) % 30) * 40.0,
            f64::from((i * 11) % 30) * 30.0,
            17.0 + f64::from((i * 13) % 25) * 0.5,
        ];
        let grown = 1.0 + 12e-6 * (value - 20.0);
        let (to_x, to_y) = (x * grown + noise(), y * grown + noise());
        writeln!(table, "P{i},{x},{y},{to_x:.5},{to_y:.5},{value}").unwrap();
    }
    let case = Case::new(&[]);
    case.write("case.toml", format!("kind = \"frame-fit\"\n[noise]\npoint_mm = 2e-4\n{setting}"));
    case.write("pairs.csv", table);
    case
}

/// Ids of the effects that were found, with their descriptions.
fn found(case: &Case) -> Vec<(String, String)> {
    let answer = case.json("loop");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let steps = answer["steps"].as_array().unwrap();
    steps.iter().map(|step| (text(&step["effect"]), text(&step["description"]))).collect()
}

#[test]
fn a_temperature_is_told_by_its_name_or_by_the_case() {
    let said = "[loop]\ncolumns = { pt100 = \"temperature\" }\n";
    for (column, setting) in [("air_c", ""), ("pt100", said)] {
        let found = found(&grown(column, setting));
        let [(effect, description)] = &found[..] else { panic!("{found:?}") };
        assert_eq!(effect, "temperature");
        assert!(description.contains(column), "{description}");
    }
}

#[test]
fn the_position_of_axis_c_is_no_temperature() {
    for (column, setting) in
        [("pos_c", ""), ("load", ""), ("air_c", "[loop.columns]\nair_c = \"other\"\n")]
    {
        let found = found(&grown(column, setting));
        assert!(found.iter().all(|(effect, _)| effect != "temperature"), "{column}: {found:?}");
    }
}

#[test]
fn a_column_that_is_not_there_is_an_error() {
    let case = grown("air_c", "[loop]\ncolumns = { air_d = \"temperature\" }\n");
    let message = case.message("check", 2);
    assert!(message.contains("case.toml") && message.contains("`air_c`"), "{message}");
    let case = grown("air_c", "[loop]\ncolumns = { air_c = \"warmth\" }\n");
    let message = case.message("check", 2);
    assert!(message.contains("temperature"), "{message}");
}

/// Points that were taken with one of two nests, which come and go: one of them is 20 µm higher than it was entered.
/// Where each stands in one piece, they are as well two sessions, and that is what is named.
#[test]
fn names_of_a_label_that_come_and_go_are_covariates() {
    let of = |nest: &dyn Fn(i32) -> &'static str| {
        let mut table = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,nest\n".to_owned();
        for i in 0..40_i32 {
            let [x, y] = [f64::from((i * 7) % 40) * 40.0, f64::from((i * 11) % 40) * 30.0];
            let noise = |k: f64| 2e-3 * (1e4 * f64::sin(12.9 * (f64::from(i) + k))).sin();
            let higher = if nest(i) == "B" { 0.02 } else { 0.0 };
            let (to_x, to_y) = (x + noise(0.1), y + higher + noise(0.7));
            writeln!(table, "P{i},{x},{y},{to_x:.5},{to_y:.5},{}", nest(i)).unwrap();
        }
        let case = Case::new(&[]);
        case.write("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.0015\n");
        case.write("pairs.csv", table);
        let names = found(&case).into_iter().map(|(id, _)| id);
        names.collect::<Vec<_>>()
    };
    assert_eq!(of(&|i| if i * i % 7 < 3 { "B" } else { "A" }), ["covariate:nest: B"]);
    assert_eq!(of(&|i| if i < 20 { "B" } else { "A" }), ["session-shift"]);
}
