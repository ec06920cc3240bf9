//! Every class of unusable input, with the text of its message: file, line, column, way out.

use std::fs;

use crate::command::{Case, truing};

const TOML: &str = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n";
const PAIRS: &str = "\
point,from_x_mm,from_y_mm,to_x_mm,to_y_mm
a,0,0,10,0
b,100,0,110,0.01
c,100,50,110.01,50
d,0,50,10,50.01
";

fn planar() -> Case {
    Case::new(&[("case.toml", TOML), ("pairs.csv", PAIRS)])
}

/// The message when `from` of `pairs.csv` is replaced by `to`.
fn pairs(from: &str, to: &str) -> String {
    let case = planar();
    case.replace("pairs.csv", from, to);
    without_folder(&case, &case.message("solve", 2))
}

/// The message for a whole `case.toml`.
fn toml(text: &str) -> String {
    let case = planar();
    case.write("case.toml", text);
    without_folder(&case, &case.message("solve", 2))
}

fn without_folder(case: &Case, message: &str) -> String {
    message.replace(&format!("{}/", case.path().display()), "")
}

#[test]
fn the_case_they_all_start_from_solves() {
    assert_eq!(planar().run("solve").code, 0);
}

#[test]
fn cells_that_are_no_numbers() {
    assert_eq!(
        pairs("100,0,110,0.01", "100,x1,110,0.01"),
        "pairs.csv, line 3, column 3 (`from_y_mm`): expected a number in mm, found `x1`"
    );
    assert_eq!(
        pairs("100,0,110,0.01", "100,,110,0.01"),
        "pairs.csv, line 3, column 3 (`from_y_mm`): expected a number in mm, found an empty cell"
    );
    assert_eq!(
        pairs("100,0,110,0.01", "100,\"0,5\",110,0.01"),
        "pairs.csv, line 3, column 3 (`from_y_mm`): expected a number in mm, found `0,5`; write \
         decimals with a point"
    );
    for number in ["nan", "NaN", "inf", "-infinity", "1e300", "1e999"] {
        assert_eq!(
            pairs("100,0,110,0.01", &format!("100,{number},110,0.01")),
            format!(
                "pairs.csv, line 3, column 3 (`from_y_mm`): expected a number in mm of magnitude \
                 below 1e12, found `{number}`"
            )
        );
    }
}

#[test]
fn lines_are_counted_as_an_editor_does() {
    let text = format!("# by hand\n\n{PAIRS}").replace("c,100", "# note\r\nc, ? ");
    let case = planar();
    case.write("pairs.csv", text);
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 7, column 2 (`from_x_mm`): expected a number in mm, found `?`"
    );
}

#[test]
fn rows_of_another_length() {
    assert_eq!(
        pairs("b,100,0,110,0.01", "b,100,0,110"),
        "pairs.csv, line 3, column 5: expected 5 cells as in the header, found 4"
    );
    assert_eq!(
        pairs("b,100,0,110,0.01", "b,100,0,110,0,01"),
        "pairs.csv, line 3, column 6: expected 5 cells as in the header, found 6; where decimals \
         have a comma, separate the cells by semicolons"
    );
    assert_eq!(
        pairs("b,100,0", "\"b,100,0"),
        "pairs.csv, line 3, column 1: the cell spans several lines; close the quote opened in it"
    );
}

#[test]
fn headers() {
    assert_eq!(
        pairs("to_y_mm", "to_x_mm"),
        "pairs.csv, line 1, column 5: duplicate column `to_x_mm`; it is column 4 already"
    );
    assert_eq!(
        pairs("to_y_mm", " "),
        "pairs.csv, line 1, column 5: the header's cell is empty; name the column or remove it"
    );
    assert_eq!(
        pairs("to_y_mm", "to_why"),
        "pairs.csv, line 1: column `to_y_mm` is missing (a number in mm)"
    );
    assert_eq!(
        pairs("from_x_mm", "form_x_mm"),
        "pairs.csv, line 1, column 2: column `from_x_mm` is missing (a number in mm); there is \
         `form_x_mm`: is that a slip?"
    );
    assert_eq!(
        pairs("to_y_mm", "to_y_mm,to_z_mm").split(": ").next(),
        Some("pairs.csv, line 2, column 6"),
        "ragged before anything else"
    );
    let case = planar();
    case.write("pairs.csv", PAIRS.replacen(',', ";", 1));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv: the header has both a comma and a semicolon between its cells; write `sep=;` \
         (or the separator that it is) as the first line, or put names with a comma between quotes"
    );
    case.write("pairs.csv", PAIRS.split_once('\n').unwrap().1.replace(['a', 'b', 'c', 'd'], "1"));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1: the first row holds numbers; expected the names of the columns"
    );
}

#[test]
fn units_other_than_those_expected() {
    assert_eq!(
        pairs("from_x_mm", "from_x_cm"),
        "pairs.csv, line 1, column 2: column `from_x_cm` is not in the unit expected: give it in \
         mm and name it `from_x_mm`"
    );
    assert_eq!(
        pairs("from_x_mm", "from_x"),
        "pairs.csv, line 1, column 2: column `from_x` is not in the unit expected: give it in mm \
         and name it `from_x_mm`"
    );
    let case = planar();
    case.write("pairs.csv", add_column(PAIRS, "sigma_cm", "10"));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1, column 6: column `sigma_cm` is not in the unit expected: give it in \
         mm and name it `sigma_mm`"
    );
    assert_eq!(
        toml("kind = \"frame-fit\"\n[noise]\npoint_um = 10.0\n"),
        "case.toml, line 3, column 1: unknown key `point_um`; give the value in mm and name the \
         key `point_mm`"
    );
}

#[test]
fn optional_columns_misspelt() {
    let case = planar();
    case.write("pairs.csv", add_column(PAIRS, "Use", "fit"));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1, column 6: column `Use` is not known; name it `use`"
    );
    case.write("pairs.csv", add_column(PAIRS, "uses", "fit"));
    let ended = case.run("solve");
    assert_eq!(ended.code, 0);
    assert!(ended.stderr.contains("did you mean `use`?"), "{}", ended.stderr);
}

fn add_column(table: &str, name: &str, value: &str) -> String {
    let mut lines = table.lines();
    let header = format!("{},{name}\n", lines.next().unwrap());
    lines.fold(header, |all, line| all + line + "," + value + "\n")
}

#[test]
fn standard_uncertainties_that_cannot_be() {
    for (value, found) in [("0", "`0`"), ("-0.01", "`-0.01`"), ("1e-30", "`1e-30`")] {
        let case = planar();
        case.write("pairs.csv", add_column(PAIRS, "sigma_mm", value));
        assert_eq!(
            without_folder(&case, &case.message("solve", 2)),
            format!(
                "pairs.csv, line 2, column 6 (`sigma_mm`): expected a positive number in mm above \
                 1e-12, found {found}"
            )
        );
    }
    let case = planar();
    let one = add_column(PAIRS, "sigma_x_mm", "0.1");
    case.write("pairs.csv", add_column(&one, "sigma_mm", "0.1"));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1, column 7: columns `sigma_mm` and `sigma_x_mm` exclude each other; \
         remove one"
    );
    case.write("pairs.csv", one);
    assert!(case.message("solve", 2).ends_with("column `sigma_y_mm` is missing (a number in mm)"));
    assert_eq!(
        toml("kind = \"frame-fit\"\n[noise]\npoint_mm = -1.0\n"),
        "case.toml, line 3, column 12: `point_mm` (in mm): expected a number between 1e-12 and \
         1e12, found -1e0"
    );
    assert_eq!(
        toml("kind = \"frame-fit\"\n[noise]\npoint_mm = \"0.01\"\n"),
        "case.toml, line 3, column 12: `point_mm` (in mm): found string \"0.01\", expected a \
         positive number"
    );
}

#[test]
fn ids_and_words() {
    assert_eq!(
        pairs("d,0,50", ",0,50"),
        "pairs.csv, line 5, column 1 (`point`): expected the name of a point, found an empty cell"
    );
    let case = planar();
    case.write("pairs.csv", add_column(PAIRS, "use", "chek"));
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 2, column 6 (`use`): expected one of `fit`, `check`, found `chek`; did \
         you mean `check`?"
    );
}

#[test]
fn case_files() {
    assert_eq!(
        toml("kind = \"frame-fit\"\n[model]\ntranform = \"rigid\"\n"),
        "case.toml, line 3, column 1: unknown key `tranform`; did you mean `transform`?"
    );
    assert_eq!(
        toml("kind = \"frame-fit\"\npoint_mm = 0.01\n"),
        "case.toml, line 2, column 1: unknown key `point_mm`; expected one of `kind`, `model`, \
         `noise`, `plan`, `conformity`, `loop`"
    );
    assert_eq!(
        toml("kind = \"frame-fit\"\n[model]\ntransform = \"ridgid\"\n"),
        "case.toml, line 3, column 13: expected one of `none`, `translation`, `rigid`, \
         `similarity`, `affine`, found `ridgid`; did you mean `rigid`?"
    );
    assert_eq!(
        toml("[model]\ntransform = \"rigid\"\n").split(": ").last(),
        Some("the kind of the case, e.g. `kind = \"frame-fit\"`")
    );
    assert_eq!(
        toml("kind = \"frame-fti\"\n"),
        "case.toml, line 1, column 8: unknown kind `frame-fti`; did you mean `frame-fit`?; the \
         kinds are `frame-fit`, `ft-center`, `tracker-lm`, `pose-icp`, `probe-comp`, \
         `force-impedance`, `positioning`"
    );
    assert_eq!(
        toml("kind = \"stylus\"\n"),
        "case.toml, line 1, column 8: unknown kind `stylus`; the kinds are `frame-fit`, \
         `ft-center`, `tracker-lm`, `pose-icp`, `probe-comp`, `force-impedance`, `positioning`"
    );
    assert!(toml("kind = \"frame-fit\n").starts_with("case.toml, line 1, column "));
    assert!(toml("kind = \"frame-fit\"\n[noise\n").contains("line 2"));
    assert!(toml("kind = \"frame-fit\"\nkind = \"frame-fit\"\n").contains("duplicate key"));
    assert!(toml("kind = 3\n").contains("line 1, column 8: `kind`: found integer `3`"));
    assert_eq!(
        toml("kind = \"frame-fit\"\n[loop]\nalpha = 0.9\n"),
        "case.toml, line 3, column 9: `alpha`: expected a number between 0 and 0.5, found 0.9"
    );
}

#[test]
fn files_that_are_missing_or_no_files() {
    let case = planar();
    fs::rename(case.file("pairs.csv"), case.file("pair.csv")).unwrap();
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv: the file is missing; there is `pair.csv`: is that a slip?"
    );
    for (workbook, said) in [
        (
            "pairs.xlsx",
            "pairs.csv: the file is missing; there is the workbook `pairs.xlsx`: save its sheet \
             as CSV, by the name `pairs.csv`",
        ),
        (
            "Messung 3.ods",
            "pairs.csv: the file is missing; there is the workbook `Messung 3.ods`: save its \
             sheet as CSV, by the name `pairs.csv`",
        ),
    ] {
        let case = planar();
        fs::rename(case.file("pairs.csv"), case.file(workbook)).unwrap();
        assert_eq!(without_folder(&case, &case.message("solve", 2)), said);
        // Beside its tables it is only named.
        case.write("pairs.csv", PAIRS);
        let solved = case.json("solve");
        let warnings = solved["warnings"].as_array().unwrap();
        let named =
            |w: &serde_json::Value| w.as_str().unwrap().contains("is a workbook and is not read");
        assert!(warnings.iter().any(named), "{warnings:?}");
    }
    fs::create_dir(case.file("pairs.csv")).unwrap();
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv: expected an ordinary file, found a folder"
    );
    fs::remove_file(case.file("case.toml")).unwrap();
    assert_eq!(without_folder(&case, &case.message("solve", 2)), "case.toml: the file is missing");
    let file = truing(&["solve", case.file("pair.csv").to_str().unwrap()]);
    assert_eq!(file.code, 2);
    assert!(file.one_message().ends_with(
        "pair.csv: a case is a folder, and this is a file; give the folder that holds `case.toml`"
    ));
    let nowhere = truing(&["loop", "/no/such/folder"]);
    assert_eq!(nowhere.code, 2);
    assert!(nowhere.one_message().starts_with("/no/such/folder: there is no such folder"));
}

#[test]
fn tables_without_rows() {
    let case = planar();
    case.write("pairs.csv", "");
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1: the table is empty; expected a header row with the columns `point`, \
         `from_x_mm`, `from_y_mm`, `to_x_mm`, `to_y_mm`"
    );
    case.write("pairs.csv", "# nothing yet\n\n");
    assert!(case.message("solve", 2).contains("the table is empty"));
    case.write("pairs.csv", PAIRS.lines().next().unwrap());
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1: the table has a header but no rows"
    );
}

/// First bytes as the programs write them: a zip's local header, an OLE header.
const XLSX: &[u8] = b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!\0[Content_Types].xml";
const XLS: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";

#[test]
fn a_workbook_is_no_table() {
    let case = planar();
    case.write("pairs.csv", XLSX);
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 1, column 1: this is a spreadsheet workbook (.xlsx, .ods, .numbers) or \
         another zip archive, not a text table; save the sheet as CSV"
    );
    case.write("pairs.csv", XLS);
    let message = case.message("loop", 2);
    assert!(message.contains("a spreadsheet workbook (.xls)"), "{message}");
    for (name, bytes) in [("their.xlsx", XLSX), ("their.xls", XLS)] {
        case.write(name, bytes);
        let file = case.file(name);
        let file = file.to_str().unwrap();
        for arguments in
            [&["import", "table", file, "--kind", "frame-fit"][..], &["import", "probe-log", file]]
        {
            let refused = truing(&[arguments, &["--out", "never"]].concat());
            assert_eq!(refused.code, 2, "{}", refused.stderr);
            for said in [name, "this is a spreadsheet workbook", "save"] {
                assert!(refused.stderr.contains(said), "{}", refused.stderr);
            }
        }
    }
}

/// What Excel calls «Unicode text»: UTF-16, cells separated by tabs.
#[test]
fn unicode_text_of_a_spreadsheet_is_read() {
    let case = planar();
    let plain = case.json("solve");
    let tabs = PAIRS.replace(',', "\t");
    let units = "\u{feff}".encode_utf16().chain(tabs.encode_utf16());
    case.write("pairs.csv", units.flat_map(u16::to_le_bytes).collect::<Vec<u8>>());
    assert_eq!(plain["estimates"], case.json("solve")["estimates"]);
}

#[test]
fn text_that_is_not_utf8() {
    let case = planar();
    let mut bytes = PAIRS.as_bytes().to_vec();
    let at = PAIRS.find("b,100").unwrap() + 2;
    bytes[at] = 0xff;
    case.write("pairs.csv", bytes);
    assert_eq!(
        without_folder(&case, &case.message("solve", 2)),
        "pairs.csv, line 3, column 3: expected UTF-8 text, found byte 0xff; save the file as UTF-8"
    );
    case.write("case.toml", b"kind = \"frame-fit\" # \xe9\n");
    assert!(case.message("solve", 2).contains("case.toml, line 1, column 22"));
}

#[test]
fn groups_that_do_not_exist() {
    assert_eq!(
        toml("kind = \"frame-fit\"\n[loop]\ngroup = \"pont\"\n"),
        "case.toml, line 3, column 9: no column `pont`; did you mean `point`?; the \
         columns are `point`, `from_x_mm`, `from_y_mm`, `to_x_mm`, `to_y_mm`"
    );
}

#[test]
fn points_that_do_not_determine_the_transform() {
    let case = planar();
    case.write("pairs.csv", "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\na,0,0,10,0\n");
    let message = case.message("solve", 3);
    assert!(
        message.ends_with(
            "a rigid transform needs at least 2 points, got 1; the rotation about the one point \
             is free"
        ),
        "{message}"
    );
    case.write("case.toml", "kind = \"frame-fit\"\n");
    let line = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n\
                a,0,0,0,10,0,0\nb,50,0,0,60,0,0\nc,70,0,0,80,0,0\nd,99,0,0,109,0,0\n";
    case.write("pairs.csv", line);
    for command in ["solve", "loop", "check"] {
        let message = case.message(command, 3);
        assert!(message.contains("rotation about the line (1.000, 0.000, 0.000)"), "{message}");
    }
    case.write("pairs.csv", line.lines().take(3).collect::<Vec<_>>().join("\n"));
    let message = case.message("solve", 3);
    assert!(message.contains("the rotation about the line through the points is free"));
}

#[test]
fn messages_quote_no_more_of_a_file_than_a_line_can_hold() {
    let huge = "\u{1b}[31m".to_owned() + &"y".repeat(1_000_000);
    let message = pairs("100,0,110,0.01", &format!("100,{huge},110,0.01"));
    assert!(message.len() < 300, "{} bytes", message.len());
    assert!(message.contains("found `\\u{1b}[31myyy"), "{message}");
}

#[test]
fn usage() {
    let no_command = truing(&[]);
    assert_eq!(no_command.code, 2);
    assert_eq!(no_command.stdout, "");
    assert_eq!(truing(&["solve"]).code, 2);
    assert_eq!(truing(&["solve", "x", "--thread", "2"]).code, 2);
    assert_eq!(truing(&["solve", "x", "--threads", "0"]).code, 2);
    assert_eq!(truing(&["--help"]).code, 0);
    let case = planar();
    let ended = truing(&[
        "solve",
        case.path().to_str().unwrap(),
        "--report",
        case.file("no/such/place.html").to_str().unwrap(),
    ]);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""));
    assert!(ended.one_message().ends_with("place.html cannot be written: entity not found"));
}
