//! Files for other programs.

use nalgebra::{Matrix6, Vector6};
use tracker_lm::{AxisError, AxisLetter, axis_errors_csv, heidenhain_table, linuxcnc_compensation};

fn errors(n: u32) -> Vec<AxisError> {
    // Measured downwards; files are ascending.
    (0..n)
        .rev()
        .map(|k| AxisError {
            angle_rad: f64::from(k).to_radians(),
            error: Vector6::new(1e-3, 2e-3, 3e-3, 4e-6, 1e-3_f64.to_radians(), 6e-6),
            covariance: Matrix6::identity() * 1e-12,
        })
        .collect()
}

#[test]
fn csv_has_the_names_of_iso_230() {
    let text = axis_errors_csv(AxisLetter::B, &errors(2));
    let mut lines = text.lines();
    let header = "angle_deg,EXB_mm,EYB_mm,EZB_mm,EAB_rad,EBB_rad,ECB_rad,std_EXB_mm,std_EYB_mm,\
                  std_EZB_mm,std_EAB_rad,std_EBB_rad,std_ECB_rad";
    assert_eq!(lines.next(), Some(header));
    let first: Vec<f64> = lines.next().unwrap().split(',').map(|v| v.parse().unwrap()).collect();
    assert_eq!(first[..4], [0.0, 1e-3, 2e-3, 3e-3]);
    assert_eq!(first[7..], [1e-6; 6]);
}

#[test]
fn linuxcnc_reads_ascending_triplets() {
    let reversal = Vector6::new(0.0, 0.0, 0.0, 0.0, 4e-4_f64.to_radians(), 0.0);
    let text = linuxcnc_compensation(AxisLetter::B, &errors(3), &reversal);
    assert_eq!(text.lines().next(), Some("0.000000000 0.001200000 0.000800000"));
    assert_eq!(text.lines().last(), Some("2.000000000 2.001200000 2.000800000"));
    let many = linuxcnc_compensation(AxisLetter::B, &errors(721), &reversal);
    assert!(many.lines().count() <= 256);
    assert!(many.lines().last().unwrap().starts_with("720.000000000 "));
}

#[test]
fn heidenhain_tables_have_a_frame() {
    let text = heidenhain_table(AxisLetter::C, &errors(2));
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("; ") && lines[0].contains("no control takes this file"));
    assert_eq!(lines[1], "BEGIN ERRORS_C.TAB MM");
    assert!(lines[2].starts_with("NR") && lines[2].ends_with("ECC"));
    let row: Vec<&str> = lines[4].split_whitespace().collect();
    assert_eq!(row[..3], ["1", "+1.000000", "+0.001000"]);
    assert_eq!(lines.last(), Some(&"[END]"));
}
