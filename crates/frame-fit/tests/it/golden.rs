//! Numbers that others have published.

use frame_fit::{
    Handedness, Noise, Options, PointPair, ReflectionVerdict, Transform, compare_transforms,
    fit_frame,
};
use nalgebra::{Matrix3, Point2, Point3};

/// Umeyama, IEEE PAMI 13 (1991) 376-380, the example at the end of section III: three points
/// that a reflection would map better. Three digits are printed. The mean squared error is that
/// of its equation 33 by hand: `σ_y² − tr(DS)²/σ_x²` = 10/9 − (10/9) c² = 0.533.
#[test]
fn umeyama_1991_example() {
    let pairs = [([0.0, 0.0], [0.0, 0.0]), ([1.0, 0.0], [-1.0, 0.0]), ([0.0, 2.0], [0.0, 2.0])]
        .map(|(source, target)| PointPair::isotropic(source, target, 0.1));
    let fit = fit_frame(&pairs, &Options::of(Transform::Similarity)).unwrap();
    let map = fit.target_from_source;
    let scale = map.linear.determinant().sqrt();
    assert!((scale - 0.721).abs() < 5e-4, "{scale}");
    let rotation = map.linear / scale;
    for (computed, printed) in rotation.iter().zip([0.832, -0.555, 0.555, 0.832]) {
        assert!((computed - printed).abs() < 5e-4, "{rotation}");
    }
    assert!((map.translation_mm.x + 0.800).abs() < 5e-4);
    assert!((map.translation_mm.y - 0.400).abs() < 5e-4);
    let by_hand = 10.0 / 9.0 * (1.0 - scale * scale);
    assert!((fit.rms_mm().powi(2) - by_hand).abs() < 1e-12, "{}", fit.rms_mm().powi(2));
    assert_eq!(fit.reflection.unwrap().verdict, ReflectionVerdict::Improper);
}

/// Document [D], Table 4: verification points, measured and computed z (mm). Row 1 of its last
/// column has the wrong sign; the differences are taken from z and zc.
const TABLE_4: [[f64; 4]; 8] = [
    [-527.552, -502.870, -283.091, -283.090],
    [-527.552, -446.301, -283.135, -283.138],
    [-513.414, -488.729, -284.398, -284.400],
    [-513.414, -460.444, -284.423, -284.423],
    [-485.130, -488.729, -284.494, -284.495],
    [-485.130, -460.444, -284.517, -284.518],
    [-470.983, -502.870, -283.277, -283.281],
    [-470.983, -446.301, -283.325, -283.327],
];

fn table_4() -> [PointPair<3>; 8] {
    TABLE_4.map(|[x, y, measured, computed]| {
        PointPair::isotropic([x, y, computed], [x, y, measured], 1e-3)
    })
}

/// The published residual: 2.12 µm rms, mean 1.5 µm.
#[test]
fn document_d_table_4() {
    let options = Options { noise: Noise::Estimated, ..Options::of(Transform::None) };
    let fit = fit_frame(&table_4(), &options).unwrap();
    assert!((fit.rms_mm() - 2.12e-3).abs() < 5e-6, "{}", fit.rms_mm());
    let mean = fit.residuals_mm.iter().map(|r| r.z).sum::<f64>() / 8.0;
    assert!((mean - 1.5e-3).abs() < 1e-9, "{mean}");
    // A translation takes the mean, a rigid motion what is left of a tilt: 1.03 µm, which is what
    // fitting the three parameters of a pose that move z gives.
    let shifted =
        fit_frame(&table_4(), &Options { transform: Transform::Translation, ..options }).unwrap();
    assert!((shifted.target_from_source.translation_mm.z - 1.5e-3).abs() < 1e-9);
    assert!((shifted.rms_mm() - 1.5e-3).abs() < 5e-6, "{}", shifted.rms_mm());
    let tests = compare_transforms(&table_4(), &options).unwrap();
    assert_eq!(tests[0].larger, Transform::Translation);
}

/// Document [A], equation 1.14: T = S P⁻¹ through three points is the affine fit, residual zero.
#[test]
fn document_a_equation_1_14_is_the_affine_fit() {
    let machine = [[12.0, 5.0], [63.0, 9.0], [31.0, 58.0]];
    let sensor = [[-28.1, -19.7], [22.9, -15.6], [-9.3, 33.2]];
    let homogeneous = |points: [[f64; 2]; 3]| {
        Matrix3::from_fn(|row, column| if row == 2 { 1.0 } else { points[column][row] })
    };
    let expected = homogeneous(sensor) * homogeneous(machine).try_inverse().unwrap();
    let pairs: Vec<_> = (0..3)
        .map(|k| PointPair::isotropic(Point2::from(machine[k]), Point2::from(sensor[k]), 0.05))
        .collect();
    let fit = fit_frame(&pairs, &Options::of(Transform::Affine)).unwrap();
    let rows = fit.target_from_source.homogeneous_rows();
    for row in 0..3 {
        for column in 0..3 {
            // Condition 100 of P, coordinates of 60 mm.
            assert!((rows[row][column] - expected[(row, column)]).abs() < 1e-11);
        }
    }
    assert_eq!((fit.degrees_of_freedom, fit.variance_factor), (0, None));
    // The rigid fit of the same points has three degrees of freedom to say what it misses.
    let rigid = fit_frame(&pairs, &Options::default()).unwrap();
    assert_eq!(rigid.degrees_of_freedom, 3);
    assert_eq!(rigid.handedness, Handedness::Proper);
}

/// ISO/IEC style hand computation: n equal readings give σ/√n of the mean.
#[test]
fn a_translation_is_a_mean() {
    let pairs: Vec<_> = (0..4)
        .map(|k| {
            let at = Point3::new(f64::from(k), 2.0, -1.0);
            PointPair::isotropic(at, at, 0.02)
        })
        .collect();
    let fit = fit_frame(&pairs, &Options::of(Transform::Translation)).unwrap();
    for sigma in fit.standard_uncertainties().unwrap().iter() {
        assert!((sigma - 0.01).abs() < 1e-15);
    }
}
