//! The only place where pointers of a caller become references.

use core::mem::{align_of, needs_drop, size_of};

use crate::FiError;

/// A copy of what a pointer points at.
///
/// Inputs are copied before an output is written, so that the two may overlap.
///
/// # Safety
///
/// A pointer that is neither null nor misaligned points at a live `T`, any bits of which are
/// valid, and that nobody writes meanwhile.
pub(crate) unsafe fn read<T: Copy>(pointer: *const T) -> Result<T, FiError> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(FiError::BadPointer);
    }
    // SAFETY: neither null nor misaligned; the rest is the caller's promise.
    Ok(unsafe { pointer.read() })
}

/// A place for an output: to be written once, after all inputs were read.
pub(crate) struct Output<T>(*mut T);

impl<T: Copy> Output<T> {
    /// # Safety
    ///
    /// A pointer that is neither null nor misaligned points at a live `T` until [`Output::put`],
    /// and nobody else reads or writes it meanwhile.
    pub(crate) unsafe fn at(pointer: *mut T) -> Result<Self, FiError> {
        if pointer.is_null() || !pointer.is_aligned() {
            return Err(FiError::BadPointer);
        }
        Ok(Self(pointer))
    }

    pub(crate) fn put(self, value: T) {
        // SAFETY: looked at in `at`; the rest is the promise given there.
        unsafe { self.0.write(value) }
    }
}

/// Storage behind a pointer, to be changed in place.
///
/// # Safety
///
/// As [`read`], and nobody else reads or writes it meanwhile.
pub(crate) unsafe fn storage<'a, T>(pointer: *mut T) -> Result<&'a mut T, FiError> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(FiError::BadPointer);
    }
    // SAFETY: neither null nor misaligned; the rest is the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// Whether two objects have a byte in common.
pub(crate) fn overlap<A, B>(a: *const A, b: *const B) -> bool {
    let (a, b) = (a.addr(), b.addr());
    a < b.saturating_add(size_of::<B>()) && b < a.saturating_add(size_of::<A>())
}

/// Storage of a caller for a value of this library: a mark that says that it is there, and words.
pub(crate) struct Slot;

impl Slot {
    /// Puts a value into the words.
    pub(crate) fn put<T: Copy, const N: usize>(words: &mut [u64; N], value: T) {
        const {
            assert!(size_of::<T>() <= 8 * N && align_of::<T>() <= align_of::<u64>());
            assert!(!needs_drop::<T>());
        }
        // SAFETY: large and aligned enough, as just asserted.
        unsafe { words.as_mut_ptr().cast::<T>().write(value) }
    }

    /// The value that [`Slot::put`] left there.
    ///
    /// # Safety
    ///
    /// `put` of the same `T` came before, and the words have not been changed since.
    pub(crate) unsafe fn get<T: Copy, const N: usize>(words: &[u64; N]) -> &T {
        // SAFETY: `put` compiled, so it is large and aligned enough; it holds a `T` by promise.
        unsafe { &*words.as_ptr().cast::<T>() }
    }

    /// The same, to be changed.
    ///
    /// # Safety
    ///
    /// As [`Slot::get`].
    pub(crate) unsafe fn get_mut<T: Copy, const N: usize>(words: &mut [u64; N]) -> &mut T {
        // SAFETY: as in `get`.
        unsafe { &mut *words.as_mut_ptr().cast::<T>() }
    }
}

/// Turns a result into the code that C sees.
pub(crate) fn code(result: Result<(), FiError>) -> FiError {
    result.err().unwrap_or(FiError::None)
}
