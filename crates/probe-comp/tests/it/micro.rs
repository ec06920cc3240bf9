//! Normals measured around a place: the table of docs/probe-comp.md.

use std::f64::consts::TAU;

use nalgebra::Point3;
use probe_comp::{BallTouch, Nominal, NormalSource, compensate, micro_radius};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene::{Height, TIP_MM, let_down, noise, normal_of, point_of, polynomials};

const SIGMA_MM: f64 = 1e-3;
/// The touch: away from every symmetry.
const AT: [f64; 2] = [1.7, -2.3];
/// Noise draws; a root mean square of 400 pairs is known to 2.5 %.
const DRAWS: u32 = 400;

/// A touch with `n` others on a circle of radius `rho`, the first at a turn that is not round.
fn around(height: Height, n: u32, rho: f64) -> BallTouch {
    let center = |x, y| let_down(height, x, y, TIP_MM);
    let place = |k: u32| -> Point3<f64> {
        let angle = 0.4 + TAU * f64::from(k) / f64::from(n);
        center(AT[0] + rho * angle.cos(), AT[1] + rho * angle.sin())
    };
    let micro_mm = (0..n).map(place).collect();
    BallTouch { micro_mm, ..BallTouch::new(center(AT[0], AT[1]), SIGMA_MM) }
}

/// Distance along the surface between the contact found and the true one.
fn tangential_mm(
    height: Height,
    nominal: &Nominal,
    touch: &BallTouch,
    source: NormalSource,
) -> f64 {
    let contact = &compensate(nominal, TIP_MM, std::slice::from_ref(touch), source).unwrap()[0];
    // The ball stands above the place; its contact is where the vertical distance is its radius.
    let (mut u, mut v) = (AT[0], AT[1]);
    for _ in 0..200 {
        let normal = normal_of(height, u, v);
        (u, v) = (AT[0] - TIP_MM * normal.x, AT[1] - TIP_MM * normal.y);
    }
    let off = contact.point_mm - point_of(height, u, v);
    let normal = normal_of(height, u, v);
    (off - normal * normal.dot(&off)).norm()
}

fn noise_mm(height: Height, nominal: &Nominal, clean: &BallTouch, source: NormalSource) -> f64 {
    let bias = |touch: &BallTouch| {
        compensate(nominal, TIP_MM, std::slice::from_ref(touch), source).unwrap()[0].normal
    };
    let clean_normal = bias(clean);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut sum = 0.0;
    for _ in 0..DRAWS {
        let mut touch = clean.clone();
        for p in &mut touch.micro_mm {
            *p += noise(SIGMA_MM, &mut rng);
        }
        sum += (TIP_MM * (bias(&touch).into_inner() - clean_normal.into_inner()).norm()).powi(2);
    }
    let _ = height;
    (sum / f64::from(DRAWS)).sqrt()
}

fn offset_difference(nominal: &Nominal, height: Height) -> ([f64; 2], f64) {
    let [major, minor] = nominal.curvatures_per_mm(&point_of(height, AT[0], AT[1])).unwrap();
    let offset = |k: f64| k / (1.0 - TIP_MM * k);
    ([major, minor], offset(major) - offset(minor))
}

#[test]
fn three_touches_are_off_by_the_difference_of_the_curvatures() {
    // The freeform's curvature changes by 2 % over the circle.
    const AGREE: f64 = 0.05;
    for (height, nominal) in polynomials() {
        let (_, difference) = offset_difference(&nominal, height);
        for rho in [0.05, 0.2, 0.5] {
            let touch = around(height, 3, rho);
            let found = tangential_mm(height, &nominal, &touch, NormalSource::MicroPlane);
            let expected = 0.25 * TIP_MM * rho * difference;
            assert!((found / expected - 1.0).abs() < AGREE, "ρ = {rho}: {found} {expected}");
        }
    }
}

/// At ρ = 0.5 mm: 7.1 µm on a cylinder of radius 50 mm, 15 µm on a saddle.
#[test]
fn more_touches_take_the_bias_away() {
    let expected_um = [7.1, 15.0];
    for ((height, nominal), three_um) in polynomials().into_iter().zip(expected_um) {
        let by = |n, source| 1e3 * tangential_mm(height, &nominal, &around(height, n, 0.5), source);
        let three = by(3, NormalSource::MicroPlane);
        assert!((three - three_um).abs() < 0.2, "{three}");
        for (n, source) in [
            (4, NormalSource::MicroPlane),
            (8, NormalSource::MicroPlane),
            (6, NormalSource::Quadric),
        ] {
            let found = by(n, source);
            assert!(found < 0.02 * three, "{n} {source:?}: {found} µm beside {three} µm");
        }
    }
}

/// A scan of places 0.5 mm apart: without noise the fitted surface is as good as a quadric around
/// each place; with it, 13 places 1 µm each over about a millimetre.
#[test]
fn a_surface_through_a_scan_needs_no_touches_around() {
    let scan = |height: Height, sigma_mm: f64| -> Vec<BallTouch> {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        (-8_i32..=8)
            .flat_map(|i| (-8_i32..=8).map(move |j| (f64::from(i), f64::from(j))))
            .map(|(i, j)| let_down(height, AT[0] + 0.5 * i, AT[1] + 0.5 * j, TIP_MM))
            .map(|center| BallTouch::new(center + noise(sigma_mm, &mut rng), SIGMA_MM))
            .collect()
    };
    for (height, nominal) in polynomials() {
        let clean = scan(height, 0.0);
        let middle = clean.len() / 2;
        let by = |touches: &[BallTouch]| {
            compensate(&nominal, TIP_MM, touches, NormalSource::SurfaceFit).unwrap()
        };
        let exact = by(&clean);
        let bias_um = 1e3 * TIP_MM * exact[middle].normal.angle(&exact[middle].nominal_normal);
        assert!(bias_um < 0.1, "{bias_um} µm");
        let noisy = by(&scan(height, SIGMA_MM));
        let inner = |contacts: &[probe_comp::Contact]| {
            let ok = |k: &usize| k % 17 > 1 && k % 17 < 15 && k / 17 > 1 && k / 17 < 15;
            let at = (0..contacts.len()).filter(ok).collect::<Vec<_>>();
            let square = at.iter().map(|&k| contacts[k].normal.angle(&exact[k].normal).powi(2));
            1e3 * TIP_MM
                * (square.sum::<f64>() / f64::from(u32::try_from(at.len()).unwrap())).sqrt()
        };
        let said = noisy[middle].sigma_tangential_mm().powi(2) - SIGMA_MM * SIGMA_MM;
        let said_um = 1e3 * (2.0 * said).sqrt();
        let found_um = inner(&noisy);
        // Neighbouring places share most of their touches: about 30 are independent.
        assert!((found_um / said_um - 1.0).abs() < 0.3, "{found_um} {said_um}");
        assert!(found_um < 3.0, "{found_um}");
    }
}

#[test]
fn noise_tilts_a_small_plane_more() {
    let (height, nominal) = polynomials()[1].clone();
    for (rho, expected_um) in [(0.05, 69.3), (0.5, 6.93)] {
        let touch = around(height, 3, rho);
        let found = 1e3 * noise_mm(height, &nominal, &touch, NormalSource::MicroPlane);
        assert!((found / expected_um - 1.0).abs() < 0.1, "ρ = {rho}: {found} µm");
        // What the crate says of its own uncertainty, per direction along the surface.
        let contact = &compensate(&nominal, TIP_MM, &[touch], NormalSource::MicroPlane).unwrap()[0];
        let own = contact.sigma_tangential_mm().powi(2) - SIGMA_MM * SIGMA_MM;
        let said_um = 1e3 * (2.0 * own).sqrt();
        assert!((said_um / found - 1.0).abs() < 0.1, "ρ = {rho}: {said_um} {found}");
    }
}

#[test]
fn the_radius_chosen_is_near_the_best() {
    const RANGE_MM: [f64; 2] = [0.05, 5.0];
    for (height, nominal) in polynomials() {
        for sigma_mm in [2e-4, 1e-3, 5e-3] {
            let (curvatures, _) = offset_difference(&nominal, height);
            let chosen = micro_radius(TIP_MM, sigma_mm, curvatures, RANGE_MM).unwrap();
            let error = |rho: f64| {
                let touch = around(height, 3, rho);
                let bias = tangential_mm(height, &nominal, &touch, NormalSource::MicroPlane);
                bias.hypot(TIP_MM * (4.0_f64 / 3.0).sqrt() * sigma_mm / rho)
            };
            let grid = (0..=60).map(|i| RANGE_MM[0] * 100f64.powf(f64::from(i) / 60.0));
            let best = grid.map(error).fold(f64::INFINITY, f64::min);
            let ratio = error(chosen.radius_mm) / best;
            assert!(ratio < 1.2, "σ = {sigma_mm}: {chosen:?} is {ratio} of the best");
            assert!(
                (chosen.bias_mm.hypot(chosen.noise_mm) / error(chosen.radius_mm) - 1.0).abs() < 0.2
            );
        }
    }
}

/// A ball's centre runs on a surface whose radii of curvature are shorter by its own; the best circle
/// is as wrong by their difference as by the noise.
#[test]
fn the_best_radius_is_that_of_the_formula() {
    // A dozen roundings.
    const TOL: f64 = 1e-14;
    for radii_mm in [[20.0, -35.0], [8.0, 15.0], [-12.0, -90.0]] {
        for sigma_mm in [2e-4, 5e-3] {
            let [a, b] = radii_mm.map(|radius_mm: f64| (radius_mm - TIP_MM).recip());
            let curvatures = radii_mm.map(f64::recip);
            let chosen = micro_radius(TIP_MM, sigma_mm, curvatures, [1e-6, 1e6]).unwrap();
            let rho_mm = chosen.radius_mm;
            let bias_mm = 0.25 * TIP_MM * rho_mm * (a - b).abs();
            let noise_mm = 2.0 * TIP_MM * sigma_mm / (3f64.sqrt() * rho_mm);
            for (found, expected) in
                [(chosen.bias_mm, bias_mm), (chosen.noise_mm, noise_mm), (bias_mm, noise_mm)]
            {
                assert!((found / expected - 1.0).abs() < TOL, "{chosen:?}: {found} {expected}");
            }
        }
    }
}
