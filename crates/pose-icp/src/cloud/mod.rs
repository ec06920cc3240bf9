//! Registration of point clouds.

mod error;
mod point_cloud;

pub use error::{RegisterError, Side};
pub use point_cloud::PointCloud;
