//! Balanced k-d tree whose leaves lie one after the other in memory.
//!
//! Queries come in groups of [`LANES`] neighbours: the tree is walked once for a group, eight boxes
//! at a time, and each point of a leaf is compared with all of its queries at once.

mod boxes;
mod build;
mod facing;
mod found;
mod group;
mod lanes;
mod nearest;
mod tree;
mod wide;

pub(crate) use boxes::Aabb;
pub(crate) use build::{LANES, leaf_of, leaf_start, n_leaves, spatial_order};
pub(crate) use facing::{BesideRule, Facing};
pub(crate) use found::{Found, NONE};
pub(crate) use tree::KdTree;
