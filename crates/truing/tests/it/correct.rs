//! Programs corrected from the command line.

use nalgebra::{Isometry3, Matrix4, Point3, Rotation3, Vector3};
use serde_json::Value;

use crate::command::{Case, Ended, truing};

/// Coordinates are written to four decimals.
const WRITTEN_MM: f64 = 0.5e-4;
const CHORD_MM: f64 = 1e-3;

fn corrected(case: &Case, program: &str, more: &[&str]) -> Ended {
    case.write("part.ngc", program);
    let (folder, file) = (case.path(), case.file("part.ngc"));
    let words = ["correct", folder.to_str().unwrap(), file.to_str().unwrap()];
    truing(&[&words[..], more].concat())
}

/// Machine from workpiece, from the rows of the matrix in the JSON.
fn pose(case: &Case) -> Isometry3<f64> {
    let answer = case.json("solve");
    let matrix = &answer["estimates"]["matrix"];
    let matrix = Matrix4::from_fn(|r, c| matrix[r][c].as_f64().unwrap());
    let rotation = Rotation3::from_matrix_unchecked(matrix.fixed_view::<3, 3>(0, 0).into_owned());
    let translation = matrix.fixed_view::<3, 1>(0, 3).into_owned();
    Isometry3::from_parts(translation.into(), rotation.into())
}

/// X, Y and Z of a block; NaN where it has none.
fn coordinates(block: &str) -> Vector3<f64> {
    let of = |letter: char| {
        let word = block.split_whitespace().find(|w| w.starts_with(letter));
        word.map_or(f64::NAN, |w| w[1..].parse().unwrap())
    };
    Vector3::new(of('X'), of('Y'), of('Z'))
}

fn moves(program: &str) -> Vec<Vector3<f64>> {
    let is_move = |l: &&str| l.contains('X') || l.contains('Y') || l.contains('Z');
    program.lines().filter(is_move).map(coordinates).collect()
}

#[test]
fn absolute_moves_go_where_the_part_is_and_the_rest_stays() {
    let case = Case::example("pose-icp");
    let program = "%\nN10 G21 G90 (roughing)\nN20 G0 X0 Y0 Z0\nN30 G1 X10 Y-20 Z5 F300 M8\nM30\n";
    let ended = corrected(&case, program, &[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let pose = pose(&case);
    let expected = [Point3::origin(), Point3::new(10.0, -20.0, 5.0)].map(|p| (pose * p).coords);
    for (found, expected) in moves(&ended.stdout).iter().zip(expected) {
        assert!((found - expected).amax() <= WRITTEN_MM, "{found} {expected}");
    }
    for kept in ["%", "(roughing)", "N30", "F300", "M8", "M30", "G21"] {
        assert!(ended.stdout.contains(kept), "{kept} is lost:\n{}", ended.stdout);
    }
}

#[test]
fn incremental_moves_end_where_absolute_ones_do() {
    let case = Case::example("pose-icp");
    let program = "G90 G0 X1 Y2 Z3\nG91 G1 X10 Y0 Z0 F100\nX0 Y5 Z0\nX-3 Y1 Z2\n";
    let ended = corrected(&case, program, &[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let moves = moves(&ended.stdout);
    let end: Vector3<f64> = moves.iter().sum();
    let expected = pose(&case) * Point3::new(8.0, 8.0, 5.0);
    // Each step starts where the rounded one before ended.
    assert!((end - expected.coords).amax() <= WRITTEN_MM, "{end} {expected}");
    assert_eq!(moves.len(), 4);
}

/// A full circle by G2 and a quarter by G3 become chords within the tolerance.
#[test]
fn arcs_become_chords_of_the_turned_circle() {
    let case = Case::example("pose-icp");
    let (center, radius) = (Point3::new(5.0, 0.0, 2.0), 20.0);
    let pose = pose(&case);
    for (arc, end) in [
        ("G2 X25 Y0 I-20 J0", Point3::new(25.0, 0.0, 2.0)),
        ("G3 X5 Y20 I-20 J0", Point3::new(5.0, 20.0, 2.0)),
        ("G3 X5 Y20 R20", Point3::new(5.0, 20.0, 2.0)),
    ] {
        let ended = corrected(&case, &format!("G90 G17 G0 X25 Y0 Z2\nF200\n{arc}\n"), &[]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let points: Vec<_> =
            moves(&ended.stdout).iter().map(|p| pose.inverse() * Point3::from(*p)).collect();
        assert!(points.len() > 10, "{}", ended.stdout);
        for pair in points.windows(2) {
            let middle = nalgebra::center(&pair[0], &pair[1]) - center;
            let sagitta = radius - middle.xy().norm();
            assert!(sagitta < CHORD_MM + 4.0 * WRITTEN_MM, "{sagitta}");
            assert!(((pair[1] - center).xy().norm() - radius).abs() < CHORD_MM + 4.0 * WRITTEN_MM);
        }
        assert!((points[points.len() - 1] - end).norm() < 4.0 * WRITTEN_MM);
    }
}

#[test]
fn a_program_for_the_pose_found_stays_as_it_is() {
    let case = Case::example("pose-icp");
    let answer: Value = case.json("solve");
    let of = |name: &str| answer["estimates"]["pose"][name].as_f64().unwrap();
    let names = ["x_mm", "y_mm", "z_mm", "alpha_deg", "beta_deg", "gamma_deg"];
    let planned = names.map(|name| format!("{:.12}", of(name))).join(",");
    let ended = corrected(&case, "G90 G1 X-500 Y-480 Z-280 F50\n", &["--planned", &planned]);
    assert_eq!(moves(&ended.stdout), [Vector3::new(-500.0, -480.0, -280.0)], "{}", ended.stdout);
}

/// Nothing is written of a program with a block that cannot be moved.
#[test]
fn what_cannot_be_corrected_is_refused_with_its_line() {
    let case = Case::example("pose-icp");
    for (block, reason) in [
        ("G81 X1 Y1 Z-2 R1", "G81 cannot be corrected; write it out as G0 to G3"),
        ("G1 X1 A30", "axis A cannot be corrected: only X, Y and Z are moved"),
        ("G41 X1", "G41 cannot be corrected"),
        ("G1 X#101", "macros and expressions have to be resolved before"),
        ("G2 X9 Y9", "arc without a centre (I, J, K) or a radius R that spans its ends"),
    ] {
        let ended = corrected(&case, &format!("(head)\nG90 G0 X0 Y0 Z0\n{block}\n"), &[]);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
        let message = ended.one_message();
        assert!(message.contains("part.ngc") && message.contains("line 3"), "{message}");
        assert!(message.contains(reason), "{message}");
    }
    let ended = corrected(&case, "G90 G1 X1 F10\n", &[]);
    assert!(ended.one_message().contains("line 1: the position is not known here"));
}

#[test]
fn only_a_pose_corrects_a_program() {
    let case = Case::example("frame-fit");
    let ended = corrected(&case, "G0 X0 Y0 Z0\n", &[]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("frame-fit"), "{}", ended.stderr);
    let case = Case::example("pose-icp");
    for more in [
        ["--decimals", "40"],
        ["--decimals", "-1"],
        ["--chord", "0"],
        ["--chord", "nan"],
        ["--chord", "1e9"],
        ["--planned", "1e308,0,0,0,0,0"],
        ["--planned", "0,0,inf,0,0,0"],
        ["--planned", "0,0,0,0,1e9,0"],
    ] {
        let ended = corrected(&case, "G0 X0 Y0 Z0\n", &more);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{more:?}");
    }
}

/// A kilometre is beyond any machine, however the program comes by it.
#[test]
fn absurd_coordinates_are_not_written() {
    let case = Case::example("pose-icp");
    for far in ["X1000001", "X-99999999999999999999999", "X40000"] {
        let program = format!("G90 G20 G0 X0 Y0 Z0\nG1 {far} F10\n");
        let ended = corrected(&case, &program, &[]);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{far}");
        let message = ended.one_message();
        assert!(message.contains("line 2: X would go to"), "{message}");
    }
}

#[test]
fn a_corrected_program_says_so_and_is_not_corrected_again() {
    let case = Case::example("pose-icp");
    let ended = corrected(&case, "%\nO0012 (PART)\nG90 G0 X0 Y0 Z0\n%\n", &[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let lines: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(lines[..2], ["%", "O0012 (PART)"]);
    let mark = format!("(TRUING {} CORRECTED FOR CASE ", env!("CARGO_PKG_VERSION"));
    assert!(lines[2].starts_with(&mark), "{}", lines[2]);
    assert_eq!(lines[2].len(), mark.len() + 64 + 1, "SHA-256 in hexadecimal digits");
    let again = corrected(&case, &ended.stdout, &[]);
    assert_eq!((again.code, again.stdout.as_str()), (2, ""));
    let message = again.one_message();
    assert!(message.contains("part.ngc, line 3: the program was corrected already"), "{message}");

    // Another case leaves another mark.
    case.replace("points.csv", "\n", "\n# measured again\n");
    let other = corrected(&case, "G90 G0 X0 Y0 Z0\n", &[]);
    assert_ne!(other.stdout.lines().next(), Some(lines[2]));
}

fn fixture(name: &str) -> Case {
    let folder = format!("{}/../../fixtures/pose-icp/{name}", env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| std::fs::read_to_string(format!("{folder}/{file}")).unwrap();
    let texts = ["case.toml", "points.csv", "edge.csv"].map(|file| (file, read(file)));
    Case::new(&texts.each_ref().map(|(file, text)| (*file, text.as_str())))
}

/// With the answer of a loop the program says what the machine reads: the pose of the answer, and
/// the axis that was found to be long, about the place where it reads right.
#[test]
fn an_answer_of_the_loop_corrects_for_the_axes_too() {
    let case = fixture("machine-scale");
    let answer = case.json("loop");
    case.write("answer.json", answer.to_string());
    let step = &answer["steps"][0];
    assert_eq!(step["effect"], "axis-scale", "{step}");
    let axis = ["x", "y", "z"].iter().position(|name| step["subject"] == *name).unwrap();
    let long = 1e-6 * step["parameters"][0]["value"].as_f64().unwrap();
    let reference: Vec<f64> = serde_json::from_value(answer["estimates"]["reference_mm"].clone())
        .expect("a scale refers to a place");
    let program = "G90 G1 X30 Y-20 Z4 F300\nX-30 Y10 Z3\n";
    let path = case.file("answer.json");
    let ended = corrected(&case, program, &["--answer", path.to_str().unwrap(), "--decimals", "9"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let of = |name: &str| answer["estimates"]["pose"][name].as_f64().unwrap();
    let [a, b, g] = ["alpha_deg", "beta_deg", "gamma_deg"].map(|name| of(name).to_radians());
    let turned = Rotation3::from_euler_angles(a, b, g);
    let at = Vector3::new(of("x_mm"), of("y_mm"), of("z_mm"));
    let planned = [Vector3::new(30.0, -20.0, 4.0), Vector3::new(-30.0, 10.0, 3.0)];
    for (found, local) in moves(&ended.stdout).iter().zip(planned) {
        let mut expected = turned * local + at;
        // The scale is one of the reading: what is true is the reading less its share.
        expected[axis] = reference[axis] + (expected[axis] - reference[axis]) / (1.0 - long);
        assert!((found - expected).amax() < 1e-8, "{found} {expected}");
    }
}

#[test]
fn an_answer_on_other_touches_is_refused() {
    let (case, other) = (fixture("machine-scale"), fixture("conic"));
    case.write("answer.json", other.json("loop").to_string());
    let path = case.file("answer.json");
    let ended = corrected(&case, "G0 X0 Y0 Z0\n", &["--answer", path.to_str().unwrap()]);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
    assert!(ended.one_message().contains("not found on the touches of this case"));
}
