//! Data drawn anew from their declared noise.

use serde_json::Value;

use crate::command::{Case, truing};

/// Draws of a test: a standard deviation is then known to 3.5 %.
const DRAWS: &str = "400";
/// Four standard deviations of that, and what one parameter of a bent model may differ by.
const AGREEMENT: f64 = 0.2;

fn answer(case: &Case, threads: &str) -> String {
    let path = case.path().to_str().unwrap();
    let asked = ["solve", path, "--json", "--no-timing", "--threads", threads];
    let ended = truing(&[&asked[..], &["--monte-carlo", DRAWS]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    ended.stdout
}

fn parameters(answer: &str) -> Vec<Value> {
    let answer: Value = serde_json::from_str(answer).unwrap();
    let drawn = &answer["monte_carlo"];
    assert_eq!((drawn["draws"].as_u64(), drawn["failed"].as_u64()), (Some(400), Some(0)));
    drawn["parameters"].as_array().unwrap().clone()
}

#[test]
fn draws_scatter_as_linear_propagation_says() {
    for kind in ["frame-fit", "pose-icp", "tracker-lm"] {
        let case = Case::example(kind);
        let drawn = parameters(&answer(&case, "2"));
        assert!(drawn.len() > 3, "{kind}");
        for parameter in &drawn {
            let number = |key: &str| parameter[key].as_f64().unwrap();
            let [low, high] = [0, 1].map(|k| parameter["interval_95"][k].as_f64().unwrap());
            assert!(low < high, "{kind}: {parameter}");
            let ratio = number("std") / number("linear_std");
            assert!((ratio - 1.0).abs() < AGREEMENT, "{kind}: {parameter}");
            // 3.92 standard deviations, ends to 6 % each.
            let width = (high - low) / number("std");
            assert!((3.3..4.5).contains(&width), "{kind}: {parameter}");
        }
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let case = Case::example("frame-fit");
    assert_eq!(answer(&case, "1"), answer(&case, "3"));
}

#[test]
fn without_declared_noise_there_is_nothing_to_draw_from() {
    let case = Case::new(&[]);
    case.write("case.toml", "kind = \"frame-fit\"\n");
    let mut table = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
    for i in 0..6_i32 {
        let (x, y) = (f64::from(i * 37 % 100), f64::from(i * 53 % 70));
        table += &format!("P{i},{x},{y},{},{}\n", x + 1.0, y + 0.001 * f64::from(i % 3));
    }
    case.write("pairs.csv", table);
    let path = case.path().to_str().unwrap().to_owned();
    let ended = truing(&["solve", &path, "--monte-carlo", DRAWS]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("`[noise] point_mm` is missing"), "{}", ended.stderr);
    // Fewer than a hundred say nothing of an interval.
    let ended = truing(&["solve", &path, "--monte-carlo", "10"]);
    assert_eq!(ended.code, 2);
}

#[test]
fn draws_of_a_loop_are_of_the_model_that_it_ended_with() {
    for (kind, effect) in [("frame-fit", "scale"), ("tracker-lm", "dead-path-jump")] {
        let case = Case::example(kind);
        let path = case.path().to_str().unwrap();
        let asked = ["loop", path, "--json", "--no-timing", "--monte-carlo", DRAWS];
        let ended = truing(&asked);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
        let steps = answer["steps"].as_array().unwrap();
        assert!(steps.iter().any(|step| step["effect"] == effect), "{kind}: {steps:?}");
        let drawn = parameters(&ended.stdout);
        let amplitude = |p: &&Value| p["name"].as_str().unwrap().starts_with(effect);
        assert!(drawn.iter().any(|p| amplitude(&p)), "{kind}: {drawn:?}");
        for parameter in &drawn {
            let ratio =
                parameter["std"].as_f64().unwrap() / parameter["linear_std"].as_f64().unwrap();
            assert!((ratio - 1.0).abs() < AGREEMENT, "{kind}: {parameter}");
        }
    }
}

#[test]
fn sources_add_up_in_squares() {
    let case = Case::example("tracker-lm");
    let drawn = parameters(&answer(&case, "2"));
    for parameter in &drawn {
        let alone = parameter["by_source"].as_array().unwrap();
        let together = alone.iter().map(|s| s.as_f64().unwrap().powi(2)).sum::<f64>().sqrt();
        let ratio = together / parameter["std"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < AGREEMENT, "{parameter}");
    }
}
