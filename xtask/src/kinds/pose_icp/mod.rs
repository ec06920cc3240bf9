//! `pose-icp`: workpieces that are touched, simulated from the physics, and what is asked of the loop on them.

#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod mirror;
pub(crate) mod mirror_cases;
pub(crate) mod mirror_cells;
#[cfg(test)]
pub(crate) mod pose_scenes;
