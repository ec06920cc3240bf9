//! The nearest points so far of queries that are answered together.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::Point3;

use super::build::LANES;
use super::found::NONE;

/// Error of a distance in single precision, of the largest coordinate or of the distance: three
/// roundings of each coordinate and of the sum, of 2^-24 each.
pub(super) const SINGLE_ERROR: f64 = 5e-7;

/// Distances in single precision, from the corner of all points: good enough to tell which point is
/// nearest, unless two are equally near but for rounding.
pub(super) struct Lanes {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    /// Squared distance of the nearest point so far.
    pub(super) best: [f32; LANES],
    /// The same of the second nearest.
    second: [f32; LANES],
    pub(super) slot: [u32; LANES],
    /// By how much distances are wrong, at most, and this share of them.
    pub(super) error_mm: f64,
}

impl Lanes {
    /// Lanes beyond the last query repeat it.
    #[inline(always)]
    pub(super) fn new(queries: &[Point3<f64>], corner: &[f64; 3], largest_mm: f64) -> Self {
        let last = queries.len() - 1;
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut size_mm = largest_mm;
        for lane in 0..LANES {
            let query = &queries[lane.min(last)];
            let at: [f64; 3] = std::array::from_fn(|k| query[k] - corner[k]);
            for value in at {
                size_mm = if value.abs() > size_mm { value.abs() } else { size_mm };
            }
            #[expect(clippy::cast_possible_truncation, reason = "the error is accounted for")]
            {
                (x[lane], y[lane], z[lane]) = (at[0] as f32, at[1] as f32, at[2] as f32);
            }
        }
        Self {
            x,
            y,
            z,
            best: [f32::INFINITY; LANES],
            second: [f32::INFINITY; LANES],
            slot: [NONE; LANES],
            error_mm: SINGLE_ERROR * size_mm + f64::from(f32::MIN_POSITIVE).sqrt(),
        }
    }

    /// Squared distance of the lane that has come least near.
    #[inline(always)]
    pub(super) fn worst(&self) -> f32 {
        let mut worst = self.best;
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                let (a, b) = (worst[lane], worst[lane + half]);
                worst[lane] = if a > b { a } else { b };
            }
            half /= 2;
        }
        worst[0]
    }

    /// Distance, at most.
    #[inline(always)]
    pub(super) fn distance_mm(&self, squared: f32) -> f64 {
        f64::from(squared).sqrt() * (1.0 + SINGLE_ERROR) + self.error_mm
    }

    #[inline(always)]
    pub(super) fn scan(&mut self, points: &[[f32; 3]], first_slot: usize) {
        #[expect(clippy::cast_possible_truncation, reason = "slots are below 2^32")]
        let mut slot = first_slot as u32;
        for &[px, py, pz] in points {
            // One operation on all lanes after the other, as registers have it.
            let mut distances = [0.0_f32; LANES];
            for (lane, distance) in distances.iter_mut().enumerate() {
                let (dx, dy, dz) = (px - self.x[lane], py - self.y[lane], pz - self.z[lane]);
                *distance = dx * dx + dy * dy + dz * dz;
            }
            for ((known, distance), best) in self.slot.iter_mut().zip(&distances).zip(&self.best) {
                *known = if distance < best { slot } else { *known };
            }
            for ((second, &distance), &best) in
                self.second.iter_mut().zip(&distances).zip(&self.best)
            {
                let loser = if distance > best { distance } else { best };
                *second = if loser < *second { loser } else { *second };
            }
            for (best, &distance) in self.best.iter_mut().zip(&distances) {
                *best = if distance < *best { distance } else { *best };
            }
            slot = slot.wrapping_add(1);
        }
    }

    /// Distances of the nearest and of the second nearest, if they tell which is which.
    #[inline(always)]
    pub(super) fn told_apart(&self, lane: usize) -> Option<(f64, f64)> {
        let [best, second] = [self.best, self.second].map(|d| f64::from(d[lane]).sqrt());
        let error_mm = 2.0 * (self.error_mm + SINGLE_ERROR * best);
        (second - second * SINGLE_ERROR > best + error_mm).then_some((best, second))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A distance errs by a share of itself and by what coordinates lose: both make a bound larger.
    #[test]
    fn a_distance_is_at_most_its_bound() {
        for size_mm in [0.0, 1.0, 1e3] {
            let lanes = Lanes::new(&[Point3::origin()], &[0.0; 3], size_mm);
            for squared in [1.0_f32, 4.0, 1e6] {
                // Roots that are exact.
                let least_mm = f64::from(squared.sqrt()) * (1.0 + SINGLE_ERROR);
                assert!(lanes.distance_mm(squared) >= least_mm + SINGLE_ERROR * size_mm);
            }
        }
    }
}
