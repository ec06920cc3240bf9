//! A stream of cycles with everything that can go wrong, and the rules its answers must keep.

use force_impedance::{Command, Controller, Head, HeadLimits, Measurement, Status};
use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

const T: f64 = 1e-3;

/// Readings of a head that wanders about, spoilt now and then; faults come in bursts.
pub(crate) struct Hostile {
    rng: ChaCha8Rng,
    /// Cycles left of the present stretch.
    left: u32,
    /// Kind of the present stretch; 0 is good.
    kind: u32,
    good: u32,
    tip_mm: Vector3<f64>,
    normal: Vector3<f64>,
    stuck_n: [f64; 4],
}

const N_KINDS: u32 = 12;
const NONSENSE: [f64; 8] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 5e-324, -0.0, 1e9];

impl Hostile {
    pub(crate) fn new(rng: ChaCha8Rng) -> Self {
        let (tip_mm, normal) = (Vector3::zeros(), Vector3::y());
        Self { rng, left: 0, kind: 0, good: 0, tip_mm, normal, stuck_n: [0.0; 4] }
    }

    /// Cycles in a row, up to the last, in which nothing was wrong.
    pub(crate) fn good_in_a_row(&self) -> u32 {
        self.good
    }

    pub(crate) fn next(&mut self, head: &Head) -> (Measurement, f64) {
        if self.left == 0 {
            self.kind =
                if self.rng.random_bool(0.5) { 0 } else { self.rng.random_range(1..N_KINDS) };
            self.left = if self.kind == 0 {
                self.rng.random_range(1..200)
            } else {
                self.rng.random_range(1..80)
            };
            self.normal = self.direction();
        }
        self.left -= 1;
        let (mut seen, mut dt_s) = self.sound(head);
        let i = self.rng.random_range(0..4_usize);
        let bad = NONSENSE[self.rng.random_range(0..NONSENSE.len())];
        match self.kind {
            1 => seen.cells_n = None,
            2 => seen.lengths_mm = None,
            3 => seen.cells_n.as_mut().unwrap()[i] = bad,
            4 => seen.lengths_mm.as_mut().unwrap()[i] = bad,
            5 => seen.normal[i % 3] = bad,
            6 => seen.reference_n = bad,
            7 => dt_s = bad,
            8 => seen.cells_n = Some(self.stuck_n),
            9 => seen.normal = self.direction() * self.rng.random_range(0.9..1.1),
            10 => seen.cells_n = Some([0; 4].map(|_| self.rng.random_range(-3000.0..3000.0))),
            11 => seen.lengths_mm = Some([0; 4].map(|_| self.rng.random_range(0.0..400.0))),
            _ => {}
        }
        self.stuck_n = seen.cells_n.unwrap_or(self.stuck_n);
        self.good = if self.kind == 0 { self.good.saturating_add(1) } else { 0 };
        (seen, dt_s)
    }

    fn direction(&mut self) -> Vector3<f64> {
        let lean =
            Vector3::new(self.rng.random_range(-0.6..0.6), 1.0, self.rng.random_range(-0.6..0.6));
        lean.normalize()
    }

    /// A cycle with nothing wrong; the interval jitters, jumps are part of life.
    fn sound(&mut self, head: &Head) -> (Measurement, f64) {
        for axis in 0..3 {
            self.tip_mm[axis] += self.rng.random_range(-0.02..0.02);
            self.tip_mm[axis] *= 0.999;
        }
        let tip_mm: Point3<f64> = head.start_tip_mm() + self.tip_mm;
        let lengths_mm = head.pose_at(&tip_mm).unwrap().lengths_mm;
        let press_n = if self.rng.random_bool(0.01) { 900.0 } else { 40.0 };
        let seen = Measurement {
            lengths_mm: Some(lengths_mm),
            cells_n: Some([0; 4].map(|_| press_n * self.rng.random_range(0.0..1.5))),
            normal: self.normal,
            reference_n: self.rng.random_range(0.0..100.0),
        };
        (seen, T * self.rng.random_range(0.6..3.0))
    }
}

/// Rate and lengths are compared with this much round-off, mm.
const ROUND_OFF_MM: f64 = 1e-10;

/// What must hold of every command.
pub(crate) struct Judge {
    before: Point3<f64>,
    limits: HeadLimits,
    longest_step_mm: f64,
    travel_mm: [f64; 2],
    recovery_cycles: u32,
}

impl Judge {
    pub(crate) fn new(controller: &Controller, limits: HeadLimits) -> Self {
        let settings = controller.settings();
        Self {
            before: controller.head().start_tip_mm(),
            limits,
            longest_step_mm: settings.rate_mm_per_s * settings.interval_s + ROUND_OFF_MM,
            travel_mm: settings.travel_mm,
            recovery_cycles: settings.recovery_cycles,
        }
    }

    /// `good_in_a_row` counts this cycle.
    pub(crate) fn check(&mut self, command: &Command, good_in_a_row: u32) {
        let [l1, l2, l3, l4] = command.lengths_mm;
        for length_mm in [l1, l2, l3] {
            assert!(length_mm >= self.limits.leg_mm[0] && length_mm <= self.limits.leg_mm[1]);
        }
        assert!(l4 >= self.limits.axial_mm[0] && l4 <= self.limits.axial_mm[1]);
        let step = command.tip_mm - self.before;
        let step_mm = step.norm();
        assert!(step_mm <= self.longest_step_mm, "{command:?}");
        assert!(command.offset_mm >= self.travel_mm[0] && command.offset_mm <= self.travel_mm[1]);
        assert!(command.reference_n >= 0.0 && command.reference_n.is_finite());
        self.before = command.tip_mm;
        if good_in_a_row > self.recovery_cycles {
            assert!(
                matches!(command.status, Status::Controlling | Status::NoContact),
                "not recovered after {good_in_a_row} good cycles: {command:?}"
            );
        }
    }
}
