//! What may be wrong with a run of a tracer, and what a run gives.

/// What is wrong with the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Defect {
    /// Nothing.
    None,
    /// The tracer reads displacements too long, relative.
    RangeScale(f64),
    /// The laser warms up through the whole measurement, so that its wavelength drifts, of all the light on its
    /// way: total, relative, with the curve of a first-order settling of that time constant in shares of
    /// the whole.
    Warming(f64, f64),
    /// The reading creeps after every lock-on: total over a run of one lock, mm, with the
    /// curve of a first-order settling whose time constant is as long as the run.
    RangeDrift(f64),
    /// The reading of the tracer at one station creeps evenly after every lock-on: which, and total over
    /// a run of one lock, mm.
    Creep(usize, f64),
    /// A station's stand warms: which, and total over the whole measurement, mm.
    StationDrift(usize, [f64; 3]),
    /// Every stand warms, each in a direction of its own: total, mm.
    StandsDrift(f64),
    /// The machine is moved against all stations before a step: which, mm, and rad about the axis' origin.
    Moved(usize, [f64; 3], [f64; 3]),
    /// A stand is knocked before a step: which, at which, mm.
    Knocked(usize, usize, [f64; 3]),
    /// Play of the drive: the axis stops short by half of this either way, rad, and its bearing
    /// gives by the displacement, mm.
    Backlash(f64, [f64; 3]),
    /// Glass path of the reflectors: mm at grazing incidence, growing with the fourth power of the
    /// angle beside its square.
    Incidence(f64),
    /// The tracer at one station reads too long (a dirty air sensor there): which, relative.
    BadStation(usize, f64),
    /// The beam to one reflector is lost at a step and found again: station, mount, step, mm.
    DeadPathJump(usize, usize, usize, f64),
    /// A reflector slips in its magnetic nest: which, from which step on, mm.
    MountSlip(usize, usize, [f64; 3]),
    /// What was counted follows the recorded temperature of the air: relative per kelvin.
    Temperature(f64),
    /// The wavelength does, of all the light on its way, dead path included: relative per kelvin.
    Wavelength(f64),
    /// The axis is not where the drawing has it: displacement of its origin, mm, and tilt, rad.
    AxisMoved([f64; 3], [f64; 3]),
    /// One of the six errors of the axis: which, how often per turn, mm or rad, phase.
    AxisMotion(usize, u8, f64, f64),
    /// One reflector's bracket bends under its weight as the axis swings it: mm.
    Bending(usize, f64),
}

/// What a run gave.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub origin_mm: [f64; 3],
    pub direction: [f64; 3],
    /// True and nominal places.
    pub stations_mm: Vec<([f64; 3], [f64; 3])>,
    /// True and nominal places, turning frame.
    pub mounts_mm: Vec<([f64; 3], [f64; 3])>,
    /// Angle of every step, degrees, and whether it was reached with rising angles.
    pub steps: Vec<(f64, bool)>,
    /// Errors of the axis at every step: displacement mm, rotation rad.
    pub errors: Vec<([f64; 3], [f64; 3])>,
    /// In the order measured.
    pub readings: Vec<Reading>,
}

/// One reading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    pub station: usize,
    pub mount: usize,
    pub step: usize,
    pub time_s: f64,
    pub air_c: f64,
    pub displacement_mm: f64,
    /// What the defect made of it, mm.
    pub disturbance_mm: f64,
}
