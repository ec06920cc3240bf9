//! `probe-comp`: touch probes, simulated from the physics, and what is asked of the loop on them.

#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod probe;
pub(crate) mod probe_cases;
pub(crate) mod probe_cells;
#[cfg(test)]
pub(crate) mod probe_scenes;
pub(crate) mod probe_tables;
