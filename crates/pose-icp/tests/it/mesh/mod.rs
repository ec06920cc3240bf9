//! Triangle meshes.

mod defects;
mod fit;
mod shapes;
