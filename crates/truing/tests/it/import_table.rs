//! `truing import table`: tables of other programs as tables of cases.

use crate::command::{Case, Ended, truing};

/// As a tracker's program exports it in a country that writes decimals with a comma.
const SURVEY: &str = "Point ID;X from [mm];Y from [mm];X to (µm);Y to (µm);Air °C\n\
    P1;0;0;10003;1;20,1\nP2;100;0;110004;990;20,2\nP3;100;50;109510;50996;20,3\n\
    P4;0;50;9502;50003;20,4\n";

fn import(case: &Case, more: &[&str]) -> Ended {
    let file = case.file("their.csv");
    truing(&[&["import", "table", file.to_str().unwrap()], more].concat())
}

#[test]
fn a_foreign_table_becomes_a_case_that_solves() {
    let case = Case::new(&[("their.csv", SURVEY)]);
    let out = case.file("case");
    let out = out.to_str().unwrap();
    let ended = import(&case, &["--kind", "frame-fit", "--out", out]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stdout.starts_with("4 rows, wrote\n"), "{}", ended.stdout);
    assert_eq!(ended.stderr.lines().count(), 1, "one note: {}", ended.stderr);
    for said in [
        "note: their.csv: cells separated by semicolons, decimals with a comma",
        "`Point ID` taken for `point`",
        "`X from [mm]` taken for `from_x_mm`",
        "`Y to (µm)` taken for `to_y_mm`",
    ] {
        assert!(ended.stderr.contains(said), "{}", ended.stderr);
    }
    let table = std::fs::read_to_string(case.file("case/pairs.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("# their.csv, sha256 "), "{table}");
    assert_eq!(lines[1], "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,Air °C");
    assert_eq!(lines[2], "P1,0,0,10.003,0.001,20.1");
    assert_eq!(lines.len(), 6);
    let solved = truing(&["solve", out, "--json"]);
    assert_eq!(solved.code, 0, "{}", solved.stderr);
    let again = import(&case, &["--kind", "frame-fit", "--out", out]);
    assert_eq!(again.code, 2);
    assert!(again.one_message().contains("pairs.csv exists already"), "{}", again.stderr);
}

#[test]
fn tables_are_added_to_a_case_one_by_one() {
    let example = Case::example("tracker-lm");
    let case = Case::new(&[]);
    let out = case.file("case");
    for table in ["ranges.csv", "stations.csv", "mounts.csv"] {
        let file = example.file(table);
        let words = ["import", "table", file.to_str().unwrap(), "--kind", "tracker-lm"];
        let ended =
            truing(&[&words[..], &["--table", table, "--out", out.to_str().unwrap()]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert_eq!(ended.stderr, "", "nothing had to be guessed");
    }
    // The settings are an example's and not in force: the axis is what is asked for.
    let ended = truing(&["solve", out.to_str().unwrap()]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("`axis` is missing"), "{}", ended.stderr);
    std::fs::copy(example.file("case.toml"), out.join("case.toml")).unwrap();
    let solved = truing(&["solve", out.to_str().unwrap(), "--json"]);
    let solved: serde_json::Value = serde_json::from_str(&solved.stdout).unwrap();
    assert_eq!(solved["estimates"], example.json("solve")["estimates"]);
}

/// The tables of every example are imported by their own names.
#[test]
fn every_table_of_the_examples_is_a_target() {
    for kind in
        ["frame-fit", "ft-center", "tracker-lm", "pose-icp", "probe-comp", "force-impedance"]
    {
        let example = Case::example(kind);
        for file in std::fs::read_dir(example.path()).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_none_or(|e| e != "csv") {
                continue;
            }
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let file = path.to_str().unwrap();
            let ended = truing(&["import", "table", file, "--kind", kind, "--table", &name]);
            assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{kind} {name}");
            let given = std::fs::read_to_string(&path).unwrap();
            let rows = |text: &str| text.lines().filter(|l| !l.starts_with('#')).count();
            assert_eq!(rows(&ended.stdout), rows(&given), "{kind} {name}");
        }
    }
}

#[test]
fn what_is_not_clear_is_refused_with_what_could_be_meant() {
    let said = |table: &str, more: &[&str]| {
        let case = Case::new(&[("their.csv", table)]);
        let ended = import(&case, more);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
        let message = ended.one_message();
        message.rsplit_once("their.csv: ").map_or(message.clone(), |(_, rest)| rest.to_owned())
    };
    let frame = ["--kind", "frame-fit"];
    assert_eq!(
        said(&SURVEY.replace("Point ID", "Marke"), &frame),
        "none of its columns is `point` by its name; say which by --map \"THEIRS=point\"; it has \
         `Marke`, `Air °C`"
    );
    // All that are missing are named at once.
    assert_eq!(
        said("Punkt;X soll;Y soll;X ist;Y ist\nP1;1,5;2;3;4\n", &frame),
        "none of its columns is `point`, `from_x_mm`, `from_y_mm`, `to_x_mm`, `to_y_mm` by its name; \
         say which by --map \"THEIRS=point\", one for each, where their heading says no unit also \
         that: --map \"THEIRS=from_x_mm[UNIT]\"; it has `Punkt`, `X soll`, `Y soll`, `X ist`, `Y ist`"
    );
    let twice = SURVEY.replace("Point ID", "Name").replace("Air °C", "Point ID");
    assert_eq!(
        said(&twice, &frame),
        "`point` may be any of `Name`, `Point ID`; say which by --map \"Name=point\""
    );
    let unit = SURVEY.replace("Point ID", "Point").replace("X from [mm]", "X from");
    assert_eq!(
        said(&unit, &frame),
        "column `X from` says no unit; say it by --map \"X from=from_x_mm[UNIT]\", such as [mm]"
    );
    let map = |map: &str| said(&unit, &[&frame[..], &["--map", map]].concat());
    assert_eq!(
        map("X from=from_x_mm[N]"),
        "column `X from` is in `N`, which is no unit of `from_x_mm`"
    );
    assert!(
        map("X form=from_x_mm").starts_with("there is no column `X form` in it; did you mean `X")
    );
    assert!(
        map("X from=form_x_mm").starts_with("pairs.csv has no column `form_x_mm`; did you mean")
    );
    let case = Case::new(&[("their.csv", SURVEY)]);
    let no_map = import(&case, &["--kind", "frame-fit", "--map", "X from"]);
    assert_eq!(no_map.code, 2);
    assert!(no_map.stderr.contains("expected \"their column=our column[unit]\""));
    let which = said(SURVEY, &["--kind", "ft-center"]);
    assert_eq!(
        which,
        "a case of kind ft-center has the tables `presses.csv`, `wrench.csv`, `displacements.csv`, \
         `gravity.csv`; say which by --table"
    );
    assert!(said(SURVEY, &["--kind", "frame-fti"]).contains("did you mean `frame-fit`?"));
    let word = unit.replace("P1;0;0;10003", "P1;0;0;x");
    let message = said(&word, &[&frame[..], &["--map", "X from=from_x_mm[mm]"]].concat());
    assert!(message.contains("line 2, column 4 (`X to (µm)`): expected a number"), "{message}");
}
