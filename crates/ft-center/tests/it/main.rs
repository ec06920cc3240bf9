//! Tests of the public interface, one binary.

mod coverage;
mod orbit;
mod simulator;
