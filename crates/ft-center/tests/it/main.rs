//! Tests of the public interface, one binary.

mod batch;
mod centroid;
mod coverage;
mod displacement;
mod frame;
mod gravity;
mod hostile;
mod jacobian;
mod locate;
mod monitor;
mod orbit;
mod press_loop;
mod pressure;
mod simulator;
mod surface_contact;
