//! Tables of commanded and solved displacements as a model for the loop.

use model_discrepancy::{
    Covariate, Declared, Effect, Group, Inside, Layout, Model, Proposal, Quantity, Role, Row,
    Scope, State, resolution_of,
};
use nalgebra::{DMatrix, DVector};

use crate::error::require_positive;
use crate::missing::axis_run::AxisTerm;
use crate::missing::parameter::parameter;
use crate::{FtCenterError, Table};

/// Lateral force times height over load of a proposed move, in units of the longest move.
const LEVER_RATIO: f64 = 0.5;

/// Standard uncertainty of a known weight over its size: a class M1 weight.
const WEIGHT_RATIO: f64 = 5e-5;

/// Standard uncertainty of an interferometer over the length measured, in air of known
/// temperature and pressure.
const TRAVEL_RATIO: f64 = 1e-6;

/// One row of a table of displacements.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Displacement {
    /// Name of the row.
    pub point: String,
    /// How far the machine moved.
    pub commanded_mm: f64,
    /// How far the sensor found it to have moved.
    pub solved_mm: f64,
}

/// Solved against commanded displacements; the declared model claims that they are equal.
///
/// Residual: solved − commanded, in mm; the declared model has no parameters. Loads are not in
/// the table, so biases are in terms of the load there was, and every gain looks alike.
#[derive(Clone, Debug)]
pub struct DisplacementModel {
    declared: Declared,
    rows: Vec<Observed>,
    /// What the axis may do, after the catalogue of the sensor.
    axis: Vec<AxisTerm>,
}

/// What one row observes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Observed {
    /// A displacement found by the sensor.
    Moved {
        commanded_mm: f64,
        solved_mm: f64,
        /// Load over that of the table.
        load_ratio: f64,
        /// `z0 Fx / Fz`: what lateral force adds to the lever arm of the moment.
        lever_mm: f64,
    },
    /// A travel of the machine measured by an independent length standard.
    Travel { length_mm: f64 },
    /// A known weight, in units of the table's load, on the sensor.
    Weight,
}

/// The catalogue, in the order of [`Declared::effects`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    DatumOffset,
    MomentBias,
    MomentGain,
    ForceGain,
    FrameScale,
    ForceBias,
}

const KINDS: [Kind; 6] = [
    Kind::DatumOffset,
    Kind::MomentBias,
    Kind::MomentGain,
    Kind::ForceGain,
    Kind::FrameScale,
    Kind::ForceBias,
];

impl DisplacementModel {
    /// Builds the model of a table; `sigma_mm` is the declared standard uncertainty of a solved
    /// displacement, `None` lets the residual tell.
    ///
    /// # Errors
    ///
    /// [`FtCenterError::Empty`], [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`].
    pub fn new(rows: &[Displacement], sigma_mm: Option<f64>) -> Result<Self, FtCenterError> {
        if rows.is_empty() {
            return Err(FtCenterError::Empty { of: Table::Displacements });
        }
        let finite = |r: &Displacement| r.commanded_mm.is_finite() && r.solved_mm.is_finite();
        if let Some(index) = rows.iter().position(|r| !finite(r)) {
            return Err(FtCenterError::NotFinite { index });
        }
        if let Some(sigma_mm) = sigma_mm {
            require_positive(sigma_mm, "sigma_mm")?;
        }
        let layout = Layout {
            unit: "mm".to_owned(),
            sigma_declared: sigma_mm.is_some(),
            ..Layout::default()
        };
        let effects = KINDS.iter().map(|kind| kind.effect()).collect();
        let declared = Declared {
            resolution: resolution_of(rows.iter().map(|r| r.solved_mm)),
            ..Declared::new(layout, Vec::new(), effects)
        };
        let mut model = Self { declared, rows: Vec::new(), axis: Vec::new() };
        for r in rows {
            let observed = Observed::Moved {
                commanded_mm: r.commanded_mm,
                solved_mm: r.solved_mm,
                load_ratio: 1.0,
                lever_mm: 0.0,
            };
            model.push(&r.point, observed, sigma_mm.unwrap_or(1.0), Role::Fit);
        }
        Ok(model)
    }

    /// The same where the axis itself may be off, as a run over its targets shows; one value per row.
    #[must_use]
    pub fn with_axis(mut self, terms: Vec<AxisTerm>) -> Self {
        self.declared.effects.extend(terms.iter().map(|term| term.effect.clone()));
        self.axis.extend(terms);
        self
    }

    /// The commanded displacement as a covariate for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        let moved = |row: &Observed| match row {
            Observed::Moved { commanded_mm, .. } => Some(*commanded_mm),
            Observed::Travel { .. } | Observed::Weight => None,
        };
        vec![Covariate::coordinate(
            "commanded_mm",
            Quantity::Position,
            self.rows.iter().filter_map(moved).collect(),
        )]
    }

    fn push(&mut self, name: &str, observed: Observed, sigma: f64, role: Role) {
        let observation = self.rows.len();
        let reported = matches!(observed, Observed::Moved { .. });
        self.rows.push(observed);
        self.declared.layout.rows.push(Row { observation, component: 0, sigma, reported });
        self.declared.layout.observations.push(observation);
        self.declared.layout.groups.push(Group { name: name.to_owned(), role });
    }

    /// The same moves again under other conditions.
    fn moved_again(&self, load_ratio: f64, lever_mm: f64) -> Self {
        let mut extended = self.clone();
        for (i, row) in self.rows.iter().enumerate() {
            if let Observed::Moved { commanded_mm, solved_mm, .. } = *row {
                // Levers of either sign, so that they are no constant offset.
                let lever_mm = if i % 2 == 0 { lever_mm } else { -lever_mm };
                let again = Observed::Moved { commanded_mm, solved_mm, load_ratio, lever_mm };
                extended.push("proposed", again, self.declared.layout.rows[i].sigma, Role::Fit);
            }
        }
        extended
    }

    fn with_standard(mut self, standard: Observed, sigma: f64) -> Self {
        self.push("standard", standard, sigma, Role::Prior);
        self
    }

    /// What a unit of an amplitude of the axis adds to a row; rows of a proposed measurement repeat
    /// those of the table, and a standard does not move.
    fn added(&self, term: &AxisTerm, amplitude: usize, row: usize) -> f64 {
        let column = &term.columns[amplitude];
        let is_elsewhere = |scope| matches!(scope, Scope::Observation(only) if only != row);
        match self.rows[row] {
            _ if is_elsewhere(term.effect.scope) => 0.0,
            Observed::Moved { .. } => column[row % column.len()],
            Observed::Travel { .. } | Observed::Weight => 0.0,
        }
    }

    fn longest_mm(&self) -> f64 {
        let length = |row: &Observed| match row {
            Observed::Moved { commanded_mm, .. } => commanded_mm.abs(),
            Observed::Travel { .. } | Observed::Weight => 0.0,
        };
        self.rows.iter().map(length).fold(0.0, f64::max)
    }
}

impl Model for DisplacementModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let a = KINDS.map(|kind| at.amplitudes[kind as usize][0]);
        let mut residuals =
            DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.residual(&a)));
        for (term, amplitudes) in self.axis.iter().zip(&at.amplitudes[KINDS.len()..]) {
            for (k, &amplitude) in amplitudes.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                let moved = residuals.iter_mut().enumerate();
                moved.for_each(|(row, r)| *r -= amplitude * self.added(term, k, row));
            }
        }
        residuals
    }

    fn base_jacobian(&self, _at: &State) -> DMatrix<f64> {
        DMatrix::zeros(self.rows.len(), 0)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        if let Some(term) = effect.checked_sub(KINDS.len()).map(|axis| &self.axis[axis]) {
            if let Scope::Observation(row) = term.effect.scope {
                return DMatrix::from_element(1, 1, -self.added(term, 0, row));
            }
            let columns = term.columns.len();
            return DMatrix::from_fn(self.rows.len(), columns, |row, k| -self.added(term, k, row));
        }
        let a = KINDS.map(|kind| at.amplitudes[kind as usize][0]);
        let rows = self.rows.iter().map(|row| row.derivative(&a, KINDS[effect]));
        DMatrix::from_iterator(self.rows.len(), 1, rows)
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        let longest_mm = self.longest_mm();
        let loaded = || self.moved_again(2.0, 0.0);
        let travel = Observed::Travel { length_mm: longest_mm };
        let travel_sigma_mm = TRAVEL_RATIO * longest_mm.max(1.0);
        vec![
            Proposal::new("press at a second load", move || Some(loaded())),
            Proposal::new(
                "press at a second load, and with a lateral force, the head tilted to either side",
                move || Some(self.moved_again(2.0, LEVER_RATIO * longest_mm)),
            ),
            Proposal::new(
                "press at a second load, and put a known weight on the sensor",
                move || Some(loaded().with_standard(Observed::Weight, WEIGHT_RATIO)),
            ),
            Proposal::new(
                "press at a second load, and measure the machine's travel with an independent \
                 length standard, e.g. a laser interferometer",
                move || Some(loaded().with_standard(travel, travel_sigma_mm)),
            ),
        ]
    }
}

/// Amplitudes, indexed by [`Kind`].
type Amplitudes = [f64; 6];

impl Observed {
    /// `x` the true displacement, `e` the lever: the sensor reads
    /// `(x + (x − e) g_M) / (1 + g_F + b_F/ratio) + b_M/ratio + offset`.
    fn residual(&self, a: &Amplitudes) -> f64 {
        let scale = 1.0 + a[Kind::FrameScale as usize];
        match *self {
            Self::Moved { commanded_mm, solved_mm, load_ratio, lever_mm } => {
                let x = commanded_mm * scale;
                let moment = x + (x - lever_mm) * a[Kind::MomentGain as usize];
                let shift =
                    a[Kind::MomentBias as usize] / load_ratio + a[Kind::DatumOffset as usize];
                solved_mm - moment / Self::force_reading(a, load_ratio) - shift
            }
            Self::Travel { length_mm } => length_mm - length_mm * scale,
            Self::Weight => 1.0 - Self::force_reading(a, 1.0),
        }
    }

    /// What the sensor reads of a unit of force.
    fn force_reading(a: &Amplitudes, load_ratio: f64) -> f64 {
        1.0 + a[Kind::ForceGain as usize] + a[Kind::ForceBias as usize] / load_ratio
    }

    fn derivative(&self, a: &Amplitudes, by: Kind) -> f64 {
        match *self {
            Self::Moved { commanded_mm, load_ratio, lever_mm, .. } => {
                let x = commanded_mm * (1.0 + a[Kind::FrameScale as usize]);
                let gain = a[Kind::MomentGain as usize];
                let force = Self::force_reading(a, load_ratio);
                let by_force = (x + (x - lever_mm) * gain) / (force * force);
                match by {
                    Kind::DatumOffset => -1.0,
                    Kind::MomentBias => -1.0 / load_ratio,
                    Kind::MomentGain => -(x - lever_mm) / force,
                    Kind::ForceGain => by_force,
                    Kind::FrameScale => -commanded_mm * (1.0 + gain) / force,
                    Kind::ForceBias => by_force / load_ratio,
                }
            }
            Self::Travel { length_mm } => match by {
                Kind::FrameScale => -length_mm,
                _ => 0.0,
            },
            Self::Weight => match by {
                Kind::ForceGain | Kind::ForceBias => -1.0,
                _ => 0.0,
            },
        }
    }
}

impl Kind {
    fn effect(self) -> Effect {
        let (id, subject, description, parameter) = match self {
            Self::DatumOffset => (
                "datum-offset",
                None,
                "machine and sensor count from different origins",
                parameter("offset", "mm", 1.0),
            ),
            Self::MomentBias => (
                "sensor-bias",
                Some("moment"),
                "the sensor reads a constant moment under no load",
                parameter("bias over load", "mm", 1.0),
            ),
            Self::MomentGain => (
                "moment-gain",
                None,
                "the sensor reads moments too large by a ratio",
                parameter("gain error", "%", 100.0),
            ),
            Self::ForceGain => (
                "force-gain",
                None,
                "the sensor reads Fz too large by a ratio",
                parameter("gain error", "%", 100.0),
            ),
            Self::FrameScale => (
                "frame-scale",
                None,
                "the machine moves farther than it says by a ratio",
                parameter("scale error", "%", 100.0),
            ),
            Self::ForceBias => (
                "sensor-bias",
                Some("normal force"),
                "the sensor reads a constant normal force under no load",
                parameter("bias over load", "%", 100.0),
            ),
        };
        // Nothing was moved: only constants show.
        let scope = match self {
            Self::DatumOffset | Self::MomentBias => Scope::Everywhere,
            _ => Scope::SomeDesigns,
        };
        let subject = subject.map(str::to_owned);
        Effect { subject, scope, ..Effect::new(id, description, vec![parameter]) }
    }
}
