//! Calibrates the markers of a body from pictures of it in many positions: the markers are what
//! all pictures share, each picture has a position and an angle of its own, and in some of them
//! a marker is hidden.

#![expect(clippy::print_stdout, reason = "the output of an example")]

use least_squares::{
    AsDense, BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, Pattern, SolveError,
    bordered_covariance, check_jacobian, solve_bordered,
};

const SIGMA_MM: f64 = 0.01;
const MARKERS: usize = 4;
/// Where the markers are on the body.
const TRUTH_MM: [[f64; 2]; MARKERS] = [[0.0, 0.0], [80.0, 0.0], [75.0, 60.0], [-10.0, 50.0]];

/// Marker positions in the plane of the picture; none where hidden.
struct Pictures {
    seen_mm: Vec<[Option<[f64; 2]>; MARKERS]>,
    patterns: Vec<Pattern>,
}

impl Pictures {
    fn new(seen_mm: Vec<[Option<[f64; 2]>; MARKERS]>) -> Self {
        // Two rows per marker: both depend on position and angle, and on that marker.
        let mut pattern = Pattern::new();
        for row in 0..2 * MARKERS {
            let marker = 2 * (row / 2);
            pattern.push(&[0, 1, 2], &[marker, marker + 1]);
        }
        Self { seen_mm, patterns: vec![pattern] }
    }
}

impl BorderedProblem for Pictures {
    fn shared_dim(&self) -> usize {
        2 * MARKERS
    }

    fn block_dim(&self) -> usize {
        3
    }

    fn block_count(&self) -> usize {
        self.seen_mm.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn observed_count(&self, block: usize) -> usize {
        2 * self.seen_mm[block].iter().flatten().count()
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let (sin, cos) = point[2].sin_cos();
        for (m, seen) in self.seen_mm[block].iter().enumerate() {
            let (x, y) = (shared[2 * m], shared[2 * m + 1]);
            let [u, v] = seen.unwrap_or_default();
            let present = f64::from(u8::from(seen.is_some()));
            out[2 * m] = present * (point[0] + cos * x - sin * y - u) / SIGMA_MM;
            out[2 * m + 1] = present * (point[1] + sin * x + cos * y - v) / SIGMA_MM;
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        self.residuals(block, shared, point, rows.residuals);
        let (sin, cos) = point[2].sin_cos();
        for (m, seen) in self.seen_mm[block].iter().enumerate() {
            let (x, y) = (shared[2 * m], shared[2 * m + 1]);
            let weight = if seen.is_some() { 1.0 / SIGMA_MM } else { 0.0 };
            let own = [1.0, 0.0, -sin * x - cos * y, 0.0, 1.0, cos * x - sin * y];
            let of_marker = [cos, -sin, sin, cos];
            for (out, derivative) in rows.by_block[6 * m..].iter_mut().zip(own) {
                *out = weight * derivative;
            }
            for (out, derivative) in rows.by_shared[4 * m..].iter_mut().zip(of_marker) {
                *out = weight * derivative;
            }
        }
    }

    fn shared_name(&self, index: usize) -> String {
        format!("{} of marker {} [mm]", ["x", "y"][index % 2], index / 2)
    }

    fn block_name(&self, block: usize, index: usize) -> String {
        format!("{} of picture {block}", ["x [mm]", "y [mm]", "angle [rad]"][index])
    }
}

fn main() -> Result<(), SolveError<BorderedPoint>> {
    let pictures = Pictures::new((0..300).map(picture).collect());
    let shared = TRUTH_MM.concat().iter().map(|v| v + 0.5).collect();
    let blocks = (0..300).flat_map(|k| pose(k).map(|v| v + 0.01)).collect();
    let start = BorderedPoint { shared, blocks };

    let first = Pictures::new(pictures.seen_mm[..3].to_vec());
    let near = BorderedPoint { blocks: start.blocks[..9].to_vec(), ..start.clone() };
    let check = check_jacobian(&AsDense(&first), &near);
    assert!(check.worst_relative_error() < 1e-9, "{check}");

    // Nothing says where on the body its frame is.
    let refused = solve_bordered(&pictures, start.clone(), &BorderedOptions::default());
    let refused = refused.expect_err("the frame is free");
    println!("{refused}");
    assert!(
        matches!(&refused, SolveError::Unobservable { directions, .. } if directions.len() == 3)
    );

    // Marker 0 is its origin, and marker 1 lies on its x axis.
    let options = BorderedOptions { held_shared: vec![0, 1, 3], ..BorderedOptions::default() };
    let mut start = start;
    start.shared[..4].copy_from_slice(&[0.0, 0.0, 80.5, 0.0]);
    let fit = solve_bordered(&pictures, start, &options)?;
    println!("{}", fit.report);
    let covariance = bordered_covariance(&pictures, &fit.point, &options)?;
    for (i, truth) in TRUTH_MM.concat().iter().enumerate() {
        let sigma = covariance.shared()[(i, i)].sqrt();
        println!("{}: {:.4} ± {sigma:.4}", pictures.shared_name(i), fit.point.shared[i]);
        assert!((fit.point.shared[i] - truth).abs() <= 4.0 * sigma);
    }
    let leverages = covariance.leverages(10);
    println!("redundancy in picture 10: {:.2}", 1.0 - leverages[0]);
    Ok(())
}

fn pose(k: u32) -> [f64; 3] {
    let k = f64::from(k);
    [200.0 * (0.1 * k).cos(), 150.0 * (0.13 * k).sin(), 0.05 * k]
}

/// What the camera sees, with a small fixed error; every fifth picture misses a marker.
fn picture(k: u32) -> [Option<[f64; 2]>; MARKERS] {
    let [x, y, angle] = pose(k);
    let (sin, cos) = angle.sin_cos();
    std::array::from_fn(|m| {
        let error = |phase: f64| {
            let place = f64::from(k) * 12.9 + 7.7 * [0.0, 1.0, 2.0, 3.0][m] + phase;
            1.4 * SIGMA_MM * (place * place).sin()
        };
        let [u, v] = TRUTH_MM[m];
        let seen = [x + cos * u - sin * v + error(0.0), y + sin * u + cos * v + error(0.5)];
        (!k.is_multiple_of(5) || m != 2).then_some(seen)
    })
}
