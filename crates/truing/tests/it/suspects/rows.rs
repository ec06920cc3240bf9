//! Mistakes in some of the rows: found by what the others say.

use super::numbers::axis;
use super::{change, first, fixture, survey};
use crate::command::Case;

const TO: [&str; 3] = ["to_x_mm", "to_y_mm", "to_z_mm"];
const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// Effect, subject and description of the first mistake of a case that is then as good as the noise.
fn named(case: &Case) -> [String; 3] {
    let (step, answer) = first(case);
    let chi2 = answer["residual"]["chi2_per_dof"].as_f64();
    assert!(chi2.is_none_or(|chi2| (0.2..2.5).contains(&chi2)), "{step} leaves {chi2:?}");
    ["effect", "subject", "description"].map(|key| step[key].as_str().unwrap().to_owned())
}

fn assert_says(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "{said:?} without {word:?}");
    }
}

fn mirror() -> Case {
    fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"])
}

fn part() -> Case {
    fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"])
}

#[test]
fn signs_and_exchanged_columns_of_a_stretch_are_named_with_their_lines() {
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        let mut row = old[n].clone();
        if (8..16).contains(&n) {
            row[1] = format!("{}", -number(&row[1]));
        }
        row
    });
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:sign", "pairs.csv: to_y_mm"));
    assert_says(&said, &["from line 10 to line 17"]);
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        let [x, y, z] = [0, 1, 2].map(|i| old[n][i].clone());
        if (8..16).contains(&n) { vec![y, x, z] } else { vec![x, y, z] }
    });
    let [effect, subject, _] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:exchanged", "pairs.csv: to_x_mm, to_y_mm"));
}

#[test]
fn a_block_that_was_pasted_twice_is_named_with_where_it_is_from() {
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        old[if (12..17).contains(&n) { n - 8 } else { n }].clone()
    });
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:copied", "pairs.csv: to_x_mm, to_y_mm, to_z_mm"));
    assert_says(&said, &["from line 14 to line 18", "from line 6 on"]);
}

#[test]
fn points_in_rows_of_others_are_put_back() {
    // To and fro along rows of five, as a machine goes and nobody notes.
    let to_and_fro = |n: usize| if n / 5 % 2 == 1 { n / 5 * 10 + 4 - n } else { n };
    let neighbours = |n: usize| if (6..12).contains(&n) { n ^ 1 } else { n };
    for order in [&to_and_fro as &dyn Fn(usize) -> usize, &neighbours] {
        let case = survey();
        change(&case, "pairs.csv", &TO, |n, old| old[order(n).min(old.len() - 1)].clone());
        let [effect, subject, _] = named(&case);
        assert_eq!((&*effect, &*subject), ("input:labels", "pairs.csv: to_x_mm, to_y_mm, to_z_mm"));
    }
}

#[test]
fn coordinates_in_increments_are_added_up() {
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        let less = |i: usize| if n == 0 { 0.0 } else { number(&old[n - 1][i]) };
        (0..3).map(|i| format!("{:.6}", number(&old[n][i]) - less(i))).collect()
    });
    let [effect, subject, _] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:increments", "pairs.csv: to_x_mm, to_y_mm, to_z_mm"));
}

#[test]
fn zeros_for_what_was_not_recorded_are_named() {
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        if [3, 9, 14].contains(&n) { vec!["0".to_owned(); 3] } else { old[n].clone() }
    });
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:missing");
    assert_says(&said, &["3 rows", "from line 5"]);
}

#[test]
fn touches_of_another_set_up_are_named_with_their_lines() {
    for (case, file) in [(mirror(), "points.csv"), (part(), "touches.csv")] {
        change(&case, file, &XYZ, |n, old| {
            let mut row = old[n].clone();
            if (10..18).contains(&n) {
                row[0] = format!("{}", number(&row[0]) + 7.0);
                row[2] = format!("{}", number(&row[2]) + 1.7);
            }
            row
        });
        let [effect, _, said] = named(&case);
        assert_eq!(effect, "input:misplaced", "{file}: {said}");
        assert_says(&said, &["another session"]);
    }
}

/// Too little beside the size of the part to be told from physics by that.
#[test]
fn points_of_another_session_in_the_middle_of_a_table_are_named_with_their_lines() {
    let case = survey();
    change(&case, "pairs.csv", &TO, |n, old| {
        let [x, y, z] = [0, 1, 2].map(|i| number(&old[n][i]));
        let [turn, by] = if (9..18).contains(&n) { [2e-3, 0.6] } else { [0.0; 2] };
        [x - turn * y + by, y + turn * x - 0.5 * by, z].map(|v| format!("{v:.5}")).to_vec()
    });
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:misplaced", "{said}");
    assert_says(&said, &["from line 11 to line 19", "another session"]);
}

#[test]
fn readings_at_other_targets_than_those_of_their_rows_are_put_there() {
    // The way back was listed in the order of the way there.
    let case = axis();
    let columns = ["actual_mm", "direction"];
    change(&case, "positions.csv", &columns, |n, old| {
        let run = |n: usize| {
            let same = |m: &usize| old[*m][1] == old[n][1];
            let start = (0..n).rev().take_while(same).last().unwrap_or(n);
            let end = (n..old.len()).take_while(same).last().unwrap_or(n);
            (start, end)
        };
        let (start, end) = run(n);
        let is_back = old[n][1] == "-";
        let from = if is_back { start + end - n } else { n };
        vec![old[from][0].clone(), old[n][1].clone()]
    });
    let [effect, subject, said] = named(&case);
    assert_eq!(
        (&*effect, &*subject),
        ("input:labels", "positions.csv: target_mm, actual_mm"),
        "{said}"
    );
}

#[test]
fn minus_signs_that_were_left_out_are_put_back() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm", "actual_mm"], |n, old| {
        let middle = 216.5;
        let [target, actual] = [0, 1].map(|i| number(&old[n][i]) - middle);
        vec![format!("{}", target.abs()), format!("{actual:.6}")]
    });
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:sign", "positions.csv: target_mm"));
    assert_says(&said, &["minus"]);
}

#[test]
fn a_term_of_the_drawing_with_its_point_elsewhere_or_another_sign_is_named() {
    let right = "[2, 0, -72.17349]";
    for (wrong, effect) in
        [("[2, 0, -7.217349]", "input:decimal-point"), ("[2, 0, 72.17349]", "input:sign")]
    {
        let case = fixture("pose-icp/measured-mirror-1", &["case.toml", "points.csv"]);
        let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
        case.write("case.toml", text.replacen(right, wrong, 1));
        let (step, _) = first(&case);
        assert_eq!(step["effect"], effect, "{step}");
        assert_eq!(step["subject"], "case.toml: [surface] terms");
        assert_says(step["description"].as_str().unwrap(), &["number 6: ", "instead of"]);
    }
}
