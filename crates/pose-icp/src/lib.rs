//! Where a workpiece lies, from points measured on it.
//!
//! [`fit_pose`] finds the pose of a part of known surface from a few touches of a ball: it
//! minimises `Σ ((dᵢ − r)/σᵢ)²`, `dᵢ` being the distance of ball centre i from the surface and `r`
//! the ball's radius, by Newton's method on the exact closest points. It says which motions the
//! touches hardly show, and [`EdgeTouches`] of the part's side settle them.
//!
//! Lengths are in mm, angles in rad. A six-vector is ordered `[tx, ty, tz, rx, ry, rz]` and
//! perturbs on the left, `T = exp(ξ) T̂`; `target_from_source` maps source to target coordinates.
//! The pose of a workpiece is `p_machine = Rz(γ) Ry(β) Rx(α) p + d`, its parameters are
//! `[x y z α β γ]` with `d = (x, y, z)`.
//!
//! Sources: document \[D\], equations (4)–(10) and (22)–(23); ISO 10110-12 for the surface.
//!
//! ```
//! use pose_icp::geometry::AsphereShape;
//! use pose_icp::nalgebra::{Point3, Vector3};
//! use pose_icp::{Part, PoseOptions, PoseParameter, PoseStart, Touch, fit_pose};
//!
//! // A paraboloid, R = 480 mm, lies 0.2 mm higher than planned and level; five points on it.
//! let part = Part::asphere(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0))?;
//! let at = [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0], [-40.0, 0.0], [0.0, -40.0]];
//! let touches = at.map(|[x, y]: [f64; 2]| {
//!     Touch::new(Point3::new(x, y, 0.2 + (x * x + y * y) / 960.0), 1e-3)
//! });
//! // x, y and γ are known from the fixture.
//! let held = vec![PoseParameter::X, PoseParameter::Y, PoseParameter::Gamma];
//! let options = PoseOptions { held, ..PoseOptions::default() };
//! let planned = PoseStart::level(Vector3::zeros(), 0.0);
//! let fit = fit_pose(&part, &touches, &planned, &options)?;
//! assert!((fit.pose.position_mm.z - 0.2).abs() < 1e-9);
//! // Five heights give the mean height to 1 µm/√5.
//! let sigma_mm = fit.standard_uncertainties().expect("the noise is declared")[2];
//! assert!((0.4e-3..0.9e-3).contains(&sigma_mm));
//! # Ok::<(), pose_icp::PoseError>(())
//! ```

#![cfg_attr(
    not(feature = "loop"),
    expect(
        dead_code,
        unused_imports,
        reason = "the model of the loop asks for more of the shared parts"
    )
)]

// Clouds and meshes.
mod cloud;
mod mesh;

// Touches of a surface that is known exactly.
mod error;
mod exact;
#[cfg(feature = "loop")]
mod missing;
mod outwards;
mod program;
mod sampled;

// What public items are made of.
pub use geometry;
pub use least_squares;
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

pub use cloud::{
    CloudTarget, Freedom, Nearest, Objective, Observability, OptionName, PointCloud, RegisterError,
    RegisterOptions, Registration, Side, Termination, WeakDirection, estimate_normals, find_start,
    register_to_cloud, thin_out,
};
pub use mesh::{Holes, MeshSurface, MeshTarget, TriangleMesh, register_to_mesh, sample_surface};

pub use error::{InvalidTouch, PoseError};
pub use exact::{
    EdgeTouches, Gap, Height, LateralPrior, Noise, Part, PoseFit, PoseOptions, PoseParameter,
    PoseStart, SideTouches, Tip, TipSide, Touch, WeakComponent, WeakMotion, fit_pose, gap_at,
    height_at, start_from_touches,
};
#[cfg(feature = "loop")]
pub use missing::{Fitted, MeasuredTouch, PoseModel};
pub use program::{
    ProgramError, ProgramOptions, ProgramPoint, Refused, correct_points, correct_program,
    correct_program_for_machine, machine_correction, program_points,
};
pub use sampled::{
    Patch, SampledFit, SampledMethod, SampledOptions, SampledPass, fit_pose_on_samples,
    measuring_points, optimal_ratio,
};

/// Runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
