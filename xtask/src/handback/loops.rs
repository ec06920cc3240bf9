//! `truing loop`, and what it found.

use std::path::PathBuf;
use std::sync::OnceLock;

use serde_json::Value;

use crate::handback::folder::Folder;
use crate::program::{Truing, label_of};

static TRUING: OnceLock<Truing> = OnceLock::new();

fn truing() -> &'static Truing {
    TRUING.get_or_init(|| Truing::beside_the_tests().expect("truing is built"))
}

/// Corrects a program by what the loop found on a folder; the program written.
pub(crate) fn correct(folder: &Folder, json: &Value, program: &str) -> String {
    let [planned, answer, written] =
        ["planned.ngc", "loop.json", "written.ngc"].map(|file| folder.path.join(file));
    std::fs::write(&planned, program).expect("an own file");
    std::fs::write(&answer, json.to_string()).expect("an own file");
    let arguments = [
        "correct".as_ref(),
        folder.path.as_os_str(),
        planned.as_os_str(),
        "--answer".as_ref(),
        answer.as_os_str(),
        "--decimals".as_ref(),
        "9".as_ref(),
        "--output".as_ref(),
        written.as_os_str(),
    ];
    let ended = truing().run(&arguments).expect("truing starts");
    assert_eq!(ended.code, Some(0), "{}: {}", folder.name(), ended.message);
    std::fs::read_to_string(written).expect("a program was written")
}

/// Closes the loop on a folder; its answer.
pub(crate) fn close(folder: &Folder) -> Value {
    let arguments = ["loop".as_ref(), folder.path.as_os_str(), "--json".as_ref()];
    let answer = truing().run(&arguments).expect("truing starts");
    assert_eq!(answer.code, Some(0), "{}: {}", folder.name(), answer.message);
    answer.json
}

/// Closes the loop and writes tables by options; the answer and the tables, `None` where these are
/// refused as no correction.
pub(crate) fn exported<const N: usize>(
    folder: &Folder,
    tables: [(&str, &str); N],
) -> Option<(Value, [String; N])> {
    let name = folder.path.file_name().expect("a folder");
    let written = Folder::written(&format!("exports/{}", name.display()), &[]).path;
    let files = tables.map(|(option, file)| (option, written.join(file)));
    let mut arguments = vec!["loop".as_ref(), folder.path.as_os_str(), "--json".as_ref()];
    arguments.extend(files.iter().flat_map(|(option, file)| [option.as_ref(), file.as_os_str()]));
    let answer = truing().run(&arguments).expect("truing starts");
    if answer.code == Some(2) && answer.message.contains("--max-correction") {
        return None;
    }
    assert_eq!(answer.code, Some(0), "{}: {}", folder.name(), answer.message);
    let read = |(_, file): (&str, PathBuf)| std::fs::read_to_string(file).expect("it was written");
    Some((answer.json, files.map(read)))
}

/// Effects that were accepted, as `id` or `id [subject]`.
pub(crate) fn accepted(json: &Value) -> Vec<String> {
    let steps = json["steps"].as_array().expect("steps");
    let label = |step: &Value| label_of(step).expect("an id");
    steps.iter().map(label).collect()
}

/// The accepted effect of that id and subject.
pub(crate) fn step<'a>(json: &'a Value, id: &str, subject: Option<&str>) -> Option<&'a Value> {
    let steps = json["steps"].as_array().expect("steps");
    steps.iter().find(|s| s["effect"] == id && s["subject"].as_str() == subject)
}

/// Accepted effects of an id, with their subjects.
pub(crate) fn subjects<'a>(json: &'a Value, id: &str) -> Vec<(&'a str, &'a Value)> {
    let steps = json["steps"].as_array().expect("steps").iter();
    steps
        .filter(|s| s["effect"] == id)
        .map(|s| (s["subject"].as_str().expect("a subject"), s))
        .collect()
}

/// Accepted effects of an id that count from one of these readings on, or to another, of those that count at a row.
pub(crate) fn begun<'a>(
    json: &'a Value,
    (id, whose): (&str, &str),
    names: &[String],
    row: usize,
) -> Vec<&'a Value> {
    let position = |name: &str| names.iter().position(|known| known == name);
    let counts = |subject: &str| {
        let when = subject.strip_prefix(whose)?.strip_prefix("from ")?;
        match (when.strip_suffix(" on"), when.split_once(" to ")) {
            (Some(first), _) => Some(row >= position(first)?),
            (None, Some((first, last))) => {
                Some((position(first)?..=position(last)?).contains(&row))
            }
            (None, None) => None,
        }
    };
    let all = subjects(json, id).into_iter();
    all.filter(|(subject, _)| counts(subject) == Some(true)).map(|(_, step)| step).collect()
}

/// Whether a drift comes to rest, by its words.
pub(crate) fn comes_to_rest(step: &Value) -> bool {
    step["description"].as_str().expect("words").contains("τ = ")
}

/// How far what comes to rest has come, or how much of what comes to rest as declared is left: `elapsed` in hours where there is a time, else as a share of so
/// many rows.
pub(crate) fn settled(step: &Value, elapsed: f64, is_time: bool, rows: usize) -> f64 {
    let text = step["description"].as_str().expect("words");
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let constants: Vec<f64> =
        text.split("τ = ").skip(1).map(|t| number(t.split(' ').next().expect("a word"))).collect();
    let slower = text.split(", and ").nth(1).and_then(|t| t.split(" % of it").next());
    let slower = slower.map_or(0.0, |share| 1e-2 * number(share));
    let passed = elapsed * if is_time { 3600.0 } else { crate::handback::as_f64(rows - 1) };
    // Parts of both sizes together; one that goes the other way is negative.
    let shares = [1.0 - slower.abs(), slower];
    let left = |(constant, share): (&f64, f64)| share * (-passed / constant).exp();
    let left: f64 = constants.iter().zip(shares).map(left).sum();
    if text.contains("1 − exp") { shares.iter().sum::<f64>() - left } else { left }
}

/// Height of the accepted patch at a point, mm: 1/e² of that at its middle where its description says.
pub(crate) fn patch_mm(json: &Value, point_mm: [f64; 3]) -> f64 {
    let patches = subjects(json, "patch").into_iter().map(|(subject, step)| {
        let place = subject.trim_start_matches('(').trim_end_matches(") mm");
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let center: Vec<f64> = place.split(',').map(number).collect();
        let text = step["description"].as_str().expect("words");
        let radius = text.split("1/e² of it ").nth(1).and_then(|t| t.split(" mm").next());
        let radius = number(radius.expect("a radius"));
        let steepness = text.split(" mm)^").nth(1).map_or(2.0, |t| number(t.trim_end_matches(')')));
        let square: f64 = (0..3).map(|k| (point_mm[k] - center[k]).powi(2)).sum();
        let exponent = (square.sqrt() / radius).powf(steepness);
        1e-3 * amplitude(step, "height") * (-2.0 * exponent).exp()
    });
    patches.sum()
}

/// Amplitude of that name in the unit printed; zero where it was not estimated.
pub(crate) fn amplitude(step: &Value, name: &str) -> f64 {
    let parameters = step["parameters"].as_array().expect("parameters");
    let found = parameters.iter().find(|p| p["name"] == name);
    found.map_or(0.0, |p| p["value"].as_f64().expect("a number"))
}

/// Numbers of a list.
pub(crate) fn numbers(list: &Value) -> Vec<f64> {
    let items = list.as_array().expect("a list");
    items.iter().map(|v| v.as_f64().expect("a number")).collect()
}
