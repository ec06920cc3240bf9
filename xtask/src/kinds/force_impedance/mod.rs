//! `force-impedance`: a polishing head and its force, simulated from the physics, and what is asked of the loop on them.

#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod polish;
pub(crate) mod polish_cases;
pub(crate) mod polish_head;
pub(crate) mod polish_tables;
pub(crate) mod run_cells;
pub(crate) mod stroke_cases;
pub(crate) mod strokes;
