//! `overhead.rs` with the allocator of the package: what is left of a difference is then that of the calls.

#[path = "overhead.rs"]
mod overhead;

use std::error::Error;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn Error>> {
    overhead::main()
}
