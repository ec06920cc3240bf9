//! What the effects do to a touch.

use model_discrepancy::Patch;
use nalgebra::{DVector, Point3, Unit, Vector3};

use super::form::{Form, FormScale};

/// What one effect does.
#[derive(Clone, Debug)]
pub(crate) enum Term {
    /// The ball is larger than declared.
    Ball,
    /// The machine is read this far behind the contact, along the approach.
    Pretravel,
    /// The same, for an approach from some sides more than from others: three seats make three
    /// lobes, and the sideways part of the approach takes them to this power.
    Lobing { power: i32 },
    /// The stylus gives way sideways.
    Bending,
    /// An axis stops behind where it is read, on the side that it came from; ways of every touch
    /// along the axes in `axes`. The first touch, whose ways are not known, is along its own.
    Reversal { ways: Vec<Vector3<f64>>, axes: Vec<usize> },
    /// The same of one axis, on the side that the ball came from along the approach.
    ApproachReversal { axis: usize },
    /// The same of one axis, on the side that a recorded column says, one sign for either.
    ColumnReversal { axis: usize, ways: Vec<f64> },
    /// The machine is read late: it has moved on by this time's travel.
    Latency { speed_mm_per_s: Vec<f64> },
    /// The workpiece frame lies beside where it is declared, along the axes in `axes`.
    Shift { axes: Vec<usize> },
    /// The workpiece frame is turned about the axes in `axes`.
    Turn { about_mm: Vector3<f64>, axes: Vec<usize> },
    /// The machine reads one axis long, from this place on.
    Scale { axis: usize, about_mm: f64 },
    /// The machine's axes are not square: `first += γ second` for each pair, `second` from this place on.
    Squareness { pairs: Vec<(usize, usize)>, about_mm: Vector3<f64> },
    /// Readings along the axes in `axes` go with time or order.
    Drift { elapsed: Vec<f64>, axes: Vec<usize> },
    /// The trigger goes with time or order: all touches come sooner or later.
    TriggerDrift { elapsed: Vec<f64> },
    /// Readings of z, and the part's size, go with a temperature.
    Temperature { excess_k: Vec<f64>, axes: Vec<usize>, about_mm: Vector3<f64> },
    /// The surface is not the nominal one, in the columns in `seen`.
    Form { form: Form, seen: Vec<usize>, scale: FormScale },
    /// It is higher in one place.
    Patch(Patch),
    /// These touches do not show it at all.
    Unseen,
    /// One touch is off on its own.
    BadPoint { observation: usize },
}

/// Where and how a touch was made, as declared.
pub(crate) struct Situation<'a> {
    pub(crate) observation: usize,
    /// Ball's centre on the nominal part: a place that no noise of the reading moves, so that no
    /// tangent follows the residual.
    pub(crate) center_mm: &'a Vector3<f64>,
    /// Contact on the nominal part.
    pub(crate) contact_mm: &'a Point3<f64>,
    /// Normal there, towards the ball.
    pub(crate) normal: &'a Unit<Vector3<f64>>,
    /// From the ball towards the part.
    pub(crate) approach: &'a Unit<Vector3<f64>>,
    /// Axis of the stylus.
    pub(crate) stylus: &'a Unit<Vector3<f64>>,
    /// Direction of azimuth zero of the probe, at right angles to the stylus.
    pub(crate) zero: &'a Unit<Vector3<f64>>,
}

/// Seats of a kinematic probe.
const SEATS: f64 = 3.0;
/// Sine below which an approach along the stylus has no azimuth.
const NO_AZIMUTH: f64 = 1e-3;

impl Situation<'_> {
    /// Part of the approach at right angles to the stylus.
    fn sideways(&self) -> Vector3<f64> {
        self.approach.into_inner() - self.stylus.into_inner() * self.stylus.dot(self.approach)
    }

    /// Lobes by azimuth, cos and sin, `sideⁿ` high.
    fn lobes(&self, power: i32) -> [f64; 2] {
        let sideways = self.sideways();
        let sine = sideways.norm();
        if sine < NO_AZIMUTH {
            return [0.0; 2];
        }
        let along = self.zero.dot(&sideways);
        let across = self.stylus.cross(self.zero).dot(&sideways);
        let angle = SEATS * across.atan2(along);
        [angle.cos(), angle.sin()].map(|v| v * sine.powi(power))
    }
}

impl Term {
    /// Whether it is an error of the part, and not of what measures it.
    pub(crate) fn is_of_the_part(&self) -> bool {
        matches!(self, Self::Form { .. } | Self::Patch(_))
    }

    /// What a drift has gone through at each touch; `None` of all else.
    pub(crate) fn elapsed(&self) -> Option<&[f64]> {
        match self {
            Self::Drift { elapsed, .. } | Self::TriggerDrift { elapsed } => Some(elapsed),
            _ => None,
        }
    }

    /// The same drift gone another way.
    pub(crate) fn gone(mut self, come: Vec<f64>) -> Self {
        if let Self::Drift { elapsed, .. } | Self::TriggerDrift { elapsed } = &mut self {
            *elapsed = come;
        }
        self
    }

    /// What a unit of each amplitude adds to the reading; empty where the effect does nothing to it.
    pub(crate) fn readings(&self, at: &Situation<'_>) -> Vec<Vector3<f64>> {
        let approach = at.approach.into_inner();
        let value = |of: &[f64]| of.get(at.observation).copied().unwrap_or(0.0);
        match self {
            Self::Pretravel => vec![approach],
            Self::Lobing { power } => at.lobes(*power).map(|lobe| approach * lobe).to_vec(),
            Self::Bending => vec![at.sideways()],
            Self::Reversal { ways, axes } => {
                let way = ways.get(at.observation).copied().unwrap_or_default();
                let first = if at.observation == 0 { approach } else { Vector3::zeros() };
                let along = axes.iter().map(|&axis| Vector3::ith(axis, way[axis]));
                along.chain([first]).collect()
            }
            Self::ApproachReversal { axis } => {
                let way = approach[*axis];
                vec![Vector3::ith(*axis, if way == 0.0 { 0.0 } else { way.signum() })]
            }
            Self::ColumnReversal { axis, ways } => vec![Vector3::ith(*axis, value(ways))],
            Self::Latency { speed_mm_per_s } => vec![approach * value(speed_mm_per_s)],
            Self::Shift { axes } => axes.iter().map(|&axis| Vector3::ith(axis, 1.0)).collect(),
            Self::Turn { about_mm, axes } => {
                let arm = at.center_mm - about_mm;
                axes.iter().map(|&axis| Vector3::ith(axis, 1.0).cross(&arm)).collect()
            }
            Self::Scale { axis, about_mm } => {
                vec![Vector3::ith(*axis, at.center_mm[*axis] - about_mm)]
            }
            Self::Squareness { pairs, about_mm } => {
                let arm = at.center_mm - about_mm;
                let reading = |&(first, second)| Vector3::ith(first, arm[second]);
                pairs.iter().map(reading).collect()
            }
            Self::Drift { elapsed, axes } => {
                let elapsed = value(elapsed);
                axes.iter().map(|&axis| Vector3::ith(axis, elapsed)).collect()
            }
            Self::TriggerDrift { elapsed } => vec![approach * value(elapsed)],
            Self::Temperature { excess_k, axes, .. } => {
                let excess_k = value(excess_k);
                let along = axes.iter().map(|&axis| Vector3::ith(axis, excess_k));
                along.chain([Vector3::zeros()]).collect()
            }
            Self::Ball
            | Self::Form { .. }
            | Self::Patch(_)
            | Self::Unseen
            | Self::BadPoint { .. } => Vec::new(),
        }
    }

    /// What a unit of each amplitude adds to the distance from the nominal surface, apart from
    /// [`Term::readings`]; empty where it adds nothing.
    pub(crate) fn distances(&self, at: &Situation<'_>) -> Vec<f64> {
        match self {
            Self::Ball => vec![1.0],
            Self::Temperature { excess_k, axes, about_mm } => {
                let excess_k = excess_k.get(at.observation).copied().unwrap_or(0.0);
                let growth = at.normal.dot(&(at.contact_mm.coords - about_mm)) * excess_k;
                axes.iter().map(|_| 0.0).chain([growth]).collect()
            }
            Self::Form { form, seen, scale } => {
                let heights = form.heights(scale, at.contact_mm);
                seen.iter().map(|&k| heights[k]).collect()
            }
            Self::Patch(patch) => vec![patch.share(at.contact_mm)],
            Self::BadPoint { observation } => {
                vec![f64::from(u8::from(*observation == at.observation))]
            }
            _ => Vec::new(),
        }
    }
}

/// Sum of the columns times the amplitudes.
pub(crate) fn combined(columns: &[Vector3<f64>], amplitudes: &DVector<f64>) -> Vector3<f64> {
    columns.iter().zip(amplitudes.iter()).fold(Vector3::zeros(), |sum, (c, a)| sum + c * *a)
}
