//! Tables as spreadsheets and other programs write them: understood, said so, or refused.

use serde_json::Value;

use crate::command::Case;

const TOML: &str = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n";
const HEADER: [&str; 5] = ["point", "from_x_mm", "from_y_mm", "to_x_mm", "to_y_mm"];
const ROWS: [[&str; 5]; 5] = [
    ["a", "0", "0", "10.003", "0.001"],
    ["b", "100", "0", "110.004", "0.99"],
    ["c", "100", "50", "109.51", "50.996"],
    ["d", "0", "50", "9.502", "50.003"],
    ["e", "40", "20", "49.79", "20.402"],
];

/// The table with `separator` between its cells and `decimal` in its numbers.
fn table(separator: &str, decimal: &str) -> String {
    let row = |cells: &[&str; 5]| cells.map(|c| c.replace('.', decimal)).join(separator) + "\n";
    HEADER.join(separator) + "\n" + &ROWS.iter().map(row).collect::<String>()
}

fn case(pairs: impl AsRef<[u8]>) -> Case {
    let case = Case::new(&[("case.toml", TOML)]);
    case.write("pairs.csv", pairs);
    case
}

/// What is solved for, and what was noted on the way.
fn solved(pairs: impl AsRef<[u8]>) -> (Value, Vec<String>) {
    let answer = case(pairs).json("solve");
    let notes = answer["notes"].as_array().unwrap().iter();
    let notes = notes.map(|note| note.as_str().unwrap().to_owned()).collect();
    (answer["estimates"].clone(), notes)
}

/// The one message about a table that is refused, without its folder.
fn refused(pairs: &str) -> String {
    let case = case(pairs);
    let message = case.message("solve", 2);
    message.replace(&format!("{}/", case.path().display()), "")
}

#[test]
fn separators_and_decimals_of_spreadsheets() {
    let (expected, notes) = solved(table(",", "."));
    assert_eq!(notes, Vec::<String>::new(), "nothing to say of the plainest form");
    let with_comma = "pairs.csv: cells separated by semicolons, decimals with a comma";
    for (text, note) in [
        (table(";", "."), "pairs.csv: cells separated by semicolons"),
        (table(";", ","), with_comma),
        (format!("sep=;\n{}", table(";", ",")), with_comma),
        (format!("\"SEP=;\"\r\n{}", table(";", ",").replace('\n', "\r\n")), with_comma),
        (table("\t", "."), "pairs.csv: cells separated by tabs"),
        (table("\t", ","), "pairs.csv: cells separated by tabs, decimals with a comma"),
        (format!("sep=,\n{}", table(",", ".")), "pairs.csv: cells separated by commas"),
    ] {
        assert_eq!(solved(&text), (expected.clone(), vec![note.to_owned()]), "{text}");
    }
}

#[test]
fn utf_16_with_its_mark() {
    let (expected, _) = solved(table(",", "."));
    let text = table(";", ",");
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for (mark, bytes, name) in
        [(b"\xff\xfe", little.clone(), "UTF-16 LE"), (b"\xfe\xff", big, "UTF-16 BE")]
    {
        let (found, notes) = solved([&mark[..], &bytes].concat());
        assert_eq!(found, expected);
        let note =
            format!("pairs.csv: {name}; cells separated by semicolons, decimals with a comma");
        assert_eq!(notes, [note]);
    }
    let broken = case([&b"\xff\xfe"[..], &little[..little.len() - 1]].concat());
    assert!(broken.message("solve", 2).contains("line 6"), "{}", broken.message("solve", 2));
    let unmarked = case(little).message("solve", 2);
    assert!(unmarked.contains("UTF-16 without a byte order mark"), "{unmarked}");
}

#[test]
fn empty_rows_and_columns_at_the_end() {
    let (expected, _) = solved(table(",", "."));
    let wide = table(",", ".").replace('\n', ",,\n");
    let long = format!("{wide},,,,,,\n,,,,,,\n");
    let note = "pairs.csv: 2 empty rows and empty columns at the right left aside";
    assert_eq!(solved(&long), (expected.clone(), vec![note.to_owned()]));
    let rows_alone = table(",", ".").replace("0.001\n", "0.001,\n");
    let note = "pairs.csv: empty columns at the right left aside";
    assert_eq!(solved(&rows_alone), (expected, vec![note.to_owned()]));
    assert_eq!(
        refused(&wide.replace("0.99,,", "0.99,,7")),
        "pairs.csv, line 1, column 7: the header's cell is empty; name the column or remove it"
    );
}

#[test]
fn lengths_in_other_units() {
    let (expected, _) = solved(table(",", "."));
    let scaled = |name: &str, column: usize, factor: f64| {
        let mut header = HEADER;
        header[column] = name;
        let rows = ROWS.map(|row| {
            let value: f64 = row[column].parse().unwrap();
            let mut cells = row.map(str::to_owned);
            cells[column] = (value * factor).to_string();
            cells.join(",") + "\n"
        });
        header.join(",") + "\n" + &rows.concat()
    };
    let number = |estimates: &Value| estimates["translation_mm"][0].as_f64().unwrap();
    for (name, factor, said) in [
        ("to_x_um", 1e3, "divided by 1000"),
        ("to_x_µm", 1e3, "divided by 1000"),
        ("to_x_m", 1e-3, "times 1000"),
        ("to_x_in", 1.0 / 25.4, "times 25.4"),
        ("to_x_inch", 1.0 / 25.4, "times 25.4"),
    ] {
        let (found, notes) = solved(scaled(name, 3, factor));
        // Round-off of the conversion over coordinates of 110 mm.
        assert!((number(&found) - number(&expected)).abs() < 1e-12 * 110.0, "{name}");
        assert_eq!(notes, [format!("pairs.csv: `{name}` read as `to_x_mm`, {said}")]);
    }
    let both = table(",", ".").replace("to_y_mm\n", "to_y_mm,to_y_in\n").replace("99\n", "99,1\n");
    let both = both.replace("001\n", "001,1\n").replace("996\n", "996,1\n");
    let both = both.replace("003\n", "003,1\n").replace("402\n", "402,1\n");
    assert_eq!(
        refused(&both),
        "pairs.csv, line 1, column 6: columns `to_y_mm` and `to_y_in` exclude each other; remove one"
    );
}

#[test]
fn what_can_be_read_in_two_ways_is_refused() {
    let semicolons = table(";", ".");
    let only_groups = semicolons
        .replace("10.003", "10,003")
        .replace("0.001", "0")
        .replace("110.004", "110")
        .replace("0.99", "1")
        .replace("109.51", "110")
        .replace("50.996", "51")
        .replace("9.502", "9")
        .replace("50.003", "50")
        .replace("49.79", "50")
        .replace("20.402", "20");
    assert_eq!(
        refused(&only_groups),
        "pairs.csv, line 2, column 4 (`to_x_mm`): found `10,003`, which may be 10.003 or 10003, and \
         no other cell decides it; write decimals with a point"
    );
    assert_eq!(
        refused(&semicolons.replace("109.51", "109,51")),
        "pairs.csv, line 2, column 4 (`to_x_mm`): found `10.003`, with a point, where `109,51` in \
         line 4 has a comma; write all decimals alike"
    );
    assert_eq!(
        refused(&semicolons.replace("109.51", "1.109,51")),
        "pairs.csv, line 4, column 4 (`to_x_mm`): found `1.109,51`: digits in groups cannot be told \
         from decimals; write the number without them"
    );
    let message = refused(&table(",", ","));
    assert!(message.starts_with("pairs.csv, line 2, column 6: expected 5 cells"), "{message}");
    let message = refused(&table(",", ".").replace("10.003", "\"1,234\""));
    assert!(message.ends_with("found `1,234`; write decimals with a point"), "{message}");
}

#[test]
fn every_kind_reads_them() {
    for kind in
        ["frame-fit", "ft-center", "tracker-lm", "pose-icp", "probe-comp", "force-impedance"]
    {
        let case = Case::example(kind);
        let expected = case.json("solve");
        for file in std::fs::read_dir(case.path()).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_some_and(|e| e == "csv") {
                let text = std::fs::read_to_string(&path).unwrap();
                let rows = text.lines().filter(|line| !line.starts_with('#'));
                // A cell of which the comma cannot be that of thousands.
                let foreign = |line: &str| line.replace(',', ";").replace('.', ",") + ";0,5\r\n";
                let mut rows = rows.map(foreign);
                let header = rows.next().unwrap().replace(";0,5", ";beside");
                let all: String = std::iter::once(header).chain(rows).collect();
                let units: Vec<u8> = all.encode_utf16().flat_map(u16::to_le_bytes).collect();
                std::fs::write(&path, [b"\xff\xfe", &units[..]].concat()).unwrap();
            }
        }
        assert_eq!(case.json("solve")["estimates"], expected["estimates"], "{kind}");
    }
}

#[test]
fn notes_are_said_beside_the_text_too() {
    let ended = case(table(";", ",")).run("solve");
    assert_eq!(ended.code, 0);
    assert_eq!(
        ended.stderr,
        "note: pairs.csv: cells separated by semicolons, decimals with a comma\n"
    );
}
