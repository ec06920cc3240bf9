//! Choice of the widest registers that the machine has.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

/// Work that gains from wide registers.
///
/// A type rather than a closure: what calls a closure is a function of its own, which the compiler
/// makes for the narrowest machine and need not inline.
pub(crate) trait Task {
    type Output;

    /// Does it; inlined into a function that may use the registers.
    fn run(self) -> Self::Output;
}

pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    pulp::Arch::new().dispatch(Chosen(task))
}

struct Chosen<T>(T);

impl<T: Task> pulp::WithSimd for Chosen<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> T::Output {
        self.0.run()
    }
}
