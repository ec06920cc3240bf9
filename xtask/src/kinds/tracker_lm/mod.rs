//! `tracker-lm`: a tracer about a rotary axis, simulated from the physics, and what is asked of the loop on them.

#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod head;
pub(crate) mod target_cases;
pub(crate) mod target_cells;
pub(crate) mod target_design;
#[cfg(test)]
pub(crate) mod target_scenes;
pub(crate) mod targets;
#[cfg(test)]
pub(crate) mod targets_handback;
pub(crate) mod tracer;
pub(crate) mod tracer_cases;
pub(crate) mod tracer_cells;
pub(crate) mod tracer_design;
pub(crate) mod tracer_physics;
pub(crate) mod tracer_run;
pub(crate) mod tracer_tables;
#[cfg(test)]
pub(crate) mod tracker_scenes;
