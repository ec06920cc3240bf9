//! The B axis of a swivel head: a tracer on the table at six places follows four reflectors
//! through 25 angles. The reflectors are known to 0.3 mm, the table's positions to 4 µm; the
//! head is displaced by 8 µm against its drawing.
//!
//! `cargo run -p tracker-lm --example swivel_head`

use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use tracker_lm::{
    AxisLetter, Mount, Noise, Options, Range, RotaryAxis, Station, Step, Survey, calibrate,
    linuxcnc_compensation,
};

const STATIONS_MM: [[f64; 3]; 6] = [
    [-360.0, -330.0, -700.0],
    [350.0, -320.0, -650.0],
    [-290.0, 330.0, -690.0],
    [300.0, 310.0, -340.0],
    [-320.0, -300.0, -280.0],
    [330.0, -290.0, -330.0],
];
const MOUNTS_MM: [[f64; 3]; 4] =
    [[0.0, -60.0, -150.0], [172.0, 70.0, -120.0], [-138.0, 40.0, -116.0], [65.0, -20.0, -241.0]];

fn main() -> Result<(), tracker_lm::TrackerError> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise =
        |size: f64| size * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng);
    let axis = RotaryAxis::new(AxisLetter::B, Point3::origin(), Vector3::y())?;
    let displaced = Vector3::new(0.008, 0.0, 0.0);
    let steps: Vec<Step> = (0..25)
        .map(|k| Step {
            name: format!("{k}"),
            angle_rad: (7.5 * f64::from(k) - 90.0).to_radians(),
            approach: None,
        })
        .collect();
    let mut ranges = Vec::new();
    for (step, stop) in steps.iter().enumerate() {
        let rotation = axis.rotation(stop.angle_rad);
        for (mount, t) in MOUNTS_MM.iter().enumerate() {
            // The real axis stands 8 µm beside the nominal one.
            let target = displaced + rotation * (Vector3::from(*t) - displaced);
            for (station, s) in STATIONS_MM.iter().enumerate() {
                let path = (target - Vector3::from(*s)).norm();
                let displacement_mm = path - 80.0 + noise(5e-4);
                ranges.push(Range { station, mount, step, displacement_mm });
            }
        }
    }
    let mut near = |places: &[[f64; 3]], off: f64| -> Vec<Point3<f64>> {
        places.iter().map(|p| Point3::from(*p).map(|v| v + noise(off))).collect()
    };
    let station =
        |(i, nominal_mm): (usize, Point3<f64>)| Station { name: format!("S{i}"), nominal_mm };
    let mount = |(j, nominal_mm): (usize, Point3<f64>)| Mount { name: format!("R{j}"), nominal_mm };
    let stations = near(&STATIONS_MM, 0.004).into_iter().enumerate().map(station).collect();
    let mounts = near(&MOUNTS_MM, 0.3).into_iter().enumerate().map(mount).collect();
    let noise = Noise { displacement_mm: Some(5e-4), station_mm: Some(0.004), ..Noise::default() };
    let options = Options { noise, ..Options::default() };
    let found =
        calibrate(&Survey { axis, second: None, stations, mounts, steps, ranges }, &options)?;

    let location = found.location.as_ref().expect("half a turn shows the axis");
    let sigma_mm = location.covariance[(0, 0)].sqrt();
    assert!((location.errors[0] - 0.008).abs() < 3.0 * sigma_mm && sigma_mm < 0.004);
    assert!((found.rms_mm() / 5e-4 - 1.0).abs() < 0.2);
    let file =
        linuxcnc_compensation(AxisLetter::B, &found.axis_errors, &nalgebra::Vector6::zeros());
    assert!(file.starts_with("-90.000000000 -90.000000000 -90.000000000\n"));
    Ok(())
}
