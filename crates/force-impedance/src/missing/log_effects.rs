//! What the declared head may leave out.

use model_discrepancy::{Effect, Parameter, Scope};

use crate::missing::log_blocks::Block;

/// One effect of the catalogue, as code sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LogEffect {
    /// Zero of a load cell.
    CellZero(usize),
    /// Zero of a length sensor.
    LengthZero(usize),
    CellGain(usize),
    HeadWeight,
    /// The same where no weight was declared, nor where it is.
    HeadWeightAnywhere,
    /// Friction counted as normal force (full balance), or left out (published formula).
    FrictionShare,
    FrictionLeftOut,
    SplineFriction,
    Drift,
    /// The same along another course, by its index.
    Course(usize),
    Delay,
    /// Follows the temperature column of this index.
    Temperature(usize),
}

/// No load cell reads too large or too small by more: a third.
const GROSS_GAIN: f64 = 1.0 / 3.0;
/// No more of the friction at the contact is read as normal force than all of it.
const WHOLE: f64 = 1.0;
/// No tool rubs on a workpiece with a larger coefficient of friction: rubber on dry steel has one.
const GROSS_FRICTION: f64 = 2.0;

/// A moment of one newton metre is as large as a weight of some newtons: both amplitudes are alike.
const NMM_PER_NM: f64 = 1e3;

const SENSORS: [&str; 4] = ["leg 1", "leg 2", "leg 3", "axial"];

impl LogEffect {
    /// The catalogue for a log with these temperature columns, of a head whose weight has a place or not.
    pub(crate) fn catalogue(published: bool, is_placed: bool, n_warmth: usize) -> Vec<Self> {
        let mut all: Vec<Self> = (0..4).map(Self::CellZero).collect();
        all.extend((0..4).map(Self::LengthZero));
        all.extend((0..4).map(Self::CellGain));
        let friction = if published { Self::FrictionLeftOut } else { Self::FrictionShare };
        let weight =
            if published || is_placed { Self::HeadWeight } else { Self::HeadWeightAnywhere };
        all.extend([weight, friction, Self::SplineFriction, Self::Drift, Self::Delay]);
        all.extend((0..n_warmth).map(Self::Temperature));
        all
    }

    /// Derivatives of a block's force residual by the amplitudes, for all effects that are linear.
    pub(crate) fn force_tangent(self, block: &Block) -> [f64; 2] {
        let s = &block.sensitivity;
        let only = match self {
            Self::HeadWeightAnywhere => {
                return [s.per_weight_at_joint, NMM_PER_NM * s.per_moment];
            }
            Self::CellZero(i) => s.per_cell[i],
            Self::LengthZero(i) => s.per_length[i],
            Self::CellGain(i) => s.of_cell_n[i],
            Self::HeadWeight => s.per_weight,
            Self::FrictionShare => s.tangential_n,
            Self::SplineFriction => block.slide_normal,
            Self::Drift => block.elapsed_share,
            Self::Temperature(column) => block.warmth_k[column],
            Self::FrictionLeftOut | Self::Course(_) | Self::Delay => 0.0,
        };
        [only, 0.0]
    }

    /// The same of a block's consistency residual.
    pub(crate) fn consistency_tangent(self, block: &Block) -> f64 {
        match self {
            Self::LengthZero(i) => block.sensitivity.consistency_per_length[i],
            _ => 0.0,
        }
    }

    /// The effect for people; `warm` names the temperature columns.
    pub(crate) fn description(self, warm: &[String]) -> Effect {
        let (id, subject, text, parameter) = self.entry(warm);
        let mut parameters = vec![parameter];
        if self == Self::HeadWeightAnywhere {
            let (name, unit) = ("its moment about the joint".to_owned(), "N·mm".to_owned());
            parameters.push(Parameter { name, unit, report_factor: NMM_PER_NM });
        }
        let driver = match self {
            Self::Temperature(column) => Some(warm[column].clone()),
            _ => None,
        };
        // A log without a reference shows lengths alone, and a head that stands still little.
        let scope = Scope::SomeDesigns;
        let maximum = self.maximum();
        Effect { subject, driver, scope, maximum, ..Effect::new(id, text, parameters) }
    }

    /// What needs more is no physics of a head: a cell in another unit, a reference of another log.
    fn maximum(self) -> Option<f64> {
        match self {
            Self::CellGain(_) => Some(GROSS_GAIN),
            Self::FrictionShare => Some(WHOLE),
            Self::FrictionLeftOut => Some(GROSS_FRICTION),
            _ => None,
        }
    }

    fn entry(self, warm: &[String]) -> (&'static str, Option<String>, &'static str, Parameter) {
        let number = |name: &str, unit: &str, report_factor: f64| Parameter {
            name: name.to_owned(),
            unit: unit.to_owned(),
            report_factor,
        };
        let of = |what: &str, i: usize| Some(format!("{what}, {}", SENSORS[i]));
        match self {
            Self::CellZero(i) => (
                "leg-zero",
                of("force", i),
                "a load cell reads a constant force under no load",
                number("zero", "N", 1.0),
            ),
            Self::LengthZero(i) => (
                "leg-zero",
                of("length", i),
                "a length sensor reads a constant length too much",
                number("zero", "µm", 1e3),
            ),
            Self::CellGain(i) => (
                "leg-gain",
                of("force", i),
                "a load cell reads too large by a ratio",
                number("gain error", "%", 100.0),
            ),
            Self::HeadWeight | Self::HeadWeightAnywhere => (
                "head-weight",
                None,
                "the head is heavier than declared",
                number("missing weight", "N", 1.0),
            ),
            Self::FrictionShare => (
                "contact-friction",
                None,
                "a share of the friction at the contact is read as normal force",
                number("share of the friction", "%", 100.0),
            ),
            Self::FrictionLeftOut => (
                "contact-friction",
                None,
                "the tool rubs on the workpiece, which the formula leaves out",
                number("coefficient of friction", "", 1.0),
            ),
            Self::SplineFriction => (
                "spline-friction",
                None,
                "friction of the spline takes force past the axial cell, against the direction of sliding",
                number("friction force", "N", 1.0),
            ),
            Self::Drift | Self::Course(_) => (
                "force-drift",
                None,
                "the force drifts evenly from the first sample to the last",
                number("drift over the log", "N", 1.0),
            ),
            Self::Delay => (
                "delay",
                None,
                "the reference is read later than the legs",
                number("delay", "ms", 1e3),
            ),
            Self::Temperature(column) => (
                "temperature",
                Some(warm[column].clone()),
                "the force read follows a temperature, counted from 20 °C",
                number("force per kelvin", "N/K", 1.0),
            ),
        }
    }
}
