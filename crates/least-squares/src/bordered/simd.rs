//! One compiled copy of the hot loops per set of vector instructions, chosen at run time.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

/// Work whose loops the compiler turns into vector code.
pub(super) trait Task {
    type Output;

    /// Runs it; has to be `#[inline(always)]`. With `FUSED`, `mul_add` is one instruction.
    fn run<S: pulp::Simd, const FUSED: bool>(self, simd: S) -> Self::Output;
}

/// Runs a task with the best instructions of this machine.
pub(super) fn dispatch<T: Task>(task: T) -> T::Output {
    pulp::Arch::new().dispatch(Chosen(task))
}

struct Chosen<T>(T);

impl<T: Task> pulp::WithSimd for Chosen<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> T::Output {
        // WebAssembly has vectors without a fused multiply-add.
        if S::IS_SCALAR || cfg!(target_family = "wasm") {
            self.0.run::<S, false>(simd)
        } else {
            self.0.run::<S, true>(simd)
        }
    }
}

/// `a b + c`.
#[inline(always)]
pub(super) fn mul_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
