//! What the declared frame of the presses may leave out.

use model_discrepancy::{Effect, Parameter, Scope, State};
use nalgebra::{DVector, Vector2};

use crate::missing::parameter::parameter;
use crate::missing::sensor_errors::{SensorError, SensorErrors};

/// Share by which no sensor reads too much or too little, or one channel of another: a third, as of a load
/// cell; the unit nearest to a newton would make four times as much of it.
const NO_SENSOR: f64 = 1.0 / 3.0;
/// Share by which no machine moves farther than it says.
const NO_MACHINE: f64 = 0.1;
/// Moment per force that no sensor reads across: of one for 200 N and 10 N·m a fiftieth of full scale is
/// 1 mm.
const NO_CROSSTALK_MM: f64 = 10.0;
/// The same the other way round, per mm: there a fiftieth is 4·10⁻⁴.
const NO_CROSSTALK_PER_MM: f64 = 0.01;
/// Error of a contact height beyond which it is that of another platform.
const NO_PLATFORM_MM: f64 = 30.0;

/// One effect of the catalogue, as code sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PressEffect {
    MomentBias,
    FzBias,
    MomentDrift,
    FzDrift,
    MomentGain,
    MomentGainDifference,
    FzGain,
    Shear,
    MomentIntoFz,
    FzIntoMoment,
    LateralIntoMoment,
    ContactHeight,
    PlatformTilt,
    Slip,
    /// In a guide whose play is round.
    SlipAlong,
    /// Farther the larger friction is against the load: to the centres another contact height.
    SlipByRatio,
    LateralCompliance,
    LoadShift,
    /// Of the machine against the sensor, evenly.
    Drift,
    /// The same along the course of this index.
    Course(usize),
    /// Of the moment read under no load along the course of this index.
    MomentCourse(usize),
    FrameScale,
    DatumOffset,
    /// Follows the temperature column of this index.
    Temperature(usize),
    /// The observation of this index.
    BadPress(usize),
}

/// Errors of the machine, as amplitudes of effects; all zero in the declared model.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MachineErrors {
    pub(crate) load_shift_mm_per_n: Vector2<f64>,
    /// Over the whole session.
    pub(crate) drift_mm: Vector2<f64>,
    pub(crate) scale: f64,
    pub(crate) datum_mm: Vector2<f64>,
    /// One per temperature column.
    pub(crate) growth_mm_per_k: Vec<Vector2<f64>>,
}

/// What drifts along a course come to in the end, one per course; zero in those of the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AlongCourses {
    /// The machine against the sensor.
    pub(crate) machine_mm: Vec<Vector2<f64>>,
    /// The moment read under no load.
    pub(crate) moment_nmm: Vec<Vector2<f64>>,
}

impl PressEffect {
    /// Amplitudes that belong to the sensor; empty for those of the machine.
    pub(crate) fn sensor_errors(self) -> &'static [SensorError] {
        use SensorError as E;
        match self {
            Self::MomentBias => &[E::MomentBias(0), E::MomentBias(1)],
            Self::FzBias => &[E::FzBias],
            Self::MomentDrift => &[E::MomentDrift(0), E::MomentDrift(1)],
            Self::FzDrift => &[E::FzDrift],
            Self::MomentGain => &[E::MomentGain],
            Self::MomentGainDifference => &[E::MomentGainDifference],
            Self::FzGain => &[E::FzGain],
            Self::Shear => &[E::Shear],
            Self::MomentIntoFz => &[E::MomentIntoFz(0), E::MomentIntoFz(1)],
            Self::FzIntoMoment => &[E::FzIntoMoment(0), E::FzIntoMoment(1)],
            Self::LateralIntoMoment => &[
                E::LateralIntoMoment(0, 0),
                E::LateralIntoMoment(0, 1),
                E::LateralIntoMoment(1, 0),
                E::LateralIntoMoment(1, 1),
            ],
            Self::ContactHeight => &[E::Height],
            Self::PlatformTilt => &[E::Slope(0), E::Slope(1)],
            Self::Slip => &[E::Slip(0), E::Slip(1)],
            Self::SlipAlong => &[E::SlipAlong],
            Self::SlipByRatio => &[E::SlipByRatio],
            Self::LateralCompliance => &[E::Give],
            Self::LoadShift
            | Self::Drift
            | Self::Course(_)
            | Self::MomentCourse(_)
            | Self::FrameScale
            | Self::DatumOffset
            | Self::Temperature(_)
            | Self::BadPress(_) => &[],
        }
    }

    /// Adds this effect's amplitudes to the errors of sensor and machine.
    pub(crate) fn apply(
        self,
        amplitude: &DVector<f64>,
        sensor: &mut SensorErrors,
        machine: &mut MachineErrors,
        along: &mut AlongCourses,
    ) {
        let pair = || Vector2::new(amplitude[0], amplitude[1]);
        match self {
            Self::MomentBias => sensor.moment_bias_nmm = pair(),
            Self::FzBias => sensor.fz_bias_n = amplitude[0],
            Self::MomentDrift => sensor.moment_drift_nmm = pair(),
            Self::FzDrift => sensor.fz_drift_n = amplitude[0],
            Self::MomentGain => sensor.moment_gain = amplitude[0],
            Self::MomentGainDifference => sensor.moment_gain_difference = amplitude[0],
            Self::FzGain => sensor.fz_gain = amplitude[0],
            Self::Shear => sensor.shear = amplitude[0],
            Self::MomentIntoFz => sensor.moment_into_fz_per_mm = pair(),
            Self::FzIntoMoment => sensor.fz_into_moment_mm = pair(),
            Self::LateralIntoMoment => {
                let entries = amplitude.fixed_rows::<4>(0);
                sensor
                    .lateral_into_moment_mm
                    .copy_from_slice(&[entries[0], entries[2], entries[1], entries[3]]);
            }
            Self::ContactHeight => sensor.height_mm = amplitude[0],
            Self::PlatformTilt => sensor.slope = pair(),
            Self::Slip => sensor.slip_mm = pair(),
            Self::SlipAlong => sensor.slip_along_mm = amplitude[0],
            Self::SlipByRatio => sensor.slip_by_ratio_mm = amplitude[0],
            Self::LateralCompliance => sensor.give_mm_per_n = amplitude[0],
            Self::LoadShift => machine.load_shift_mm_per_n = pair(),
            Self::Drift => machine.drift_mm = pair(),
            Self::Course(course) => along.machine_mm[course] = pair(),
            Self::MomentCourse(course) => along.moment_nmm[course] = pair(),
            Self::FrameScale => machine.scale = amplitude[0],
            Self::DatumOffset => machine.datum_mm = pair(),
            Self::Temperature(column) => machine.growth_mm_per_k[column] = pair(),
            Self::BadPress(_) => {}
        }
    }

    /// What the frame leaves out, or when it holds; `None` for what is in it and in the centres.
    pub(crate) fn condition(self, described: &Effect) -> Option<String> {
        let in_corrections = "is in the corrections of the presses";
        match self {
            Self::LoadShift => {
                Some(format!("the frame holds without load; the shift by load {in_corrections}"))
            }
            Self::Drift | Self::Course(_) => {
                Some(format!("the frame holds at the first press; the drift {in_corrections}"))
            }
            Self::Temperature(_) => {
                let column = described.driver.as_deref().unwrap_or("a temperature");
                Some(format!("the frame holds at {column} = 20 °C; the growth {in_corrections}"))
            }
            Self::BadPress(_) => {
                let press = described.subject.as_deref().unwrap_or_default();
                Some(format!(
                    "the frame is that of the other presses; the correction of {press} is its own \
                     error"
                ))
            }
            _ => None,
        }
    }

    fn description(self) -> Effect {
        let (id, subject, text, parameters) = self.entry();
        let subject = (!subject.is_empty()).then(|| subject.to_owned());
        let (scope, maximum) = (self.scope(), self.maximum());
        Effect { subject, scope, maximum, ..Effect::new(id, text, parameters) }
    }

    /// What needs more is no physics of sensor and machine: a channel in another unit, or another case.
    fn maximum(self) -> Option<f64> {
        match self {
            Self::MomentGain | Self::MomentGainDifference | Self::FzGain | Self::Shear => {
                Some(NO_SENSOR)
            }
            Self::FrameScale => Some(NO_MACHINE),
            Self::LateralIntoMoment => Some(NO_CROSSTALK_MM),
            Self::MomentIntoFz => Some(NO_CROSSTALK_PER_MM),
            Self::ContactHeight | Self::SlipByRatio => Some(NO_PLATFORM_MM),
            _ => None,
        }
    }

    /// Where no force acts sideways, where temperature stands at 20 °C, some show nothing.
    fn scope(self) -> Scope {
        match self {
            Self::MomentBias
            | Self::FzBias
            | Self::FzGain
            | Self::MomentGain
            | Self::FrameScale
            | Self::DatumOffset
            | Self::LoadShift => Scope::Everywhere,
            _ => Scope::SomeDesigns,
        }
    }

    #[expect(clippy::too_many_lines, reason = "a table: one entry per effect")]
    fn entry(self) -> (&'static str, &'static str, &'static str, Vec<Parameter>) {
        let axes = |unit: &str, factor: f64| {
            vec![parameter("x", unit, factor), parameter("y", unit, factor)]
        };
        let moments = |unit: &str| vec![parameter("mx", unit, 1.0), parameter("my", unit, 1.0)];
        match self {
            Self::MomentBias => (
                "sensor-bias",
                "moment",
                "the sensor reads a constant moment under no load",
                moments("N·mm"),
            ),
            Self::FzBias => (
                "sensor-bias",
                "normal force",
                "the sensor reads a constant normal force under no load",
                vec![parameter("fz", "N", 1.0)],
            ),
            Self::MomentDrift | Self::MomentCourse(_) => (
                "bias-drift",
                "moment",
                "the moment read under no load drifts evenly from the first press to the last",
                moments("N·mm"),
            ),
            Self::FzDrift => (
                "bias-drift",
                "normal force",
                "the normal force read under no load drifts evenly from the first press to the last",
                vec![parameter("fz", "N", 1.0)],
            ),
            Self::MomentGain => (
                "moment-gain",
                "",
                "the sensor reads Mx and My too large by the same ratio",
                vec![parameter("gain error", "ppm", 1e6)],
            ),
            Self::MomentGainDifference => (
                "moment-gain",
                "mx against my",
                "the sensor reads Mx too large and My too small by the same ratio",
                vec![parameter("gain error", "ppm", 1e6)],
            ),
            Self::FzGain => (
                "force-gain",
                "",
                "the sensor reads Fz too large by a ratio",
                vec![parameter("gain error", "ppm", 1e6)],
            ),
            Self::Shear => (
                "crosstalk",
                "mx and my",
                "Mx reads a share of My and My the same share of Mx",
                vec![parameter("share", "ppm", 1e6)],
            ),
            Self::MomentIntoFz => (
                "crosstalk",
                "moments into fz",
                "Fz reads a share of the moments",
                vec![parameter("of mx", "N/(N·m)", 1e3), parameter("of my", "N/(N·m)", 1e3)],
            ),
            Self::FzIntoMoment => (
                "crosstalk",
                "fz into moments",
                "the moments read a share of Fz",
                vec![parameter("into mx", "mm", 1.0), parameter("into my", "mm", 1.0)],
            ),
            Self::LateralIntoMoment => (
                "crosstalk",
                "lateral forces into moments",
                "the moments read a share of Fx and Fy",
                ["fx into mx", "fy into mx", "fx into my", "fy into my"]
                    .map(|name| parameter(name, "mm", 1.0))
                    .to_vec(),
            ),
            Self::ContactHeight => (
                "contact-height",
                "",
                "the contact plane lies higher than z0",
                vec![parameter("height error", "mm", 1.0)],
            ),
            Self::PlatformTilt => (
                "platform-tilt",
                "",
                "the contact plane is tilted against the sensor's xy plane",
                vec![
                    parameter("slope along x", "mrad", 1e3),
                    parameter("slope along y", "mrad", 1e3),
                ],
            ),
            Self::Slip => (
                "slip",
                "",
                "friction shifts the head within the play of its guide, by the same amount along each \
                 axis of the sensor whatever the force",
                axes("µm", 1e3),
            ),
            Self::SlipAlong => (
                "slip",
                "round guide",
                "friction shifts the head within the play of its round guide, by the same amount \
                 whatever the force and its direction",
                vec![parameter("along the friction", "µm", 1e3)],
            ),
            Self::SlipByRatio => (
                "slip",
                "friction over load",
                "friction shifts the head the farther, the larger it is against the load",
                vec![parameter("per ratio", "mm", 1.0)],
            ),
            Self::LateralCompliance => (
                "lateral-compliance",
                "",
                "the head gives way along the lateral force in proportion to it",
                vec![parameter("compliance", "µm/N", 1e3)],
            ),
            Self::LoadShift => (
                "load-shift",
                "",
                "the head gives way sideways in proportion to the load",
                axes("µm/N", 1e3),
            ),
            Self::Drift | Self::Course(_) => (
                "drift",
                "machine",
                "the machine drifts against the sensor from the first press to the last",
                axes("µm", 1e3),
            ),
            Self::FrameScale => (
                "frame-scale",
                "",
                "the machine moves farther than it says by a ratio",
                vec![parameter("scale error", "ppm", 1e6)],
            ),
            Self::DatumOffset => (
                "datum-offset",
                "",
                "machine and sensor count from different origins",
                axes("mm", 1.0),
            ),
            Self::Temperature(_) => (
                "temperature",
                "",
                "the head moves with temperature, from 20 °C",
                axes("µm/K", 1e3),
            ),
            Self::BadPress(_) => {
                ("bad-press", "", "one press was not where the machine says", axes("mm", 1.0))
            }
        }
    }
}

/// The catalogue, in the order of the model's effects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Catalogue {
    pub(crate) effects: Vec<PressEffect>,
}

impl Catalogue {
    /// All effects, with one per temperature column, and one per fitted press, given by
    /// observation and name.
    ///
    /// Besides, the same for people.
    pub(crate) fn new(temperatures: &[String], presses: &[(usize, String)]) -> (Self, Vec<Effect>) {
        let mut all = Vec::new();
        for effect in [
            PressEffect::FzBias,
            PressEffect::MomentBias,
            PressEffect::MomentDrift,
            PressEffect::FzDrift,
            PressEffect::FzGain,
            PressEffect::MomentGain,
            PressEffect::FrameScale,
            PressEffect::MomentGainDifference,
            PressEffect::Shear,
            PressEffect::MomentIntoFz,
            PressEffect::FzIntoMoment,
            PressEffect::LateralIntoMoment,
            PressEffect::ContactHeight,
            PressEffect::PlatformTilt,
            PressEffect::Slip,
            PressEffect::SlipAlong,
            PressEffect::SlipByRatio,
            PressEffect::LateralCompliance,
            PressEffect::LoadShift,
            PressEffect::Drift,
            PressEffect::DatumOffset,
        ] {
            all.push((effect, effect.description()));
        }
        for (column, name) in temperatures.iter().enumerate() {
            let effect = PressEffect::Temperature(column);
            let subject = (temperatures.len() > 1).then(|| name.clone());
            let driver = Some(name.clone());
            all.push((effect, Effect { subject, driver, ..effect.description() }));
        }
        for (observation, name) in presses {
            let effect = PressEffect::BadPress(*observation);
            let subject = Some(name.clone());
            all.push((effect, Effect { subject, ..effect.description() }));
        }
        let (effects, described) = all.into_iter().unzip();
        (Self { effects }, described)
    }

    /// Errors of sensor and machine at the amplitudes of `at`.
    pub(crate) fn errors(&self, at: &State) -> (SensorErrors, MachineErrors, AlongCourses) {
        let none = |is: fn(&&PressEffect) -> bool| {
            vec![Vector2::zeros(); self.effects.iter().filter(is).count()]
        };
        let courses = none(|e| matches!(e, PressEffect::Course(_) | PressEffect::MomentCourse(_)));
        let mut along = AlongCourses { machine_mm: courses.clone(), moment_nmm: courses };
        let growth_mm_per_k = none(|e| matches!(e, PressEffect::Temperature(_)));
        let mut sensor = SensorErrors::default();
        let mut machine = MachineErrors { growth_mm_per_k, ..MachineErrors::default() };
        for (effect, amplitude) in self.effects.iter().zip(&at.amplitudes) {
            effect.apply(amplitude, &mut sensor, &mut machine, &mut along);
        }
        (sensor, machine, along)
    }
}
