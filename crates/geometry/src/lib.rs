//! Rigid and planar transforms, wrenches and optical surfaces for precision machines.
//!
//! - [`so3`], [`se3`], [`se2`]: exp, log, adjoint and Jacobians on nalgebra's own types, accurate
//!   to round-off from 1e-9 rad to π; machine errors live at 1e-6 rad. [`EulerAngles`] are
//!   `R = Rz(γ) Ry(β) Rx(α)`, [`PlanarMap`] takes in reflection, scale and shear.
//! - [`Wrench`]: change of reference point and frame, power, line of action, free moment.
//! - [`Plane`], [`Sphere`], [`Asphere`], [`Polynomial`], [`HeightGrid`], [`Nurbs`] answer as
//!   [`Surface`]s, with a measured map of deviations as [`FormedSurface`]: closest point, curvature, hits of a line. Where there is no answer, or not a single one, they say which way it failed.
//!
//! Lengths are in mm, forces in N, moments in N·mm, angles in rad ([`units`] has the factors).
//! Six-vectors are `[tx, ty, tz, rx, ry, rz]` and perturb on the left, `T = exp(ξ) T̂`; wrenches
//! are `[fx, fy, fz, mx, my, mz]`, so that their product is power. A transform named
//! `target_from_source` takes source coordinates to target coordinates.
//!
//! Sources: Barfoot, *State Estimation for Robotics* (2017), ch. 7; Solà, Deray, Atchuthan, *A
//! micro Lie theory* (2018), arXiv:1812.01537; ISO 10110-12 for the sag of an asphere.
//!
//! ```
//! use geometry::nalgebra::{Point3, Vector3};
//! use geometry::{Asphere, AsphereShape, Surface, Wrench};
//!
//! // A paraboloid bowl, R = 480 mm, 100 mm across, touched 0.012 mm above its surface.
//! let bowl = Asphere::new(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0))?;
//! let on = Point3::new(30.0, 40.0, 2500.0 / 960.0);
//! let normal = bowl.normal(on.x, on.y)?;
//! let foot = bowl.closest_point(&(on + normal.into_inner() * 0.012))?;
//! assert!((foot.point_mm - on).norm() < 1e-12);
//! assert!((foot.signed_distance_mm - 0.012).abs() < 1e-12);
//!
//! // A force through that point is found again where its line of action meets the bowl.
//! let wrench = Wrench::of_force(Vector3::new(0.5, -0.2, -40.0), &on);
//! let hit = bowl.hits(&wrench.line_of_action()?.line)?[0];
//! assert!((hit.point_mm - on).norm() < 1e-12);
//! # Ok::<(), geometry::GeometryError>(())
//! ```

mod asphere;
mod continued;
mod error;
mod euler;
mod formed;
mod graph;
mod height_grid;
mod line;
mod nurbs;
mod planar;
mod plane;
mod polynomial;
mod sphere;
mod surface;
mod univariate;
mod wrench;

// Public as namespaces: `se3::exp` and `so3::exp` have no better names apart from their group.
pub mod coefficients;
pub mod se2;
pub mod se3;
pub mod so3;
pub mod units;

pub use nalgebra;

pub use asphere::{Asphere, AsphereShape};
pub use error::GeometryError;
pub use euler::{EulerAngles, EulerReading};
pub use formed::{DeviationAlong, FormedSurface};
pub use height_grid::HeightGrid;
pub use line::Line;
pub use nurbs::{Nurbs, NurbsJet};
pub use planar::{PlanarMap, PlanarParts};
pub use plane::Plane;
pub use polynomial::Polynomial;
pub use sphere::Sphere;
pub use surface::{Curvature, Foot, Hit, Surface};
pub use wrench::{LineOfAction, Wrench};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
