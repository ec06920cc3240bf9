//! Without `std` a static library brings its own panic handler.

unsafe extern "C" {
    /// Nobody provides it: a library built with link-time optimisation asks for it only if a panic
    /// can be reached.
    fn force_impedance_panicked() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it takes nothing and does not return; without it the program does not link.
    unsafe { force_impedance_panicked() }
}
