//! A spinning, wobbling pad on a force platform, from the physics; it knows nothing of the
//! crate's formulas.

use std::f64::consts::TAU;

use ft_center::{Contact, Press, PressRole, Sample};
use geometry::Wrench;
use nalgebra::{Point2, Point3, Vector2, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Height of the platform in every test.
pub(crate) const Z0_MM: f64 = 30.0;

pub(crate) const CONTACT: Contact = Contact { z0_mm: Z0_MM, min_fz_n: Some(5.0) };

/// A head on the platform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Head {
    pub(crate) load_n: f64,
    /// Part of the load that rises and falls once per turn, with the wobble.
    pub(crate) load_ripple: f64,
    pub(crate) wobble_mm: f64,
    pub(crate) spin_hz: f64,
    /// Constant lateral force of the feed.
    pub(crate) lateral_n: Vector2<f64>,
    /// Friction couple of the pad about z.
    pub(crate) couple_nmm: f64,
}

impl Default for Head {
    fn default() -> Self {
        Self {
            load_n: 40.0,
            load_ripple: 0.1,
            wobble_mm: 0.8,
            spin_hz: 1.7,
            lateral_n: Vector2::new(3.0, -2.0),
            couple_nmm: 180.0,
        }
    }
}

/// Noise of the wrench: white, and a first-order autoregression on top of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Colour {
    pub(crate) white_force_n: f64,
    pub(crate) white_moment_nmm: f64,
    /// Standard deviation of the coloured part of the moments.
    pub(crate) coloured_moment_nmm: f64,
    /// Its correlation time.
    pub(crate) memory_s: f64,
}

impl Colour {
    pub(crate) const NONE: Self =
        Self { white_force_n: 0.0, white_moment_nmm: 0.0, coloured_moment_nmm: 0.0, memory_s: 0.1 };
    pub(crate) const WHITE: Self =
        Self { white_force_n: 0.05, white_moment_nmm: 2.0, ..Self::NONE };
    pub(crate) const COLOURED: Self =
        Self { coloured_moment_nmm: 6.0, memory_s: 0.3, ..Self::WHITE };
}

pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Wrench on the sensor of a force and a couple about z at a point of the platform.
pub(crate) fn wrench_at(point_mm: Point2<f64>, force_n: Vector3<f64>, couple_nmm: f64) -> Wrench {
    let arm = Point3::new(point_mm.x, point_mm.y, Z0_MM);
    let (x, y, z) = (arm.x, arm.y, arm.z);
    let (fx, fy, fz) = (force_n.x, force_n.y, force_n.z);
    let torque_nmm = Vector3::new(y * fz - z * fy, z * fx - x * fz, x * fy - y * fx + couple_nmm);
    Wrench { force_n, torque_nmm }
}

/// A record of `samples` readings at `rate_hz`, the head pressing down on −z.
pub(crate) fn record(
    center_mm: Point2<f64>,
    head: &Head,
    colour: &Colour,
    samples: usize,
    rate_hz: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<Sample> {
    let phase: f64 = rng.random_range(0.0..TAU);
    let keep = (-1.0 / (rate_hz * colour.memory_s)).exp();
    let mut slow = Vector3::from_fn(|_, _| colour.coloured_moment_nmm * normal(rng));
    (0..samples)
        .map(|i| {
            let time_s = i as f64 / rate_hz;
            let (sin, cos) = (TAU * head.spin_hz * time_s + phase).sin_cos();
            let at = center_mm + head.wobble_mm * Vector2::new(cos, sin);
            let load_n = head.load_n * (1.0 + head.load_ripple * cos);
            let force = Vector3::new(head.lateral_n.x, head.lateral_n.y, -load_n);
            let mut wrench = wrench_at(at, force, head.couple_nmm);
            let push = (1.0 - keep * keep).sqrt() * colour.coloured_moment_nmm;
            slow = slow * keep + Vector3::from_fn(|_, _| push * normal(rng));
            wrench.force_n += Vector3::from_fn(|_, _| colour.white_force_n * normal(rng));
            wrench.torque_nmm +=
                slow + Vector3::from_fn(|_, _| colour.white_moment_nmm * normal(rng));
            Sample { time_s, wrench }
        })
        .collect()
}

/// Where the sensor sits in the machine: `sensor = Rot(angle) · mirror · machine + shift`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) angle_rad: f64,
    pub(crate) mirrored: bool,
    pub(crate) shift_mm: Vector2<f64>,
}

impl Placement {
    pub(crate) fn to_sensor(self, machine_mm: Point2<f64>) -> Point2<f64> {
        let y = if self.mirrored { -machine_mm.y } else { machine_mm.y };
        let (sin, cos) = self.angle_rad.sin_cos();
        let turned = Vector2::new(cos * machine_mm.x - sin * y, sin * machine_mm.x + cos * y);
        Point2::from(turned + self.shift_mm)
    }
}

/// A press at a machine position, its record taken by the sensor.
pub(crate) fn press(
    name: &str,
    role: PressRole,
    machine_mm: Point2<f64>,
    record: Vec<Sample>,
) -> Press {
    Press { name: name.to_owned(), role, machine_mm, record }
}
