//! What must *not* matter: byte order marks, line ends, column order, comments, spaces.

use serde_json::Value;

use crate::command::Case;

const TOML: &str = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n";

/// Points, as they are written in the plainest way.
const POINTS: [(&str, [f64; 4]); 5] = [
    ("a", [0.0, 0.0, 10.003, 0.001]),
    ("b", [100.0, 0.0, 110.004, 0.99]),
    ("c", [100.0, 50.0, 109.51, 50.996]),
    ("d", [0.0, 50.0, 9.502, 50.003]),
    ("e", [40.0, 20.0, 49.79, 20.402]),
];

fn plain() -> String {
    let mut text = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
    for (name, [fx, fy, tx, ty]) in POINTS {
        text += &format!("{name},{fx},{fy},{tx},{ty}\n");
    }
    text
}

fn solved(toml: impl AsRef<[u8]>, pairs: impl AsRef<[u8]>) -> Value {
    let case = Case::new(&[]);
    case.write("case.toml", toml);
    case.write("pairs.csv", pairs);
    let mut answer = case.json("solve");
    // How long it took, and the bytes that were read, differ.
    for key in ["timing", "inputs"] {
        answer.as_object_mut().unwrap().remove(key).unwrap();
    }
    answer
}

#[test]
fn byte_order_marks_and_line_ends() {
    let expected = solved(TOML, plain());
    let bom = |text: &str| [b"\xef\xbb\xbf", text.as_bytes()].concat();
    assert_eq!(solved(bom(TOML), bom(&plain())), expected);
    let crlf = |text: &str| text.replace('\n', "\r\n");
    assert_eq!(solved(crlf(TOML), crlf(&plain())), expected);
    assert_eq!(solved(TOML, bom(&crlf(&plain()))), expected);
    assert_eq!(solved(TOML, plain().replace('\n', "\r")), expected);
    assert_eq!(solved(TOML, plain().trim_end()), expected);
}

#[test]
fn spaces_comments_quotes_and_blank_lines() {
    let expected = solved(TOML, plain());
    let text = plain().replace(',', " ,\t ").replace('\n', " \n# said aside\n\n   \n");
    assert_eq!(solved(TOML, format!("# head\n\n{text}")), expected);
    let quoted = plain().replace("b,100", "\"b\",\"100\"");
    assert_eq!(solved(TOML, quoted), expected);
}

#[test]
fn column_order() {
    let expected = solved(TOML, plain());
    let mut text = "to_y_mm,from_y_mm,point,to_x_mm,from_x_mm\n".to_owned();
    for (name, [fx, fy, tx, ty]) in POINTS {
        text += &format!("{ty},{fy},{name},{tx},{fx}\n");
    }
    assert_eq!(solved(TOML, text), expected);
}

#[test]
fn declared_uncertainties_in_any_form() {
    let expected = solved(TOML, plain());
    let no_noise = "kind = \"frame-fit\"\n";
    let with = |columns: &str, cells: &str| {
        let text = plain();
        let mut lines = text.lines();
        let header = format!("{},{columns}\n", lines.next().unwrap());
        lines.fold(header, |all, line| format!("{all}{line},{cells}\n"))
    };
    assert_eq!(solved(no_noise, with("sigma_mm", "0.01")), expected);
    let per_axis = solved(no_noise, with("sigma_x_mm,sigma_y_mm", "0.01,0.01"));
    let chi2 = |answer: &Value| answer["residual"]["chi2_per_dof"].as_f64().unwrap();
    // Another way to the same minimum: relative agreement of the fit's own tolerance.
    assert!((chi2(&per_axis) / chi2(&expected) - 1.0).abs() < 1e-9);
}

#[test]
fn unknown_noise_is_estimated_and_said_so() {
    let answer = solved("kind = \"frame-fit\"\n", plain());
    assert_eq!(answer["residual"]["chi2_per_dof"], Value::Null);
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("standard uncertainties are estimated from the residual"));
    assert!(answer["estimates"]["std"]["translation_mm"][0].as_f64().unwrap() > 0.0);
}

#[test]
fn covariates_with_gaps_are_dropped_and_said_so() {
    let case = Case::new(&[("case.toml", TOML)]);
    let mut text = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,air_c,oil_c,who,load\n".to_owned();
    for (i, (name, [fx, fy, tx, ty])) in POINTS.iter().enumerate() {
        let oil = if i == 2 { String::new() } else { format!("{}", 20 + i) };
        let load = if i == 3 { "n/a" } else { "7" };
        text += &format!("{name},{fx},{fy},{tx},{ty},{},{oil},me,{load}\n", 20 + i);
    }
    case.write("pairs.csv", text);
    let answer = case.json("check");
    let covariates = answer["covariates"].to_string();
    assert!(covariates.contains("air_c") && !covariates.contains("oil_c"), "{covariates}");
    let warnings = answer["warnings"].to_string();
    assert!(
        warnings.contains("line 4, column 7 (`oil_c`): the cell is empty, so the covariate"),
        "{warnings}"
    );
    assert!(warnings.contains("line 5, column 9 (`load`): not a number"), "{warnings}");
    assert!(!warnings.contains("`who`"), "{warnings}");
}

#[test]
fn tables_that_nobody_reads_are_named() {
    let case = Case::new(&[("case.toml", TOML)]);
    case.write("pairs.csv", plain());
    case.write("wrench.csv", "a\n");
    let warnings = case.json("solve")["warnings"].to_string();
    assert!(warnings.contains("`wrench.csv` is not read by a case of kind frame-fit"));
}

#[test]
fn where_data_come_from_changes_no_answer() {
    let case = Case::new(&[("case.toml", TOML)]);
    case.write("pairs.csv", plain());
    let before = case.json("solve")["estimates"].clone();
    case.write("provenance.toml", "title = \"T < & >\"\nsource = \"S\"\npublished = \"P\"\n");
    assert_eq!(case.json("solve")["estimates"], before);
    let page = case.file("page.html");
    let ended = crate::command::truing(&[
        "solve",
        case.path().to_str().unwrap(),
        "--report",
        page.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("T &lt; &amp; &gt;") && !page.contains("T < &"));
    case.write("provenance.toml", "title = 3\n");
    let answer = case.json("solve");
    assert_eq!(answer["estimates"], before);
    assert!(answer["warnings"].to_string().contains("provenance.toml is left aside"));
}
