//! Programs corrected for the pose that was found.

use geometry::EulerAngles;
use nalgebra::{Isometry3, Point3, Vector3};
use pose_icp::{
    PoseStart, ProgramError, ProgramOptions, Refused, correct_points, correct_program,
    machine_correction,
};

fn correction() -> Isometry3<f64> {
    let planned = PoseStart::level(Vector3::new(100.0, 50.0, -20.0), 0.0);
    let angles = EulerAngles { alpha_rad: 8e-3, beta_rad: -5e-3, gamma_rad: 0.01 };
    let found = PoseStart { position_mm: Vector3::new(100.3, 49.8, -19.95), angles };
    machine_correction(&planned, &found)
}

const OPTIONS: ProgramOptions = ProgramOptions { chord_mm: 1e-3, decimals: 6 };
/// Half of the last decimal in each coordinate.
const WRITTEN_MM: f64 = 1e-6;

/// Positions that a program of G0 and G1 goes through: an interpreter of its own.
fn run(program: &str) -> Vec<Point3<f64>> {
    let (mut at, mut incremental, mut path) = (Point3::origin(), false, Vec::new());
    for line in program.lines() {
        let line = line.split([';', '(']).next().unwrap();
        let mut moved = false;
        for word in line.split_whitespace() {
            let (letter, number) = word.split_at(1);
            match (letter, number) {
                ("G", "90") => incremental = false,
                ("G", "91") => incremental = true,
                ("G", code) => assert!(["0", "1", "17", "21", "90.1"].contains(&code), "{line}"),
                ("X" | "Y" | "Z", number) => {
                    let k = "XYZ".find(letter).unwrap();
                    let value: f64 = number.parse().unwrap();
                    at[k] = if incremental { at[k] + value } else { value };
                    moved = true;
                }
                _ => {}
            }
        }
        if moved {
            path.push(at);
        }
    }
    path
}

fn near(a: &Point3<f64>, b: &Point3<f64>, tolerance: f64) -> bool {
    (a - b).norm() < tolerance
}

#[test]
fn every_move_lands_where_the_part_is() {
    let program = "%\nN10 G21 G17 G90 (absolute)\nN20 G0 X100 Y50 Z30 ; over the part\n\
                   N30 G1 Z-20 F200\nN40 X110.5\nY60\nG91\nX-3.25 Z0.5 M8\nG90 G1 X100 Y50\n";
    let corrected = correct_program(program, &correction(), &OPTIONS).unwrap();
    let planned = run(program);
    let expected = correct_points(&correction(), &planned);
    let found = run(&corrected);
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        assert!(near(a, b, WRITTEN_MM), "{a} {b}");
    }
    for kept in ["N10 G21 G17 G90 (absolute)", "; over the part", "N30 G1", "F200", "M8", "%"] {
        assert!(corrected.contains(kept), "{kept} in {corrected}");
    }
}

#[test]
fn nothing_to_correct_changes_no_position() {
    let program = "G0 X1 Y2 Z3\nG1 X4\nG91 X1 Y1 Z1\n";
    let same = correct_program(program, &Isometry3::identity(), &OPTIONS).unwrap();
    assert_eq!(run(&same).len(), 3);
    assert!(run(&same).iter().zip(run(program)).all(|(a, b)| near(a, &b, WRITTEN_MM)));
}

#[test]
fn arcs_become_chords_that_stay_within_tolerance() {
    // A quarter, a half by its radius, a full circle and a helix, all of radius 20.
    for (arc, turns) in [
        ("G3 X100 Y70 I-20 J0", 0.25),
        ("G2 X80 Y50 R20", 0.5),
        ("G2 I-20", 1.0),
        ("G3 X100 Y70 Z5 I-20 J0", 0.25),
        ("G90.1 G3 X100 Y70 I100 J50", 0.25),
    ] {
        let program = format!("G0 X120 Y50 Z0\n{arc} F100 (arc)\n");
        let corrected = correct_program(&program, &correction(), &OPTIONS);
        let corrected = corrected.unwrap_or_else(|e| panic!("{arc}: {e}"));
        assert!(corrected.contains("F100 (arc)"));
        // Every one of them is about (100, 50), the one by its radius over a diameter.
        let center = Vector3::new(100.0, 50.0, 0.0);
        let back: Vec<Point3<f64>> =
            run(&corrected).iter().map(|p| correction().inverse() * p).collect();
        let mut length = 0.0;
        for pair in back.windows(2) {
            let middle = (pair[0].coords + pair[1].coords) / 2.0 - center;
            let radius = middle.xy().norm();
            assert!((20.0 - radius) < 1.01e-3 && radius < 20.0 + WRITTEN_MM, "{arc}: {radius}");
            length += (pair[1] - pair[0]).xy().norm();
        }
        let expected = std::f64::consts::TAU * 20.0 * turns;
        // Chords over 2·acos(1 − 5e-5) are shorter by θ²/24.
        assert!((length / expected - 1.0).abs() < 1e-4, "{arc}: {length} of {expected}");
    }
}

#[test]
fn what_cannot_be_corrected_is_refused_with_its_line() {
    let start = "G0 X0 Y0 Z0\n";
    let refused =
        |text: &str| match correct_program(&format!("{start}{text}\n"), &correction(), &OPTIONS) {
            Err(ProgramError::Line { line: 2, reason }) => reason,
            other => panic!("{text}: {other:?}"),
        };
    assert!(matches!(refused("G81 X1 Y1 Z-3 R2"), Refused::Code { .. }));
    assert!(matches!(refused("G41 D1"), Refused::Code { .. }));
    assert!(matches!(refused("G92 X0"), Refused::Code { .. }));
    assert_eq!(refused("G1 X1 B30"), Refused::Axis { axis: 'B' });
    assert!(matches!(refused("G1 X#5"), Refused::Word { .. }));
    assert!(matches!(refused("G1 X[1+2]"), Refused::Word { .. }));
    assert!(matches!(refused("G2 X1 Y1"), Refused::NoCenter));
    assert!(matches!(refused("G2 X1 Y1 I50 J3"), Refused::Arc { .. }));
    assert!(matches!(refused("G1 X1 (open"), Refused::Word { .. }));
    let first = correct_program("G0 Z5\n", &correction(), &OPTIONS);
    assert_eq!(first, Err(ProgramError::Line { line: 1, reason: Refused::UnknownPosition }));
    let no_motion = correct_program("X1 Y1 Z1\n", &correction(), &OPTIONS);
    assert_eq!(no_motion, Err(ProgramError::Line { line: 1, reason: Refused::NoMotion }));
    let options = ProgramOptions { chord_mm: 0.0, ..OPTIONS };
    assert!(matches!(
        correct_program("", &correction(), &options),
        Err(ProgramError::InvalidOption { .. })
    ));
}

/// A probe ends its move anywhere: what it moved is known again when the program says it.
#[test]
fn touches_are_moved_and_what_they_moved_is_given_again() {
    let shift = Isometry3::translation(1.0, 2.0, 3.0);
    let corrected = |text: &str| correct_program(text, &shift, &OPTIONS);
    let moved = corrected("G90 G0 X0 Y0 Z9\nG38.2 Z-1 F60\nG1 Z9\nG38.3 X4 Y0 Z0\n").unwrap();
    let expected = "G90 G0 X1.000000 Y2.000000 Z12.000000\n\
                    G38.2 X1.000000 Y2.000000 Z2.000000 F60\n\
                    G1 X1.000000 Y2.000000 Z12.000000\nG38.3 X5.000000 Y2.000000 Z3.000000\n";
    let lines = |text: &str| text.lines().map(|l| l.trim_end().to_owned()).collect::<Vec<_>>();
    assert_eq!(lines(&moved), lines(expected));
    let touched = "G90 G0 X0 Y0 Z9\nG38.2 Z-1 F60\n";
    for after in ["G0 X5", "G91 G1 Z4", "G38.4 Y3"] {
        let refused = corrected(&format!("{touched}{after}\n"));
        let unknown = ProgramError::Line { line: 3, reason: Refused::UnknownPosition };
        assert_eq!(refused, Err(unknown), "{after}");
    }
    // Steps go on from the first place that is known again.
    let steps = corrected(&format!("{touched}G1 X0 Y0 Z9\nG91\nX1\n")).unwrap();
    assert!(steps.ends_with("G91\nX1.000000 Y0.000000 Z0.000000\n"), "{steps}");
}

#[test]
fn inches_are_moved_by_as_many_millimetres() {
    let shift = Isometry3::translation(25.4, 0.0, 0.0);
    let corrected = correct_program("G20\nG0 X1 Y0 Z0\nG21\nG1 X0\n", &shift, &OPTIONS).unwrap();
    assert!(corrected.contains("X2.000000 Y0.000000 Z0.000000"), "{corrected}");
    assert!(corrected.contains("X25.400000"), "{corrected}");
}

#[test]
fn a_long_incremental_path_does_not_drift() {
    let mut program = "G90 G0 X0 Y0 Z0\nG91 G1\n".to_owned();
    program.push_str(&"X0.1 Y0.1\n".repeat(2000));
    let options = ProgramOptions { decimals: 3, ..OPTIONS };
    let corrected = correct_program(&program, &correction(), &options).unwrap();
    let end = *run(&corrected).last().unwrap();
    let expected = correction() * Point3::new(200.0, 200.0, 0.0);
    // Half of the last decimal in each coordinate, once.
    assert!(near(&end, &expected, 1e-3), "{end} {expected}");
}
