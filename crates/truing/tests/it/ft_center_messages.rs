//! What can be wrong with presses, samples, displacements and poses.

use std::fs;

use crate::command::Case;

fn message(case: &Case, code: i32) -> String {
    let message = case.message("solve", code);
    message.replace(&format!("{}/", case.path().display()), "")
}

/// The example with text of one of its files replaced.
fn edited(file: &str, from: &str, to: &str) -> Case {
    let case = Case::example("ft-center");
    case.replace(file, from, to);
    case
}

fn line_of(case: &Case, file: &str, text: &str) -> usize {
    let content = fs::read_to_string(case.file(file)).unwrap();
    1 + content[..content.find(text).unwrap()].matches('\n').count()
}

#[test]
fn references_between_the_tables() {
    let case = edited("wrench.csv", "\n1,0.00,", "\n12,0.00,");
    let line = line_of(&case, "wrench.csv", "12,0.00,");
    assert_eq!(
        message(&case, 2),
        format!(
            "wrench.csv, line {line}, column 1 (`press`): press `12` is not in presses.csv; \
                 did you mean `1`?"
        )
    );
    let case = Case::example("ft-center");
    let text = fs::read_to_string(case.file("presses.csv")).unwrap();
    case.write("presses.csv", text + "12,150.0,110.0,check,20.0\n");
    let line = line_of(&case, "presses.csv", "12,150.0");
    assert_eq!(
        message(&case, 2),
        format!(
            "presses.csv, line {line}: press `12` has no rows in wrench.csv; measure it or \
                 remove it"
        )
    );
    let case = edited("presses.csv", "\n2,", "\n1,");
    assert!(message(&case, 2).contains("(`press`): duplicate press `1`, first used in line"));
}

#[test]
fn columns_and_words() {
    let case = edited("wrench.csv", "fz_n", "fz_kn");
    assert!(
        message(&case, 2).ends_with(
            "column 5: column `fz_kn` is not in the unit expected: give it in N and name it `fz_n`"
        ),
        "{}",
        message(&case, 2)
    );
    let case = edited("wrench.csv", "mx_nmm", "mx_ncm");
    assert!(message(&case, 2).ends_with("give it in N·mm and name it `mx_nmm`"));
    let case = edited("presses.csv", ",frame,", ",frames,");
    assert!(
        message(&case, 2).ends_with(
            "(`use`): expected one of `frame`, `check`, `locate`, found `frames`; did you mean \
             `frame`?"
        ),
        "{}",
        message(&case, 2)
    );
    let case = edited("presses.csv", ",frame,", ",,");
    assert!(message(&case, 2).contains("(`use`): expected frame or check or locate, found an"));
}

#[test]
fn settings() {
    let case = edited("case.toml", "z0_mm = 42.0\n", "");
    assert_eq!(
        message(&case, 2),
        "case.toml: `[contact] z0_mm` is missing: it is the height of the contact plane above the \
         sensor's reference point, which no wrench can tell"
    );
    let case = edited("case.toml", "z0_mm = 42.0", "z0_um = 42000.0");
    assert!(
        message(&case, 2)
            .ends_with("unknown key `z0_um`; give the value in mm and name the key `z0_mm`"),
        "{}",
        message(&case, 2)
    );
    let case = edited("case.toml", "moment_nmm = 2.0\n", "");
    assert!(message(&case, 2).contains("`[noise] moment_nmm` is missing"));
}

#[test]
fn tables() {
    let case = Case::example("ft-center");
    fs::remove_file(case.file("wrench.csv")).unwrap();
    assert_eq!(message(&case, 2), "wrench.csv: the file is missing");
    fs::remove_file(case.file("presses.csv")).unwrap();
    assert!(message(&case, 2).contains(
        "no table found; this kind needs `presses.csv` with `wrench.csv`, or `displacements.csv`, \
         or `gravity.csv`"
    ));
    let case = Case::example("ft-center");
    case.write("gravity.csv", "");
    assert_eq!(
        message(&case, 2),
        "gravity.csv: this file and `presses.csv` exclude each other; move one to a case of its \
         own"
    );
}

#[test]
fn records_that_cannot_be_used() {
    let case = edited("wrench.csv", "\n1,0.02,", "\n1,-0.02,");
    let line = line_of(&case, "wrench.csv", "1,-0.02,");
    let text = message(&case, 2);
    assert!(text.starts_with(&format!("wrench.csv, line {line}: press 1: ")), "{text}");
    assert!(text.contains("time does not increase"), "{text}");
    let case = edited("case.toml", "# min_fz_n = 5.0", "min_fz_n = 500.0");
    let text = message(&case, 2);
    assert!(text.contains("press 1: 0 of 48 samples are in contact"), "{text}");
}

#[test]
fn frames_that_are_not_determined() {
    let case = Case::example("ft-center");
    let text = fs::read_to_string(case.file("presses.csv")).unwrap();
    case.write("presses.csv", text.replace(",frame,", ",check,"));
    let text = message(&case, 3);
    assert!(text.contains("0 presses at known positions (use = frame), need"), "{text}");
    assert!(text.ends_with("; the whole frame is free"), "{text}");
}

#[test]
fn poses_that_are_not_rotations_or_too_alike() {
    let header = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n";
    let rows = |quaternion: &str| {
        (0..5).fold(header.to_owned(), |all, i| {
            all + &format!("p{i},{quaternion},0,0,-20.{i},0,0,0\n")
        })
    };
    let case = Case::new(&[("case.toml", "kind = \"ft-center\"\n")]);
    case.write("gravity.csv", rows("1,0,0,0.5"));
    assert!(message(&case, 2).starts_with(
        "gravity.csv, line 2: expected a unit quaternion (qw, qx, qy, qz), found one of length 1.1"
    ));
    case.write("gravity.csv", rows("1,0,0,0"));
    let text = message(&case, 3);
    assert!(text.contains("gravity.csv: the poses do not determine"), "{text}");
    case.write("case.toml", "kind = \"ft-center\"\n[model]\ngravity = [0, 0, 0]\n");
    assert!(message(&case, 2).contains("must not be the zero vector"));
}

#[test]
fn a_column_of_the_samples_can_group_presses_but_not_split_one() {
    let case = edited("case.toml", "# group = \"session\"", "group = \"session\"");
    let text = fs::read_to_string(case.file("wrench.csv")).unwrap();
    let with = |split: bool| {
        let mut header = true;
        text.lines()
            .map(|line| {
                if line.starts_with('#') {
                    return line.to_owned() + "\n";
                }
                if std::mem::take(&mut header) {
                    return line.to_owned() + ",session\n";
                }
                let press: usize = line.split(',').next().unwrap().parse().unwrap();
                let session = if split && line.starts_with("2,0.1") { 9 } else { press / 2 };
                format!("{line},s{session}\n")
            })
            .collect::<String>()
    };
    case.write("wrench.csv", with(false));
    let answer = case.json("check");
    // Presses 1 | 2, 3 | 4, 5 | 6, 7 | 8 place the sensor; 9 | 10 are judged, 11 is located.
    assert_eq!(answer["counts"]["fit_groups"], 5);
    assert_eq!(answer["counts"]["check_groups"], 2);
    case.write("wrench.csv", with(true));
    let text = message(&case, 2);
    assert!(
        text.ends_with(
            "(`session`): press `2` has both `s1` and `s9` in column `session`; one press belongs \
             to one group"
        ),
        "{text}"
    );
}

#[test]
fn the_published_table() {
    // [A], table 4: commanded and solved displacements, mm; its rms is printed as 0.280.
    let case = Case::new(&[
        ("case.toml", "kind = \"ft-center\"\n"),
        (
            "displacements.csv",
            "point,commanded_mm,solved_mm\n1,1,0.819\n2,2,1.961\n3,5,5.168\n4,10,10.500\n",
        ),
    ]);
    let answer = case.json("solve");
    let rms = answer["residual"]["rms"].as_f64().unwrap();
    assert!((rms - 0.280).abs() < 0.0005, "{rms}");
    assert_eq!(answer["residual"]["n"], 4);
    assert_eq!(answer["estimates"]["centers"], serde_json::json!([]));
    let residual = answer["estimates"]["points"][3]["residual_mm"].as_f64().unwrap();
    assert!((residual - 0.5).abs() < 1e-12);
}

#[test]
fn the_example_recovers_what_it_was_made_from() {
    let answer = Case::example("ft-center").json("loop");
    let centers = answer["estimates"]["centers"].as_array().unwrap();
    let located = centers.iter().find(|c| c["use"] == "locate").unwrap();
    // The head of the example is off by (0.42, −0.27) mm; four standard uncertainties.
    for (axis, truth) in [("x", 0.42), ("y", -0.27)] {
        let offset = located[format!("offset_{axis}_mm")].as_f64().unwrap();
        let std = located[format!("std_{axis}_mm")].as_f64().unwrap();
        assert!(std < 0.05 && (offset - truth).abs() < 4.0 * std, "{axis}: {offset} ± {std}");
    }
    let angle = answer["estimates"]["frame"]["angle_deg"].as_f64().unwrap();
    let std = answer["estimates"]["frame"]["std_angle_deg"].as_f64().unwrap();
    assert!((angle - 12.0).abs() < 4.0 * std && std < 0.2, "{angle} ± {std}");
}
