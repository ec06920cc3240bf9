//! What the calibration of a free-hanging tool may leave out.

use std::ops::Range;

use geometry::so3;
use model_discrepancy::{Effect, Parameter, Scope};
use nalgebra::{DMatrix, DVector, Matrix3, Unit, UnitQuaternion, Vector3, Vector6};

use crate::missing::parameter::parameter;

/// One effect of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GravityEffect {
    /// The zero of some channels follows this many drivers from the first on.
    Zero {
        of: Channels,
        first: usize,
        drivers: usize,
    },
    ForceGain,
    MomentGain,
    ForceCrosstalk,
    /// What one force reads of another, and not the other way round.
    ForceIntoForce {
        of: usize,
        into: usize,
    },
    ForceIntoMoment,
    PlatformTilt,
    MountRotation,
}

/// Channels of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channels {
    Force,
    Moment,
    All,
}

/// Driver of the zero that goes on evenly, from 0 at the first pose to 1 at the last.
pub(crate) const ELAPSED: usize = 0;

/// What every case is asked for.
pub(crate) const GRAVITY_EFFECTS: [GravityEffect; 14] = [
    GravityEffect::Zero { of: Channels::Force, first: ELAPSED, drivers: 1 },
    GravityEffect::Zero { of: Channels::Moment, first: ELAPSED, drivers: 1 },
    GravityEffect::ForceGain,
    GravityEffect::MomentGain,
    GravityEffect::ForceCrosstalk,
    GravityEffect::ForceIntoForce { of: 0, into: 1 },
    GravityEffect::ForceIntoForce { of: 0, into: 2 },
    GravityEffect::ForceIntoForce { of: 1, into: 0 },
    GravityEffect::ForceIntoForce { of: 1, into: 2 },
    GravityEffect::ForceIntoForce { of: 2, into: 0 },
    GravityEffect::ForceIntoForce { of: 2, into: 1 },
    GravityEffect::ForceIntoMoment,
    GravityEffect::PlatformTilt,
    GravityEffect::MountRotation,
];

/// Amplitudes of all effects; zero in the declared model.
///
/// A reading is `force (I + F) W·g + zero`, `moment (I + G)(r × W·g) + K W·g + zero`; the zero is that
/// of the base parameters and, for each driver, its value times an amplitude.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GravityErrors {
    /// Per unit of each driver.
    pub(crate) zero: Vec<Vector6<f64>>,
    /// `F`: gains on the diagonal, cross-talk beside it.
    pub(crate) force: Matrix3<f64>,
    /// `G`: diagonal.
    pub(crate) moment: Matrix3<f64>,
    /// `K`: symmetric; its skew part is a shift of the centre of gravity.
    pub(crate) force_into_moment_mm: Matrix3<f64>,
    /// Rotation of gravity against the base, about two axes across it.
    pub(crate) tilt_rad: [f64; 2],
    /// Rotation of the sensor's axes against the orientation given.
    pub(crate) mount_rad: Vector3<f64>,
}

/// Entries of a symmetric matrix: the diagonal, then xy, xz, yz.
const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Channels of a force.
const FORCES: [&str; 3] = ["fx", "fy", "fz"];

impl Channels {
    /// Of a wrench `[force, moment]`.
    pub(crate) fn range(self) -> Range<usize> {
        match self {
            Self::Force => 0..3,
            Self::Moment => 3..6,
            Self::All => 0..6,
        }
    }
}

impl GravityEffect {
    /// Writes an amplitude into the errors.
    pub(crate) fn apply(self, amplitude: &DVector<f64>, errors: &mut GravityErrors) {
        let triple = || Vector3::from_column_slice(&amplitude.as_slice()[..3]);
        match self {
            Self::Zero { of, first, drivers } => {
                let channels = of.range();
                let each = amplitude.as_slice().chunks(channels.len());
                for (zero, values) in errors.zero[first..first + drivers].iter_mut().zip(each) {
                    channels.clone().zip(values).for_each(|(k, value)| zero[k] += value);
                }
            }
            Self::ForceGain => errors.force += Matrix3::from_diagonal(&triple()),
            Self::MomentGain => errors.moment = Matrix3::from_diagonal(&triple()),
            Self::ForceCrosstalk => {
                let entries = SYMMETRIC[3..].iter().zip(amplitude.iter());
                errors.force += entries.map(|(at, a)| unit(*at) * *a).sum::<Matrix3<f64>>();
            }
            Self::ForceIntoForce { of, into } => errors.force[(into, of)] += amplitude[0],
            Self::ForceIntoMoment => {
                let entries = SYMMETRIC.iter().zip(amplitude.iter());
                errors.force_into_moment_mm = entries.map(|(at, a)| unit(*at) * *a).sum();
            }
            Self::PlatformTilt => errors.tilt_rad = [amplitude[0], amplitude[1]],
            Self::MountRotation => errors.mount_rad = triple(),
        }
    }

    /// When bias, weight and centre of gravity hold, and what they leave out.
    pub(crate) fn condition(self, described: &Effect) -> String {
        let corrections = "is in the corrections of the poses";
        match self {
            Self::Zero { of: Channels::All, .. } => {
                let column = described.driver.as_deref().unwrap_or("a temperature");
                format!("the bias holds at {column} = 20 °C; its change beyond {corrections}")
            }
            Self::Zero { .. } => {
                format!("the bias is that of the first pose; its drift {corrections}")
            }
            Self::ForceGain | Self::MomentGain => format!(
                "weight and centre of gravity are as the axes read them that have no gain among the \
                 parameters of {}; what the others read more {corrections}",
                described.id
            ),
            _ => format!(
                "weight and centre of gravity are those without {}, whose part {corrections}",
                described.id
            ),
        }
    }

    pub(crate) fn described(self) -> Effect {
        let (id, subject, description, parameters) = self.entry();
        // A sensor that is turned about one line only never sees some of its axes loaded.
        let scope = match self {
            Self::Zero { .. } => Scope::Everywhere,
            _ => Scope::SomeDesigns,
        };
        let subject = match self {
            Self::ForceIntoForce { of, into } => {
                Some(format!("{} into {}", FORCES[of], FORCES[into]))
            }
            _ => subject.map(str::to_owned),
        };
        Effect { subject, scope, ..Effect::new(id, description, parameters) }
    }

    fn entry(self) -> (&'static str, Option<&'static str>, &'static str, Vec<Parameter>) {
        let named = |names: &[&str], unit: &str, factor: f64| {
            names.iter().map(|name| parameter(name, unit, factor)).collect::<Vec<_>>()
        };
        let (forces, moments) = (FORCES, ["mx", "my", "mz"]);
        match self {
            Self::Zero { of: Channels::Force, .. } => (
                "bias-drift",
                Some("force"),
                "the force read under no load drifts evenly from the first pose to the last",
                named(&forces, "N", 1.0),
            ),
            Self::Zero { of: Channels::Moment, .. } => (
                "bias-drift",
                Some("moment"),
                "the moment read under no load drifts evenly from the first pose to the last",
                named(&moments, "N·mm", 1.0),
            ),
            Self::ForceGain => (
                "force-gain",
                None,
                "the sensor's axes read forces with unequal gains",
                named(&forces, "%", 100.0),
            ),
            Self::MomentGain => (
                "moment-gain",
                None,
                "the sensor's axes read moments with unequal gains",
                named(&moments, "%", 100.0),
            ),
            Self::ForceCrosstalk => (
                "crosstalk",
                Some("forces"),
                "each force reads a share of the others, the same both ways",
                named(&["fx and fy", "fx and fz", "fy and fz"], "%", 100.0),
            ),
            Self::ForceIntoForce { .. } => (
                "crosstalk",
                None,
                "one force reads a share of another, and not the other way round",
                named(&["share"], "%", 100.0),
            ),
            Self::ForceIntoMoment => (
                "crosstalk",
                Some("forces into moments"),
                "the moments read a share of the forces",
                named(
                    &["mx of fx", "my of fy", "mz of fz", "x and y", "x and z", "y and z"],
                    "mm",
                    1.0,
                ),
            ),
            Self::PlatformTilt => (
                "platform-tilt",
                None,
                "the base is not level",
                named(&["about axis 1", "about axis 2"], "mrad", 1e3),
            ),
            Self::MountRotation => (
                "mount-rotation",
                None,
                "the sensor's axes are turned against the orientation given",
                named(&["about x", "about y", "about z"], "mrad", 1e3),
            ),
            Self::Zero { of: Channels::All, .. } => {
                let mut parameters = named(&forces, "N/K", 1.0);
                parameters.extend(named(&moments, "N·mm/K", 1.0));
                ("temperature", None, "the zero of the sensor follows the temperature", parameters)
            }
        }
    }
}

/// 1 at an entry and at its mirror image.
fn unit((row, column): (usize, usize)) -> Matrix3<f64> {
    let mut unit = Matrix3::zeros();
    unit[(row, column)] = 1.0;
    unit[(column, row)] = 1.0;
    unit
}

/// Direction of gravity in sensor axes, with its derivatives by tilt and mount rotation.
pub(crate) struct Down {
    pub(crate) direction: Vector3<f64>,
    /// By the rotation of gravity about the base's x, y, z.
    by_base: Matrix3<f64>,
    /// By `mount_rad`.
    by_mount: Matrix3<f64>,
}

/// Two axes across gravity.
pub(crate) fn across(gravity: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let first = gravity.cross(&Vector3::ith(gravity.iamin(), 1.0)).normalize();
    [first, gravity.cross(&first)]
}

impl Down {
    pub(crate) fn of(
        base_from_sensor: &UnitQuaternion<f64>,
        gravity: &Unit<Vector3<f64>>,
        errors: &GravityErrors,
    ) -> Self {
        let [first, second] = across(gravity);
        let tilt = first * errors.tilt_rad[0] + second * errors.tilt_rad[1];
        let tilted = so3::exp(&tilt) * gravity.into_inner();
        let turn = so3::exp(&-errors.mount_rad) * base_from_sensor.inverse();
        let direction = turn * tilted;
        let rotation = turn.to_rotation_matrix().into_inner();
        Self {
            direction,
            by_base: -rotation * tilted.cross_matrix() * so3::left_jacobian(&tilt),
            by_mount: direction.cross_matrix() * so3::left_jacobian(&-errors.mount_rad),
        }
    }
}

/// What one pose should read, in parts that derivatives need.
pub(crate) struct Predicted<'a> {
    pub(crate) errors: &'a GravityErrors,
    pub(crate) down: Down,
    pub(crate) weight_n: f64,
    pub(crate) arm_mm: Vector3<f64>,
    pub(crate) drivers: &'a [f64],
}

impl Predicted<'_> {
    /// Force and moment, zero left out.
    pub(crate) fn wrench(&self) -> Vector6<f64> {
        let load = self.down.direction * self.weight_n;
        let zero = self.errors.zero.iter().zip(self.drivers);
        self.by_load(load) + zero.map(|(per_unit, driver)| per_unit * *driver).sum::<Vector6<f64>>()
    }

    /// Linear in the load.
    pub(crate) fn by_load(&self, load: Vector3<f64>) -> Vector6<f64> {
        let e = self.errors;
        let moment = self.arm_mm.cross(&load);
        stacked(load + e.force * load, moment + e.moment * moment + e.force_into_moment_mm * load)
    }

    /// Derivative by the centre of gravity.
    pub(crate) fn by_arm(&self, axis: usize) -> Vector6<f64> {
        let moment = Vector3::ith(axis, 1.0).cross(&(self.down.direction * self.weight_n));
        stacked(Vector3::zeros(), moment + self.errors.moment * moment)
    }

    /// Derivative by the amplitudes of one effect, `6 × parameters`.
    pub(crate) fn derivative(
        &self,
        effect: GravityEffect,
        gravity: &Unit<Vector3<f64>>,
    ) -> DMatrix<f64> {
        let load = self.down.direction * self.weight_n;
        let moment = self.arm_mm.cross(&load);
        let none = Vector3::zeros();
        let axis = |k: usize| Vector3::ith(k, 1.0);
        let columns: Vec<Vector6<f64>> = match effect {
            GravityEffect::Zero { of, first, drivers } => self.drivers[first..first + drivers]
                .iter()
                .flat_map(|driver| of.range().map(|k| Vector6::ith(k, *driver)))
                .collect(),
            GravityEffect::ForceGain => (0..3).map(|k| stacked(axis(k) * load[k], none)).collect(),
            GravityEffect::MomentGain => {
                (0..3).map(|k| stacked(none, axis(k) * moment[k])).collect()
            }
            GravityEffect::ForceCrosstalk => {
                SYMMETRIC[3..].iter().map(|&at| stacked(unit(at) * load, none)).collect()
            }
            GravityEffect::ForceIntoForce { of, into } => {
                vec![stacked(axis(into) * load[of], none)]
            }
            GravityEffect::ForceIntoMoment => {
                SYMMETRIC.iter().map(|&at| stacked(none, unit(at) * load)).collect()
            }
            GravityEffect::PlatformTilt => across(gravity)
                .iter()
                .map(|a| self.by_load(self.down.by_base * a * self.weight_n))
                .collect(),
            GravityEffect::MountRotation => {
                (0..3).map(|k| self.by_load(self.down.by_mount.column(k) * self.weight_n)).collect()
            }
        };
        DMatrix::from_fn(6, columns.len(), |row, column| columns[column][row])
    }
}

fn stacked(force: Vector3<f64>, moment: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}
