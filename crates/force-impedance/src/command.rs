use nalgebra::{Point3, Vector3};

use crate::ContactForce;

/// What the sensors say in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// `l1, l2, l3, l4`; `None` when no sample arrived.
    pub lengths_mm: Option<[f64; 4]>,
    /// Load cells, compression positive; `None` when no sample arrived.
    pub cells_n: Option<[f64; 4]>,
    /// Outward unit normal of the workpiece at the programmed point, frame Y.
    pub normal: Vector3<f64>,
    /// Contact force asked for.
    pub reference_n: f64,
}

/// A set of load cells, counted from 0 in the order of the readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    bits: u8,
}

impl Cells {
    pub(crate) const fn one(cell: usize) -> Self {
        Self { bits: 1 << (cell & 3) }
    }

    pub(crate) const fn and(self, other: Self) -> Self {
        Self { bits: self.bits | other.bits }
    }

    /// Whether a cell, 0 to 3, is one of them.
    #[must_use]
    pub const fn has(self, cell: usize) -> bool {
        cell < 4 && self.bits & (1 << (cell & 3)) != 0
    }

    /// One bit per cell, the first leg's lowest.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.bits
    }
}

/// What is wrong with a cycle's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The interval is not a number, not positive, under half or over ten times the nominal one.
    Interval,
    /// No sample of the cells or of the lengths.
    NoSample,
    /// A reading is NaN or infinite.
    NotFinite,
    /// A cell reads more than it can.
    CellRange,
    /// The cells have stopped changing.
    Frozen,
    /// The lengths belong to no pose.
    Lengths,
    /// The normal is no unit vector, or too far from the tool's axis.
    Normal,
    /// These cells have stopped changing while others go on.
    CellStuck(Cells),
    /// The cells contradict each other; these explain it best.
    CellsDisagree(Cells),
}

impl Fault {
    /// Cells that are to be looked at.
    #[must_use]
    pub const fn suspects(self) -> Cells {
        match self {
            Self::CellStuck(cells) | Self::CellsDisagree(cells) => cells,
            _ => Cells { bits: 0 },
        }
    }
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The tool is in contact, the force is controlled.
    Controlling,
    /// The tool touches nothing and approaches at no more than the approach rate.
    NoContact,
    /// The input is good again; output still held, or, after `hold_cycles`, moved away from the
    /// workpiece while the force is above what is asked for.
    Recovering,
    /// Output held: the tip stops, and stays.
    Held(Fault),
    /// The tip moves away from the workpiece: the force is above what is asked for, or has not been
    /// known for too long.
    Retracting(Fault),
}

/// Which limits cut the output of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    bits: u8,
}

impl Limits {
    pub(crate) const ERROR: u8 = 1;
    pub(crate) const REFERENCE: u8 = 2;
    pub(crate) const RATE: u8 = 4;
    pub(crate) const TRAVEL: u8 = 8;
    pub(crate) const WORKSPACE: u8 = 16;
    pub(crate) const OUTSIDE: u8 = 32;

    pub(crate) fn set(&mut self, bit: u8, on: bool) {
        if on {
            self.bits |= bit;
        }
    }

    const fn has(self, bit: u8) -> bool {
        self.bits & bit != 0
    }

    /// Whether any limit was reached.
    #[must_use]
    pub const fn any(self) -> bool {
        self.bits != 0
    }

    /// The force error was saturated.
    #[must_use]
    pub const fn error(self) -> bool {
        self.has(Self::ERROR)
    }

    /// The reference asked for was out of range or no number.
    #[must_use]
    pub const fn reference(self) -> bool {
        self.has(Self::REFERENCE)
    }

    /// The tip was kept to its speed, acceleration or jerk.
    #[must_use]
    pub const fn rate(self) -> bool {
        self.has(Self::RATE)
    }

    /// The correction was kept within its travel.
    #[must_use]
    pub const fn travel(self) -> bool {
        self.has(Self::TRAVEL)
    }

    /// The tip was kept within the head's workspace.
    #[must_use]
    pub const fn workspace(self) -> bool {
        self.has(Self::WORKSPACE)
    }

    /// The head was seen outside its limits; the tip is on its way back.
    #[must_use]
    pub const fn outside(self) -> bool {
        self.has(Self::OUTSIDE)
    }
}

/// What to do until the next cycle; always finite, within limits, speed, acceleration and jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Lengths to command, `l1, l2, l3, l4`.
    pub lengths_mm: [f64; 4],
    /// Where they put the tip.
    pub tip_mm: Point3<f64>,
    /// Correction along the normal in force.
    pub offset_mm: f64,
    /// Reference in force, after its ramp.
    pub reference_n: f64,
    /// Contact force of this cycle; `None` when the input was no good.
    pub contact: Option<ContactForce>,
    /// What the controller is doing.
    pub status: Status,
    /// What cut the output.
    pub limits: Limits,
    /// Cycles since the output was last free.
    pub held_cycles: u32,
}
