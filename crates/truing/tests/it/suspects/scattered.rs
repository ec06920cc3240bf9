//! Mistakes in single numbers, and in rows here and there.

use super::numbers::axis;
use super::{SURVEY, change, first, fixture, survey};
use crate::command::Case;

const FROM: [&str; 3] = ["from_x_mm", "from_y_mm", "from_z_mm"];

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// Effect and description of the first mistake.
fn named(case: &Case) -> [String; 2] {
    let (step, _) = first(case);
    ["effect", "description"].map(|key| step[key].as_str().unwrap().to_owned())
}

/// The first two neighbouring digits that differ the other way round.
fn slipped(cell: &str) -> String {
    let mut bytes = cell.as_bytes().to_vec();
    let is_slip = |pair: &[u8]| pair.iter().all(u8::is_ascii_digit) && pair[0] != pair[1];
    let at = bytes.windows(2).position(is_slip).expect("two digits that differ");
    bytes.swap(at, at + 1);
    String::from_utf8(bytes).unwrap()
}

#[test]
fn two_digits_of_one_number_are_put_back() {
    let case = survey();
    change(&case, "pairs.csv", &FROM[..1], |n, old| {
        vec![if n == 6 { slipped(&old[n][0]) } else { old[n][0].clone() }]
    });
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:digits");
    assert!(said.contains("two digits exchanged"), "{said}");
}

#[test]
fn inches_here_and_there_are_named_with_their_lines() {
    let case = survey();
    let wrong = [2, 5, 6, 11, 15];
    change(&case, "pairs.csv", &FROM, |n, old| {
        let factor = if wrong.contains(&n) { 25.4 } else { 1.0 };
        old[n].iter().map(|cell| format!("{:.5}", number(cell) / factor)).collect()
    });
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:unit");
    assert!(said.contains("multiply by 25.4"), "{said}");
}

#[test]
fn orientations_one_row_further_down_are_shifted_back() {
    let turns = |i: usize| f64::from(u32::try_from(i).unwrap());
    let quaternion = |i: usize| {
        let (a, b, c) =
            (0.7 * turns(i), 0.9 * (1.3 * turns(i)).sin(), 0.8 * (0.9 * turns(i)).cos());
        let half = |angle: f64| ((0.5 * angle).cos(), (0.5 * angle).sin());
        let ((cz, sz), (cy, sy), (cx, sx)) = (half(a), half(b), half(c));
        [
            cz * cy * cx + sz * sy * sx,
            cz * cy * sx - sz * sy * cx,
            cz * sy * cx + sz * cy * sx,
            sz * cy * cx - cz * sy * sx,
        ]
    };
    let n = 24;
    // The tip is 80 mm out along z and 30 mm along x, and stays at one place.
    let row = |i: usize, of: usize| {
        let [w, x, y, z] = quaternion(i);
        let tip = |k: usize| {
            let columns = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
                [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
            ];
            30.0 * columns[0][k] + 80.0 * columns[1][k]
        };
        let noise = |k: usize| 0.02 * ((1e5 * turns(5 * i + k + 1)).sin() * 43.0).fract();
        let at = [0, 1, 2].map(|k| [400.0, -120.0, 250.0][k] - tip(k) + noise(k));
        let q = quaternion(of);
        format!(
            "p{i},ball,{:.5},{:.5},{:.5},{:.9},{:.9},{:.9},{:.9}\n",
            at[0], at[1], at[2], q[0], q[1], q[2], q[3]
        )
    };
    let header = "pose,place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
    let table = |of: &dyn Fn(usize) -> usize| -> String {
        header.to_owned() + &(0..n).map(|i| row(i, of(i))).collect::<String>()
    };
    let settings = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.0115\n";
    let sound = Case::new(&[("case.toml", settings), ("poses.csv", &table(&|i| i))]);
    assert_ne!(sound.json("loop")["verdict"], "input-wrong");
    let case = Case::new(&[("case.toml", settings), ("poses.csv", &table(&|i| (i + n - 1) % n))]);
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:row-shift");
    assert!(said.contains("`qw`") && said.contains("one row down"), "{said}");
}

#[test]
fn a_spike_of_a_cell_is_told() {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + "\n[noise]\nforce_n = 1.5\n");
    change(&case, "log.csv", &["f4_n"], |n, old| {
        let spike = if n == 133 { 95.0 } else { 0.0 };
        vec![format!("{:.4}", number(&old[n][0]) + 1.5 + spike)]
    });
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:spike");
    assert!(said.contains("in line 135") && said.contains("a spike of `f4_n`"), "{said}");
}

/// A slip of any other channel there would explain as much, and none of them jumps.
#[test]
fn a_spike_is_of_the_channel_that_jumps() {
    for (column, row, by) in [("reference_n", 133, 6.0), ("l2_mm", 201, 4.0)] {
        let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
        change(&case, "log.csv", &[column], |n, old| {
            let spike = if n == row { by } else { 0.0 };
            vec![format!("{:.4}", number(&old[n][0]) + spike)]
        });
        let [effect, said] = named(&case);
        assert_eq!(effect, "input:spike", "{said}");
        assert!(said.contains(&format!("a spike of `{column}`")), "{said}");
    }
}

/// A sound log of a head whose weight is written otherwise.
fn with_weight(of: impl Fn(f64) -> f64) -> Case {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("weight_n")).unwrap();
    let weight_n = number(line.split_once('=').unwrap().1.trim());
    case.write("case.toml", text.replace(line, &format!("weight_n = {:?}", of(weight_n))));
    case
}

#[test]
fn a_weight_in_pounds_is_no_zero_of_a_cell() {
    let [effect, said] = named(&with_weight(|n| (1e3 * n / 4.448_221_615_260_5).round() / 1e3));
    assert_eq!(effect, "input:unit");
    assert!(said.contains("lbf instead of N"), "{said}");
}

#[test]
fn a_weight_ten_times_as_large_is_a_decimal_point_and_no_heavier_head() {
    let [effect, said] = named(&with_weight(|n| 10.0 * n));
    assert_eq!(effect, "input:decimal-point");
    assert!(said.contains("`[head] weight_n`"), "{said}");
}

#[test]
fn readings_that_were_not_recorded_are_left_out() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        vec![if (7..12).contains(&n) { "0.0000".to_owned() } else { old[n][0].clone() }]
    });
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:missing");
    assert!(said.contains("5 rows"), "{said}");
}

#[test]
fn targets_in_place_of_deviations_are_told() {
    let row = |i: u32| {
        let target = 20.0 * f64::from(i % 15);
        let deviation = 0.002 * f64::from(i * 7 % 11) - 0.01;
        let deviation = if (18..25).contains(&i) { target } else { deviation };
        format!("{target:.3},{deviation:.5},{}\n", ["+", "-"][(i / 15 % 2) as usize])
    };
    let table =
        "target_mm,deviation_mm,direction\n".to_owned() + &(0..60).map(row).collect::<String>();
    let settings = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.007\n";
    let case = Case::new(&[("case.toml", settings), ("positions.csv", &table)]);
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:copied");
    assert!(said.contains("in lines 20–26"), "{said}");
}

#[test]
fn contact_points_among_centres_of_the_ball_are_told() {
    let row = |i: u32| {
        let noise = 0.002 * ((1e5 * f64::from(i)).sin() * 43.0).fract();
        let z = if [3, 4, 9, 17].contains(&i) { 0.0 } else { 2.5 };
        format!("T{i},{},{},{:.5}\n", 7 * i % 40, 11 * i % 37, z + noise)
    };
    let table = "touch,x_mm,y_mm,z_mm\n".to_owned() + &(0..40).map(row).collect::<String>();
    let settings = "kind = \"probe-comp\"\n[surface]\nshape = \"plane\"\npoint_mm = [0.0, 0.0, 0.0]\n\
                    normal = [0.0, 0.0, 1.0]\n[probe]\ntip_radius_mm = 2.5\n[noise]\npoint_mm = 0.001\n";
    let case = Case::new(&[("case.toml", settings), ("touches.csv", &table)]);
    let [effect, said] = named(&case);
    assert_eq!(effect, "input:compensated");
    assert!(said.contains("in lines 5–6, 11, 19"), "{said}");
}

/// In the order of the table the wrong rows lie apart, and the station is left without any.
#[test]
fn reflectors_of_one_station_exchanged_from_a_step_on_are_given_their_names_back() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "ranges.csv"];
    let case = fixture("tracker-lm/nothing", &files);
    change(&case, "ranges.csv", &["station", "mount", "step"], |n, old| {
        let [station, mount, step] = [0, 1, 2].map(|i| &*old[n][i]);
        let is_wrong = station == "S4" && number(step) >= 9.0;
        let other = match mount {
            "R1" if is_wrong => "R3",
            "R3" if is_wrong => "R1",
            same => same,
        };
        [station, other, step].map(str::to_owned).into()
    });
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("the labels `R1` and `R3` in `mount`"), "{said}");
}

/// Nine rows with noise of their own are no slips.
#[test]
fn a_sound_survey_of_few_rows_is_not_accused() {
    let row = |i: u32| {
        let at = |k: u32| 13.7 * f64::from(i * k % 9) + f64::from(k);
        let noise = |k: u32| 0.005 * ((1e5 * f64::from(i + 17 * k)).sin() * 43.0).fract();
        let [x, y, z] = [at(1), at(4), at(7)];
        format!(
            "P{i},{x:.3},{y:.3},{z:.3},{:.4},{:.4},{:.4}\n",
            x + 30.0 + noise(1),
            y - 20.0 + noise(2),
            z + 5.0 + noise(3)
        )
    };
    let header = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n";
    let table: String = (0..9).map(row).collect();
    let case = Case::new(&[("case.toml", SURVEY), ("pairs.csv", &(header.to_owned() + &table))]);
    let answer = case.json("loop");
    assert_ne!(answer["verdict"], "input-wrong", "{}", answer["steps"]);
}
