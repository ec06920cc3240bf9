//! Poses of the stations, reflectors and six errors per angle in one problem.
//!
//! `r = Q·(Rᵀ·(o + e + exp(ω)·Rot(b)·t − c) − p)`, one block `[e, ω]` per angle; everything else
//! is shared. Reflectors move only such that they stay fitted to their nominal places: that is
//! the machine frame. The errors at the first angle are held at zero.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem, Pattern};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3, Vector6};

use super::sight::{ErrorAt, Place, Sight, StationAt, Weights};
use crate::angle_steps::{AngleSteps, angles};
use crate::curves::{Curves, LOCATION, Shape};
use crate::frame::Frame;
use crate::gauge::{StationChart, rigid_fit};
use crate::joint::location_name;
use crate::readings::Readings;
use crate::{AxisModel, Gauge, Options, TargetOptions, TargetSurvey, TrackerError};

/// Numbers of a station, and of a block.
const SIX: usize = 6;

/// What is in the model beside what is declared.
#[derive(Clone, Debug, Default)]
pub(super) struct Added {
    /// Of a perfect axis.
    pub(super) shapes: Vec<Shape>,
    /// Columns of other effects: three rows per reading, mm.
    pub(super) extras: Vec<Vec<f64>>,
    /// Uncertainty of the frame that the place of a perfect axis is in.
    pub(super) frame: Option<Frame>,
}

/// The bundle of a survey of points.
#[derive(Clone, Debug)]
pub(super) struct Bundle<'a> {
    pub(super) survey: &'a TargetSurvey,
    pub(super) axis_model: AxisModel,
    pub(super) angles: Vec<AngleSteps>,
    pub(super) angle_of_step: Vec<usize>,
    /// Places of the reflectors under the gauge.
    pub(super) chart: StationChart,
    /// Poses about which stations move, machine frame from their own.
    starts: Vec<Isometry3<f64>>,
    /// Nominal rotation at each angle.
    rotations: Vec<Matrix3<f64>>,
    /// Readings of each angle, in the order of its rows.
    pub(super) targets_of: Vec<Vec<usize>>,
    pub(super) weights: Vec<Weights>,
    /// What is fitted of a perfect axis.
    pub(super) curves: Curves,
    /// Columns of effects in the model: by effect, three rows per reading, mm.
    extras: Vec<Vec<f64>>,
    patterns: Vec<Pattern>,
    pattern_of: Vec<usize>,
}

impl<'a> Bundle<'a> {
    pub(super) fn new(
        survey: &'a TargetSurvey,
        options: &TargetOptions,
        estimated_mm: f64,
        added: Added,
    ) -> Result<Self, TrackerError> {
        let (angles, angle_of_step) = angles(&survey.steps);
        let nominal: Vec<Point3<f64>> = survey.mounts.iter().map(|m| m.nominal_mm).collect();
        let inner = Options { gauge: Gauge::Inner, ..Options::default() };
        let rotation =
            |a: &AngleSteps| survey.axis.rotation(a.angle_rad).to_rotation_matrix().into_inner();
        let mut targets_of = vec![Vec::new(); angles.len()];
        for step in angles.iter().flat_map(|a| a.steps.iter().copied()) {
            let own = (0..survey.targets.len()).filter(|&n| survey.targets[n].step == step);
            targets_of[angle_of_step[step]].extend(own);
        }
        let weights = (survey.targets.iter())
            .map(|t| Weights::new(t, options.noise, estimated_mm))
            .collect::<Result<_, _>>()?;
        let fitted = match options.axis {
            AxisModel::Located => &LOCATION[..],
            AxisModel::Free | AxisModel::Fixed => &[],
        };
        let shapes = fitted.iter().chain(&added.shapes).cloned().collect();
        let angles_rad: Vec<f64> = angles.iter().map(|a| a.angle_rad).collect();
        let mut bundle = Self {
            survey,
            axis_model: options.axis,
            curves: Curves::new(&survey.axis, &angles_rad, shapes),
            chart: StationChart::new(&nominal, &inner)?,
            starts: starts(survey)?,
            rotations: angles.iter().map(rotation).collect(),
            angles,
            angle_of_step,
            targets_of,
            weights,
            extras: added.extras,
            patterns: Vec::new(),
            pattern_of: Vec::new(),
        };
        bundle.find_patterns();
        Ok(bundle)
    }

    /// One pattern for all blocks that see the same.
    fn find_patterns(&mut self) {
        let mut known = std::collections::HashMap::new();
        for targets in &self.targets_of {
            let ids: Vec<_> = targets.iter().map(|&n| self.shared_of(n)).collect();
            let next = self.patterns.len();
            let mut pattern = Pattern::new();
            for shared in ids.iter().flat_map(|shared| [shared; 3]) {
                pattern.push(&[0, 1, 2, 3, 4, 5], shared);
            }
            let index = *known.entry(ids).or_insert(next);
            if index == next {
                self.patterns.push(pattern);
            }
            self.pattern_of.push(index);
        }
    }

    /// Everything at its start: stations fitted to the nominal reflectors, no errors.
    pub(super) fn start(&self) -> BorderedPoint {
        BorderedPoint {
            shared: vec![0.0; self.shared_dim()],
            blocks: vec![0.0; SIX * self.angles.len()],
        }
    }

    /// Index of the first reflector's parameter.
    pub(super) fn mount_start(&self) -> usize {
        SIX * self.survey.stations.len()
    }

    /// Index of the first amplitude of the axis.
    pub(super) fn curve_start(&self) -> usize {
        self.mount_start() + self.chart.dim()
    }

    /// Index of the first amplitude of an effect that is not on the axis.
    pub(super) fn extra_start(&self) -> usize {
        self.curve_start() + self.curves.len()
    }

    fn amplitudes<'s>(&self, shared: &'s [f64]) -> &'s [f64] {
        &shared[self.curve_start()..self.extra_start()]
    }

    /// Errors of an angle whose own are `point`.
    fn error_at(&self, angle: usize, shared: &[f64], point: &[f64]) -> ErrorAt {
        let own = Vector6::from_column_slice(point);
        ErrorAt::new((own + self.curves.error(angle, self.amplitudes(shared))).as_slice())
    }

    pub(super) fn angles_rad(&self) -> Vec<f64> {
        self.angles.iter().map(|a| a.angle_rad).collect()
    }

    /// Pose of a station, machine frame from its own.
    pub(super) fn station(&self, station: usize, shared: &[f64]) -> Isometry3<f64> {
        let at = StationAt::new(&self.starts[station], &shared[SIX * station..]);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(at.rotation);
        Isometry3::from_parts(at.center_mm.into(), rotation.into())
    }

    pub(super) fn body_mm(&self, mount: usize, shared: &[f64]) -> Vector3<f64> {
        self.chart.position_mm(mount, &shared[self.mount_start()..])
    }

    /// Shared parameters of a reading: station, reflector, effects.
    fn shared_of(&self, target: usize) -> Vec<usize> {
        let t = &self.survey.targets[target];
        let station = SIX * t.station..SIX * (t.station + 1);
        let mount = self.chart.moves(t.mount).iter().map(|(p, _)| self.mount_start() + p);
        station.chain(mount).chain(self.curve_start()..self.shared_dim()).collect()
    }

    /// Geometry of a reading.
    pub(super) fn sight(&self, target: usize, shared: &[f64], error: &ErrorAt) -> Sight {
        let t = &self.survey.targets[target];
        let place = Place {
            origin_mm: self.survey.axis.origin_mm.coords,
            nominal: self.rotations[self.angle_of_step[t.step]],
            error: *error,
            body_mm: self.body_mm(t.mount, shared),
            station: StationAt::new(&self.starts[t.station], &shared[SIX * t.station..]),
        };
        Sight::new(&place, t, &self.weights[target])
    }

    /// Geometry of a reading at a point.
    pub(super) fn sight_at(&self, target: usize, at: &BorderedPoint) -> Sight {
        let k = self.angle_of_step[self.survey.targets[target].step];
        let own = &at.blocks[SIX * k..SIX * (k + 1)];
        self.sight(target, &at.shared, &self.error_at(k, &at.shared, own))
    }

    /// Residual with the effects in the model, over its standard uncertainty.
    fn whitened(&self, target: usize, sight: &Sight, shared: &[f64]) -> Vector3<f64> {
        let mut residual = sight.residual_mm;
        for (column, amplitude) in self.extras.iter().zip(&shared[self.extra_start()..]) {
            residual +=
                Vector3::from_column_slice(&column[3 * target..3 * target + 3]) * *amplitude;
        }
        residual.component_div(&self.weights[target].sigma_mm)
    }
}

/// Stations by the fit of what they saw to the nominal axis (Kabsch 1976).
fn starts(survey: &TargetSurvey) -> Result<Vec<Isometry3<f64>>, TrackerError> {
    let place = |station: usize| {
        let own = || survey.targets.iter().filter(move |t| t.station == station);
        let nominal = |t: &crate::Target| {
            let pose = survey.axis.machine_from_table(survey.steps[t.step].angle_rad);
            (pose * survey.mounts[t.mount].nominal_mm).coords
        };
        let measured: Vec<Vector3<f64>> = own().map(|t| t.at_mm.coords).collect();
        let nominal: Vec<Vector3<f64>> = own().map(nominal).collect();
        rigid_fit(&measured, &nominal).ok_or(TrackerError::NotFinite)
    };
    (0..survey.stations.len()).map(place).collect()
}

impl BorderedProblem for Bundle<'_> {
    fn shared_dim(&self) -> usize {
        self.extra_start() + self.extras.len()
    }

    fn block_dim(&self) -> usize {
        SIX
    }

    fn block_count(&self) -> usize {
        self.angles.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        self.pattern_of[block]
    }

    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let error = self.error_at(block, shared, point);
        for (&target, out) in self.targets_of[block].iter().zip(out.chunks_exact_mut(3)) {
            let sight = self.sight(target, shared, &error);
            out.copy_from_slice(self.whitened(target, &sight, shared).as_slice());
        }
    }

    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let error = self.error_at(block, shared, point);
        let curves = self.curves.at(block, self.amplitudes(shared)).slopes;
        let (mut row, mut at) = (0, 0);
        for &target in &self.targets_of[block] {
            let t = &self.survey.targets[target];
            let sight = self.sight(target, shared, &error);
            let whitened = self.whitened(target, &sight, shared);
            for c in 0..3 {
                let weight = 1.0 / self.weights[target].sigma_mm[c];
                rows.residuals[row] = whitened[c];
                for i in 0..SIX {
                    rows.by_block[SIX * row + i] = weight * sight.by_error[(c, i)];
                    rows.by_shared[at + i] = weight * sight.by_station[(c, i)];
                }
                at += SIX;
                for (_, way) in self.chart.moves(t.mount) {
                    rows.by_shared[at] = weight * (sight.by_mount.row(c) * way)[0];
                    at += 1;
                }
                for curve in &curves {
                    rows.by_shared[at] = weight * (sight.by_error.row(c) * curve)[0];
                    at += 1;
                }
                for column in &self.extras {
                    rows.by_shared[at] = weight * column[3 * target + c];
                    at += 1;
                }
                row += 1;
            }
        }
    }

    fn shared_name(&self, index: usize) -> String {
        const COORDINATES: [&str; 6] = ["x", "y", "z", "a", "b", "c"];
        if index < self.mount_start() {
            let station = &self.survey.stations[index / SIX].name;
            let unit = if index % SIX < 3 { "mm" } else { "rad" };
            return format!("{} of station {station} ({unit})", COORDINATES[index % SIX]);
        }
        if let Some(Shape::Location(c)) =
            index.checked_sub(self.curve_start()).and_then(|i| self.curves.shapes.get(i))
        {
            return location_name(self.survey.axis.letter, *c);
        }
        if index < self.curve_start() {
            let coordinate = self.chart.coordinate(index - self.mount_start());
            let mount = &self.survey.mounts[coordinate / 3].name;
            return format!("{} of mount {mount} (mm)", COORDINATES[coordinate % 3]);
        }
        format!("amplitude {}", index - self.curve_start())
    }

    fn block_name(&self, block: usize, index: usize) -> String {
        let letter = self.survey.axis.letter;
        let angle_deg = self.angles[block].angle_rad.to_degrees();
        let unit = if index < 3 { "mm" } else { "rad" };
        format!("{} at {angle_deg:.4}° ({unit})", letter.error_names()[index])
    }
}

impl Readings for Bundle<'_> {
    fn range_count(&self, block: usize) -> usize {
        3 * self.targets_of[block].len()
    }
}

#[cfg(test)]
mod tests {
    use least_squares::{AsDense, check_jacobian};
    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;
    use crate::{AxisLetter, Mount, RotaryAxis, Station, Step, Target, TargetNoise};

    /// Two trackers, of which one sees two of the three reflectors, at three angles.
    fn survey() -> TargetSurvey {
        let axis = RotaryAxis::new(AxisLetter::C, Point3::new(5.0, -3.0, 2.0), Vector3::z());
        let mounts = [[300.0, 0.0, 40.0], [-100.0, 250.0, -60.0], [-150.0, -200.0, 10.0]];
        let name = |n: usize| format!("{n}");
        let station_from_machine =
            Isometry3::new(Vector3::new(900.0, 200.0, 150.0), Vector3::new(0.3, -1.0, 0.8));
        let mut survey = TargetSurvey {
            axis: axis.unwrap(),
            stations: (0..2)
                .map(|i| Station { name: name(i), nominal_mm: Point3::origin() })
                .collect(),
            mounts: (0..3)
                .map(|j| Mount { name: name(j), nominal_mm: Point3::from(mounts[j]) })
                .collect(),
            steps: [0.0, 0.8, 1.7]
                .iter()
                .map(|a| Step { name: a.to_string(), angle_rad: *a, approach: None })
                .collect(),
            targets: Vec::new(),
        };
        for step in 0..3 {
            for (station, mount) in [(0, 0), (0, 1), (0, 2), (1, 2), (1, 0)] {
                let pose = survey.axis.machine_from_table(survey.steps[step].angle_rad);
                let shift = Vector3::new(f64::from(u8::from(station == 1)) * 70.0, 0.0, 0.0);
                let at_mm = station_from_machine * (pose * survey.mounts[mount].nominal_mm) + shift;
                survey.targets.push(Target { station, mount, step, at_mm });
            }
        }
        survey
    }

    #[test]
    fn derivatives_are_those_of_the_residuals() {
        let survey = survey();
        let noise = TargetNoise::Polar { range_mm: 0.01, angle_rad: 5e-6 };
        let options = TargetOptions { noise, ..TargetOptions::default() };
        let extra = (0..45).map(|i| f64::from(i).sin()).collect();
        let motion = Shape::Motion(vec![Vector6::new(0.1, -0.3, 0.2, 1e-3, 2e-3, -1e-3); 3]);
        let shapes = LOCATION.into_iter().chain([motion]).collect();
        let added = Added { shapes, extras: vec![extra], frame: None };
        let bundle = Bundle::new(&survey, &options, 1.0, added).unwrap();
        let mut at = bundle.start();
        for (i, value) in at.shared.iter_mut().chain(&mut at.blocks).enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a small index")]
            let index = i as f64;
            *value = 0.02 * (1.7 * index).sin();
        }
        let check = check_jacobian(&AsDense(&bundle), &at);
        // What central differences are good for.
        assert!(check.worst_relative_error() < 1e-8, "{check}");
    }

    /// As directions that a survey leaves free are reported.
    #[test]
    fn what_is_shared_has_a_name_with_its_unit() {
        let survey = survey();
        let located = TargetOptions { axis: AxisModel::Located, ..TargetOptions::default() };
        let bundle = Bundle::new(&survey, &located, 1.0, Added::default()).unwrap();
        let names: Vec<String> =
            (0..bundle.shared_dim()).map(|index| bundle.shared_name(index)).collect();
        let of_station = |station: usize| {
            ["x", "y", "z", "a", "b", "c"].iter().zip(["mm", "mm", "mm", "rad", "rad", "rad"]).map(
                move |(coordinate, unit)| format!("{coordinate} of station {station} ({unit})"),
            )
        };
        let stations: Vec<String> = (0..2).flat_map(of_station).collect();
        assert_eq!(names[..12], stations);
        // Three reflectors of nine coordinates, less the six of the frame.
        assert!(names[12..15].iter().all(|name| name.contains(" of mount ")), "{names:?}");
        assert_eq!(names[15..], ["EX0C (mm)", "EY0C (mm)", "EA0C (rad)", "EB0C (rad)"]);
    }
}
