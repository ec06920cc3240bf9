//! Where a part lies, from touches or from clouds.

use nalgebra::{
    DMatrix, Isometry3, Matrix4, Point3, Rotation3, Translation3, Unit, UnitQuaternion,
};
use numpy::{PyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::geometry::EulerAngles;
use truing::pose_icp::{
    self, CloudTarget, Freedom, Noise, Objective, PointCloud, PoseOptions, PoseParameter,
    PoseStart, RegisterOptions, Side, Tip, TipSide, Touch, register_to_cloud, start_from_touches,
};

use crate::arrays::{Table, column, rows, rows_of, small, std_of_each, vectors};
use crate::frame::named_loss;
use crate::refusal::Refusal;
use crate::surface::Surface;

/// Fits the pose of a part to touches of a ball.
#[pyfunction]
#[pyo3(signature = (surface, touches_mm, std_mm, tip_radius_mm, below, held, start, estimate_noise))]
pub(crate) fn fit_pose<'py>(
    py: Python<'py>,
    surface: PyRef<'py, Surface>,
    touches_mm: Table<'py>,
    std_mm: PyReadonlyArrayDyn<'py, f64>,
    tip_radius_mm: f64,
    below: bool,
    held: Vec<String>,
    start: ([f64; 6], bool),
    estimate_noise: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let part = surface.part()?;
    let centers = rows::<3>("touches_mm", &touches_mm)?;
    let std_mm = std_of_each("std_mm", &std_mm, centers.len())?;
    let touches: Vec<Touch> = (centers.iter().enumerate())
        .map(|(i, at)| Touch::new(Point3::from(*at), std_mm.of(i)))
        .collect();
    let side = if below { TipSide::Below } else { TipSide::Above };
    let tip = Tip { radius_mm: tip_radius_mm, side };
    let held = held.iter().map(|name| parameter(name)).collect::<Result<_, _>>()?;
    let noise = if estimate_noise { Noise::Estimated } else { Noise::Declared };
    let options = PoseOptions { tip, held, noise, ..PoseOptions::default() };
    let ([x, y, z, alpha_rad, beta_rad, gamma_rad], given) = start;
    let fit = py.detach(|| {
        let start = if given {
            let angles = EulerAngles { alpha_rad, beta_rad, gamma_rad };
            PoseStart { position_mm: nalgebra::Vector3::new(x, y, z), angles }
        } else {
            start_from_touches(&part, &touches, tip, gamma_rad)?
        };
        pose_icp::fit_pose(&part, &touches, &start, &options)
    });
    let fit = fit.map_err(Refusal::from)?;
    let found = PyDict::new(py);
    found.set_item("matrix", homogeneous(py, &fit.machine_from_workpiece))?;
    let (at, angles) = (fit.pose.position_mm, fit.pose.angles);
    let pose = vec![at.x, at.y, at.z, angles.alpha_rad, angles.beta_rad, angles.gamma_rad];
    found.set_item("pose", column(py, pose))?;
    found.set_item("covariance", small(py, &fit.covariance))?;
    let std = fit.standard_uncertainties();
    found.set_item("std", std.map(|s| column(py, s.iter().copied().collect())))?;
    found.set_item("contacts_mm", vectors(py, fit.contacts.iter().map(|c| &c.point_mm.coords)))?;
    found.set_item("residuals_mm", column(py, fit.residuals_mm))?;
    found.set_item("degrees_of_freedom", fit.degrees_of_freedom)?;
    found.set_item("variance_factor", fit.variance_factor)?;
    let weak = |motion: &pose_icp::WeakMotion| {
        let words: Vec<_> = motion.components.iter().map(|c| c.parameter.words()).collect();
        words.join(" against ")
    };
    found.set_item("weak", fit.weak_directions.iter().map(weak).collect::<Vec<_>>())?;
    found.set_item("iterations", fit.iterations)?;
    Ok(found)
}

fn parameter(found: &str) -> Result<PoseParameter, Refusal> {
    let named = PoseParameter::ALL.into_iter().find(|p| p.name() == found);
    named.ok_or_else(|| Refusal::word("hold", found, &PoseParameter::ALL.map(PoseParameter::name)))
}

fn homogeneous<'py>(py: Python<'py>, pose: &Isometry3<f64>) -> Bound<'py, PyArray2<f64>> {
    small(py, &pose.to_homogeneous())
}

/// Positions, and normals where they are known.
type Cloud<'py> = (Table<'py>, Option<Table<'py>>);

/// Moves one cloud onto another.
#[pyfunction]
#[pyo3(signature = (source, target, objective, start, hold, loss, keep_share, max_distance_mm, tolerance_mm, max_iterations))]
pub(crate) fn register<'py>(
    py: Python<'py>,
    source: Cloud<'py>,
    target: Cloud<'py>,
    objective: &str,
    start: Option<Table<'py>>,
    hold: [bool; 6],
    loss: Option<&str>,
    keep_share: f64,
    max_distance_mm: Option<f64>,
    tolerance_mm: f64,
    max_iterations: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (source, target) = (cloud("source", &source)?, cloud("target", &target)?);
    let options = RegisterOptions {
        objective: match objective {
            "point-to-plane" => Objective::PointToPlane,
            "point-to-point" => Objective::PointToPoint,
            "symmetric" => Objective::Symmetric,
            found => {
                let known = ["point-to-plane", "point-to-point", "symmetric"];
                return Err(Refusal::word("method", found, &known).into());
            }
        },
        start: start.as_ref().map_or(Ok(Isometry3::identity()), isometry)?,
        freedoms: hold.map(|held| if held { Freedom::Held } else { Freedom::Free }),
        loss: loss.map(named_loss).transpose()?,
        keep_share,
        max_distance_mm,
        tolerance_mm,
        max_iterations,
        ..RegisterOptions::default()
    };
    let registered =
        py.detach(|| register_to_cloud(&source, &CloudTarget::new(&target)?, &options));
    let registered = registered.map_err(Refusal::from)?;
    let found = PyDict::new(py);
    found.set_item("matrix", homogeneous(py, &registered.target_from_source))?;
    found.set_item("covariance", small(py, &registered.covariance))?;
    found.set_item("pivot_mm", column(py, registered.pivot_mm.iter().copied().collect()))?;
    found.set_item("std_mm", registered.sigma_mm)?;
    found.set_item("rms_mm", registered.rms_mm)?;
    found.set_item("used", registered.used)?;
    found.set_item("iterations", registered.iterations)?;
    let weak = registered.observability.iter().flat_map(|o| &o.weak);
    found.set_item("weak", weak.map(ToString::to_string).collect::<Vec<_>>())?;
    Ok(found)
}

fn cloud(name: &str, (points, normals): &Cloud<'_>) -> Result<PointCloud, Refusal> {
    let points_mm: Vec<_> = rows::<3>(name, points)?.iter().map(|p| Point3::from(*p)).collect();
    let Some(normals) = normals else { return Ok(PointCloud::new(points_mm)) };
    let normals = rows_of::<3>(&format!("normals of the {name}"), normals, points_mm.len())?;
    let normals = normals.iter().map(|n| Unit::new_unchecked((*n).into())).collect();
    Ok(PointCloud::with_normals(points_mm, normals))
}

/// Rounding of a matrix that was written with single precision.
const ORTHOGONAL_TOL: f64 = 1e-6;

fn isometry(start: &Table<'_>) -> Result<Isometry3<f64>, Refusal> {
    let matrix = Matrix4::from_row_slice(rows_of::<4>("start", start, 4)?.as_flattened());
    let rotation = matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let off = (rotation.transpose() * rotation - nalgebra::Matrix3::identity()).amax();
    let is_pose = off <= ORTHOGONAL_TOL && rotation.determinant() > 0.0;
    let last: DMatrix<f64> = DMatrix::from_row_slice(1, 4, &[0.0, 0.0, 0.0, 1.0]);
    if !is_pose || matrix.row(3) != last {
        let words = "start must be a rotation and a shift, a 4 × 4 matrix with 0 0 0 1 below";
        return Err(Refusal::of(words.to_owned()));
    }
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let shift = Translation3::new(matrix[(0, 3)], matrix[(1, 3)], matrix[(2, 3)]);
    Ok(Isometry3::from_parts(shift, rotation))
}

/// Unit normals of a cloud from the planes through neighbours.
#[pyfunction]
#[pyo3(signature = (points_mm, neighbours, viewpoint_mm))]
pub(crate) fn estimate_normals<'py>(
    py: Python<'py>,
    points_mm: Table<'py>,
    neighbours: usize,
    viewpoint_mm: Option<[f64; 3]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points_mm: Vec<_> =
        rows::<3>("points_mm", &points_mm)?.iter().map(|p| Point3::from(*p)).collect();
    let viewpoint_mm = viewpoint_mm.map(Point3::from);
    let normals = py
        .detach(|| pose_icp::estimate_normals(&points_mm, neighbours, viewpoint_mm, Side::Source))
        .map_err(Refusal::from)?;
    Ok(vectors(py, normals.iter().map(Unit::as_ref)))
}
