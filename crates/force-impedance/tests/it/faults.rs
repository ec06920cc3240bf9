//! The fault table of `docs/force-impedance.md`, row by row.

use force_impedance::{
    Command, Controller, ControllerSettings, Fault, Head, HeadLimits, Measurement, Status,
};
use nalgebra::Vector3;

use crate::rig::{Rig, SOFT, T, force};
use crate::usual_head::GEOMETRY;

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
    for bad in [2000.0, -2000.0, 2001.0, 1e300] {
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

/// Intervals that jitter between half and three times the nominal one are no fault.
#[test]
fn an_interval_that_jitters_is_controlled() {
    let mut rig = running();
    let mut before = rig.last.unwrap();
    for i in 0..2000_u32 {
        let dt_s = T * [0.5, 1.7, 0.8, 3.0, 1.0][i as usize % 5];
        let seen = rig.read();
        let command = rig.feed(&seen, dt_s);
        assert_eq!(command.status, Status::Controlling, "cycle {i}");
        assert!((command.tip_mm - before.tip_mm).norm() <= 50.0 * T + 1e-12, "cycle {i}");
        before = command;
    }
    assert!((force(&before) - 20.0).abs() < 1e-6);
}

/// Good again at once: no recovery is needed, for the output was never in doubt.
#[test]
fn a_reference_that_is_no_number_leaves_the_last_good_one() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut rig = running();
        rig.run(2000);
        rig.reference_n = bad;
        for _ in 0..100 {
            let command = rig.cycle();
            assert_eq!(command.status, Status::Controlling);
            assert!(command.limits.reference());
            assert_eq!(command.reference_n.to_bits(), 20.0_f64.to_bits());
            assert!((force(&command) - 20.0).abs() < 1e-6);
        }
        rig.reference_n = 25.0;
        let command = rig.cycle();
        assert!(!command.limits.reference());
        // The ramp of 500 N/s begins in the same cycle.
        assert!((command.reference_n - 20.5).abs() < 1e-9, "{}", command.reference_n);
    }
}

#[test]
fn a_reference_out_of_range_is_brought_within() {
    for (asked_n, end_n) in [(1e9, 200.0), (201.0, 200.0), (-5.0, 0.0)] {
        let mut rig = running();
        rig.reference_n = asked_n;
        for _ in 0..500 {
            let command = rig.cycle();
            assert!(command.limits.reference());
            assert!((0.0..=200.0).contains(&command.reference_n));
        }
        assert!((rig.last.unwrap().reference_n - end_n).abs() < 1e-9);
        rig.reference_n = 20.0;
        assert!(!rig.cycle().limits.reference());
    }
}

/// An error of 500 N moves the tool exactly as one of the limit does.
#[test]
fn a_force_error_beyond_its_limit_counts_as_the_limit() {
    let with_error = |depth_mm: f64| {
        let settings = ControllerSettings { max_error_n: 50.0, ..ControllerSettings::default() };
        let mut rig = Rig::new(SOFT, settings);
        rig.surface_mm = 0.2;
        rig.run(2000);
        rig.surface_mm += depth_mm;
        rig.cycle()
    };
    // 100 N/mm: 500 N and 50.001 N too much.
    let (far, near) = (with_error(5.0), with_error(0.500_01));
    assert!(far.limits.error() && near.limits.error());
    assert_eq!(far.offset_mm.to_bits(), near.offset_mm.to_bits());
    assert!(!with_error(0.49).limits.error());
}

/// The surface comes by 3 mm at once: the tool yields at its rate, cycle by cycle, and the force is
/// back when the way is made.
#[test]
fn a_jump_of_the_surface_is_followed_at_the_rate() {
    let mut rig = running();
    rig.surface_mm += 3.0;
    let mut before = rig.last.unwrap();
    let mut limited = 0;
    for _ in 0..70 {
        let command = rig.cycle();
        assert_eq!(command.status, Status::Controlling);
        assert!(command.offset_mm - before.offset_mm <= 50.0 * T + 1e-12);
        limited += u32::from(command.limits.rate());
        before = command;
    }
    // 2.8 mm of the 3 mm at 0.05 mm a cycle.
    assert!(limited >= 50, "{limited}");
    let command = rig.run(2000);
    assert!(!command.limits.any());
    assert!((force(&command) - 20.0).abs() < 1e-6);
}

/// At the end of its travel the tool waits, and turns back in the first cycle that asks for it.
#[test]
fn travel_that_is_used_up() {
    let settings = ControllerSettings { travel_mm: [-0.3, 0.2], ..ControllerSettings::default() };
    let mut rig = Rig::new(SOFT, settings);
    rig.surface_mm = 1.0;
    let command = rig.run(1000);
    assert_eq!(command.status, Status::Controlling);
    assert!(command.limits.travel());
    assert!((command.offset_mm - 0.2).abs() < 1e-12);
    rig.surface_mm = 0.25;
    rig.cycle();
    let command = rig.cycle();
    assert!(!command.limits.travel() && command.offset_mm < 0.2, "{}", command.offset_mm);
    assert!((force(&rig.run(3000)) - 20.0).abs() < 1e-6);
}

/// What the legs cannot reach is not commanded: the tool waits at the end of its workspace. 20 N are
/// 0.2 mm into the contact, 0.05 mm past the straight head.
#[test]
fn a_workspace_that_ends() {
    let limits = HeadLimits { axial_mm: [179.9, 180.1], ..HeadLimits::wide(&GEOMETRY) };
    let head = Head::new(GEOMETRY, limits).unwrap();
    let mut rig = running();
    rig.controller = Controller::new(head, SOFT, ControllerSettings::default()).unwrap();
    rig.last = None;
    rig.surface_mm = 0.15;
    rig.run(300);
    rig.surface_mm = -1.0;
    for _ in 0..300 {
        let command = rig.cycle();
        assert!((179.9..=180.1).contains(&command.lengths_mm[3]), "{:?}", command.lengths_mm);
    }
    let command = rig.last.unwrap();
    assert_eq!(command.status, Status::NoContact);
    assert!(command.limits.workspace());
    rig.surface_mm = 0.15;
    assert!((force(&rig.run(3000)) - 20.0).abs() < 1e-6);
}
