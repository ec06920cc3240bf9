use core::ffi::c_char;
use core::fmt::Write as _;

use force_impedance::{Controller, ControllerSettings};

use crate::FiError;
use crate::head::{FiHeadGeometry, FiHeadLimits, head_of};
use crate::pointer::{code, read};
use crate::settings::{FiImpedance, FiSettings};

/// A caller's buffer that is filled up to its last byte but one.
struct Buffer {
    at: *mut c_char,
    left: usize,
}

impl core::fmt::Write for Buffer {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for symbol in text.chars() {
            if self.left < symbol.len_utf8() {
                self.left = 0;
                return Ok(());
            }
            let mut bytes = [0; 4];
            for byte in symbol.encode_utf8(&mut bytes).bytes() {
                // SAFETY: `left` bytes and one for the end are the caller's from `at` on.
                unsafe {
                    self.at.write(byte.cast_signed() as c_char);
                    self.at = self.at.add(1);
                }
                self.left -= 1;
            }
        }
        Ok(())
    }
}

/// Says with numbers why dimensions, limits, impedance or settings are refused: writes UTF-8 into
/// `text`, ended by a zero within `size` bytes, and returns the code that `fi_head_init` or
/// `fi_controller_init` gives. An empty text where nothing is wrong. All but `geometry` may be
/// null; what is null is not looked at. Not for a control cycle.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type, `text` at `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_explain(
    geometry: *const FiHeadGeometry,
    limits: *const FiHeadLimits,
    impedance: *const FiImpedance,
    settings: *const FiSettings,
    text: *mut c_char,
    size: usize,
) -> FiError {
    let explain = || {
        let left = size.checked_sub(1).filter(|_| !text.is_null()).ok_or(FiError::BadPointer)?;
        let mut buffer = Buffer { at: text, left };
        // SAFETY: the caller's promise.
        let tried = unsafe { attempt(geometry, limits, impedance, settings) };
        if let Ok(Err(why)) = &tried {
            let written = write!(buffer, "{why}");
            debug_assert!(written.is_ok(), "the buffer takes everything");
        }
        // SAFETY: one byte is left for the end.
        unsafe { buffer.at.write(0) };
        Ok(tried??)
    };
    code(explain())
}

/// # Safety
///
/// Pointers are null or point at live objects of their type.
unsafe fn attempt(
    geometry: *const FiHeadGeometry,
    limits: *const FiHeadLimits,
    impedance: *const FiImpedance,
    settings: *const FiSettings,
) -> Result<Result<(), force_impedance::ForceImpedanceError>, FiError> {
    // SAFETY: the caller's promise.
    let head = match unsafe { head_of(geometry, limits) }? {
        Ok(head) => head,
        Err(why) => return Ok(Err(why)),
    };
    if impedance.is_null() {
        return Ok(Ok(()));
    }
    // SAFETY: the caller's promise.
    let impedance = unsafe { read(impedance) }?;
    let settings = if settings.is_null() {
        ControllerSettings::default()
    } else {
        // SAFETY: the caller's promise.
        ControllerSettings::try_from(&unsafe { read(settings) }?)?
    };
    Ok(Controller::new(head, (&impedance).into(), settings).map(|_| ()))
}
