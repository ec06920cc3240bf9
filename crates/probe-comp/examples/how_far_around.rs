//! How far around a place to touch for its normal: how far the contact found lies beside the true
//! one along the surface, by method and by the radius ρ of the circle, without noise and by 1 µm
//! of it; and how good the radius is that is chosen from noise and curvature.

#![expect(clippy::print_stdout, reason = "the table is what the program is for")]

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use geometry::{Nurbs, Polynomial};
use nalgebra::{Point3, Vector3};
use probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate, micro_radius};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const TIP_MM: f64 = 3.0;
const SIGMA_MM: f64 = 1e-3;
/// A root mean square of so many pairs is known to 2.5 %.
const DRAWS: u32 = 400;
/// Away from every symmetry.
const AT: [f64; 2] = [1.7, -2.3];
const RADII_MM: [f64; 4] = [0.05, 0.1, 0.2, 0.5];
/// Between which a machine can be told to touch around a place.
const RANGE_MM: [f64; 2] = [0.05, 5.0];

/// Touches around a place, and how they are used.
#[derive(Clone, Copy)]
enum Method {
    /// So many on the circle.
    Circle(u32, NormalSource),
    /// A scan of 5 × 5 places, ρ apart.
    Scan,
}

const METHODS: [Method; 4] = [
    Method::Circle(3, NormalSource::MicroPlane),
    Method::Circle(4, NormalSource::MicroPlane),
    Method::Circle(6, NormalSource::Quadric),
    Method::Scan,
];

/// A part over xy: its height with both slopes, and as the crate takes it.
struct Part {
    name: &'static str,
    height: Box<dyn Fn(f64, f64) -> [f64; 3]>,
    nominal: Nominal,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| surface | ρ mm | three | four | quadric of six | surface fit |");
    println!("|---|---|---|---|---|---|");
    let parts = parts()?;
    for part in &parts {
        let difference = offset_difference(part)?;
        for rho in RADII_MM {
            let cells: Vec<[f64; 2]> = METHODS
                .iter()
                .map(|&method| Ok([bias_um(part, method, rho)?, noise_um(part, method, rho)?]))
                .collect::<Result<_, Box<dyn Error>>>()?;
            let text: Vec<String> = cells.iter().map(|[b, n]| format!("{b:.2} / {n:.1}")).collect();
            println!("| {} | {rho} | {} |", part.name, text.join(" | "));
            // Three touches are off by r ρ |κ1' − κ2'|/4, the others by what the curvatures change
            // by; over the scan, which reaches twice as far, that is four times as much.
            let three_um = 1e3 * 0.25 * TIP_MM * rho * difference;
            assert!((cells[0][0] / three_um - 1.0).abs() < 0.05, "{three_um} {cells:?}");
            let mut shares = cells[1..].iter().zip([0.02, 0.02, 0.08]);
            assert!(shares.all(|([bias, _], share)| *bias < share * three_um));
            let expected_um = 1e3 * TIP_MM * (4.0_f64 / 3.0).sqrt() * SIGMA_MM / rho;
            assert!((cells[0][1] / expected_um - 1.0).abs() < 0.1, "{expected_um} {cells:?}");
        }
    }
    parts.iter().try_for_each(chosen)
}

/// The radius chosen for three touches beside the best of a fine grid.
fn chosen(part: &Part) -> Result<(), Box<dyn Error>> {
    let curvatures = part.nominal.curvatures_per_mm(&point(part, contact(part, AT)))?;
    let radius = micro_radius(TIP_MM, SIGMA_MM, curvatures, RANGE_MM)?;
    let error_um = |rho: f64| -> Result<f64, Box<dyn Error>> {
        Ok(bias_um(part, METHODS[0], rho)?.hypot(noise_um(part, METHODS[0], rho)?))
    };
    let step = |i: i32| RANGE_MM[0] * (RANGE_MM[1] / RANGE_MM[0]).powf(f64::from(i) / 60.0);
    let mut best = (f64::NAN, f64::INFINITY);
    for rho in (0..=60).map(step) {
        let error = error_um(rho)?;
        if error < best.1 {
            best = (rho, error);
        }
    }
    let found = error_um(radius.radius_mm)?;
    println!(
        "{}: chosen ρ = {:.2} mm, off by {found:.2} µm; best ρ = {:.2} mm, {:.2} µm",
        part.name, radius.radius_mm, best.0, best.1
    );
    assert!(found <= 1.2 * best.1);
    Ok(())
}

fn parts() -> Result<[Part; 3], Box<dyn Error>> {
    let by_terms = |terms: &[(usize, usize, f64)]| -> Result<Nominal, Box<dyn Error>> {
        Ok(Nominal::new(Arc::new(Polynomial::new(1.0, terms.iter().copied())?), Side::Along))
    };
    let cylinder = Part {
        name: "cylinder, R = 50 mm, hump",
        height: Box::new(|x, _| [-0.01 * x * x, -0.02 * x, 0.0]),
        nominal: by_terms(&[(2, 0, -0.01)])?,
    };
    let saddle = Part {
        name: "saddle, R = ±50 mm",
        height: Box::new(|x, y| [0.01 * (y * y - x * x), -0.02 * x, 0.02 * y]),
        nominal: by_terms(&[(2, 0, -0.01), (0, 2, 0.01)])?,
    };
    let nurbs = Arc::new(freeform()?);
    let shown = Arc::clone(&nurbs);
    let height = move |x: f64, y: f64| {
        let [u, v] = [(x + 20.0) / 10.0, (y + 20.0) / 10.0];
        let jet = shown.jet(u, v).expect("the place is on the part");
        [jet.point_mm.z, jet.tangents_mm[0].z / 10.0, jet.tangents_mm[1].z / 10.0]
    };
    let nominal = Nominal::new(nurbs, Side::Along);
    Ok([cylinder, saddle, Part { name: "freeform, NURBS", height: Box::new(height), nominal }])
}

/// A bicubic spline over 40 × 40 mm whose control points stand over the means of their knots, so
/// that u and v run evenly with x and y.
fn freeform() -> Result<Nurbs, Box<dyn Error>> {
    let knots = Nurbs::clamped_knots(3, 7);
    let place = |i: usize| 10.0 * knots[i + 1..=i + 3].iter().sum::<f64>() / 3.0 - 20.0;
    let control = |(i, j): (usize, usize)| {
        let (x, y) = (place(i), place(j));
        Point3::new(x, y, 0.9 * (0.13 * x + 0.4).sin() - 1.2 * (0.11 * y - 0.05 * x).cos())
    };
    let points: Vec<Point3<f64>> =
        (0..7).flat_map(|j| (0..7).map(move |i| (i, j))).map(control).collect();
    let weights = vec![1.0; points.len()];
    Ok(Nurbs::new([3, 3], [knots.clone(), knots], &points, &weights)?)
}

/// Difference of the principal curvatures of the surface on which the balls' centres lie.
fn offset_difference(part: &Part) -> Result<f64, Box<dyn Error>> {
    let [major, minor] = part.nominal.curvatures_per_mm(&point(part, contact(part, AT)))?;
    let offset = |k: f64| k / (1.0 - TIP_MM * k);
    Ok(offset(major) - offset(minor))
}

/// Distance along the surface between the contact found without noise and the true one.
fn bias_um(part: &Part, method: Method, rho: f64) -> Result<f64, Box<dyn Error>> {
    let found = first_contact(part, method, &touches(part, method, rho))?.0;
    let at = contact(part, AT);
    let off = found - point(part, at);
    let normal = normal(part, at);
    Ok(1e3 * (off - normal * normal.dot(&off)).norm())
}

/// Root mean square of how far noise turns the ball's radius.
fn noise_um(part: &Part, method: Method, rho: f64) -> Result<f64, Box<dyn Error>> {
    let clean = touches(part, method, rho);
    let exact = first_contact(part, method, &clean)?.1;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut draw = || -> Vector3<f64> {
        Vector3::from_fn(|_, _| { let n: f64 = StandardNormal.sample(&mut rng); n } * SIGMA_MM)
    };
    let mut square = 0.0;
    for _ in 0..DRAWS {
        let mut noisy = clean.clone();
        for touch in &mut noisy {
            touch.center_mm += draw();
            touch.micro_mm.iter_mut().for_each(|p| *p += draw());
        }
        let turned = first_contact(part, method, &noisy)?.1 - exact;
        square += (TIP_MM * turned.norm()).powi(2);
    }
    Ok(1e3 * (square / f64::from(DRAWS)).sqrt())
}

/// Contact and normal of the ball in the middle, which comes first.
fn first_contact(
    part: &Part,
    method: Method,
    touches: &[BallTouch],
) -> Result<(Point3<f64>, Vector3<f64>), Box<dyn Error>> {
    let source = match method {
        Method::Circle(_, source) => source,
        Method::Scan => NormalSource::SurfaceFit,
    };
    let contact = compensate(&part.nominal, TIP_MM, touches, source)?.swap_remove(0);
    Ok((contact.point_mm, contact.normal.into_inner()))
}

fn touches(part: &Part, method: Method, rho: f64) -> Vec<BallTouch> {
    let at = |x: f64, y: f64| ball(part, [AT[0] + x, AT[1] + y]);
    let middle = BallTouch::new(at(0.0, 0.0), SIGMA_MM);
    match method {
        Method::Circle(n, _) => {
            let place = |k: u32| {
                let (sin, cos) = (0.4 + TAU * f64::from(k) / f64::from(n)).sin_cos();
                at(rho * cos, rho * sin)
            };
            vec![BallTouch { micro_mm: (0..n).map(place).collect(), ..middle }]
        }
        Method::Scan => {
            let steps = || (-2..=2).map(f64::from);
            let all = steps().flat_map(|i| steps().map(move |j| (rho * i, rho * j)));
            let others = all.filter(|(x, y)| *x != 0.0 || *y != 0.0);
            let others = others.map(|(x, y)| BallTouch::new(at(x, y), SIGMA_MM));
            [middle].into_iter().chain(others).collect()
        }
    }
}

/// Centre of a ball that is let down above a place until it touches.
fn ball(part: &Part, above: [f64; 2]) -> Point3<f64> {
    let at = contact(part, above);
    point(part, at) + normal(part, at) * TIP_MM
}

/// Where that ball touches.
fn contact(part: &Part, above: [f64; 2]) -> [f64; 2] {
    let mut at = above;
    for _ in 0..60 {
        let n = normal(part, at);
        at = [above[0] - TIP_MM * n.x, above[1] - TIP_MM * n.y];
    }
    at
}

fn point(part: &Part, [x, y]: [f64; 2]) -> Point3<f64> {
    Point3::new(x, y, (part.height)(x, y)[0])
}

fn normal(part: &Part, [x, y]: [f64; 2]) -> Vector3<f64> {
    let [_, slope_x, slope_y] = (part.height)(x, y);
    Vector3::new(-slope_x, -slope_y, 1.0).normalize()
}
