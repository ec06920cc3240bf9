//! Tests of the public interface, one binary.

mod coverage;
mod orbit;
mod press_loop;
mod simulator;
