//! What the controller does in contact: steady force, limits, changes without a bump.

use force_impedance::{
    Controller, ControllerSettings, Discretisation, ForceImpedanceError, HeadLimits,
    ImpedanceParameters, ReferenceMode, Status,
};
use nalgebra::Vector3;

use crate::rig::{Rig, SOFT, T, force};
use crate::usual_head::{GEOMETRY, head};

/// Force after a settled transient of some 20 time constants, and the readings' last digits.
const SETTLED_N: f64 = 1e-6;

fn settings() -> ControllerSettings {
    ControllerSettings { recovery_cycles: 3, ..ControllerSettings::default() }
}

#[test]
fn a_rebased_spring_holds_nothing_back() {
    let stiff = ImpedanceParameters { stiffness_n_per_mm: 50.0, ..SOFT };
    let mut rig = Rig::new(stiff, settings());
    let command = rig.run(4000);
    assert!((force(&command) - 20.0).abs() < SETTLED_N, "{}", force(&command));
    assert_eq!(command.status, Status::Controlling);
    assert!(!command.limits.any());
}

/// `F − F_r = (F0 − F_r)/(1 + K_e/K)`, with F0 the force of the programmed path.
#[test]
fn an_absolute_spring_leaves_the_steady_error_of_the_formula() {
    let stiff = ImpedanceParameters { stiffness_n_per_mm: 50.0, ..SOFT };
    for discretisation in [Discretisation::ExactHold, Discretisation::Bilinear] {
        let mode = ReferenceMode::Absolute;
        let mut rig = Rig::new(stiff, ControllerSettings { mode, discretisation, ..settings() });
        rig.surface_mm = 0.8;
        let command = rig.run(4000);
        let expected = 20.0 + (100.0 * 0.8 - 20.0) / (1.0 + 100.0 / 50.0);
        assert!((force(&command) - expected).abs() < SETTLED_N, "{}", force(&command));
    }
}

/// Along a straight normal the rig is a linear loop: its samples follow the difference equation.
#[test]
fn the_transient_is_that_of_the_difference_equation() {
    let p = ImpedanceParameters { mass_kg: 5.0, damping_ns_per_mm: 0.8, stiffness_n_per_mm: 0.0 };
    let quick = ControllerSettings { reference_rate_n_per_s: 1e9, ..settings() };
    let mut rig = Rig::new(p, quick);
    rig.surface_mm = 0.5;
    rig.run(3);
    // The solution of m v' + d v = f over one interval, written out.
    let (m, d) = (p.mass_kg / 1e3, p.damping_ns_per_mm);
    let decay = (-d * T / m).exp();
    let (mut e, mut v) = (0.0, 0.0);
    for cycle in 0..300 {
        let command = rig.cycle();
        let f = 100.0 * (0.5 - e) - 20.0;
        assert!((force(&command) - 20.0 - f).abs() < 1e-7, "cycle {cycle}");
        let terminal = f / d;
        e += terminal * T + (v - terminal) * (1.0 - decay) * m / d;
        v = terminal + (v - terminal) * decay;
        assert!((command.offset_mm - e).abs() < 1e-9, "cycle {cycle}: {} {e}", command.offset_mm);
    }
}

#[test]
fn the_approach_is_slow_and_the_retreat_is_not() {
    let mut rig = Rig::new(SOFT, settings());
    rig.surface_mm = -0.5;
    let mut before_mm = 0.0;
    for _ in 0..30 {
        let command = rig.cycle();
        assert!(before_mm - command.offset_mm <= 5.0 * T + 1e-12);
        before_mm = command.offset_mm;
    }
    assert_eq!(rig.last.unwrap().status, Status::NoContact);
    assert!(rig.last.unwrap().limits.rate());
    let command = rig.run(3000);
    assert!((force(&command) - 20.0).abs() < SETTLED_N);
    // The workpiece comes towards the tool by 1 mm: 100 N too much.
    rig.surface_mm += 1.0;
    let command = rig.cycle();
    assert!(command.offset_mm - rig.last.unwrap().offset_mm < 50.0 * T + 1e-12);
    let pushed = rig.run(40);
    assert!(pushed.offset_mm > command.offset_mm + 0.5, "{}", pushed.offset_mm);
}

#[test]
fn travel_and_workspace_end_the_correction_without_winding_up() {
    let short = ControllerSettings { travel_mm: [-0.3, 0.2], ..settings() };
    let mut rig = Rig::new(SOFT, short);
    rig.surface_mm = -2.0;
    let command = rig.run(400);
    assert!((command.offset_mm + 0.3).abs() < 1e-12 && command.limits.travel());
    // Released at once: the wall comes to where the tool waits.
    rig.surface_mm = 0.5;
    rig.cycle();
    let command = rig.cycle();
    assert!(command.offset_mm > -0.3 + 1e-3, "{}", command.offset_mm);

    let limits = HeadLimits { axial_mm: [179.9, 180.1], ..HeadLimits::wide(&GEOMETRY) };
    let head = force_impedance::Head::new(GEOMETRY, limits).unwrap();
    let mut rig = Rig::new(SOFT, settings());
    rig.controller = Controller::new(head, SOFT, settings()).unwrap();
    rig.surface_mm = -2.0;
    let command = rig.run(600);
    assert!(command.limits.workspace());
    assert!((command.lengths_mm[3] - 180.1).abs() < 50.0 * T, "{:?}", command.lengths_mm);
    assert!(command.lengths_mm[3] <= 180.1);
}

/// A change of parameters leaves position and speed alone: the step after it differs from the
/// step before by what the forces can do in one interval, never by a jump.
#[test]
fn parameters_change_without_a_bump() {
    let mut rig = Rig::new(SOFT, settings());
    rig.surface_mm = 0.2;
    rig.run(20);
    let (a, b) = (rig.cycle().offset_mm, rig.cycle().offset_mm);
    let other =
        ImpedanceParameters { mass_kg: 4.0, damping_ns_per_mm: 3.0, stiffness_n_per_mm: 5.0 };
    let prepared = rig.controller.prepare(other).unwrap();
    rig.controller.adopt(prepared).unwrap();
    rig.controller.set_mode(ReferenceMode::Absolute);
    let command = rig.cycle();
    let jump_mm = (command.offset_mm - b) - (b - a);
    // (F − D v − K E)/M over an interval of 1 ms: forces of at most 30 N on 4 kg.
    let most_mm = 30.0 / 4e-3 * T * T;
    assert!(jump_mm.abs() < most_mm, "{jump_mm} {most_mm}");
    let elsewhere =
        force_impedance::Impedance::new(other, 2e-3, Discretisation::ExactHold).unwrap();
    assert!(rig.controller.adopt(elsewhere).is_err());
}

#[test]
fn a_new_reference_is_reached_by_a_ramp() {
    let mut rig = Rig::new(SOFT, settings());
    rig.run(2000);
    rig.reference_n = 60.0;
    let mut before_n = 20.0;
    for _ in 0..80 {
        let now_n = rig.cycle().reference_n;
        assert!(now_n - before_n <= 500.0 * T + 1e-9);
        before_n = now_n;
    }
    assert!((before_n - 60.0).abs() < 1e-9);
    for (asked, kept) in [(f64::NAN, 60.0), (f64::INFINITY, 60.0)] {
        rig.reference_n = asked;
        let command = rig.cycle();
        assert!((command.reference_n - kept).abs() < 1e-9);
        assert!(command.limits.reference());
        assert_eq!(command.status, Status::Controlling);
    }
    for (asked, end) in [(1e9, 200.0), (-5.0, 0.0)] {
        rig.reference_n = asked;
        assert!(rig.cycle().limits.reference());
        assert!((rig.run(500).reference_n - end).abs() < 1e-9);
    }
}

/// The correction stays on the normal of the moment while the normal turns.
#[test]
fn the_tip_is_the_programmed_point_plus_the_correction_along_the_normal() {
    let mut rig = Rig::new(SOFT, settings());
    rig.surface_mm = 0.3;
    for i in 0..2000 {
        let angle = 0.2 * (f64::from(i) * 2e-3).sin();
        rig.normal = Vector3::new(angle.sin(), angle.cos(), 0.0);
        let command = rig.cycle();
        if !command.limits.any() {
            let on_normal = head().start_tip_mm() + rig.normal * command.offset_mm;
            assert!((command.tip_mm - on_normal).norm() < 1e-12);
        }
    }
    assert!((force(&rig.last.unwrap()) - 20.0).abs() < 1.0);
}

#[test]
fn impossible_settings_are_refused() {
    let refuse = |s: ControllerSettings| Controller::new(head(), SOFT, s).unwrap_err();
    let s = settings();
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
        refuse(ControllerSettings { acceleration_mm_per_s2: bad, ..s });
        refuse(ControllerSettings { jerk_mm_per_s3: bad, ..s });
        refuse(ControllerSettings { reference_acceleration_n_per_s2: bad, ..s });
        refuse(ControllerSettings { reference_jerk_n_per_s3: bad, ..s });
        refuse(ControllerSettings { max_friction_ratio: bad, ..s });
        refuse(ControllerSettings { max_disagreement_n: bad, ..s });
        refuse(ControllerSettings { max_blind_mm: bad, ..s });
        refuse(ControllerSettings { travel_mm: [-bad, 1.0], ..s });
        refuse(ControllerSettings { interval_s: bad, ..s });
        refuse(ControllerSettings { max_error_n: bad, ..s });
        refuse(ControllerSettings { max_reference_n: bad, ..s });
        refuse(ControllerSettings { reference_rate_n_per_s: bad, ..s });
        refuse(ControllerSettings { travel_mm: [-1.0, bad], ..s });
        refuse(ControllerSettings { rate_mm_per_s: bad, ..s });
        refuse(ControllerSettings { approach_mm_per_s: bad, ..s });
        refuse(ControllerSettings { contact_n: bad, ..s });
        refuse(ControllerSettings { max_cell_n: bad, ..s });
        refuse(ControllerSettings { max_consistency_mm: bad, ..s });
        refuse(ControllerSettings { max_normal_rad: bad, ..s });
    }
    refuse(ControllerSettings { travel_mm: [1.0, 2.0], ..s });
    refuse(ControllerSettings { approach_mm_per_s: 60.0, ..s });
    refuse(ControllerSettings { frozen_cycles: 1, ..s });
    refuse(ControllerSettings { suspect_cycles: 1, ..s });
    // A stop would take longer than 1e5 cycles.
    refuse(ControllerSettings { acceleration_mm_per_s2: 1e-4, ..s });
    refuse(ControllerSettings { jerk_mm_per_s3: 1e-6, ..s });
    refuse(ControllerSettings { recovery_cycles: 0, ..s });
    refuse(ControllerSettings { max_normal_rad: 1.6, ..s });
}

/// What bounds a motion is positive, whatever follows from it.
#[test]
fn a_bound_of_nought_is_refused_as_that() {
    let s = settings();
    for (bounds, name) in [
        (ControllerSettings { rate_mm_per_s: 0.0, ..s }, "rate_mm_per_s"),
        (ControllerSettings { approach_mm_per_s: 0.0, ..s }, "approach_mm_per_s"),
        (ControllerSettings { acceleration_mm_per_s2: 0.0, ..s }, "acceleration_mm_per_s2"),
        (ControllerSettings { jerk_mm_per_s3: 0.0, ..s }, "jerk_mm_per_s3"),
    ] {
        let error = Controller::new(head(), SOFT, bounds).unwrap_err();
        let ForceImpedanceError::InvalidSetting { setting, needs, .. } = error else {
            panic!("{error}");
        };
        assert!(setting == name && needs.starts_with("positive"), "{setting}: {needs}");
    }
}
