//! `frame-fit`: points in two frames, simulated from the physics, and what is asked of the loop on them.

pub(crate) mod frame_cases;
#[cfg(test)]
pub(crate) mod frame_scenes;
#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod survey;
pub(crate) mod tip_poses;
