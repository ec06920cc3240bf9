//! `truing import probe-log`: logs of LinuxCNC as cases.

use crate::command::{Case, truing};

/// Three triggers as LinuxCNC 2.9 writes them, and a blank line.
const LOG: &str = "10.000000 20.000000 3.000500 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n\
                   -10.000000 20.000000 2.999000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n\n\
                   0.000000 -20.000000 3.001000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n";

#[test]
fn a_log_becomes_a_case_that_solves() {
    let case = Case::new(&[("probe.log", LOG)]);
    let (log, out) = (case.file("probe.log"), case.file("imported"));
    let (log, out) = (log.to_str().unwrap(), out.to_str().unwrap());
    let made = truing(&["import", "probe-log", log, "--feed", "120", "--out", out]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert!(made.stdout.starts_with("3 touches, wrote"), "{}", made.stdout);
    let solved = truing(&["solve", out, "--json"]);
    assert_eq!(solved.code, 0, "{}", solved.stderr);
    let solved: serde_json::Value = serde_json::from_str(&solved.stdout).unwrap();
    let touch = &solved["estimates"]["touches"][1];
    assert_eq!(touch["touch"], "T2");
    assert!((touch["deviation_mm"].as_f64().unwrap() + 1e-3).abs() < 1e-12, "{touch}");
    let again = truing(&["import", "probe-log", log, "--out", out]);
    assert_eq!(again.code, 2);
    assert!(again.one_message().contains("exists already"), "{}", again.stderr);
}

#[test]
fn without_a_folder_the_table_is_printed() {
    let case = Case::new(&[("probe.log", LOG)]);
    let log = case.file("probe.log");
    let printed = truing(&["import", "probe-log", log.to_str().unwrap(), "--inch"]);
    assert_eq!(printed.code, 0, "{}", printed.stderr);
    let mut lines = printed.stdout.lines();
    assert_eq!(lines.next(), Some("touch,x_mm,y_mm,z_mm"));
    assert_eq!(lines.next(), Some("T1,254,508,76.2127"));
    assert_eq!(lines.count(), 2);
}

/// Rows that were measured stay; what the plan left open takes the log, in order.
#[test]
fn a_log_fills_the_rows_of_its_plan() {
    let planned = "point,x_mm,y_mm,z_mm,use\nP1,1,2,3,check\nN1,,,,fit\nN2,,,,fit\nN3,,,,fit\n";
    let case = Case::new(&[("probe.log", LOG), ("points.csv", planned)]);
    let (log, plan) = (case.file("probe.log"), case.path());
    let fill = || {
        truing(&["import", "probe-log", log.to_str().unwrap(), "--plan", plan.to_str().unwrap()])
    };
    let filled = fill();
    assert_eq!(filled.code, 0, "{}", filled.stderr);
    let table = std::fs::read_to_string(case.file("points.csv")).unwrap();
    let expected = "point,x_mm,y_mm,z_mm,use\nP1,1,2,3,check\nN1,10,20,3.0005,fit\n\
                    N2,-10,20,2.999,fit\nN3,0,-20,3.001,fit\n";
    assert_eq!(table, expected);
    let again = fill();
    assert_eq!(again.code, 2);
    assert!(again.one_message().contains("0 rows wait for a touch"), "{}", again.stderr);
}

#[test]
fn a_log_says_where_a_part_lies() {
    let case = Case::new(&[("probe.log", LOG)]);
    let (log, out) = (case.file("probe.log"), case.file("lies"));
    let out = out.to_str().unwrap();
    let made =
        truing(&["import", "probe-log", log.to_str().unwrap(), "--kind", "pose-icp", "--out", out]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let points = std::fs::read_to_string(case.file("lies/points.csv")).unwrap();
    assert!(points.starts_with("point,x_mm,y_mm,z_mm\nP1,10,20,3.0005\n"), "{points}");
}

#[test]
fn logs_that_are_none() {
    let said = |text: &str| {
        let case = Case::new(&[("probe.log", text)]);
        let log = case.file("probe.log");
        let ended = truing(&["import", "probe-log", log.to_str().unwrap()]);
        assert_eq!(ended.code, 2, "{text}");
        ended.one_message()
    };
    let short = said("1 2 3 0 0 0 0 0 0\n1 2 3\n");
    assert!(short.contains("probe.log, line 2: expected the 9 numbers"), "{short}");
    assert!(short.ends_with("found 3"), "{short}");
    assert!(said("1 2 NaN 0 0 0 0 0 0\n").contains("line 1: expected a number below"));
    assert!(said("x y z a b c u v w\n").contains("found `x`"));
    assert!(said("\n\n").contains("the log holds no touches"));
    let absent = truing(&["import", "probe-log", "/nowhere/probe.log"]);
    assert_eq!(absent.code, 2);
    assert!(absent.stderr.contains("cannot be read"), "{}", absent.stderr);
    let case = Case::new(&[("probe.log", LOG)]);
    let log = case.file("probe.log");
    let negative = truing(&["import", "probe-log", log.to_str().unwrap(), "--feed", "0"]);
    assert_eq!(negative.code, 2);
}
