//! What the Python package `truing` calls: plain arguments and `NumPy` arrays in, dictionaries of
//! arrays out. Classes, documentation and types are in `python/truing`.
//!
//! Arrays are read where they lie unless a solver wants records; results are handed over without a
//! copy. The interpreter is free for other threads while anything is computed.
#![expect(
    clippy::needless_pass_by_value,
    clippy::too_many_arguments,
    reason = "a function for Python takes its arguments one by one, and owns what is made of them"
)]

mod arrays;
mod case;
mod force;
mod frame;
mod free;
mod head;
mod own_model;
mod pose;
mod pressure;
mod probe;
mod refusal;
mod surface;
mod tracker;

use pyo3::prelude::*;

/// Keeps freed memory for the next call; the system's allocator hands it back, page by page.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The native half of the package `truing`.
#[pymodule]
mod _truing {
    #[pymodule_export]
    use crate::case::{check, close_loop, close_machine, depth, init, kinds, plan, solve};
    #[pymodule_export]
    use crate::force::Controller;
    #[pymodule_export]
    use crate::frame::fit_frame;
    #[pymodule_export]
    use crate::head::Head;
    #[pymodule_export]
    use crate::own_model::close_own_loop;
    #[pymodule_export]
    use crate::pose::{estimate_normals, fit_pose, register};
    #[pymodule_export]
    use crate::pressure::{centers, locate_contact, locate_presses};
    #[pymodule_export]
    use crate::probe::compensate;
    #[pymodule_export]
    use crate::surface::Surface;
    #[pymodule_export]
    use crate::tracker::calibrate;

    use super::{Bound, PyModule, PyModuleMethods, PyResult};

    #[pymodule_init]
    fn init_module(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
