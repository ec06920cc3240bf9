//! Zero, weight and centre of gravity of a tool that hangs free from the sensor.

use geometry::Wrench;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, SMatrix, Unit, UnitQuaternion, Vector3};

use crate::error::require_positive;
use crate::{FtCenterError, Noise, Table};

/// Smallest over largest singular value of a scaled design under which a direction is free.
const RANK_TOLERANCE: f64 = 1e-6;

/// Weight over the largest force read, under which there is no weight to locate.
const MIN_WEIGHT_RATIO: f64 = 1e-9;

/// One static pose with nothing touched.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StaticPose {
    /// Name of the pose.
    pub name: String,
    /// Orientation of the sensor: maps sensor to base coordinates.
    pub base_from_sensor: UnitQuaternion<f64>,
    /// Wrench read, sensor frame, about the sensor's reference point.
    pub wrench: Wrench,
}

/// What is known before the poses are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GravityOptions {
    /// Direction of gravity in the base. Default −z.
    pub gravity: Unit<Vector3<f64>>,
    /// Noise of one reading. Default `None`: estimated from the residual.
    pub noise: Option<Noise>,
}

impl Default for GravityOptions {
    fn default() -> Self {
        Self { gravity: -Vector3::z_axis(), noise: None }
    }
}

/// Zero of the sensor and weight of the tool.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GravityCalibration {
    /// What the sensor reads under no load.
    pub bias: Wrench,
    /// Weight of the tool beyond the sensor; negative where the sensor reads the reaction.
    pub weight_n: f64,
    /// Centre of gravity of the tool, sensor frame.
    pub center_of_gravity_mm: Point3<f64>,
    /// Covariance of `[bias force, bias moment, weight, centre of gravity]`; a priori where noise
    /// was given, else a posteriori.
    pub covariance: SMatrix<f64, 10, 10>,
    /// Reading − prediction, in input order.
    pub residuals: Vec<Wrench>,
    /// Distance by which the line of action of the weight, zero taken off, misses the centre of
    /// gravity, in input order.
    pub line_miss_mm: Vec<f64>,
    /// Noise of one reading, given or estimated from the residual.
    pub noise: Noise,
    /// `6 n − 10`.
    pub degrees_of_freedom: usize,
}

/// Calibrates zero, weight and centre of gravity from static poses.
///
/// Reading = zero + `W·g` with moment `r × W·g`, `g` the direction of gravity in sensor axes.
/// Forces give zero and weight, moments give zero and `W·r`; both are linear.
///
/// # Errors
///
/// [`FtCenterError::Empty`], [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`] and
/// [`FtCenterError::PosesNotEnough`], which names what the poses leave free.
pub fn calibrate_gravity(
    poses: &[StaticPose],
    options: &GravityOptions,
) -> Result<GravityCalibration, FtCenterError> {
    check(poses, options)?;
    let down: Vec<_> =
        poses.iter().map(|p| p.base_from_sensor.inverse() * options.gravity.into_inner()).collect();
    let force = |i: usize| poses[i].wrench.force_n;
    let moment = |i: usize| poses[i].wrench.torque_nmm;
    let by_weight = |i: usize| DMatrix::from_column_slice(3, 1, down[i].as_slice());
    let by_moment = |i: usize| {
        let cross = -down[i].cross_matrix();
        DMatrix::from_column_slice(3, 3, cross.as_slice())
    };
    let forces = linear(poses.len(), 1, force, by_weight, "the weight")?;
    let moments = linear(poses.len(), 3, moment, by_moment, "the centre of gravity")?;
    let weight_n = forces.solution[3];
    let largest_n = poses.iter().map(|p| p.wrench.force_n.norm()).fold(0.0, f64::max);
    if weight_n.abs() <= MIN_WEIGHT_RATIO * largest_n {
        return Err(FtCenterError::NoWeight { weight_n });
    }
    let bias = Wrench {
        force_n: forces.solution.fixed_rows::<3>(0).into_owned(),
        torque_nmm: moments.solution.fixed_rows::<3>(0).into_owned(),
    };
    let arm: Vector3<f64> = moments.solution.fixed_rows::<3>(3) / weight_n;
    let center_of_gravity_mm = Point3::from(arm);
    let residuals: Vec<_> = (poses.iter().zip(&down))
        .map(|(p, g)| p.wrench - bias - Wrench::of_force(g * weight_n, &center_of_gravity_mm))
        .collect();
    let noise = options.noise.unwrap_or_else(|| scatter(&residuals));
    let line_miss_mm = poses.iter().map(|p| line_miss(p.wrench - bias, &arm)).collect();
    let covariance = covariance(&forces, &moments, noise);
    let finite = covariance.iter().chain(arm.iter()).all(|v| v.is_finite());
    if !finite {
        return Err(FtCenterError::OutOfRange);
    }
    Ok(GravityCalibration {
        bias,
        weight_n,
        center_of_gravity_mm,
        covariance,
        residuals,
        line_miss_mm,
        noise,
        degrees_of_freedom: 6 * poses.len() - 10,
    })
}

fn check(poses: &[StaticPose], options: &GravityOptions) -> Result<(), FtCenterError> {
    if poses.is_empty() {
        return Err(FtCenterError::Empty { of: Table::Poses });
    }
    let finite = |p: &StaticPose| {
        let readings = p.wrench.to_vector();
        readings.iter().chain(p.base_from_sensor.coords.iter()).all(|v| v.is_finite())
    };
    if let Some(index) = poses.iter().position(|p| !finite(p)) {
        return Err(FtCenterError::NotFinite { index });
    }
    if let Some(noise) = options.noise {
        require_positive(noise.force_n, "force_n")?;
        require_positive(noise.moment_nmm, "moment_nmm")?;
    }
    Ok(())
}

/// Solution of a linear fit, and its covariance for unit noise.
struct Linear {
    solution: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// Least squares of `observed = zero + block · unknowns`, three rows per pose.
fn linear(
    poses: usize,
    unknowns: usize,
    observed: impl Fn(usize) -> Vector3<f64>,
    block: impl Fn(usize) -> DMatrix<f64>,
    parameter: &'static str,
) -> Result<Linear, FtCenterError> {
    let mut design = DMatrix::zeros(3 * poses, 3 + unknowns);
    let mut right = DVector::zeros(3 * poses);
    for i in 0..poses {
        design.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&Matrix3::identity());
        design.view_mut((3 * i, 3), (3, unknowns)).copy_from(&block(i));
        right.fixed_rows_mut::<3>(3 * i).copy_from(&observed(i));
    }
    let not_enough =
        |largest, smallest| FtCenterError::PosesNotEnough { parameter, largest, smallest };
    if design.nrows() < design.ncols() {
        return Err(not_enough(1.0, 0.0));
    }
    // Directions are unit vectors: all columns are of the same size.
    let singular = design.singular_values();
    let (largest, smallest) = (singular.max(), singular.min());
    if smallest <= RANK_TOLERANCE * largest {
        return Err(not_enough(largest, smallest));
    }
    let unknowns = design.ncols();
    let qr = design.qr();
    let (projected, r) = (qr.q().transpose() * right, qr.r());
    let free = || not_enough(largest, smallest);
    let solution = r.solve_upper_triangular(&projected).ok_or_else(free)?;
    let inverse =
        r.solve_upper_triangular(&DMatrix::identity(unknowns, unknowns)).ok_or_else(free)?;
    Ok(Linear { solution, covariance: &inverse * inverse.transpose() })
}

/// Noise of one reading from the residual: 4 parameters in the forces, 6 in the moments.
fn scatter(residuals: &[Wrench]) -> Noise {
    let n = crate::count(3 * residuals.len());
    let forces: f64 = residuals.iter().map(|r| r.force_n.norm_squared()).sum();
    let moments: f64 = residuals.iter().map(|r| r.torque_nmm.norm_squared()).sum();
    Noise {
        force_n: (forces / (n - 4.0).max(1.0)).sqrt(),
        moment_nmm: (moments / (n - 6.0).max(1.0)).sqrt(),
    }
}

/// Distance between a point and the line of action of a wrench.
pub(crate) fn line_miss(wrench: Wrench, arm_mm: &Vector3<f64>) -> f64 {
    let f = wrench.force_n;
    let miss = arm_mm.cross(&f) - wrench.torque_nmm;
    let along = f * (miss.dot(&f) / f.norm_squared());
    (miss - along).norm() / f.norm()
}

/// From `[zero, weight]` of the forces and `[zero, W·r]` of the moments to
/// `[zero force, zero moment, weight, r]`.
fn covariance(forces: &Linear, moments: &Linear, noise: Noise) -> SMatrix<f64, 10, 10> {
    let weight_n = forces.solution[3];
    let mut split = SMatrix::<f64, 10, 10>::zeros();
    // Where the unknowns of the linear fits go.
    let (of_forces, of_moments) = ([0, 1, 2, 6], [3, 4, 5, 7, 8, 9]);
    for (i, &row) in of_forces.iter().enumerate() {
        for (j, &column) in of_forces.iter().enumerate() {
            split[(row, column)] = forces.covariance[(i, j)] * noise.force_n.powi(2);
        }
    }
    for (i, &row) in of_moments.iter().enumerate() {
        for (j, &column) in of_moments.iter().enumerate() {
            split[(row, column)] = moments.covariance[(i, j)] * noise.moment_nmm.powi(2);
        }
    }
    // r = u/W
    let mut jacobian = SMatrix::<f64, 10, 10>::identity();
    for k in 0..3 {
        jacobian[(7 + k, 7 + k)] = 1.0 / weight_n;
        jacobian[(7 + k, 6)] = -moments.solution[3 + k] / weight_n.powi(2);
    }
    jacobian * split * jacobian.transpose()
}
