//! Bases, the system in use, and what is left of its rows: linear algebra, no statistics.

pub(crate) mod basis;
pub(crate) mod columns;
pub(crate) mod components;
pub(crate) mod course;
pub(crate) mod coverage;
pub(crate) mod drifts;
pub(crate) mod f_tail;
pub(crate) mod independent;
pub(crate) mod interruption;
pub(crate) mod inverse_root;
pub(crate) mod leverage;
pub(crate) mod linearised;
pub(crate) mod looked_through;
pub(crate) mod patch;
pub(crate) mod product;
pub(crate) mod raw_observations;
pub(crate) mod reading;
pub(crate) mod session;
pub(crate) mod settling;
pub(crate) mod settling_search;
pub(crate) mod shown;
pub(crate) mod silent;
pub(crate) mod system;
pub(crate) mod taken;
