//! The fault table of `docs/force-impedance.md`, row by row.

use force_impedance::{Command, ControllerSettings, Fault, Measurement, Status};
use nalgebra::Vector3;

use crate::rig::{Rig, SOFT, T, force};

const RECOVERY_CYCLES: u32 = 4;
const FROZEN_CYCLES: u32 = 6;

fn running() -> Rig {
    let settings = ControllerSettings {
        recovery_cycles: RECOVERY_CYCLES,
        frozen_cycles: FROZEN_CYCLES,
        ..ControllerSettings::default()
    };
    let mut rig = Rig::new(SOFT, settings);
    rig.surface_mm = 0.1;
    rig.run(300);
    assert_eq!(rig.last.unwrap().status, Status::Controlling);
    rig
}

fn assert_held(command: &Command, before: &Command, fault: Fault) {
    assert_eq!(command.status, Status::Held(fault));
    assert_eq!(command.lengths_mm.map(f64::to_bits), before.lengths_mm.map(f64::to_bits));
    assert_eq!(command.tip_mm, before.tip_mm);
    assert!(command.contact.is_none());
}

/// Good cycles: held for as many as documented, then control again, and the force as before.
fn assert_recovers(rig: &mut Rig, held: u32) {
    for i in 1..=RECOVERY_CYCLES {
        let command = rig.cycle();
        assert_eq!(command.status, Status::Recovering);
        assert_eq!(command.held_cycles, held + i);
    }
    let command = rig.cycle();
    assert_eq!(command.status, Status::Controlling);
    assert_eq!(command.held_cycles, 0);
    assert!((force(&rig.run(2000)) - 20.0).abs() < 1e-6);
}

fn row(fault: Fault, dt_s: f64, spoil: impl Fn(&mut Measurement)) {
    let mut rig = running();
    let before = rig.last.unwrap();
    for n in 1..=3 {
        let mut seen = rig.read();
        spoil(&mut seen);
        let command = rig.feed(&seen, dt_s);
        assert_held(&command, &before, fault);
        assert_eq!(command.held_cycles, n);
    }
    assert_recovers(&mut rig, 3);
}

#[test]
fn an_interval_that_cannot_be() {
    for dt_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -T, 0.4 * T, 11.0 * T] {
        row(Fault::Interval, dt_s, |_| {});
    }
}

#[test]
fn no_sample() {
    row(Fault::NoSample, T, |m| m.cells_n = None);
    row(Fault::NoSample, T, |m| m.lengths_mm = None);
}

#[test]
fn readings_that_are_no_numbers() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..4 {
            row(Fault::NotFinite, T, |m| m.cells_n.as_mut().unwrap()[i] = bad);
            row(Fault::NotFinite, T, |m| m.lengths_mm.as_mut().unwrap()[i] = bad);
        }
    }
}

#[test]
fn a_cell_beyond_its_range() {
    for bad in [2001.0, -2001.0, 1e300] {
        row(Fault::CellRange, T, |m| m.cells_n.as_mut().unwrap()[2] = bad);
    }
}

#[test]
fn cells_that_stop_changing() {
    let mut rig = running();
    let stuck = rig.read().cells_n;
    for _ in 0..FROZEN_CYCLES {
        let mut seen = rig.read();
        seen.cells_n = stuck;
        let command = rig.feed(&seen, T);
        assert_eq!(command.status, Status::Controlling);
    }
    let before = rig.last.unwrap();
    for _ in 0..5 {
        let mut seen = rig.read();
        seen.cells_n = stuck;
        let command = rig.feed(&seen, T);
        assert_held(&command, &before, Fault::Frozen);
    }
    assert_recovers(&mut rig, 5);
}

#[test]
fn lengths_of_no_pose() {
    // Beyond the limits, disagreeing with each other, nonsense.
    row(Fault::Lengths, T, |m| m.lengths_mm.as_mut().unwrap()[0] += 1.0);
    row(Fault::Lengths, T, |m| m.lengths_mm = Some([70.0, 70.0, 70.0, 500.0]));
    row(Fault::Lengths, T, |m| m.lengths_mm = Some([-1e9; 4]));
    row(Fault::Lengths, T, |m| m.lengths_mm = Some([0.0; 4]));
}

#[test]
fn normals_that_cannot_be() {
    for bad in [
        Vector3::zeros(),
        Vector3::new(f64::NAN, 1.0, 0.0),
        Vector3::new(0.0, f64::INFINITY, 0.0),
        Vector3::new(0.0, 1.01, 0.0),
        Vector3::new(0.0, 1e300, 0.0),
        -Vector3::y(),
        Vector3::new(0.99, (1.0f64 - 0.99 * 0.99).sqrt(), 0.0),
    ] {
        row(Fault::Normal, T, |m| m.normal = bad);
    }
}

/// Not a fault: the tool goes looking for the workpiece, slowly.
#[test]
fn contact_that_is_lost() {
    let mut rig = running();
    let before = rig.last.unwrap();
    rig.surface_mm -= 1.0;
    for n in 1..=20 {
        let command = rig.cycle();
        assert_eq!(command.status, Status::NoContact);
        let most_mm = 5.0 * T * f64::from(n) + 1e-12;
        assert!(before.offset_mm - command.offset_mm <= most_mm);
    }
    rig.run(3000);
    assert_eq!(rig.last.unwrap().status, Status::Controlling);
    assert!((force(&rig.last.unwrap()) - 20.0).abs() < 1e-6);
}

/// Late but believable cycles make one step, no faster than the rate allows per nominal cycle.
#[test]
fn a_late_cycle_is_one_step() {
    let mut rig = running();
    rig.surface_mm += 3.0;
    let before = rig.last.unwrap();
    let seen = rig.read();
    let command = rig.feed(&seen, 9.0 * T);
    assert_eq!(command.status, Status::Controlling);
    assert!(command.offset_mm - before.offset_mm <= 50.0 * T + 1e-12);
}

#[test]
fn one_good_cycle_between_bad_ones_is_not_trusted() {
    let mut rig = running();
    let before = rig.last.unwrap();
    for _ in 0..20 {
        let mut seen = rig.read();
        seen.cells_n = None;
        assert_held(&rig.feed(&seen, T), &before, Fault::NoSample);
        let command = rig.cycle();
        assert_eq!(command.status, Status::Recovering);
        assert_eq!(command.tip_mm, before.tip_mm);
    }
}
