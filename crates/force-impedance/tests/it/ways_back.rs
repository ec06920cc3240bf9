//! From every state, with every fault, a way back: within a bounded time the force is no more than
//! asked for or the tool stands at the outward end of its way, and when the fault is over, control
//! resumes. States and faults are enumerated; head and contact are simulated from statics alone.

use force_impedance::{
    Command, Controller, ControllerSettings, Head, HeadLimits, Measurement, Status,
};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::equilibrium::equilibrium;
use crate::rig::{SOFT, T};
use crate::usual_head::GEOMETRY;

const ASKED_N: f64 = 30.0;
const CONTACT_N_PER_MM: f64 = 100.0;
/// A force above what is asked for: 150 N.
const TOO_DEEP_MM: f64 = 1.5;
/// Noise of a length sensor and of a cell.
const LENGTH_NOISE_MM: f64 = 0.002;
const CELL_NOISE_N: f64 = 0.05;
/// Until the force is away: the default hold of 50 cycles, then 1.5 mm of way at the rate of
/// 50 mm/s, some times over.
const AWAY_CYCLES: usize = 400;
/// 6 mm back to the workpiece at 5 mm/s, and what the contact takes to settle.
const BACK_CYCLES: usize = 2000;

/// What is wrong while a fault lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrong {
    Nothing,
    LengthsBiased(f64),
    NoLengths,
    LengthsNotFinite,
    LengthsDisagree,
    LengthsStuck,
    LengthsFar,
    NoCells,
    CellNotFinite(usize),
    CellAtItsEnd(usize),
    CellStuck(usize),
    CellsFrozen,
    NormalNotUnit,
    NormalAside,
    IntervalNotFinite,
    IntervalZero,
}

const WRONG: [Wrong; 20] = [
    Wrong::Nothing,
    Wrong::LengthsBiased(0.1),
    Wrong::LengthsBiased(-0.15),
    Wrong::LengthsBiased(0.3),
    Wrong::NoLengths,
    Wrong::LengthsNotFinite,
    Wrong::LengthsDisagree,
    Wrong::LengthsStuck,
    Wrong::LengthsFar,
    Wrong::NoCells,
    Wrong::CellNotFinite(0),
    Wrong::CellNotFinite(3),
    Wrong::CellAtItsEnd(3),
    Wrong::CellStuck(1),
    Wrong::CellStuck(3),
    Wrong::CellsFrozen,
    Wrong::NormalNotUnit,
    Wrong::NormalAside,
    Wrong::IntervalNotFinite,
    Wrong::IntervalZero,
];

struct Bench {
    head: Head,
    controller: Controller,
    normal: Vector3<f64>,
    /// Offset along the normal at which the tool touches.
    surface_mm: f64,
    tip_mm: Point3<f64>,
    before: Option<Measurement>,
    rng: ChaCha8Rng,
}

impl Bench {
    fn new(limits: HeadLimits, travel_mm: [f64; 2], normal: Vector3<f64>) -> Self {
        let head = Head::new(GEOMETRY, limits).unwrap();
        let settings = ControllerSettings { travel_mm, ..ControllerSettings::default() };
        Self {
            head,
            controller: Controller::new(head, SOFT, settings).unwrap(),
            normal,
            surface_mm: -50.0,
            tip_mm: head.start_tip_mm(),
            before: None,
            rng: ChaCha8Rng::seed_from_u64(11),
        }
    }

    fn offset_mm(&self) -> f64 {
        (self.tip_mm - self.head.start_tip_mm()).dot(&self.normal)
    }

    fn force_n(&self) -> f64 {
        (CONTACT_N_PER_MM * (self.surface_mm - self.offset_mm())).max(0.0)
    }

    fn cycle(&mut self, wrong: Wrong) -> Command {
        let force_n = self.normal * self.force_n();
        let held = equilibrium(self.tip_mm, self.normal, force_n, 300.0, &GEOMETRY);
        let mut noise = |most: f64| self.rng.random_range(-most..most);
        let lengths_mm = held.lengths_mm.map(|l| l + noise(LENGTH_NOISE_MM));
        let cells_n = held.cells_n.map(|f| f + noise(CELL_NOISE_N));
        let mut seen = Measurement {
            lengths_mm: Some(lengths_mm),
            cells_n: Some(cells_n),
            normal: self.normal,
            reference_n: ASKED_N,
        };
        let dt_s = self.spoil(wrong, &mut seen);
        self.before = Some(seen);
        let command = self.controller.update(&seen, dt_s);
        assert!(self.head.pose_at(&command.tip_mm).is_ok(), "{wrong:?} {command:?}");
        self.tip_mm = command.tip_mm;
        command
    }

    fn spoil(&self, wrong: Wrong, seen: &mut Measurement) -> f64 {
        let before = self.before.unwrap_or(*seen);
        let lengths_mm = seen.lengths_mm.as_mut().unwrap();
        let cells_n = seen.cells_n.as_mut().unwrap();
        match wrong {
            Wrong::Nothing => {}
            Wrong::LengthsBiased(mm) => *lengths_mm = lengths_mm.map(|l| l + mm),
            Wrong::NoLengths => seen.lengths_mm = None,
            Wrong::LengthsNotFinite => lengths_mm[1] = f64::NAN,
            Wrong::LengthsDisagree => lengths_mm[2] += 2.0,
            Wrong::LengthsStuck => seen.lengths_mm = before.lengths_mm.or(seen.lengths_mm),
            // A pose that it could have, far outside its limits.
            Wrong::LengthsFar => {
                let away_mm = self.tip_mm + Vector3::new(20.0, -15.0, 10.0);
                let far = equilibrium(away_mm, self.normal, Vector3::zeros(), 300.0, &GEOMETRY);
                *lengths_mm = far.lengths_mm;
            }
            Wrong::NoCells => seen.cells_n = None,
            Wrong::CellNotFinite(i) => cells_n[i] = f64::INFINITY,
            Wrong::CellAtItsEnd(i) => cells_n[i] = 2000.0,
            Wrong::CellStuck(i) => cells_n[i] = before.cells_n.map_or(cells_n[i], |f| f[i]),
            Wrong::CellsFrozen => seen.cells_n = before.cells_n.or(seen.cells_n),
            Wrong::NormalNotUnit => seen.normal *= 1.5,
            Wrong::NormalAside => seen.normal = Vector3::x(),
            Wrong::IntervalNotFinite => return f64::NAN,
            Wrong::IntervalZero => return 0.0,
        }
        T
    }
}

/// Heads whose way into the workpiece ends at a leg, at the axial unit, at a tilt, at the travel.
fn ends() -> [(HeadLimits, [f64; 2]); 4] {
    let wide = HeadLimits::wide(&GEOMETRY);
    [
        (HeadLimits { leg_mm: [60.0, 70.6], ..wide }, [-10.0, 3.0]),
        (HeadLimits { axial_mm: [150.0, 180.8], ..wide }, [-10.0, 3.0]),
        (HeadLimits { tilt_rad: 2e-3, ..wide }, [-10.0, 3.0]),
        (wide, [-0.8, 3.0]),
    ]
}

fn normals() -> [Vector3<f64>; 3] {
    [
        Vector3::y(),
        Vector3::new(0.5, 0.75_f64.sqrt(), 0.0),
        Vector3::new(-0.3, 0.9, -0.25).normalize(),
    ]
}

#[test]
fn there_is_a_way_back_from_every_end_with_every_fault() {
    for (limits, travel_mm) in ends() {
        for normal in normals() {
            let mut bench = Bench::new(limits, travel_mm, normal);
            // Into the workpiece as far as it goes: nothing is there to be touched.
            for _ in 0..500 {
                bench.cycle(Wrong::Nothing);
            }
            for wrong in WRONG {
                for moving in [false, true] {
                    comes_back(&bench, wrong, moving);
                }
            }
        }
    }
}

fn comes_back(ended: &Bench, wrong: Wrong, moving: bool) {
    let mut bench =
        Bench { controller: ended.controller, rng: ChaCha8Rng::seed_from_u64(12), ..*ended };
    let what = format!("{wrong:?}, moving {moving}, {:?} {:?}", bench.normal, bench.head.limits());
    // The workpiece comes: too much force at once, or after some cycles of backing off.
    bench.surface_mm = bench.offset_mm() + TOO_DEEP_MM;
    if moving {
        for _ in 0..12 {
            bench.cycle(Wrong::Nothing);
        }
        bench.surface_mm = bench.offset_mm() + TOO_DEEP_MM;
    }
    for _ in 0..AWAY_CYCLES {
        bench.cycle(wrong);
    }
    let command = bench.cycle(wrong);
    let away = bench.force_n() <= ASKED_N + 2.0;
    let ended = command.limits.travel() || command.limits.workspace();
    assert!(away || ended, "{what}: {} N, {command:?}", bench.force_n());
    assert!(away || wrong != Wrong::Nothing, "{what}: {} N, {command:?}", bench.force_n());
    for _ in 0..BACK_CYCLES {
        bench.cycle(Wrong::Nothing);
    }
    let command = bench.cycle(Wrong::Nothing);
    assert_eq!(command.status, Status::Controlling, "{what}: {command:?}");
    assert!((bench.force_n() - ASKED_N).abs() < 1.0, "{what}: {} {command:?}", bench.force_n());
    assert!(!command.limits.outside(), "{what}: {command:?}");
}
