//! The same answers as the Rust interface, and codes where a caller is wrong.

use std::ffi::CStr;
use std::mem::{size_of, size_of_val, zeroed};
use std::ptr::{null, null_mut};

use force_impedance::{
    Controller, ControllerSettings, Head, HeadLimits, ImpedanceParameters, Measurement,
};
use force_impedance_c::{
    FiCommand, FiContact, FiController, FiError, FiFault, FiHead, FiHeadGeometry, FiHeadLimits,
    FiImpedance, FiMeasurement, FiMode, FiPose, FiSettings, FiStatus, fi_controller_init,
    fi_controller_set_impedance, fi_controller_set_mode, fi_controller_update, fi_error_text,
    fi_explain, fi_head_contact, fi_head_forward, fi_head_init, fi_head_inverse, fi_head_jacobian,
    fi_head_limits_wide, fi_head_published_normal, fi_head_start, fi_settings_default,
};
use nalgebra::{Point3, Vector3};

const GEOMETRY: FiHeadGeometry = FiHeadGeometry {
    tip_to_plane_mm: 120.0,
    plane_to_joint_mm: 180.0,
    head_radius_mm: 40.0,
    bracket_radius_mm: 110.0,
    leg_angles_rad: [std::f64::consts::FRAC_PI_2, 3.665_191_429_188_092, 5.759_586_531_581_288],
    weight_n: 85.0,
    center_of_gravity_mm: 140.0,
    gravity_direction: [0.0, 0.0, -1.0],
};
const IMPEDANCE: FiImpedance =
    FiImpedance { mass_kg: 1.0, damping_ns_per_mm: 1.0, stiffness_n_per_mm: 0.0 };
const T: f64 = 1e-3;

fn head() -> FiHead {
    // SAFETY: plain numbers; the pointers are to live locals.
    unsafe {
        let mut head: FiHead = zeroed();
        assert_eq!(fi_head_init(&raw mut head, &GEOMETRY, null()), FiError::None);
        head
    }
}

fn settings() -> FiSettings {
    // SAFETY: plain numbers; the pointer is to a live local.
    unsafe {
        let mut settings: FiSettings = zeroed();
        assert_eq!(fi_settings_default(&raw mut settings), FiError::None);
        settings
    }
}

fn controller() -> FiController {
    let (head, settings) = (head(), settings());
    // SAFETY: plain numbers; the pointers are to live locals.
    unsafe {
        let mut controller: FiController = zeroed();
        let made = fi_controller_init(
            &raw mut controller,
            &raw const head,
            &IMPEDANCE,
            &raw const settings,
        );
        assert_eq!(made, FiError::None);
        controller
    }
}

fn seen(lengths_mm: [f64; 4]) -> FiMeasurement {
    FiMeasurement {
        lengths_mm,
        cells_n: [100.0, 101.0, 102.0, 35.0],
        normal: [0.0, 1.0, 0.0],
        reference_n: 30.0,
        has_lengths: 1,
        has_cells: 1,
    }
}

/// To the last bit.
fn same(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits()))
}

#[test]
fn kinematics_and_force_are_those_of_rust() {
    let (rust, c) =
        (Head::new((&GEOMETRY).into(), HeadLimits::wide(&(&GEOMETRY).into())).unwrap(), head());
    let tip_mm = [4.0, -301.5, -2.5];
    let (cells_n, normal) = ([100.0, 90.0, 110.0, 60.0], [0.0, 1.0, 0.0]);
    let pose = rust.pose_at(&Point3::from(tip_mm)).unwrap();
    // SAFETY: plain numbers; the pointers are to live locals of the right length.
    unsafe {
        let mut found: FiPose = zeroed();
        assert_eq!(fi_head_inverse(&raw const c, tip_mm.as_ptr(), &raw mut found), FiError::None);
        assert_eq!((found.tip_mm, found.lengths_mm), (tip_mm, pose.lengths_mm));
        let mut lengths_mm = pose.lengths_mm;
        lengths_mm[0] += 0.01;
        let again = rust.pose_of_lengths(&lengths_mm).unwrap();
        let mut off_mm = f64::NAN;
        let said =
            fi_head_forward(&raw const c, lengths_mm.as_ptr(), &raw mut found, &raw mut off_mm);
        assert_eq!(said, FiError::None);
        assert_eq!((off_mm, Point3::from(found.tip_mm)), (again.consistency_mm, again.pose.tip_mm));
        let mut jacobian = [0.0; 12];
        let said = fi_head_jacobian(&raw const c, tip_mm.as_ptr(), jacobian.as_mut_ptr());
        assert_eq!(said, FiError::None);
        let expected = rust.leg_jacobian(&pose);
        assert!((0..12).all(|i| jacobian[i].to_bits() == expected[(i / 3, i % 3)].to_bits()));
        let mut contact: FiContact = zeroed();
        let lengths_mm = pose.lengths_mm;
        let at = (lengths_mm.as_ptr(), cells_n.as_ptr(), normal.as_ptr());
        assert_eq!(
            fi_head_contact(&raw const c, at.0, at.1, at.2, &raw mut contact),
            FiError::None
        );
        let balance = rust.balance(&rust.pose_of_lengths(&lengths_mm).unwrap().pose);
        let expected = balance.contact(&cells_n, &Vector3::from(normal));
        assert_eq!(Vector3::from(contact.force_n), expected.force_n);
        let mut published_n = f64::NAN;
        let said = fi_head_published_normal(&raw const c, at.0, at.1, at.2, &raw mut published_n);
        assert_eq!(said, FiError::None);
        let expected_n = balance.published_normal_n(&cells_n, &Vector3::from(normal)).unwrap();
        assert_eq!(published_n.to_bits(), expected_n.to_bits());
        let mut limits: FiHeadLimits = zeroed();
        assert_eq!(fi_head_limits_wide(&GEOMETRY, &raw mut limits), FiError::None);
        assert!(same(&limits.axial_mm, &[90.0, 360.0]));
    }
}

/// Two thousand cycles with faults in between: every command is that of the Rust controller.
#[test]
fn a_run_is_that_of_rust() {
    let geometry = (&GEOMETRY).into();
    let rust_head = Head::new(geometry, HeadLimits::wide(&geometry)).unwrap();
    let parameters = ImpedanceParameters::from(&IMPEDANCE);
    let mut rust = Controller::new(rust_head, parameters, ControllerSettings::default()).unwrap();
    let mut c = controller();
    let mut lengths_mm = rust_head.pose_at(&rust_head.start_tip_mm()).unwrap().lengths_mm;
    for cycle in 0..2000_u32 {
        let mut now = seen(lengths_mm);
        now.cells_n[3] += f64::from(cycle * 7919 % 101) * 0.1;
        match cycle % 97 {
            40 => now.has_cells = 0,
            60 => now.lengths_mm[1] = f64::NAN,
            80 => now.normal = [2.0, 0.0, 0.0],
            _ => {}
        }
        let expected = rust.update(&Measurement::from(&now), T);
        // SAFETY: plain numbers; the pointers are to live locals.
        let command = unsafe {
            let mut command: FiCommand = zeroed();
            let said = fi_controller_update(&raw mut c, &raw const now, T, &raw mut command);
            assert_eq!(said, FiError::None);
            if cycle == 1000 {
                let softer = FiImpedance { damping_ns_per_mm: 2.0, ..IMPEDANCE };
                let said = fi_controller_set_impedance(&raw mut c, &raw const softer);
                assert_eq!(said, FiError::None);
                rust.adopt(rust.prepare((&softer).into()).unwrap()).unwrap();
            }
            command
        };
        assert!(same(&command.lengths_mm, &expected.lengths_mm), "cycle {cycle}");
        assert_eq!(command.contact.normal_n.is_nan(), expected.contact.is_none());
        lengths_mm = command.lengths_mm;
    }
}

#[test]
fn null_and_misaligned_pointers_are_codes() {
    let (head, settings) = (head(), settings());
    let mut c = controller();
    // SAFETY: the functions look at pointers before they use them.
    unsafe {
        let mut pose: FiPose = zeroed();
        assert_eq!(fi_head_init(null_mut(), &GEOMETRY, null()), FiError::BadPointer);
        let mut other: FiHead = zeroed();
        assert_eq!(fi_head_init(&raw mut other, null(), null()), FiError::BadPointer);
        assert_eq!(fi_head_inverse(&raw const head, null(), &raw mut pose), FiError::BadPointer);
        assert_eq!(fi_head_start(&raw const head, null_mut()), FiError::BadPointer);
        let odd = std::ptr::without_provenance_mut::<FiPose>(4097);
        assert_eq!(fi_head_start(&raw const head, odd), FiError::BadPointer);
        assert_eq!(fi_settings_default(null_mut()), FiError::BadPointer);
        let made = fi_controller_init(&raw mut c, &raw const head, null(), &raw const settings);
        assert_eq!(made, FiError::BadPointer);
        assert_eq!(fi_controller_update(&raw mut c, null(), T, null_mut()), FiError::BadPointer);
        let mut command: FiCommand = zeroed();
        assert_eq!(fi_controller_update(&raw mut c, null(), T, &raw mut command), FiError::None);
        assert_eq!((command.status, command.fault), (FiStatus::Held, FiFault::NoSample));
    }
}

#[test]
fn storage_that_was_not_initialised_is_a_code() {
    // SAFETY: any bits are a valid storage.
    unsafe {
        let (head, mut pose): (FiHead, FiPose) = (zeroed(), zeroed());
        assert_eq!(fi_head_start(&raw const head, &raw mut pose), FiError::NotInitialised);
        let (mut c, mut command): (FiController, FiCommand) = (zeroed(), zeroed());
        let now = seen([70.0, 70.0, 70.0, 180.0]);
        let said = fi_controller_update(&raw mut c, &raw const now, T, &raw mut command);
        assert_eq!(said, FiError::NotInitialised);
        assert_eq!(fi_controller_set_mode(&raw mut c, 0), FiError::NotInitialised);
    }
}

#[test]
fn what_is_refused_is_said_with_its_number() {
    let explain = |geometry: &FiHeadGeometry, impedance: &FiImpedance, size: usize| {
        let mut text = [1; 200];
        let settings = settings();
        // SAFETY: the pointers are to live locals, `size` is within the text.
        let said = unsafe {
            fi_explain(geometry, null(), impedance, &raw const settings, text.as_mut_ptr(), size)
        };
        // SAFETY: the function ends what it writes with a zero.
        let text = unsafe { CStr::from_ptr(text.as_ptr()) };
        (said, text.to_str().unwrap().to_owned())
    };
    assert_eq!(explain(&GEOMETRY, &IMPEDANCE, 200), (FiError::None, String::new()));
    let short = FiHeadGeometry { head_radius_mm: -40.0, ..GEOMETRY };
    let (said, text) = explain(&short, &IMPEDANCE, 200);
    assert_eq!(said, FiError::InvalidSetting);
    assert_eq!(text, "head_radius_mm is -40, must be positive and finite");
    assert_eq!(explain(&short, &IMPEDANCE, 8).1, "head_ra");
    let quick = FiImpedance { mass_kg: 1e-6, damping_ns_per_mm: 1e-9, stiffness_n_per_mm: 1e6 };
    assert_eq!(explain(&GEOMETRY, &quick, 200).0, FiError::TooFastForSampling);
    let nameless = FiSettings { mode: 7, ..settings() };
    let (head, mut c) = (head(), controller());
    // SAFETY: plain numbers; the pointers are to live locals.
    unsafe {
        let said = fi_controller_init(&raw mut c, &raw const head, &IMPEDANCE, &raw const nameless);
        assert_eq!(said, FiError::InvalidSetting);
        // The refusal left nothing there.
        let mode = FiMode::Absolute as u32;
        assert_eq!(fi_controller_set_mode(&raw mut c, mode), FiError::NotInitialised);
        let mut c = controller();
        assert_eq!(fi_controller_set_mode(&raw mut c, mode), FiError::None);
    }
}

/// Kinds of trouble that a caller can meet, each with the code of its own.
#[test]
fn every_code_has_its_text_and_geometry_its_codes() {
    let head = head();
    let reach = |tip_mm: [f64; 3]| {
        // SAFETY: plain numbers; the pointers are to live locals.
        unsafe {
            let mut pose: FiPose = zeroed();
            fi_head_inverse(&raw const head, tip_mm.as_ptr(), &raw mut pose)
        }
    };
    assert_eq!(reach([f64::NAN, -300.0, 0.0]), FiError::NotFinite);
    assert_eq!(reach([0.0, -900.0, 0.0]), FiError::AxialOutOfRange);
    assert_eq!(reach([300.0, -100.0, 0.0]), FiError::TiltOutOfRange);
    let mut texts: Vec<String> = (0..=13)
        // SAFETY: the texts live for ever.
        .map(|code| unsafe { CStr::from_ptr(fi_error_text(code)) }.to_str().unwrap().to_owned())
        .collect();
    texts.sort();
    texts.dedup();
    assert_eq!(texts.len(), 14);
}

/// A refused initialisation stops the controller that was there.
#[test]
fn a_failed_initialisation_leaves_no_controller() {
    let (head, good) = (head(), settings());
    let bad = FiSettings { max_cell_n: 1e300, ..good };
    let (light, heavy) = (IMPEDANCE, FiImpedance { mass_kg: -1.0, ..IMPEDANCE });
    // SAFETY: plain numbers.
    let mut command: FiCommand = unsafe { zeroed() };
    // SAFETY: plain numbers; the pointers are to live locals.
    unsafe {
        for (impedance, settings, code) in [
            (&raw const light, &raw const bad, FiError::InvalidSetting),
            (&raw const heavy, &raw const good, FiError::InvalidSetting),
        ] {
            let mut c = controller();
            assert_eq!(fi_controller_init(&raw mut c, &raw const head, impedance, settings), code);
            let said = fi_controller_update(&raw mut c, null(), T, &raw mut command);
            assert_eq!(said, FiError::NotInitialised);
        }
        let mut head = head;
        let short = FiHeadGeometry { head_radius_mm: -40.0, ..GEOMETRY };
        assert_eq!(fi_head_init(&raw mut head, &raw const short, null()), FiError::InvalidSetting);
        let mut pose: FiPose = zeroed();
        assert_eq!(fi_head_start(&raw const head, &raw mut pose), FiError::NotInitialised);
    }
}

/// A command over its own measurement is as good as beside it; one within the controller is refused.
#[test]
fn outputs_may_overlap_inputs_but_not_the_controller() {
    let head = head();
    // SAFETY: plain numbers.
    let mut start: FiPose = unsafe { zeroed() };
    // SAFETY: plain numbers; the pointers are to live locals.
    unsafe {
        assert_eq!(fi_head_start(&raw const head, &raw mut start), FiError::None);
        let now = seen(start.lengths_mm);
        let (mut one, mut other) = (controller(), controller());
        let mut beside: FiCommand = zeroed();
        // Room for the larger of the two, a measurement in its beginning.
        let mut room = [0_u64; 64];
        assert!(size_of_val(&room) >= size_of::<FiCommand>().max(size_of::<FiMeasurement>()));
        for _ in 0..100 {
            let at = room.as_mut_ptr();
            at.cast::<FiMeasurement>().write(now);
            let said = fi_controller_update(&raw mut one, &raw const now, T, &raw mut beside);
            assert_eq!(said, FiError::None);
            let said = fi_controller_update(&raw mut other, at.cast(), T, at.cast());
            assert_eq!(said, FiError::None);
            let over = at.cast::<FiCommand>().read();
            assert!(same(&over.lengths_mm, &beside.lengths_mm) && over.status == beside.status);
        }
        let within = (&raw mut one).cast::<u64>().add(3).cast::<FiCommand>();
        let said = fi_controller_update(&raw mut one, &raw const now, T, within);
        assert_eq!(said, FiError::BadPointer);
        let said = fi_controller_update(&raw mut one, &raw const now, T, &raw mut beside);
        assert_eq!(said, FiError::None);
        // A pose over the point it is made for.
        let mut pose = start;
        let at = &raw mut pose;
        assert_eq!(fi_head_inverse(&raw const head, at.cast(), at), FiError::None);
        assert!(same(&pose.tip_mm, &start.tip_mm));
    }
}
