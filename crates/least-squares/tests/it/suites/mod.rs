//! Test suites that others wrote, with their known answers.

pub mod dual;
pub mod mgh;
pub mod nist;
