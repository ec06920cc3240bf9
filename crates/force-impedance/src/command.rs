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

/// What is wrong with a cycle's input; the last safe output is held.
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
    /// The lengths belong to no pose within the limits.
    Lengths,
    /// The normal is no unit vector, or too far from the tool's axis.
    Normal,
}

/// What the controller is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The tool is in contact, the force is controlled.
    Controlling,
    /// The tool touches nothing and approaches at no more than the approach rate.
    NoContact,
    /// The input is good again; output still held.
    Recovering,
    /// Output held.
    Held(Fault),
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

    /// The tip was kept to its rate.
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
}

/// What to do until the next cycle; always finite, within limits and rate.
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
