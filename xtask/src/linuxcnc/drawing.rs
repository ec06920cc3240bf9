//! What stands on the table, as it is drawn.

use std::f64::consts::TAU;

use super::touch::{Touch, at, dot, unit};

/// Reference sphere: radius and declared centre.
pub(super) const SPHERE_MM: f64 = 12.5;
pub(super) const SPHERE_CENTER_MM: [f64; 3] = [-120.0, 0.0, 0.0];
/// Radius that the ball is sold with.
pub(super) const BALL_MM: f64 = 3.0;
/// Lengths by which the part's polynomial counts.
pub(super) const UNIT_MM: f64 = 40.0;
/// The part: z = Σ a (x/40)^i (y/40)^j over |x| < 38, |y| < 28.
pub(super) const TERMS: [(i32, i32, f64); 6] =
    [(2, 0, -6.0), (0, 2, -8.0), (1, 1, 2.0), (3, 0, 1.5), (0, 3, -1.0), (2, 1, 1.2)];
/// Half of the region that is touched.
pub(super) const HALF_MM: [f64; 2] = [36.0, 26.0];
/// Golden angle: places spread evenly over a disk or sphere.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// Touches of the upper part of the sphere, from 20° above its equator, spread by the golden angle;
/// `lean_rad` is the angle between approach and normal, its direction turning on, `shift` takes other
/// places.
pub(super) fn sphere_touches(
    count: u32,
    feeds: &[f64],
    lean_rad: &[f64],
    shift: f64,
) -> Vec<Touch> {
    let lowest = 20.0_f64.to_radians().sin();
    (0..count)
        .map(|n| {
            let share = (f64::from(n) + 0.5) / f64::from(count);
            let up = lowest + (1.0 - lowest) * share;
            let (sin, cos) = (GOLDEN_RAD * f64::from(n) + shift).sin_cos();
            let side = (1.0 - up * up).sqrt();
            let normal = [side * cos, side * sin, up];
            let contact = at(SPHERE_CENTER_MM, normal, SPHERE_MM);
            let index = n as usize;
            let mut touch =
                Touch::along_the_normal(contact, normal, BALL_MM, feeds[index % feeds.len()]);
            let lean = lean_rad[index % lean_rad.len()];
            let (first, second) = across(normal);
            let (sin_way, cos_way) = (TAU * share * 3.0).sin_cos();
            let (sin_lean, cos_lean) = lean.sin_cos();
            touch.way = unit(std::array::from_fn(|k| {
                sin_lean * (cos_way * first[k] + sin_way * second[k]) - cos_lean * normal[k]
            }));
            touch
        })
        .collect()
}

/// Two directions at right angles to one.
fn across(n: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let helper = if n[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let along = dot(helper, n);
    let first = unit(std::array::from_fn(|k| helper[k] - along * n[k]));
    let second = [
        n[1] * first[2] - n[2] * first[1],
        n[2] * first[0] - n[0] * first[2],
        n[0] * first[1] - n[1] * first[0],
    ];
    (first, second)
}

/// Contact and normal of the part at x and y.
fn part_at([x, y]: [f64; 2]) -> ([f64; 3], [f64; 3]) {
    let (u, v) = (x / UNIT_MM, y / UNIT_MM);
    let (mut z, mut by_x, mut by_y) = (0.0, 0.0, 0.0);
    for (i, j, a) in TERMS {
        z += a * u.powi(i) * v.powi(j);
        by_x += a * f64::from(i) * u.powi((i - 1).max(0)) * v.powi(j) / UNIT_MM;
        by_y += a * f64::from(j) * u.powi(i) * v.powi((j - 1).max(0)) / UNIT_MM;
    }
    ([x, y, z], unit([-by_x, -by_y, 1.0]))
}

/// Touches of the part along its normal on an even grid; `inset` keeps a share of the region's half
/// away from its sides.
pub(super) fn part_touches(
    columns: u32,
    rows: u32,
    inset: f64,
    radius_mm: f64,
    feed: f64,
) -> Vec<Touch> {
    let place = |n: u32, of: u32, half: f64| {
        let share = if of > 1 { f64::from(n) / f64::from(of - 1) } else { 0.5 };
        half * (1.0 - inset) * (2.0 * share - 1.0)
    };
    let pairs = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    pairs
        .map(|(column, row)| {
            let (contact, normal) =
                part_at([place(column, columns, HALF_MM[0]), place(row, rows, HALF_MM[1])]);
            Touch::along_the_normal(contact, normal, radius_mm, feed)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_of_the_part_is_that_of_its_heights() {
        const STEP_MM: f64 = 1e-4;
        // Third derivatives below 1e-3 per mm², and 1e-16 · 10 mm over the step.
        const SLOPE_TOL: f64 = 1e-9;
        for place in [[0.0, 0.0], [31.0, -22.0], [-17.0, 9.0]] {
            let (_, normal) = part_at(place);
            for axis in 0..2 {
                let height = |way: f64| {
                    let mut moved = place;
                    moved[axis] += way;
                    part_at(moved).0[2]
                };
                let slope = (height(STEP_MM) - height(-STEP_MM)) / (2.0 * STEP_MM);
                assert!((slope + normal[axis] / normal[2]).abs() < SLOPE_TOL, "{place:?}");
            }
        }
    }

    #[test]
    fn touches_lean_by_what_is_asked() {
        for touch in sphere_touches(9, &[60.0], &[0.5], 0.1) {
            let out = unit(at(touch.ball_mm, SPHERE_CENTER_MM, -1.0));
            // Rounding of unit vectors.
            assert!((dot(touch.way, out) + 0.5_f64.cos()).abs() < 1e-12);
        }
    }
}
