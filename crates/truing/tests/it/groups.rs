//! `[loop] group`: what is left out together.

use serde_json::Value;

use crate::command::Case;

/// A frame-fit case of twelve points with a text and a number to group by.
fn with_columns(setting: &str) -> Case {
    let case = Case::example("frame-fit");
    case.replace("case.toml", "# group = \"session\"", setting);
    let text = std::fs::read_to_string(case.file("pairs.csv")).unwrap();
    let mut row = 0;
    let rows = text.lines().map(|line| {
        if line.starts_with('#') {
            return line.to_owned() + "\n";
        }
        row += 1;
        match row {
            1 => format!("{line},session,day\n"),
            // 1 and 1.0 are one day.
            _ => format!("{line},s{},{}\n", row % 4, ["1", "1.0", "2", "3", "4", "5"][row % 6]),
        }
    });
    case.write("pairs.csv", rows.collect::<String>());
    case
}

fn groups(setting: &str) -> (Value, Value) {
    let counts = with_columns(setting).json("check")["counts"].clone();
    (counts["fit_groups"].clone(), counts["check_groups"].clone())
}

#[test]
fn equal_values_are_one_group_and_judged_points_stay_apart() {
    assert_eq!(groups(""), (10.into(), 2.into()), "every point by itself");
    assert_eq!(groups("group = \"session\""), (4.into(), 2.into()));
    assert_eq!(groups("group = \"day\""), (5.into(), 2.into()));
}

#[test]
fn a_group_that_is_empty_is_an_error() {
    let case = with_columns("group = \"session\"");
    case.replace("pairs.csv", ",s3,", ",,");
    let message = case.message("loop", 2);
    assert!(message.contains("(`session`): expected the name of a group"), "{message}");
}
