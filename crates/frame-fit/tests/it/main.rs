//! Public behaviour of frame-fit.

mod consistency;
mod degenerate;
mod golden;
mod hostile;
mod laws;
mod model;
mod nested;
mod reflection;
mod robust;
mod scene;
mod snooping;
