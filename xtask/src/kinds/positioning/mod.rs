//! `positioning`: positioning runs of an axis, simulated from the physics, and what is asked of the loop on them.

pub(crate) mod axis_curves;
pub(crate) mod axis_run;
pub(crate) mod positions;
