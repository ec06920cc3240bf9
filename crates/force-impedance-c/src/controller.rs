use force_impedance::{Controller, ControllerSettings, Measurement};
use nalgebra::Vector3;

use crate::head::{FiHead, head_in};
use crate::pointer::{Output, Slot, code, overlap, read, storage};
use crate::settings::{FiImpedance, FiSettings, mode};
use crate::{FiCommand, FiError, FiMeasurement};

/// Says that a controller is in the storage, and which layout it has.
const MARK: u64 = 0x4649_2d43_5452_4c02;

/// Storage of a controller; `fi_controller_init` fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct FiController {
    mark: u64,
    /// More than there is to hold; the compiler says when they are too few.
    words: [u64; 240],
}

/// A cycle without a sample: the output is held.
const NOTHING: Measurement = Measurement {
    lengths_mm: None,
    cells_n: None,
    normal: Vector3::new(0.0, 1.0, 0.0),
    reference_n: 0.0,
};

/// The controller in a storage.
///
/// # Safety
///
/// As [`storage`].
unsafe fn controller_in<'a>(controller: *mut FiController) -> Result<&'a mut Controller, FiError> {
    // SAFETY: the caller's promise.
    let slot = unsafe { storage(controller) }?;
    if slot.mark != MARK {
        return Err(FiError::NotInitialised);
    }
    // SAFETY: only `fi_controller_init` sets the mark, after it has put a controller there.
    Ok(unsafe { Slot::get_mut(&mut slot.words) })
}

/// Checks everything once and fills the storage; the head is copied into it.
///
/// Output is held until `recovery_cycles` good cycles have been seen. Storage that held a controller
/// holds none after a refusal: it has to be initialised again. A bad pointer changes nothing.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_controller_init(
    controller: *mut FiController,
    head: *const FiHead,
    impedance: *const FiImpedance,
    settings: *const FiSettings,
) -> FiError {
    let init = || {
        // SAFETY: the caller's promise.
        let (head, impedance, settings) =
            unsafe { (head_in(head), read(impedance)?, read(settings)?) };
        // SAFETY: the caller's promise; inputs are copies.
        let slot = unsafe { storage(controller) }?;
        if head != Err(FiError::BadPointer) {
            slot.mark = 0;
        }
        let head = head?;
        let settings = ControllerSettings::try_from(&settings)?;
        let made = Controller::new(head, (&impedance).into(), settings)?;
        Slot::put(&mut slot.words, made);
        slot.mark = MARK;
        Ok(())
    };
    code(init())
}

/// One cycle: readings in, lengths to command out; `dt_s` is the time since the last call.
///
/// It fails only on a bad or uninitialised handle and a bad `command`, which must not lie within
/// the controller's storage; it may overlap `seen`, which is copied first. A null `seen` is a cycle
/// without a sample. Work is bounded, nothing is allocated or locked.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_controller_update(
    controller: *mut FiController,
    seen: *const FiMeasurement,
    dt_s: f64,
    command: *mut FiCommand,
) -> FiError {
    let update = || {
        if overlap(controller, command) {
            return Err(FiError::BadPointer);
        }
        // SAFETY: the caller's promise.
        let (output, seen) = unsafe { (Output::at(command)?, read(seen)) };
        let seen = seen.map_or(NOTHING, |seen| Measurement::from(&seen));
        // SAFETY: the caller's promise.
        let controller = unsafe { controller_in(controller) }?;
        output.put((&controller.update(&seen, dt_s)).into());
        Ok(())
    };
    code(update())
}

/// Continues with another impedance, without a bump: position and speed carry over.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_controller_set_impedance(
    controller: *mut FiController,
    impedance: *const FiImpedance,
) -> FiError {
    let set = || {
        // SAFETY: the caller's promise.
        let impedance = unsafe { read(impedance) };
        // SAFETY: the caller's promise.
        let controller = unsafe { controller_in(controller) }?;
        let prepared = controller.prepare((&impedance?).into())?;
        Ok(controller.adopt(prepared)?)
    };
    code(set())
}

/// Counts the correction from elsewhere (an `FiMode`) from the next cycle on, without a bump.
///
/// # Safety
///
/// The pointer is null or points at a live object.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_controller_set_mode(
    controller: *mut FiController,
    number: u32,
) -> FiError {
    let set = || {
        // SAFETY: the caller's promise.
        let controller = unsafe { controller_in(controller) }?;
        controller.set_mode(mode(number)?);
        Ok(())
    };
    code(set())
}
