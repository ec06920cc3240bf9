//! `ft-center`: presses and poses of a force/torque sensor, simulated from the physics, and what is asked of the loop on them.

pub(crate) mod gravity_scenes;
#[cfg(test)]
pub(crate) mod handback;
pub(crate) mod press;
pub(crate) mod press_cases;
pub(crate) mod press_tables;
