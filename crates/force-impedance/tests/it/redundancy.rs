//! One cell that is stuck, at its end, or exchanged with another: noticed, named, and away.

use force_impedance::{Controller, ControllerSettings, Fault, Measurement, Status};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::equilibrium::{equilibrium, random_load, tilted};
use crate::rig::{SOFT, T};
use crate::usual_head::{GEOMETRY, head};

const ASKED_N: f64 = 30.0;
const CONTACT_N_PER_MM: f64 = 100.0;
/// 50 ms at 1 kHz.
const NOTICED_CYCLES: usize = 50;

struct Pressing {
    controller: Controller,
    tip_mm: Point3<f64>,
    normal: Vector3<f64>,
    rng: ChaCha8Rng,
}

impl Pressing {
    fn new(tilt_rad: f64) -> Self {
        let controller = Controller::new(head(), SOFT, ControllerSettings::default()).unwrap();
        let normal = tilted(&Vector3::y(), tilt_rad, 0.7);
        let tip_mm = head().start_tip_mm();
        Self { controller, tip_mm, normal, rng: ChaCha8Rng::seed_from_u64(3) }
    }

    fn force_n(&self) -> f64 {
        let depth_mm = 0.2 - (self.tip_mm - head().start_tip_mm()).dot(&self.normal);
        (CONTACT_N_PER_MM * depth_mm).max(0.0)
    }

    fn cycle(&mut self, spoil: impl FnOnce(&mut [f64; 4])) -> Status {
        let force_n = self.normal * self.force_n();
        let held = equilibrium(self.tip_mm, self.normal, force_n, 300.0, &GEOMETRY);
        let mut cells_n = held.cells_n.map(|f| f + self.rng.random_range(-0.1..0.1));
        spoil(&mut cells_n);
        let seen = Measurement {
            lengths_mm: Some(held.lengths_mm),
            cells_n: Some(cells_n),
            normal: self.normal,
            reference_n: ASKED_N,
        };
        let command = self.controller.update(&seen, T);
        self.tip_mm = command.tip_mm;
        command.status
    }

    fn settled(tilt_rad: f64) -> Self {
        let mut pressing = Self::new(tilt_rad);
        for _ in 0..300 {
            pressing.cycle(|_| {});
        }
        assert!((pressing.force_n() - ASKED_N).abs() < 1.0);
        pressing
    }
}

const TILTS_RAD: [f64; 3] = [0.0, 0.3, 0.55];

fn stuck_cells(status: Status) -> Option<u8> {
    match status {
        Status::Retracting(fault @ (Fault::CellStuck(_) | Fault::CellsDisagree(_))) => {
            Some(fault.suspects().bits())
        }
        _ => None,
    }
}

/// Stuck where it stood, or at nothing, or where the converter ends: noticed within 50 ms, the cell
/// named, the force no more than at the start, and the tool gone.
#[test]
fn one_stuck_or_saturated_cell_is_noticed_and_named() {
    for tilt_rad in TILTS_RAD {
        for cell in 0..4 {
            for stuck_at in [None, Some(0.0), Some(20.0)] {
                let mut pressing = Pressing::settled(tilt_rad);
                let mut last_n = f64::NAN;
                pressing.cycle(|cells_n| last_n = cells_n[cell]);
                let value_n = stuck_at.unwrap_or(last_n);
                let mut noticed = None;
                for cycle in 0..NOTICED_CYCLES {
                    let status = pressing.cycle(|cells_n| cells_n[cell] = value_n);
                    noticed = noticed.or_else(|| stuck_cells(status).map(|cells| (cycle, cells)));
                }
                let what = format!("{tilt_rad} rad, cell {cell} at {value_n} N: {noticed:?}");
                assert_eq!(noticed.map(|(_, cells)| cells), Some(1 << cell), "{what}");
                for _ in 0..300 {
                    let status = pressing.cycle(|cells_n| cells_n[cell] = value_n);
                    assert!(matches!(status, Status::Retracting(_)), "{what}");
                }
                assert!(pressing.force_n() <= 0.0, "{what}: {}", pressing.force_n());
            }
        }
    }
}

/// The axial cell never lived: with the normal along the tool nothing tells of a contact, and the
/// tool turns back before it goes farther than allowed.
#[test]
fn an_axial_cell_that_never_lived_does_not_lead_into_the_workpiece() {
    let mut pressing = Pressing::new(0.0);
    let mut most_n: f64 = 0.0;
    for _ in 0..3000 {
        pressing.cycle(|cells_n| cells_n[3] = 0.0);
        most_n = most_n.max(pressing.force_n());
    }
    // It starts in contact, 20 N; the blind way of 0.25 mm and the stop add 30 N.
    assert!(most_n < 60.0, "{most_n}");
    assert!(pressing.force_n() <= 0.0);
}

/// Two legs exchanged, on a normal that the legs feel: noticed before the force runs away.
#[test]
fn exchanged_cells_do_not_lead_into_the_workpiece() {
    for tilt_rad in [0.0, 0.3, 0.55] {
        for (i, j) in [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)] {
            let mut pressing = Pressing::new(tilt_rad);
            let mut most_n: f64 = 0.0;
            let mut named = None;
            for _ in 0..3000 {
                let status = pressing.cycle(|cells_n| cells_n.swap(i, j));
                named = named.or(stuck_cells(status));
                most_n = most_n.max(pressing.force_n());
            }
            assert!(most_n < 4.0 * ASKED_N, "{tilt_rad} {i} {j}: {most_n} {named:?}");
        }
    }
}

/// Loads of every direction with friction up to 0.4 and noise: never a false alarm.
#[test]
fn clean_cycles_raise_no_alarm() {
    const N_LOADS: usize = 500;
    const N_CYCLES: usize = 1_000_000;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let loads: Vec<_> = (0..N_LOADS).map(|_| random_load(&mut rng, &GEOMETRY)).collect();
    let mut controller = Controller::new(head(), SOFT, ControllerSettings::default()).unwrap();
    let mut controlled = 0_usize;
    for cycle in 0..N_CYCLES {
        let load = &loads[cycle / 400 % N_LOADS];
        let seen = Measurement {
            lengths_mm: Some(load.lengths_mm),
            cells_n: Some(load.cells_n.map(|f| f + rng.random_range(-0.5..0.5))),
            normal: load.normal,
            reference_n: ASKED_N,
        };
        let status = controller.update(&seen, T).status;
        assert!(stuck_cells(status).is_none(), "{cycle}: {status:?}");
        controlled += usize::from(status == Status::Controlling);
    }
    assert!(controlled > N_CYCLES / 2, "{controlled}");
}
