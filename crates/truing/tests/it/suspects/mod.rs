//! Mistakes in the input: made in sound cases, and named before any physics.

mod axis;
mod beside;
mod deviations;
mod digits;
mod every_table;
mod heights;
mod log;
mod numbers;
mod points;
mod poses;
mod rows;
mod scattered;
mod touches;
mod tracer;
mod wrench;

use std::path::Path;

use serde_json::Value;

use crate::command::Case;

/// A committed case, to make mistakes in.
pub(crate) fn fixture(name: &str, files: &[&str]) -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name);
    let text = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    let texts: Vec<(&str, String)> = files.iter().map(|file| (*file, text(file))).collect();
    let texts: Vec<(&str, &str)> = texts.iter().map(|(file, text)| (*file, &**text)).collect();
    Case::new(&texts)
}

/// Settings of a survey whose noise is declared.
const SURVEY: &str =
    "kind = \"frame-fit\"\n[model]\ntransform = \"rigid\"\n[noise]\npoint_mm = 0.005\n";

fn survey() -> Case {
    fixture("frame-fit/nothing-white", &["case.toml", "pairs.csv"])
}

/// Rewrites the cells of some columns of a table, row by row.
pub(crate) fn change(
    case: &Case,
    file: &str,
    columns: &[&str],
    of: impl Fn(usize, &[Vec<String>]) -> Vec<String>,
) {
    let text = std::fs::read_to_string(case.file(file)).unwrap();
    let cells = |line: &str| -> Vec<String> { line.split(',').map(str::to_owned).collect() };
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(cells);
    let header = lines.next().unwrap();
    let mut rows: Vec<Vec<String>> = lines.collect();
    let at: Vec<usize> =
        columns.iter().map(|c| header.iter().position(|h| h == c).unwrap()).collect();
    let old: Vec<Vec<String>> =
        rows.iter().map(|row| at.iter().map(|&i| row[i].clone()).collect()).collect();
    for (n, row) in rows.iter_mut().enumerate() {
        for (&i, cell) in at.iter().zip(of(n, &old)) {
            row[i] = cell;
        }
    }
    let all = std::iter::once(&header).chain(&rows).map(|row| row.join(",") + "\n");
    case.write(file, all.collect::<String>());
}

fn scale(case: &Case, file: &str, columns: &[&str], factor: f64) {
    change(case, file, columns, |n, old| {
        old[n].iter().map(|cell| format!("{}", cell.parse::<f64>().unwrap() * factor)).collect()
    });
}

/// Exchanges the values of two columns, whose headings stay.
fn swap(case: &Case, file: &str, columns: [&str; 2]) {
    change(case, file, &columns, |n, old| vec![old[n][1].clone(), old[n][0].clone()]);
}

/// The first step of the loop, which must be about the input.
fn first(case: &Case) -> (Value, Value) {
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "input-wrong", "{}", answer["steps"]);
    (answer["steps"][0].clone(), answer)
}
