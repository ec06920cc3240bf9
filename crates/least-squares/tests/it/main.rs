//! Behaviour of the solver, seen from outside.

mod line;
mod suites;
