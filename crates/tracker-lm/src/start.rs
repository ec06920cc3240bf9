//! Where the search starts: nominal positions, or stations resected from the ranges.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};

use crate::gauge::StationChart;
use crate::network::Network;

/// A start: places of stations and reflectors, and the dead paths that go with them, in mm.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) stations: Vec<Vector3<f64>>,
    pub(crate) mounts: Vec<Vector3<f64>>,
    pub(crate) dead_paths: Vec<f64>,
    /// Where the nominal axis and all on it are: not where the drawing has them, once the
    /// stations are given the gauge's frame.
    pub(crate) moved: Isometry3<f64>,
}

/// Gauss-Newton steps of a resection: from the closed form three reach rounding.
const POLISH: usize = 8;

impl Start {
    /// Everything where the drawing has it.
    pub(crate) fn nominal(network: &Network<'_>) -> Self {
        let stations = network.survey.stations.iter().map(|s| s.nominal_mm.coords).collect();
        Self::with_stations(network, stations)
    }

    /// Every station resected from its ranges to the nominal reflectors.
    ///
    /// Helps where the stations are known to metres at best and the reflectors to a millimetre.
    /// A station whose ranges do not show where it stood stays where the drawing has it.
    pub(crate) fn resected(network: &Network<'_>, chart: &StationChart) -> Self {
        let stations: Vec<Vector3<f64>> = (0..network.survey.stations.len())
            .map(|i| {
                let sights = Sights::of(network, i);
                let nominal = network.survey.stations[i].nominal_mm.coords;
                sights.resect(&nominal).unwrap_or(nominal)
            })
            .collect();
        let mut start = Self::with_stations(network, stations);
        if let Some(moved) = chart.alignment(&start.stations) {
            for station in &mut start.stations {
                *station = (moved * Point3::from(*station)).coords;
            }
            start.moved = moved;
        }
        start
    }

    fn with_stations(network: &Network<'_>, stations: Vec<Vector3<f64>>) -> Self {
        let survey = network.survey;
        let poses: Vec<_> = network.angle_of_step.iter().map(|&k| network.nominal(k)).collect();
        let mut sums = vec![(0.0, 0.0); network.dead_paths.len()];
        for range in &survey.ranges {
            let target = (poses[range.step] * survey.mounts[range.mount].nominal_mm).coords;
            let path = (target - stations[range.station]).norm();
            let sum = &mut sums[network.dead_path_of(range)];
            *sum = (sum.0 + path - range.displacement_mm, sum.1 + 1.0);
        }
        Self {
            stations,
            mounts: survey.mounts.iter().map(|m| m.nominal_mm.coords).collect(),
            dead_paths: sums.into_iter().map(|(sum, n)| sum / n).collect(),
            moved: Isometry3::identity(),
        }
    }

    /// Points of every step, mount by mount; the origin where one was not seen.
    pub(crate) fn points_mm(&self, network: &Network<'_>) -> Vec<Vec<Vector3<f64>>> {
        let step = |step: usize| {
            let pose = self.moved * network.nominal(network.angle_of_step[step]);
            let seen = network.mounts_at(step);
            let point = |(mount, place): (usize, &Vector3<f64>)| {
                let point = (pose * Point3::from(*place)).coords;
                if seen.contains(&mount) { point } else { Vector3::zeros() }
            };
            self.mounts.iter().enumerate().map(point).collect()
        };
        (0..network.survey.steps.len()).map(step).collect()
    }
}

fn target_mm(network: &Network<'_>, mount: usize, step: usize) -> Vector3<f64> {
    let pose = network.nominal(network.angle_of_step[step]);
    (pose * network.survey.mounts[mount].nominal_mm).coords
}

/// What one station saw of nominal targets as they turned about one axis, about its origin.
struct Sights {
    origin_mm: Vector3<f64>,
    axis: Vector3<f64>,
    /// Target, displacement, and which of the station's dead paths it has.
    seen: Vec<(Vector3<f64>, f64, usize)>,
    n_paths: usize,
    /// Mean height of the targets of each dead path along the axis.
    heights_mm: Vec<f64>,
}

impl Sights {
    fn of(network: &Network<'_>, station: usize) -> Self {
        let turning = network.carrier();
        let origin_mm = turning.origin_mm.coords;
        let axis = turning.direction.into_inner();
        let last = network.axis_count() - 1;
        let is_about_it = |step: usize| {
            let angle = network.angle_of_step[step];
            angle == 0 || network.angles[angle].axis == last
        };
        let mut paths: Vec<usize> = Vec::new();
        let mut seen = Vec::new();
        let own = network.survey.ranges.iter().filter(|r| r.station == station);
        for range in own.filter(|r| is_about_it(r.step)) {
            // Each mount is a circle of its own, whatever shares the dead path.
            let own = paths.iter().position(|&m| m == range.mount).unwrap_or_else(|| {
                paths.push(range.mount);
                paths.len() - 1
            });
            let target = target_mm(network, range.mount, range.step) - origin_mm;
            seen.push((target, range.displacement_mm, own));
        }
        let n_paths = paths.len();
        let mut sums = vec![(0.0, 0.0); n_paths];
        for (target, _, own) in &seen {
            sums[*own] = (sums[*own].0 + target.dot(&axis), sums[*own].1 + 1.0);
        }
        let heights_mm = sums.into_iter().map(|(sum, n)| sum / n).collect();
        Self { origin_mm, axis, seen, n_paths, heights_mm }
    }

    /// Position of the station, machine frame.
    fn resect(&self, nominal_mm: &Vector3<f64>) -> Option<Vector3<f64>> {
        let (across, paths, constants) = self.closed_form()?;
        let near = nominal_mm - self.origin_mm;
        let candidates = self.heights_of_station(across.norm_squared(), &paths, &constants);
        let polished = candidates
            .into_iter()
            .filter_map(|height| self.polish(across + self.axis * height, paths.clone()));
        // The mirror image across the plane of the circles fits nearly as well: the nominal
        // position decides between those that fit alike.
        let all: Vec<_> = polished.collect();
        let best = all.iter().map(|(_, rms)| *rms).reduce(f64::min)?;
        all.into_iter()
            .filter(|(_, rms)| *rms <= 2.0 * best)
            .map(|(at, _)| at)
            .reduce(|a, b| if (b - near).norm() < (a - near).norm() { b } else { a })
            .map(|at| at + self.origin_mm)
    }

    /// `|P|² − L² = 2 P·S + 2 L d + (d² − |S|²)` is linear in the station's place across the
    /// axis, the dead path of each circle, and one constant of each circle, which takes the share
    /// of the station's height.
    fn closed_form(&self) -> Option<(Vector3<f64>, Vec<f64>, Vec<f64>)> {
        let first = self.axis.cross(&Vector3::ith(self.axis.iamin(), 1.0)).normalize();
        let second = self.axis.cross(&first);
        let columns = 2 + 2 * self.n_paths;
        let mut design = DMatrix::zeros(self.seen.len(), columns);
        let mut right = DVector::zeros(self.seen.len());
        for (row, (target, displacement, own)) in self.seen.iter().enumerate() {
            design[(row, 0)] = 2.0 * target.dot(&first);
            design[(row, 1)] = 2.0 * target.dot(&second);
            design[(row, 2 + own)] = 2.0 * displacement;
            design[(row, 2 + self.n_paths + own)] = 1.0;
            right[row] = target.norm_squared() - displacement * displacement;
        }
        let x = least_squares(design, &right)?;
        let across = first * x[0] + second * x[1];
        let paths = x.rows(2, self.n_paths).iter().copied().collect();
        let constants = x.rows(2 + self.n_paths, self.n_paths).iter().copied().collect();
        Some((across, paths, constants))
    }

    /// Heights that `2 h s + d² − |S|²` of all circles allow.
    fn heights_of_station(&self, across2: f64, paths: &[f64], constants: &[f64]) -> Vec<f64> {
        #[expect(clippy::cast_precision_loss, reason = "a handful of reflectors")]
        let n = self.n_paths as f64;
        let rest: Vec<f64> =
            constants.iter().zip(paths).map(|(c, d)| c - d * d + across2).collect();
        let (mean_h, mean_rest) =
            (self.heights_mm.iter().sum::<f64>() / n, rest.iter().sum::<f64>() / n);
        let (mut slope, mut square) = (0.0, 0.0);
        for (h, r) in self.heights_mm.iter().zip(&rest) {
            slope += (h - mean_h) * (r - mean_rest);
            square += (h - mean_h).powi(2);
        }
        // s² − 2 h s + rest = 0 at the mean height.
        let root = (mean_h * mean_h - mean_rest).max(0.0).sqrt();
        let mut heights = vec![mean_h + root, mean_h - root];
        if square > 0.0 {
            heights.push(0.5 * slope / square);
        }
        heights
    }

    /// Gauss-Newton on place and dead paths; the place and the root-mean-square residual.
    fn polish(&self, mut at: Vector3<f64>, mut paths: Vec<f64>) -> Option<(Vector3<f64>, f64)> {
        let mut rms = f64::INFINITY;
        for _ in 0..POLISH {
            let mut design = DMatrix::zeros(self.seen.len(), 3 + self.n_paths);
            let mut right = DVector::zeros(self.seen.len());
            for (row, (target, displacement, own)) in self.seen.iter().enumerate() {
                let along = target - at;
                let path = along.norm();
                for axis in 0..3 {
                    design[(row, axis)] = -along[axis] / path;
                }
                design[(row, 3 + own)] = -1.0;
                right[row] = -(path - paths[*own] - displacement);
            }
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            let count = self.seen.len() as f64;
            rms = right.norm() / count.sqrt();
            let step = least_squares(design, &right)?;
            at += step.fixed_rows::<3>(0);
            for (path, change) in paths.iter_mut().zip(step.rows(3, self.n_paths).iter()) {
                *path += change;
            }
        }
        (rms.is_finite() && at.iter().all(|v| v.is_finite())).then_some((at, rms))
    }
}

/// Reciprocal condition below which a resection says nothing.
const FREE: f64 = 1e-10;

/// Solution by singular values of unit columns; `None` where a direction is free.
fn least_squares(mut design: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    if design.nrows() < design.ncols() {
        return None;
    }
    let lengths: Vec<f64> = design.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in design.column_iter_mut().zip(&lengths) {
        if !(*length > 0.0 && length.is_finite()) {
            return None;
        }
        column.unscale_mut(*length);
    }
    let svd = design.svd(true, true);
    if svd.singular_values.min() <= FREE * svd.singular_values.max() {
        return None;
    }
    let mut x = svd.solve(right, 0.0).ok()?;
    for (value, length) in x.iter_mut().zip(&lengths) {
        *value /= length;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of hundreds of mm, some ten operations, over heights of tens of mm.
    const ROUND_OFF_MM: f64 = 1e-9;

    /// Circles at three heights, seen from one place: `2 h s + d² − |S|²` of each gives the height `s` by
    /// how it grows from circle to circle, and by its mean up to the mirror image across the mean circle.
    #[test]
    fn circles_show_the_height_of_a_station_twice() {
        let (height, across) = (210.0, 330.0);
        let paths = [60.0, 95.0, 140.0];
        let sights = Sights {
            origin_mm: Vector3::zeros(),
            axis: Vector3::z(),
            seen: Vec::new(),
            n_paths: 3,
            heights_mm: vec![-40.0, 10.0, 75.0],
        };
        let squares = across * across + height * height;
        let constant = |(h, d): (&f64, &f64)| 2.0 * h * height + d * d - squares;
        let constants: Vec<f64> = sights.heights_mm.iter().zip(&paths).map(constant).collect();
        let found = sights.heights_of_station(across * across, &paths, &constants);
        let mirrored = 2.0 * (-40.0 + 10.0 + 75.0) / 3.0 - height;
        for (found, expected) in found.iter().zip([height, mirrored, height]) {
            assert!((found - expected).abs() < ROUND_OFF_MM, "{found} {expected}");
        }
        assert_eq!(found.len(), 3);
    }
}
