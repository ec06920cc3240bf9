//! Surveys a machine with a tracker whose scale is off by 80 ppm, writes the survey as a case
//! folder, and lets the loop find what the rigid transform is missing.
//!
//! Run with `cargo run --example close_the_loop`.

#![expect(clippy::print_stdout, reason = "the output of an example")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use truing::{close_loop, read_case};

/// What the loop has to find.
const SCALE_ERROR: f64 = 80e-6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::temp_dir().join(format!("truing-example-{}", std::process::id()));
    write_case(&folder)?;
    let case = read_case(&folder)?;
    let closed = close_loop(&case)?;
    fs::remove_dir_all(&folder)?;

    println!("{closed}");
    let step = closed.steps.first().ok_or("nothing was added")?;
    assert_eq!(step.effect, "scale");
    let found = &step.parameters[0];
    let error_ppm = (found.value - 1e6 * SCALE_ERROR).abs();
    assert!(error_ppm < 4.0 * found.std, "{} ± {} {}", found.value, found.std, found.unit);
    assert!(closed.after.held_out_rms < 0.5 * closed.before.held_out_rms);
    Ok(())
}

/// Twenty-seven points of a cube of one metre, seen by a tracker in another place.
fn write_case(folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("case.toml"), "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.003\n")?;
    let mut pairs = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n".to_owned();
    let (sin, cos) = 0.4_f64.sin_cos();
    for point in 0..27_i32 {
        let [x, y, z] = [point % 3, point / 3 % 3, point / 9].map(|i| 500.0 * f64::from(i));
        let seen = [cos * x - sin * y, sin * x + cos * y, z].map(|c| c * (1.0 + SCALE_ERROR));
        // Noise that is the same in every run: the fractional parts of multiples of √2, √3, √5,
        // spread evenly over ± 5 µm.
        let noise = [2.0_f64, 3.0, 5.0].map(|n| {
            let even = (f64::from(point + 1) * n.sqrt()).fract();
            0.005 * (2.0 * even - 1.0)
        });
        let [u, v, w] = [0, 1, 2].map(|i| seen[i] + noise[i] + 100.0);
        writeln!(pairs, "P{point},{x},{y},{z},{u:.4},{v:.4},{w:.4}")
            .expect("a String takes any text");
    }
    fs::write(folder.join("pairs.csv"), pairs)
}
