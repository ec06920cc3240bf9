//! Many samples at once against the same samples one by one.

use ft_center::{
    FtCenterError, OrbitOptions, Sample, WrenchArrays, center_of_pressure, centers_into,
    solve_batch, solve_orbit,
};
use nalgebra::Point2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulator::{CONTACT, Colour, Head, Z0_MM, record};

const CENTER: Point2<f64> = Point2::new(12.0, -7.0);
const GATE_N: f64 = 5.0;

struct Columns([Vec<f64>; 6]);

impl Columns {
    fn of(record: &[Sample]) -> Self {
        let column = |k: usize| record.iter().map(|s| s.wrench.to_vector()[k]).collect();
        Self([column(0), column(1), column(2), column(3), column(4), column(5)])
    }

    fn arrays(&self) -> WrenchArrays<'_> {
        let [fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm] = &self.0;
        WrenchArrays { fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm }
    }
}

fn columns(samples: usize, seed: u64) -> (Vec<Sample>, Columns) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let head = Head { wobble_mm: 0.0, ..Head::default() };
    let mut record = record(CENTER, &head, &Colour::WHITE, samples, 100.0, &mut rng);
    for s in record.iter_mut().skip(100).step_by(7) {
        s.wrench.force_n.z *= 0.01;
    }
    let columns = Columns::of(&record);
    (record, columns)
}

#[test]
fn it_is_the_orbit_without_spin() {
    for samples in [150, 1000, 4099] {
        let (record, columns) = columns(samples, 1);
        let batch = solve_batch(&columns.arrays(), Z0_MM, GATE_N).unwrap();
        let orbit = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap();
        assert!(orbit.wobble.is_none());
        // Sums of 4e3 terms in another order: 30 mm · 2⁻⁵² · 60.
        assert!((batch.center_mm - orbit.center_mm).norm() < 1e-12);
        assert_eq!(batch.contact_samples, orbit.contact_samples);
        let force = batch.mean_wrench.force_n - orbit.mean_wrench.force_n;
        assert!(force.norm() < 1e-11);
        assert!((batch.free_moment_nmm - orbit.free_moment_nmm).abs() < 1e-9);
        assert!((batch.mean_wrench.torque_nmm - orbit.mean_wrench.torque_nmm).norm() < 1e-9);
    }
}

#[test]
fn batch_means_tell_white_noise() {
    let (record, columns) = columns(20_000, 2);
    let batch = solve_batch(&columns.arrays(), Z0_MM, GATE_N).unwrap();
    let orbit = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap();
    let white = orbit.scatter_mm2 / orbit.contact_samples as f64;
    assert_eq!(batch.degrees_of_freedom, 63);
    // A variance of 63 degrees of freedom has a standard deviation of 18 %; 4 of them.
    for axis in 0..2 {
        let ratio = batch.covariance_mm2[(axis, axis)] / white[(axis, axis)];
        assert!((ratio - 1.0).abs() < 0.72, "{ratio}");
    }
}

#[test]
fn every_sample_is_that_of_the_formula() {
    let (record, columns) = columns(1003, 3);
    let (mut x, mut y) = (vec![0.0; 1003], vec![0.0; 1003]);
    centers_into(&columns.arrays(), Z0_MM, GATE_N, &mut x, &mut y).unwrap();
    for (i, s) in record.iter().enumerate() {
        match center_of_pressure(&s.wrench, Z0_MM, GATE_N) {
            Ok(p) => {
                // One multiplication by a reciprocal: 2⁻⁵² · 30 mm · 3.
                assert!((p.position_mm - Point2::new(x[i], y[i])).norm() < 2e-14);
            }
            Err(_) => assert!(x[i].is_nan() && y[i].is_nan()),
        }
    }
}

#[test]
fn what_cannot_be_used_is_an_error() {
    let (_, mut columns) = columns(1000, 4);
    let mut short = columns.arrays();
    short.my_nmm = &short.my_nmm[1..];
    let error = solve_batch(&short, Z0_MM, GATE_N).unwrap_err();
    assert_eq!(
        error,
        FtCenterError::UnequalLengths { lengths: vec![1000, 1000, 1000, 1000, 999, 1000] }
    );
    let error = centers_into(&columns.arrays(), Z0_MM, GATE_N, &mut [], &mut []).unwrap_err();
    assert!(matches!(error, FtCenterError::UnequalLengths { .. }));
    let none = solve_batch(&columns.arrays(), Z0_MM, 1e4).unwrap_err();
    assert!(matches!(none, FtCenterError::TooFewContactSamples { contact: 0, given: 1000, .. }));
    let empty =
        WrenchArrays { fx_n: &[], fy_n: &[], fz_n: &[], mx_nmm: &[], my_nmm: &[], mz_nmm: &[] };
    let none = solve_batch(&empty, Z0_MM, GATE_N).unwrap_err();
    assert!(matches!(none, FtCenterError::TooFewContactSamples { contact: 0, given: 0, .. }));
    columns.0[5][321] = f64::NAN;
    let error = solve_batch(&columns.arrays(), Z0_MM, GATE_N).unwrap_err();
    assert_eq!(error, FtCenterError::NotFinite { index: 321 });
    columns.0[5][321] = 0.0;
    for fz in columns.0[2].iter_mut().step_by(3) {
        *fz = -*fz;
    }
    let error = solve_batch(&columns.arrays(), Z0_MM, GATE_N).unwrap_err();
    assert!(matches!(error, FtCenterError::MixedSign { .. }));
}
