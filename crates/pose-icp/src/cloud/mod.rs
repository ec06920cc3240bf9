//! Registration of point clouds.

mod averages;
mod chart;
mod error;
mod information;
mod kd_tree;
mod motions;
mod moving;
mod normals;
mod observability;
mod options;
mod pass;
mod point_cloud;
mod register;
mod registration;
mod search;
mod start;
mod sums;
mod target;
mod voxels;
mod wide_registers;

pub(crate) use kd_tree::{Found, NONE, leaf_start, n_leaves, spatial_order};
pub(crate) use point_cloud::check_points;
pub(crate) use register::register;
pub(crate) use target::{Foot, Target, Wanted};
pub(crate) use wide_registers::{Task, dispatch};

pub use error::{OptionName, RegisterError, Side};
pub use normals::estimate_normals;
pub use observability::{Observability, WeakDirection};
pub use options::{Freedom, Objective, RegisterOptions};
pub use point_cloud::PointCloud;
pub use register::register_to_cloud;
pub use registration::{Registration, Termination};
pub use start::find_start;
pub use target::{CloudTarget, Nearest};
pub use voxels::thin_out;
