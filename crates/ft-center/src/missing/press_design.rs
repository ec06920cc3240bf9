//! Presses as rows of a least-squares problem: residuals and their derivatives.

use std::f64::consts::FRAC_PI_2;

use geometry::Wrench;
use model_discrepancy::State;
use nalgebra::{DMatrix, Matrix2, Matrix2x3, Point2, Rotation2, Vector2, Vector3};

use crate::Handedness;
use crate::missing::press_effects::{AlongCourses, Catalogue, MachineErrors, PressEffect};
use crate::missing::sensor_errors::{Corrected, Reading, SensorError, SensorErrors};

/// Temperature from which growth counts, ISO 1.
pub(crate) const REFERENCE_C: f64 = 20.0;

/// One press: where it was and what the sensor read.
#[derive(Clone, Debug)]
pub(crate) struct PressPoint {
    pub(crate) machine_mm: Point2<f64>,
    pub(crate) reading: Reading,
    /// Covariance of the centre, sensor frame.
    pub(crate) covariance_mm2: Matrix2<f64>,
    /// One per temperature column, from 20 °C; empty where the press has none.
    pub(crate) warmth_k: Vec<f64>,
    /// How far a drift has come along each course that it may take.
    pub(crate) come: Vec<f64>,
    /// Which `bad-press` candidate is about it.
    pub(crate) observation: Option<usize>,
}

impl PressPoint {
    /// What drifts along courses have come to.
    fn along(&self, in_the_end: &[Vector2<f64>]) -> Vector2<f64> {
        in_the_end.iter().zip(&self.come).map(|(whole, come)| whole * *come).sum()
    }
}

/// Knowledge from outside, which splits effects that presses confuse.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Standard {
    /// A known weight on the platform.
    Weight { load_n: f64, sigma_n: f64 },
    /// Travel of the machine measured independently.
    Travel { length_mm: f64, sigma_mm: f64 },
    /// The sensor's reference point located in the machine by a probe.
    Datum { sigma_mm: f64 },
}

impl Standard {
    pub(crate) fn rows(self) -> usize {
        match self {
            Self::Weight { .. } | Self::Travel { .. } => 1,
            Self::Datum { .. } => 2,
        }
    }

    pub(crate) fn sigma(self) -> f64 {
        match self {
            Self::Weight { sigma_n, .. } => sigma_n,
            Self::Travel { sigma_mm, .. } | Self::Datum { sigma_mm } => sigma_mm,
        }
    }
}

/// What does not depend on the estimate.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    pub(crate) z0_mm: f64,
    pub(crate) handedness: Handedness,
    pub(crate) pivot_mm: Point2<f64>,
    pub(crate) catalogue: Catalogue,
}

/// The estimate, taken apart.
pub(crate) struct Unpacked {
    turn: Rotation2<f64>,
    /// Image of the pivot in the sensor frame.
    center_mm: Vector2<f64>,
    sensor: SensorErrors,
    machine: MachineErrors,
    along: AlongCourses,
}

impl Unpacked {
    pub(crate) fn center_mm(&self) -> Vector2<f64> {
        self.center_mm
    }

    pub(crate) fn machine(&self) -> &MachineErrors {
        &self.machine
    }
}

impl Design {
    pub(crate) fn unpack(&self, at: &State) -> Unpacked {
        let (sensor, machine, along) = self.catalogue.errors(at);
        Unpacked {
            turn: Rotation2::new(at.base[0]),
            center_mm: Vector2::new(at.base[1], at.base[2]),
            sensor,
            machine,
            along,
        }
    }

    pub(crate) fn corrected(&self, point: &PressPoint, at: &Unpacked) -> Corrected {
        let moment_bias_nmm = at.sensor.moment_bias_nmm + point.along(&at.along.moment_nmm);
        let sensor = SensorErrors { moment_bias_nmm, ..at.sensor };
        Corrected::of(&point.reading, &sensor, self.z0_mm)
    }

    /// Machine from sensor, without translation.
    pub(crate) fn linear(&self, at: &Unpacked) -> Matrix2<f64> {
        self.handedness.mirror() * at.turn.inverse().into_inner()
    }

    fn machine_arm(&self, sensor_mm: Vector2<f64>, at: &Unpacked) -> Vector2<f64> {
        self.linear(at) * (sensor_mm - at.center_mm)
    }

    /// Found − expected position, machine frame.
    pub(crate) fn residual(
        &self,
        point: &PressPoint,
        at: &Unpacked,
        state: &State,
    ) -> Vector2<f64> {
        let arm = point.machine_mm - self.pivot_mm;
        let expected = arm + self.moved_by_machine(point, at, state);
        self.machine_arm(self.corrected(point, at).center_mm, at) - expected
    }

    /// Where the effects of the machine put the head − where the machine says that it is.
    pub(crate) fn moved_by_machine(
        &self,
        point: &PressPoint,
        at: &Unpacked,
        state: &State,
    ) -> Vector2<f64> {
        let m = &at.machine;
        let growth = m.growth_mm_per_k.iter().zip(&point.warmth_k);
        let mut moved = (point.machine_mm - self.pivot_mm) * m.scale
            + m.datum_mm
            + m.load_shift_mm_per_n * load_n(point)
            + m.drift_mm * point.reading.elapsed_ratio
            + point.along(&at.along.machine_mm)
            + growth.map(|(k, warmth)| k * *warmth).sum::<Vector2<f64>>();
        if let Some(observation) = point.observation {
            let is = |e: &PressEffect| *e == PressEffect::BadPress(observation);
            if let Some(effect) = self.catalogue.effects.iter().position(is) {
                moved += state.amplitudes[effect].fixed_rows::<2>(0);
            }
        }
        moved
    }

    /// Derivative of [`Design::residual`] by `[angle, image of the pivot]`.
    pub(crate) fn base_jacobian(&self, point: &PressPoint, at: &Unpacked) -> Matrix2x3<f64> {
        self.base_jacobian_of(self.corrected(point, at).center_mm, at)
    }

    fn base_jacobian_of(&self, sensor_mm: Vector2<f64>, at: &Unpacked) -> Matrix2x3<f64> {
        let linear = self.linear(at);
        let mut jacobian = Matrix2x3::zeros();
        // d Rot(−θ)/dθ = Rot(−θ) Rot(−90°)
        let turned = Rotation2::new(-FRAC_PI_2) * (sensor_mm - at.center_mm);
        jacobian.set_column(0, &(linear * turned));
        jacobian.fixed_columns_mut::<2>(1).copy_from(&-linear);
        jacobian
    }

    /// Derivative of [`Design::residual`] by the amplitudes of one effect.
    pub(crate) fn tangent(&self, point: &PressPoint, at: &Unpacked, effect: usize) -> DMatrix<f64> {
        let effect = self.catalogue.effects[effect];
        let both = |ratio: f64| DMatrix::from_diagonal_element(2, 2, -ratio);
        match effect {
            PressEffect::LoadShift => both(load_n(point)),
            PressEffect::Drift => both(point.reading.elapsed_ratio),
            PressEffect::Course(k) => both(point.come.get(k).copied().unwrap_or(0.0)),
            PressEffect::DatumOffset => both(1.0),
            PressEffect::Temperature(k) => both(point.warmth_k.get(k).copied().unwrap_or(0.0)),
            PressEffect::BadPress(o) => both(if point.observation == Some(o) { 1.0 } else { 0.0 }),
            PressEffect::FrameScale => {
                let arm = point.machine_mm - self.pivot_mm;
                DMatrix::from_column_slice(2, 1, &[-arm.x, -arm.y])
            }
            PressEffect::MomentCourse(k) => {
                let zeros = [SensorError::MomentBias(0), SensorError::MomentBias(1)];
                self.by_sensor(point, at, &zeros) * point.come.get(k).copied().unwrap_or(0.0)
            }
            _ => self.by_sensor(point, at, effect.sensor_errors()),
        }
    }

    /// Derivative of [`Design::residual`] by errors of the sensor.
    fn by_sensor(&self, point: &PressPoint, at: &Unpacked, by: &[SensorError]) -> DMatrix<f64> {
        let (corrected, linear) = (self.corrected(point, at), self.linear(at));
        let columns: Vec<_> = by.iter().map(|by| linear * corrected.derivative(*by)).collect();
        DMatrix::from_fn(2, columns.len(), |row, column| columns[column][row])
    }

    /// Reading of a standard − what it should be.
    pub(crate) fn standard_residual(&self, standard: Standard, at: &Unpacked) -> Vec<f64> {
        match standard {
            Standard::Weight { load_n, .. } => {
                vec![self.weighed(load_n, at).fz_n() - load_n]
            }
            Standard::Travel { length_mm, .. } => vec![-length_mm * at.machine.scale],
            Standard::Datum { .. } => {
                // Where a probe would find it is not known: the design alone counts.
                let arm = self.machine_arm(Vector2::zeros(), at);
                vec![arm.x, arm.y]
            }
        }
    }

    fn weighed(&self, load_n: f64, at: &Unpacked) -> Corrected {
        let wrench =
            Wrench { force_n: Vector3::new(0.0, 0.0, load_n), torque_nmm: Vector3::zeros() };
        let drag_n = Vector2::zeros();
        Corrected::of(&Reading { wrench, drag_n, elapsed_ratio: 1.0 }, &at.sensor, self.z0_mm)
    }

    pub(crate) fn standard_base_jacobian(&self, standard: Standard, at: &Unpacked) -> DMatrix<f64> {
        match standard {
            Standard::Weight { .. } | Standard::Travel { .. } => DMatrix::zeros(1, 3),
            Standard::Datum { .. } => {
                let jacobian = self.base_jacobian_of(Vector2::zeros(), at);
                DMatrix::from_column_slice(2, 3, jacobian.as_slice())
            }
        }
    }

    pub(crate) fn standard_tangent(
        &self,
        standard: Standard,
        at: &Unpacked,
        effect: usize,
        parameters: usize,
    ) -> DMatrix<f64> {
        let effect = self.catalogue.effects[effect];
        let mut tangent = DMatrix::zeros(standard.rows(), parameters);
        match standard {
            Standard::Weight { load_n, .. } => {
                let corrected = self.weighed(load_n, at);
                for (column, &by) in effect.sensor_errors().iter().enumerate() {
                    tangent[(0, column)] = corrected.fz_derivative(by);
                }
            }
            Standard::Travel { length_mm, .. } if effect == PressEffect::FrameScale => {
                tangent[(0, 0)] = -length_mm;
            }
            Standard::Travel { .. } | Standard::Datum { .. } => {}
        }
        tangent
    }
}

/// Mean load of a press.
pub(crate) fn load_n(point: &PressPoint) -> f64 {
    load_of(&point.reading.wrench)
}

/// Load of a wrench, N.
pub(crate) fn load_of(wrench: &Wrench) -> f64 {
    wrench.force_n.z.abs()
}
