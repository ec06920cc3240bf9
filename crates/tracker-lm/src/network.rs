//! A survey that has been checked: which readings share what.

use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen, Vector3};

use crate::angle_steps::{AngleSteps, angles};
use crate::curves::LOCATION;
use crate::error::{Record, Shortage};
use crate::gauge::StationChart;
use crate::head::head_angles;
use crate::lists::Lists;
use crate::{
    AxisModel, DeadPath, Formulation, Gauge, Options, Range, RotaryAxis, Survey, TrackerError,
};

/// Fewest stations: three distances place a point, the fourth checks the stations.
const MIN_STATIONS: usize = 4;
/// Fewest reflectors that show six errors.
pub(crate) const MIN_MOUNTS: usize = 3;
/// Numbers beyond are slips; a double then resolves less than 0.1 µm.
pub(crate) const LARGEST: f64 = 1e9;
/// Spread about a line over spread along it below which reflectors count as collinear: the
/// rotation about the line is then a thousand times less certain than the others.
const COLLINEAR: f64 = 1e-3;

/// A survey whose references and counts are in order.
#[derive(Clone, Debug)]
pub(crate) struct Network<'a> {
    pub(crate) survey: &'a Survey,
    pub(crate) axis_model: AxisModel,
    /// In the order measured; the first is the reference, of two axes that where both stand.
    pub(crate) angles: Vec<AngleSteps>,
    /// Where each axis is at the reference.
    reference_rad: [f64; 2],
    /// Angle of each step.
    pub(crate) angle_of_step: Vec<usize>,
    /// Ranges of each step.
    pub(crate) ranges_of_step: Lists,
    /// Station, and mount where each lock has its own.
    pub(crate) dead_paths: Vec<(usize, Option<usize>)>,
    /// Dead path of each station and mount that have one.
    dead_path_of: Vec<usize>,
    /// Mounts seen at each step, sorted, step after step.
    mounts_seen: Vec<usize>,
    /// Where those of each step begin; then their end.
    seen_from: Vec<usize>,
}

impl<'a> Network<'a> {
    pub(crate) fn new(survey: &'a Survey, options: &Options) -> Result<Self, TrackerError> {
        check_noise(options)?;
        check_numbers(survey)?;
        let ranges_of_step = check_references(survey)?;
        check_shape(survey)?;
        let (angles, angle_of_step, reference_rad) = match &survey.second {
            None => {
                let (angles, angle_of_step) = angles(&survey.steps);
                let first_rad = angles.first().map_or(0.0, |angle| angle.angle_rad);
                (angles, angle_of_step, [first_rad, 0.0])
            }
            Some(second) => {
                if options.axis != AxisModel::Free || options.formulation != Formulation::Joint {
                    return Err(TrackerError::TwoAxesOtherwise);
                }
                head_angles(survey, second)?
            }
        };
        let (mut mounts_seen, mut seen_from) = (Vec::new(), vec![0]);
        let mut seen = Vec::new();
        for ranges in ranges_of_step.iter() {
            seen.clear();
            seen.extend(ranges.iter().map(|&r| survey.ranges[r as usize].mount));
            seen.sort_unstable();
            seen.dedup();
            mounts_seen.extend_from_slice(&seen);
            seen_from.push(mounts_seen.len());
        }
        let (dead_paths, dead_path_of) = dead_paths(survey, options.dead_path);
        let network = Self {
            survey,
            axis_model: options.axis,
            angles,
            reference_rad,
            angle_of_step,
            ranges_of_step,
            dead_paths,
            dead_path_of,
            mounts_seen,
            seen_from,
        };
        network.check_count(options)?;
        Ok(network)
    }

    pub(crate) fn angles_rad(&self) -> Vec<f64> {
        self.angles.iter().map(|a| a.angle_rad).collect()
    }

    /// Axes that turn: one, or two.
    pub(crate) fn axis_count(&self) -> usize {
        1 + usize::from(self.survey.second.is_some())
    }

    pub(crate) fn axis(&self, axis: usize) -> &'a RotaryAxis {
        match &self.survey.second {
            Some(second) if axis == 1 => &second.axis,
            _ => &self.survey.axis,
        }
    }

    /// The axis that the reflectors are on.
    pub(crate) fn carrier(&self) -> &'a RotaryAxis {
        self.axis(self.axis_count() - 1)
    }

    /// Index of every angle at which an axis was, from the reference on, and where it was there.
    pub(crate) fn angles_of(&self, axis: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let reference = self.reference_rad[axis];
        let others = self.angles.iter().enumerate().skip(1).filter(move |(_, a)| a.axis == axis);
        std::iter::once((0, reference)).chain(others.map(|(k, a)| (k, a.angle_rad)))
    }

    /// Point that the errors of an angle move, machine frame.
    pub(crate) fn pivot_mm(&self, angle: usize) -> Point3<f64> {
        self.axis(self.angles[angle].axis).origin_mm
    }

    /// Machine frame from that of the reflectors at an angle, without errors.
    pub(crate) fn nominal(&self, angle: usize) -> Isometry3<f64> {
        let AngleSteps { axis, angle_rad, .. } = self.angles[angle];
        let first = &self.survey.axis;
        let Some(second) = &self.survey.second else { return first.machine_from_table(angle_rad) };
        if axis == 1 {
            return second.axis.machine_from_table(angle_rad);
        }
        // The first axis carries the second one along from where it stands.
        let turned = first.machine_from_table(angle_rad)
            * first.machine_from_table(self.reference_rad[0]).inverse();
        turned * second.axis.machine_from_table(self.reference_rad[1])
    }

    /// Station, mount and dead path of a range.
    pub(crate) fn seen_by(&self, range: u32) -> [usize; 3] {
        let r = &self.survey.ranges[range as usize];
        [r.station, r.mount, self.dead_path_of(r)]
    }

    /// Dead path of a range.
    pub(crate) fn dead_path_of(&self, range: &Range) -> usize {
        self.dead_path_of[range.station * self.survey.mounts.len() + range.mount]
    }

    /// Number of target points: mounts seen at a step, over all steps.
    pub(crate) fn point_count(&self) -> usize {
        self.mounts_seen.len()
    }

    /// Mounts seen at a step, sorted.
    pub(crate) fn mounts_at(&self, step: usize) -> &[usize] {
        &self.mounts_seen[self.seen_from[step]..self.seen_from[step + 1]]
    }

    fn check_count(&self, options: &Options) -> Result<(), TrackerError> {
        let (n_stations, n_mounts) = (self.survey.stations.len(), self.survey.mounts.len());
        let (stations, prior_rows) = match (options.gauge, options.noise.station_mm) {
            (Gauge::Stations, Some(_)) => (3 * n_stations, 3 * n_stations),
            (Gauge::Shape, Some(_)) => (3 * n_stations - 6, 3 * n_stations - 6),
            _ => (3 * n_stations - 6, 0),
        };
        let n_angles = self.angles.len();
        let ranges = self.survey.ranges.len();
        let (rows, fixed, per_angle, angles_that_count) = match options.formulation {
            Formulation::Joint => {
                let (located, free) = match options.axis {
                    AxisModel::Free => (0, n_angles - 1),
                    AxisModel::Fixed => (0, 0),
                    AxisModel::Located => (LOCATION.len(), 0),
                };
                (ranges, 3 * n_mounts + located, 6 * free, free)
            }
            Formulation::FreePoints => {
                let pairs = |n: usize| n * n.saturating_sub(1) / 2;
                let rigid: usize =
                    (0..self.survey.steps.len()).map(|s| pairs(self.mounts_at(s).len())).sum();
                let points = 3 * self.point_count();
                (ranges + rigid, pairs(n_mounts), points, n_angles)
            }
        };
        let equations = rows + prior_rows;
        let shared = stations + self.dead_paths.len() + fixed;
        let unknowns = shared + per_angle;
        if equations > unknowns {
            return Ok(());
        }
        // What an angle like the mean of these brings beyond its own unknowns, of which the
        // first angle of the joint bundle has none.
        let own = per_angle.div_ceil(angles_that_count.max(1));
        let brings = (rows / n_angles).saturating_sub(own);
        let gift = own * (n_angles - angles_that_count);
        let missing = shared.saturating_sub(prior_rows + gift);
        let (shortage, needed, got) = match missing.checked_div(brings) {
            Some(more) => (Shortage::Angles, (more + 1).max(n_angles + 1), n_angles),
            None => (Shortage::RangesPerAngle, own + 1, rows / n_angles),
        };
        Err(TrackerError::TooFewRanges { equations, unknowns, shortage, needed, got })
    }
}

fn check_noise(options: &Options) -> Result<(), TrackerError> {
    let noise = options.noise;
    let all = [
        ("displacement_mm", noise.displacement_mm),
        ("rigid_mm", noise.rigid_mm),
        ("station_mm", noise.station_mm),
    ];
    for (which, value) in all {
        if let Some(value) = value
            && !(value > 0.0 && value.is_finite())
        {
            return Err(TrackerError::InvalidNoise { which, value });
        }
    }
    Ok(())
}

fn check_numbers(survey: &Survey) -> Result<(), TrackerError> {
    let check = |what: Record, index: usize, values: &[f64]| {
        let bad = values.iter().find(|v| !v.is_finite() || v.abs() > LARGEST);
        bad.map_or(Ok(()), |&value| {
            Err(TrackerError::InvalidNumber { what, index, value, limit: LARGEST })
        })
    };
    for (i, station) in survey.stations.iter().enumerate() {
        check(Record::Station, i, station.nominal_mm.coords.as_slice())?;
    }
    for (j, mount) in survey.mounts.iter().enumerate() {
        check(Record::Mount, j, mount.nominal_mm.coords.as_slice())?;
    }
    for (k, step) in survey.steps.iter().enumerate() {
        check(Record::Step, k, &[step.angle_rad])?;
    }
    for (k, angle) in survey.second.iter().flat_map(|s| &s.angles_rad).enumerate() {
        check(Record::Step, k, &[*angle])?;
    }
    for (r, range) in survey.ranges.iter().enumerate() {
        check(Record::Range, r, &[range.displacement_mm])?;
    }
    Ok(())
}

/// Refuses what refers to nothing and what is never referred to; the ranges of each step.
fn check_references(survey: &Survey) -> Result<Lists, TrackerError> {
    let (n_stations, n_mounts, n_steps) =
        (survey.stations.len(), survey.mounts.len(), survey.steps.len());
    let mut unseen = [vec![true; n_stations], vec![true; n_mounts], vec![true; n_steps]];
    let unknown = survey.ranges.iter().enumerate().find_map(|(range, r)| {
        let references = [
            (Record::Station, r.station, n_stations),
            (Record::Mount, r.mount, n_mounts),
            (Record::Step, r.step, n_steps),
        ];
        for (kind, (what, index, count)) in references.into_iter().enumerate() {
            if index >= count {
                return Some((range, TrackerError::UnknownIndex { range, what, index, count }));
            }
            unseen[kind][index] = false;
        }
        None
    });
    let known = unknown.as_ref().map_or(survey.ranges.len(), |(range, _)| *range);
    let ranges_of_step = by_step(&survey.ranges[..known], n_steps);
    if let Some(range) = first_duplicate(survey, &ranges_of_step) {
        let r = &survey.ranges[range];
        return Err(TrackerError::DuplicateRange {
            station: survey.stations[r.station].name.clone(),
            mount: survey.mounts[r.mount].name.clone(),
            step: survey.steps[r.step].name.clone(),
            range,
        });
    }
    if let Some((_, error)) = unknown {
        return Err(error);
    }
    let first = |kind: usize| unseen[kind].iter().position(|u| *u);
    let name = if let Some(i) = first(0) {
        (Record::Station, &survey.stations[i].name)
    } else if let Some(j) = first(1) {
        (Record::Mount, &survey.mounts[j].name)
    } else if let Some(k) = first(2) {
        (Record::Step, &survey.steps[k].name)
    } else {
        return Ok(ranges_of_step);
    };
    Err(TrackerError::Unseen { what: name.0, name: name.1.clone() })
}

fn by_step(ranges: &[Range], n_steps: usize) -> Lists {
    let mut counts = vec![0; n_steps];
    for range in ranges {
        counts[range.step] += 1;
    }
    Lists::sorted(&counts, ranges.iter().map(|range| range.step))
}

/// The first range that repeats one before it.
fn first_duplicate(survey: &Survey, ranges_of_step: &Lists) -> Option<usize> {
    let mut first: Option<usize> = None;
    let mut seen: Vec<(usize, usize, usize)> = Vec::new();
    for ranges in ranges_of_step.iter() {
        seen.clear();
        let reading = |&i: &u32| (&survey.ranges[i as usize], i as usize);
        seen.extend(ranges.iter().map(reading).map(|(r, i)| (r.mount, r.station, i)));
        // Most records are in this order already.
        if !seen.is_sorted() {
            seen.sort_unstable();
        }
        let again = seen.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1));
        first = again.map(|w| w[1].2).chain(first).min();
    }
    first
}

fn check_shape(survey: &Survey) -> Result<(), TrackerError> {
    let got = survey.stations.len();
    if got < MIN_STATIONS {
        return Err(TrackerError::TooFewStations { needed: MIN_STATIONS, got });
    }
    let got = survey.mounts.len();
    if got < MIN_MOUNTS {
        return Err(TrackerError::TooFewMounts { needed: MIN_MOUNTS, got });
    }
    check_collinear(&survey.mounts.iter().map(|m| m.nominal_mm.coords).collect::<Vec<_>>())
}

/// Refuses points of the turning frame that lie on one line.
pub(crate) fn check_collinear(points_mm: &[Vector3<f64>]) -> Result<(), TrackerError> {
    #[expect(clippy::cast_precision_loss, reason = "a handful of reflectors")]
    let n = points_mm.len() as f64;
    let centroid = points_mm.iter().sum::<Vector3<f64>>() / n;
    let scatter: Matrix3<f64> =
        points_mm.iter().map(|p| (p - centroid) * (p - centroid).transpose()).sum();
    let eigen = SymmetricEigen::new(scatter / n);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let spread = order.map(|i| eigen.eigenvalues[i].max(0.0).sqrt());
    if spread[1] > COLLINEAR * spread[0] {
        return Ok(());
    }
    Err(TrackerError::CollinearMounts {
        along_mm: spread[0],
        off_line_mm: spread[1],
        line: eigen.eigenvectors.column(order[0]).into_owned().into(),
    })
}

/// Dead paths in the order of stations and mounts, and that of each station and mount.
fn dead_paths(survey: &Survey, model: DeadPath) -> (Vec<(usize, Option<usize>)>, Vec<usize>) {
    let n_mounts = survey.mounts.len();
    let mut is_seen = vec![false; survey.stations.len() * n_mounts];
    for range in &survey.ranges {
        is_seen[range.station * n_mounts + range.mount] = true;
    }
    let (mut dead_paths, mut of_pairs) = (Vec::new(), vec![0; is_seen.len()]);
    for (pair, _) in is_seen.iter().enumerate().filter(|(_, is_seen)| **is_seen) {
        let dead_path = match model {
            DeadPath::Lock => (pair / n_mounts, Some(pair % n_mounts)),
            DeadPath::Station => (pair / n_mounts, None),
        };
        if dead_paths.last() != Some(&dead_path) {
            dead_paths.push(dead_path);
        }
        of_pairs[pair] = dead_paths.len() - 1;
    }
    (dead_paths, of_pairs)
}

impl Network<'_> {
    /// Name of a station's coordinate or a dead path, the first of the shared parameters.
    pub(crate) fn name_of_shared(&self, chart: &StationChart, index: usize) -> String {
        let station = |i: usize| &self.survey.stations[i].name;
        if index < chart.dim() {
            let coordinate = chart.coordinate(index);
            let axis = ["x", "y", "z"][coordinate % 3];
            return format!("{axis} of station {} (mm)", station(coordinate / 3));
        }
        match self.dead_paths[index - chart.dim()] {
            (i, Some(j)) => {
                let mount = &self.survey.mounts[j].name;
                format!("dead path from {} to {mount} (mm)", station(i))
            }
            (i, None) => format!("dead path of {} (mm)", station(i)),
        }
    }
}
