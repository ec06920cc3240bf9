//! The touches nearest to each other, for a surface through all of them.

use std::collections::HashMap;

use nalgebra::Point3;

/// Touches of a cell on average, where they lie on a surface.
const PER_CELL: f64 = 4.0;

/// Balls' centres sorted into cubes.
pub(crate) struct Nearest<'a> {
    centers: &'a [Point3<f64>],
    edge_mm: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Nearest<'a> {
    pub(crate) fn new(centers: &'a [Point3<f64>]) -> Self {
        let range = |axis: usize| {
            let of = centers.iter().map(|p| p[axis]);
            let (low, high) = of.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            (high - low).max(0.0)
        };
        let mut sides = [range(0), range(1), range(2)];
        sides.sort_by(f64::total_cmp);
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = centers.len().max(1) as f64;
        // The two longer sides span the surface; a scan along a line has only one.
        let by_area = (PER_CELL * sides[2] * sides[1] / n).sqrt();
        let edge_mm = by_area.max(PER_CELL * sides[2] / n).max(f64::MIN_POSITIVE);
        let mut all = Self { centers, edge_mm, cells: HashMap::new() };
        for (index, center) in (0_u32..).zip(centers) {
            let cell = all.cell(center);
            all.cells.entry(cell).or_default().push(index);
        }
        all
    }

    fn cell(&self, at: &Point3<f64>) -> [i64; 3] {
        #[expect(clippy::cast_possible_truncation, reason = "coordinates over the edge of a cell")]
        let index = |v: f64| (v / self.edge_mm).floor() as i64;
        [index(at.x), index(at.y), index(at.z)]
    }

    /// The `count` touches nearest to one, itself left out; fewer where there are no more.
    pub(crate) fn around(&self, index: usize, count: usize) -> Vec<Point3<f64>> {
        let at = self.centers[index];
        let home = self.cell(&at);
        let wanted = count.min(self.centers.len().saturating_sub(1));
        let mut reach = 1_i64;
        loop {
            let mut found: Vec<(f64, u32)> = Vec::new();
            for x in -reach..=reach {
                for y in -reach..=reach {
                    for z in -reach..=reach {
                        let cell = [home[0] + x, home[1] + y, home[2] + z];
                        for &other in self.cells.get(&cell).into_iter().flatten() {
                            if other as usize != index {
                                let far = (self.centers[other as usize] - at).norm();
                                found.push((far, other));
                            }
                        }
                    }
                }
            }
            found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            found.truncate(wanted);
            // What is further than the cubes reach may be nearer than what lies in their corners.
            #[expect(clippy::cast_precision_loss, reason = "a few cells")]
            let sure_mm = reach as f64 * self.edge_mm;
            let complete = found.len() == wanted && found.last().is_none_or(|l| l.0 <= sure_mm);
            if complete || reach > MAX_REACH {
                return found.iter().map(|(_, i)| self.centers[*i as usize]).collect();
            }
            reach *= 2;
        }
    }
}

/// Cells each way after which a touch counts as alone.
const MAX_REACH: i64 = 32;
