//! The joint bundle: stations, dead paths, reflectors and six errors per angle in one problem.
//!
//! `u = |o + e + exp(ω)·Rot(b)·t − S| − (l + L)`, one block `[e, ω]` per angle; everything else
//! is shared. The errors at the first angle are held at zero: the reflectors absorb them. Of a head
//! with two axes each angle belongs to one of them, and the other one stands.

#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use geometry::so3;
use least_squares::{BlockRows, BorderedPoint, BorderedProblem, Pattern};
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Vector3, Vector6};

use crate::curves::{Curves, LOCATION};
use crate::gauge::{Places, StationChart};
use crate::kinds::Kinds;
use crate::lists::Lists;
use crate::network::Network;
use crate::readings::Readings;
use crate::shift::Shift;
use crate::start::Start;
use crate::{AxisLetter, AxisModel};

/// Joint bundle over a network.
#[derive(Clone, Debug)]
pub(crate) struct Joint<'a> {
    pub(crate) network: &'a Network<'a>,
    pub(crate) chart: &'a StationChart,
    /// Standard uncertainty of one range.
    sigma_mm: f64,
    /// Nominal rotation at each angle.
    rotations: Vec<Matrix3<f64>>,
    /// What the errors of each angle move, and from there to the origin of the reflectors.
    pivots_mm: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Ranges of each angle, in the order of its rows.
    pub(crate) ranges_of: Lists,
    patterns: Vec<Pattern>,
    pattern_of: Vec<usize>,
    /// Location of the axis where it is fitted.
    pub(crate) curves: Curves,
    /// What effects of known size move, range by range; empty where there are none.
    shifts: Vec<Shift>,
}

/// Derivatives of one range.
pub(crate) struct Slopes {
    pub(crate) residual_mm: f64,
    /// From the station to the target.
    pub(crate) along_mm: Vector3<f64>,
    /// Its unit vector: derivative by the error's displacement.
    pub(crate) beam: Vector3<f64>,
    pub(crate) by_rotation: Vector3<f64>,
    pub(crate) by_mount: Vector3<f64>,
}

impl Slopes {
    /// Derivative by the six errors.
    pub(crate) fn by_error(&self) -> Vector6<f64> {
        let (e, w) = (&self.beam, &self.by_rotation);
        Vector6::new(e.x, e.y, e.z, w.x, w.y, w.z)
    }
}

/// Angles without errors of their own: the first, or all of a perfect axis.
pub(crate) fn held(axis_model: AxisModel, n_angles: usize) -> Vec<usize> {
    match axis_model {
        AxisModel::Free => vec![0],
        AxisModel::Fixed | AxisModel::Located => (0..n_angles).collect(),
    }
}

/// Name of an amplitude of the axis' location, with its unit.
pub(crate) fn location_name(letter: AxisLetter, index: usize) -> String {
    let unit = if index < 2 { "mm" } else { "rad" };
    format!("{} ({unit})", letter.location_names()[index])
}

impl<'a> Joint<'a> {
    pub(crate) fn new(network: &'a Network<'a>, chart: &'a StationChart, sigma_mm: f64) -> Self {
        let axis = &network.survey.axis;
        let nominal: Vec<_> = (0..network.angles.len()).map(|k| network.nominal(k)).collect();
        let rotations =
            nominal.iter().map(|n| n.rotation.to_rotation_matrix().into_inner()).collect();
        let pivot = |(k, nominal): (usize, &Isometry3<f64>)| {
            let pivot_mm = network.pivot_mm(k).coords;
            (pivot_mm, nominal.translation.vector - pivot_mm)
        };
        let pivots_mm = nominal.iter().enumerate().map(pivot).collect();
        let steps = network.angles.iter().map(|angle| &angle.steps[..]);
        let ranges_of = network.ranges_of_step.joined(steps);
        let shapes = match network.axis_model {
            AxisModel::Located => LOCATION.to_vec(),
            AxisModel::Free | AxisModel::Fixed => Vec::new(),
        };
        let mut joint = Self {
            curves: Curves::new(axis, &network.angles_rad(), shapes),
            network,
            chart,
            sigma_mm,
            rotations,
            pivots_mm,
            ranges_of,
            patterns: Vec::new(),
            pattern_of: Vec::new(),
            shifts: Vec::new(),
        };
        joint.find_patterns();
        joint
    }

    /// With effects of known size in the geometry.
    pub(crate) fn shifted(self, shifts: Vec<Shift>) -> Self {
        Self { shifts, ..self }
    }

    /// One pattern for all blocks that see the same.
    fn find_patterns(&mut self) {
        let mut kinds = Kinds::default();
        for ranges in self.ranges_of.iter() {
            let (kind, is_new) = kinds.number(ranges.iter().map(|&r| self.network.seen_by(r)));
            if is_new {
                let mut pattern = Pattern::new();
                for &range in ranges {
                    pattern.push(&[0, 1, 2, 3, 4, 5], &self.shared_of(range as usize));
                }
                self.patterns.push(pattern);
            }
            self.pattern_of.push(kind);
        }
    }

    /// Shared parameters of a range: station, dead path, mount.
    pub(crate) fn shared_of(&self, range: usize) -> Vec<usize> {
        let r = &self.network.survey.ranges[range];
        let station = self.chart.moves(r.station).iter().map(|(p, _)| *p);
        let mount = self.mount_start() + 3 * r.mount;
        let dead_path = self.dead_path_start() + self.network.dead_path_of(r);
        let curves = self.curve_start()..self.curve_start() + self.curves.len();
        station.chain([dead_path, mount, mount + 1, mount + 2]).chain(curves).collect()
    }

    /// Index of the first dead path among the shared parameters.
    pub(crate) fn dead_path_start(&self) -> usize {
        self.chart.dim()
    }

    /// Index of the first reflector's coordinate among the shared parameters.
    pub(crate) fn mount_start(&self) -> usize {
        self.chart.dim() + self.network.dead_paths.len()
    }

    /// Index of the first amplitude of the axis' location among the shared parameters.
    pub(crate) fn curve_start(&self) -> usize {
        self.mount_start() + 3 * self.network.survey.mounts.len()
    }

    /// Angles without errors of their own.
    pub(crate) fn held(&self) -> Vec<usize> {
        held(self.network.axis_model, self.network.angles.len())
    }

    /// A start as parameters: the first angle's errors are zero, whatever frame the axis is in.
    pub(crate) fn start(&self, start: &Start) -> BorderedPoint {
        let first = self.network.nominal(0);
        let mounts = start.mounts.iter().flat_map(|m| {
            let at = first.inverse() * start.moved * first * Point3::from(*m);
            <[f64; 3]>::from(at.coords)
        });
        let blocks = (0..self.network.angles.len()).flat_map(|k| {
            if k == 0 || self.network.axis_model != AxisModel::Free {
                return [0.0; 6];
            }
            let nominal = self.network.nominal(k);
            let origin = Translation3::from(self.network.pivot_mm(k).coords);
            // Where the body is, against where the nominal turn from the first angle takes it.
            let body = start.moved * nominal * (start.moved * first).inverse() * first;
            let error = origin.inverse() * body * nominal.inverse() * origin;
            let rotation = so3::log(&error.rotation);
            let moved = error.translation.vector;
            [moved.x, moved.y, moved.z, rotation.x, rotation.y, rotation.z]
        });
        let stations = self.chart.parameters(&start.stations);
        let shared = stations.iter().copied().chain(start.dead_paths.iter().copied()).chain(mounts);
        let shared = shared.chain(std::iter::repeat_n(0.0, self.curves.len()));
        BorderedPoint { shared: shared.collect(), blocks: blocks.collect() }
    }

    /// The reflector of a range, in the frame that turns with the axis.
    #[inline(always)]
    pub(crate) fn body_mm(&self, range: usize, shared: &[f64]) -> Vector3<f64> {
        let at = self.mount_start() + 3 * self.network.survey.ranges[range].mount;
        let moved = self.shifts.get(range).map_or(Vector3::zeros(), |shift| shift.mount_mm);
        Vector3::new(shared[at], shared[at + 1], shared[at + 2]) + moved
    }

    /// What all ranges of an angle share.
    #[inline(always)]
    fn at_angle<'s>(
        &'s self,
        angle: usize,
        shared: &'s [f64],
        places: Places<'s>,
        point: &[f64],
    ) -> AtAngle<'s> {
        let error = self.error(angle, shared, point);
        let block = Block::of(&error);
        let n_mounts = self.network.survey.mounts.len();
        let are_few = n_mounts <= FEW && places.are_known && self.shifts.is_empty();
        let reflectors = are_few.then(|| {
            let mut reflectors = [Reflector::default(); FEW];
            for (mount, reflector) in reflectors.iter_mut().enumerate().take(n_mounts) {
                let at = self.mount_start() + 3 * mount;
                let body_mm = Vector3::new(shared[at], shared[at + 1], shared[at + 2]);
                *reflector = self.reflector(angle, &body_mm, &block);
            }
            reflectors
        });
        AtAngle { angle, shared, places, error, block, reflectors }
    }

    /// Where a reflector is at an angle.
    #[inline(always)]
    fn reflector(&self, angle: usize, body_mm: &Vector3<f64>, block: &Block) -> Reflector {
        let (pivot_mm, from_pivot_mm) = &self.pivots_mm[angle];
        let arm_mm = block.turned * (self.rotations[angle] * body_mm + from_pivot_mm);
        Reflector { arm_mm, at_mm: pivot_mm + block.displacement_mm + arm_mm }
    }

    /// From the station of a range to its reflector, and from the displaced axis to that, machine frame.
    #[inline(always)]
    fn lines(&self, range: usize, at: &AtAngle<'_>, block: &Block) -> (Vector3<f64>, Vector3<f64>) {
        let r = &self.network.survey.ranges[range];
        let station_mm = at.places.at_mm(r.station);
        if let Some(known) = &at.reflectors {
            let Reflector { arm_mm, at_mm } = known[r.mount];
            return (at_mm - station_mm, arm_mm);
        }
        let moved_mm = self.shifts.get(range).map_or(Vector3::zeros(), |shift| shift.station_mm);
        let reflector = self.reflector(at.angle, &self.body_mm(range, at.shared), block);
        (reflector.at_mm - (station_mm + moved_mm), reflector.arm_mm)
    }

    /// Errors at an angle whose own are `point`.
    #[inline(always)]
    fn error(&self, angle: usize, shared: &[f64], point: &[f64]) -> Vector6<f64> {
        let own = Vector6::from_column_slice(point);
        if self.curves.len() == 0 {
            return own;
        }
        own + self.curves.error(angle, &shared[self.curve_start()..])
    }

    /// The block that a range sees where effects add to the errors of its angle.
    #[inline(always)]
    fn shifted_block(&self, range: usize, error: &Vector6<f64>) -> Option<Block> {
        let shift = self.shifts.get(range)?;
        Some(Block::of(&(error + shift.error)))
    }

    /// Residual and derivatives of a range at the errors `point` of its angle.
    pub(crate) fn slopes_at(
        &self,
        range: usize,
        angle: usize,
        shared: &[f64],
        point: &[f64],
    ) -> Slopes {
        self.slopes(range, &self.at_angle(angle, shared, self.chart.place(shared), point))
    }

    /// Residual of a range in mm, and the path that it is of.
    #[inline(always)]
    fn residual_mm(&self, range: usize, shared: &[f64], along: &Vector3<f64>) -> (f64, f64) {
        let path = along.norm();
        let range = &self.network.survey.ranges[range];
        let dead_path = shared[self.dead_path_start() + self.network.dead_path_of(range)];
        (path - dead_path - range.displacement_mm, path)
    }

    #[inline(always)]
    fn slopes(&self, range: usize, at: &AtAngle<'_>) -> Slopes {
        let shifted = self.shifted_block(range, &at.error);
        let block = shifted.as_ref().unwrap_or(&at.block);
        let (along, arm) = self.lines(range, at, block);
        let (residual_mm, path) = self.residual_mm(range, at.shared, &along);
        let beam = along * path.recip();
        Slopes {
            residual_mm,
            along_mm: along,
            beam,
            by_rotation: block.jacobian.tr_mul(&arm.cross(&beam)),
            by_mount: self.rotations[at.angle].tr_mul(&block.turned.tr_mul(&beam)),
        }
    }
}

/// Reflectors whose places at an angle are worked out once for all of its ranges.
const FEW: usize = 8;

/// What all ranges of an angle share.
struct AtAngle<'a> {
    angle: usize,
    shared: &'a [f64],
    places: Places<'a>,
    error: Vector6<f64>,
    block: Block,
    /// `None` where they are more than fit, differ from range to range, or are asked for once only.
    reflectors: Option<[Reflector; FEW]>,
}

/// Where a reflector is at an angle, and from the displaced axis to it, machine frame.
#[derive(Clone, Copy, Default)]
struct Reflector {
    arm_mm: Vector3<f64>,
    at_mm: Vector3<f64>,
}

/// Six errors as what they do.
struct Block {
    displacement_mm: Vector3<f64>,
    turned: Matrix3<f64>,
    jacobian: Matrix3<f64>,
}

impl Block {
    fn of(point: &Vector6<f64>) -> Self {
        let rotation = Vector3::new(point[3], point[4], point[5]);
        Self {
            displacement_mm: Vector3::new(point[0], point[1], point[2]),
            turned: so3::exp(&rotation).to_rotation_matrix().into_inner(),
            jacobian: so3::left_jacobian(&rotation),
        }
    }
}

impl BorderedProblem for Joint<'_> {
    fn shared_dim(&self) -> usize {
        self.curve_start() + self.curves.len()
    }

    fn block_dim(&self) -> usize {
        6
    }

    fn block_count(&self) -> usize {
        self.network.angles.len()
    }

    fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    fn pattern_of(&self, block: usize) -> usize {
        self.pattern_of[block]
    }

    #[inline(always)]
    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
        let at = self.at_angle(block, shared, self.chart.places(shared), point);
        for (&range, out) in self.ranges_of.at(block).iter().zip(out) {
            let range = range as usize;
            let shifted = self.shifted_block(range, &at.error);
            let along = self.lines(range, &at, shifted.as_ref().unwrap_or(&at.block)).0;
            *out = self.residual_mm(range, shared, &along).0 / self.sigma_mm;
        }
    }

    #[inline(always)]
    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
        let at = self.at_angle(block, shared, self.chart.places(shared), point);
        let curves = self.curves.at(block, &shared[self.curve_start()..]).slopes;
        let weight = 1.0 / self.sigma_mm;
        let by_block = rows.by_block.as_chunks_mut::<6>().0.iter_mut();
        let mut by_shared = rows.by_shared.iter_mut();
        let ranges = self.ranges_of.at(block).iter().map(|&range| range as usize);
        for ((range, residual), by_block) in ranges.zip(rows.residuals).zip(by_block) {
            let slopes = self.slopes(range, &at);
            *residual = weight * slopes.residual_mm;
            *by_block = (weight * slopes.by_error()).into();
            let mut put = |value: f64| {
                *by_shared.next().expect("a number for each derivative") = value;
            };
            let station = self.network.survey.ranges[range].station;
            for (_, way) in self.chart.moves(station) {
                put(-weight * way.dot(&slopes.beam));
            }
            put(-weight);
            (weight * slopes.by_mount).iter().for_each(|value| put(*value));
            for curve in &curves {
                put(weight * slopes.by_error().dot(curve));
            }
        }
    }

    fn shared_residual_count(&self) -> usize {
        self.chart.prior_mm.map_or(0, |_| self.chart.dim())
    }

    fn linearise_shared(&self, shared: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) {
        self.chart.linearise_prior(shared, residuals, jacobian);
    }

    fn shared_name(&self, index: usize) -> String {
        if index >= self.curve_start() {
            return location_name(self.network.survey.axis.letter, index - self.curve_start());
        }
        if index >= self.mount_start() {
            let at = index - self.mount_start();
            let mount = &self.network.survey.mounts[at / 3].name;
            return format!("{} of mount {mount} (mm)", ["x", "y", "z"][at % 3]);
        }
        self.network.name_of_shared(self.chart, index)
    }

    fn block_name(&self, block: usize, index: usize) -> String {
        let letter = self.network.axis(self.network.angles[block].axis).letter;
        let angle_deg = self.network.angles[block].angle_rad.to_degrees();
        let unit = if index < 3 { "mm" } else { "rad" };
        format!("{} at {angle_deg:.4}° ({unit})", letter.error_names()[index])
    }
}

impl Readings for Joint<'_> {
    fn range_count(&self, block: usize) -> usize {
        self.ranges_of.at(block).len()
    }
}
