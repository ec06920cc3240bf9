//! The real-time functions of force-impedance behind unmangled names, with a panic handler that
//! calls a function nobody has. Built without `std` and with link-time optimisation, the archive
//! asks for that function only if a panic can be reached.
#![no_std]

use force_impedance::{
    Command, ContactForce, Controller, ForceImpedanceError, ForwardPose, Head, HeadPose,
    Impedance, Measurement, ReferenceMode,
};
use nalgebra::{Point3, Vector3};

unsafe extern "C" {
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe { a_panic_is_reachable() }
}

#[unsafe(no_mangle)]
pub fn probe_update(
    controller: &mut Controller,
    seen: &Measurement,
    dt_s: f64,
    command: &mut Command,
) {
    *command = controller.update(seen, dt_s);
}

#[unsafe(no_mangle)]
pub fn probe_change(controller: &mut Controller, impedance: Impedance, mode: ReferenceMode) -> bool {
    controller.set_mode(mode);
    controller.adopt(impedance).is_ok()
}

#[unsafe(no_mangle)]
pub fn probe_inverse(
    head: &Head,
    tip_mm: &Point3<f64>,
    pose: &mut Result<HeadPose, ForceImpedanceError>,
) {
    *pose = head.pose_at(tip_mm);
}

#[unsafe(no_mangle)]
pub fn probe_forward(
    head: &Head,
    lengths_mm: &[f64; 4],
    pose: &mut Result<ForwardPose, ForceImpedanceError>,
) {
    *pose = head.pose_of_lengths(lengths_mm);
}

#[unsafe(no_mangle)]
pub fn probe_contact(
    head: &Head,
    pose: &HeadPose,
    cells_n: &[f64; 4],
    normal: &Vector3<f64>,
    contact: &mut ContactForce,
) {
    *contact = head.balance(pose).contact(cells_n, normal);
}

/// What the check must find, so that it is known to find anything.
#[cfg(feature = "control")]
#[unsafe(no_mangle)]
pub fn probe_control(values: &[f64], index: usize) -> f64 {
    values[index]
}
