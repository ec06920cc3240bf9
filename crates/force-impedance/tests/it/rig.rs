//! A head against a spring: where the tool goes, what the cells read. Written from statics alone.

use force_impedance::{Command, Controller, ControllerSettings, ImpedanceParameters, Measurement};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::equilibrium::equilibrium;
use crate::usual_head::{GEOMETRY, head};

pub(crate) const T: f64 = 1e-3;

pub(crate) const SOFT: ImpedanceParameters =
    ImpedanceParameters { mass_kg: 1.0, damping_ns_per_mm: 1.0, stiffness_n_per_mm: 0.0 };

pub(crate) struct Rig {
    pub(crate) controller: Controller,
    /// Stiffness of the contact.
    pub(crate) contact_n_per_mm: f64,
    /// Offset along the normal at which the tool touches.
    pub(crate) surface_mm: f64,
    pub(crate) normal: Vector3<f64>,
    pub(crate) reference_n: f64,
    pub(crate) last: Option<Command>,
    rng: ChaCha8Rng,
}

impl Rig {
    pub(crate) fn new(parameters: ImpedanceParameters, settings: ControllerSettings) -> Self {
        Self {
            controller: Controller::new(head(), parameters, settings).unwrap(),
            contact_n_per_mm: 100.0,
            surface_mm: 0.0,
            normal: Vector3::y(),
            reference_n: 20.0,
            last: None,
            rng: ChaCha8Rng::seed_from_u64(5),
        }
    }

    /// What the sensors read with the tool where it was last sent.
    pub(crate) fn read(&mut self) -> Measurement {
        let start_mm = head().start_tip_mm();
        let tip_mm = self.last.map_or(start_mm, |c| c.tip_mm);
        let depth_mm = self.surface_mm - (tip_mm - start_mm).dot(&self.normal);
        let press_n = (self.contact_n_per_mm * depth_mm).max(0.0);
        let held = equilibrium(tip_mm, self.normal, self.normal * press_n, 300.0, &GEOMETRY);
        // The last digits of the converters.
        let cells_n = held.cells_n.map(|f| f + 1e-9 * self.rng.random_range(-1.0..1.0));
        Measurement {
            lengths_mm: Some(held.lengths_mm),
            cells_n: Some(cells_n),
            normal: self.normal,
            reference_n: self.reference_n,
        }
    }

    pub(crate) fn cycle(&mut self) -> Command {
        let seen = self.read();
        self.feed(&seen, T)
    }

    pub(crate) fn feed(&mut self, seen: &Measurement, dt_s: f64) -> Command {
        let command = self.controller.update(seen, dt_s);
        self.last = Some(command);
        command
    }

    pub(crate) fn run(&mut self, cycles: usize) -> Command {
        for _ in 1..cycles {
            self.cycle();
        }
        self.cycle()
    }
}

pub(crate) fn force(command: &Command) -> f64 {
    command.contact.unwrap().normal_n
}
