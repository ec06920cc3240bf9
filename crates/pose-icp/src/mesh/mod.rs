//! Triangle meshes: what makes one usable, and registration onto one.

mod border;
mod face_tree;
mod nominal;
mod sample;
mod surface;
mod target;
mod triangles;

pub use border::Holes;
pub use nominal::MeshSurface;
pub use sample::sample_surface;
pub use target::{MeshTarget, register_to_mesh};
pub use triangles::TriangleMesh;
