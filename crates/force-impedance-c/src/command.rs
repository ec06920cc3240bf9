use force_impedance::{Command, Fault, Measurement, Status};
use nalgebra::Vector3;

use crate::FiContact;

/// What the sensors say in one cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiMeasurement {
    /// l1, l2, l3, l4.
    pub lengths_mm: [f64; 4],
    /// Load cells, compression positive.
    pub cells_n: [f64; 4],
    /// Outward unit normal of the workpiece at the programmed point, frame Y.
    pub normal: [f64; 3],
    /// Contact force asked for.
    pub reference_n: f64,
    /// Not zero when a sample of the lengths arrived.
    pub has_lengths: u32,
    /// Not zero when a sample of the cells arrived.
    pub has_cells: u32,
}

impl From<&FiMeasurement> for Measurement {
    fn from(seen: &FiMeasurement) -> Self {
        Self {
            lengths_mm: (seen.has_lengths != 0).then_some(seen.lengths_mm),
            cells_n: (seen.has_cells != 0).then_some(seen.cells_n),
            normal: Vector3::from(seen.normal),
            reference_n: seen.reference_n,
        }
    }
}

/// What the controller is doing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiStatus {
    /// The tool is in contact, the force is controlled.
    Controlling = 0,
    /// The tool touches nothing and approaches at no more than the approach rate.
    NoContact = 1,
    /// The input is good again; output still held, or, after `hold_cycles`, moved away from the
    /// workpiece while the force is above what is asked for.
    Recovering = 2,
    /// Output held: the tip stops, and stays; `fault` says why.
    Held = 3,
    /// The tip moves away from the workpiece: the force is above what is asked for, or has not been
    /// known for too long; `fault` says why.
    Retracting = 4,
}

/// What is wrong with a cycle's input.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiFault {
    /// Nothing.
    None = 0,
    /// The interval is no number, not positive, under half or over ten times the nominal one.
    Interval = 1,
    /// No sample of the cells or of the lengths.
    NoSample = 2,
    /// A reading is NaN or infinite.
    NotFinite = 3,
    /// A cell reads more than it can.
    CellRange = 4,
    /// The cells have stopped changing.
    Frozen = 5,
    /// The lengths belong to no pose.
    Lengths = 6,
    /// The normal is no unit vector, or too far from the tool's axis.
    Normal = 7,
    /// Something that this version of the interface has no name for.
    Unnamed = 8,
    /// A cell has stopped changing while others go on; `suspects` says which.
    CellStuck = 9,
    /// The cells contradict each other; `suspects` explain it best.
    CellsDisagree = 10,
}

impl From<Fault> for FiFault {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Interval => Self::Interval,
            Fault::NoSample => Self::NoSample,
            Fault::NotFinite => Self::NotFinite,
            Fault::CellRange => Self::CellRange,
            Fault::Frozen => Self::Frozen,
            Fault::Lengths => Self::Lengths,
            Fault::Normal => Self::Normal,
            Fault::CellStuck(_) => Self::CellStuck,
            Fault::CellsDisagree(_) => Self::CellsDisagree,
            _ => Self::Unnamed,
        }
    }
}

/// Bits of `FiCommand.limits`: what cut the output of a cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiLimit {
    /// The force error was saturated.
    Error = 1,
    /// The reference asked for was out of range or no number.
    Reference = 2,
    /// The tip was kept to its speed, acceleration or jerk.
    Rate = 4,
    /// The correction was kept within its travel.
    Travel = 8,
    /// The tip was kept within the head's workspace.
    Workspace = 16,
    /// The head was seen outside its limits; the tip is on its way back.
    Outside = 32,
}

/// What to do until the next cycle; always finite, within limits, speed, acceleration and jerk.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiCommand {
    /// Lengths to command, l1, l2, l3, l4.
    pub lengths_mm: [f64; 4],
    /// Where they put the tip.
    pub tip_mm: [f64; 3],
    /// Correction along the normal in force.
    pub offset_mm: f64,
    /// Reference in force, after its ramp.
    pub reference_n: f64,
    /// Contact force of this cycle; all NaN when the input was no good.
    pub contact: FiContact,
    /// What the controller is doing.
    pub status: FiStatus,
    /// Why the output is held, or the tip retracts.
    pub fault: FiFault,
    /// Bits of `FiLimit`.
    pub limits: u32,
    /// Cycles since the output was last free.
    pub held_cycles: u32,
    /// One bit per cell that the fault names, the first leg's lowest.
    pub suspects: u32,
}

const NO_CONTACT: FiContact = FiContact {
    force_n: [f64::NAN; 3],
    normal_n: f64::NAN,
    tangential_n: f64::NAN,
    friction_ratio: f64::NAN,
};

impl From<&Command> for FiCommand {
    fn from(command: &Command) -> Self {
        let (status, fault) = match command.status {
            Status::Controlling => (FiStatus::Controlling, FiFault::None),
            Status::NoContact => (FiStatus::NoContact, FiFault::None),
            Status::Recovering => (FiStatus::Recovering, FiFault::None),
            Status::Held(fault) => (FiStatus::Held, fault.into()),
            Status::Retracting(fault) => (FiStatus::Retracting, fault.into()),
        };
        let suspects = match command.status {
            Status::Held(fault) | Status::Retracting(fault) => fault.suspects().bits(),
            _ => 0,
        };
        let limits = command.limits;
        let bit = |on: bool, bit: FiLimit| if on { bit as u32 } else { 0 };
        Self {
            lengths_mm: command.lengths_mm,
            tip_mm: command.tip_mm.coords.into(),
            offset_mm: command.offset_mm,
            reference_n: command.reference_n,
            contact: command.contact.as_ref().map_or(NO_CONTACT, FiContact::from),
            status,
            fault,
            limits: bit(limits.error(), FiLimit::Error)
                | bit(limits.reference(), FiLimit::Reference)
                | bit(limits.rate(), FiLimit::Rate)
                | bit(limits.travel(), FiLimit::Travel)
                | bit(limits.workspace(), FiLimit::Workspace)
                | bit(limits.outside(), FiLimit::Outside),
            held_cycles: command.held_cycles,
            suspects: suspects.into(),
        }
    }
}
