use nalgebra::{Matrix1x6, Point3};

use super::chart::Chart;
use crate::{Part, PoseError, PoseFit, PoseStart, Tip};

/// Height at which the ball meets the surface above a point of the machine's xy plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// Machine z of the ball's centre.
    pub z_mm: f64,
    /// Its standard uncertainty from that of the pose; `None` where the noise is not known.
    pub sigma_mm: Option<f64>,
}

/// Newton steps; each squares the error, and the start is on the part.
const MAX_STEPS: usize = 50;
/// Steps below this are round-off.
const LAST_STEP_MM: f64 = 1e-11;

/// Predicts where the probe meets the part, moving along the machine's z axis.
///
/// `from_z_mm` is where the search starts; the surface must be met once near it.
///
/// # Errors
///
/// [`PoseError::NoFoot`] where the axis misses the part, [`PoseError::NotConverged`].
pub fn height_at(
    part: &Part,
    fit: &PoseFit,
    tip: Tip,
    x_mm: f64,
    y_mm: f64,
    from_z_mm: f64,
) -> Result<Height, PoseError> {
    let chart = Chart::new(&fit.pose, 0.0);
    let (z_mm, row, slope) = meet(part, &fit.pose, tip, [x_mm, y_mm, from_z_mm])?;
    debug_assert!(chart.pivot_mm == 0.0, "the covariance is that of the origin");
    // Along the line of the probe the distance stays that of the tip: dz = −(∂d/∂pose) / (∂d/∂z).
    let row = Matrix1x6::from_row_slice(&row) / slope;
    let variance = (row * fit.covariance * row.transpose())[(0, 0)].max(0.0);
    let sigma_mm = fit.covariance_scale().map(|s| (s * variance).sqrt());
    Ok(Height { z_mm, sigma_mm })
}

/// Height, derivative of the distance by the pose and by the height.
pub(crate) fn meet(
    part: &Part,
    pose: &PoseStart,
    tip: Tip,
    from_mm: [f64; 3],
) -> Result<(f64, [f64; 6], f64), PoseError> {
    let chart = Chart::new(pose, 0.0);
    let mut center_mm = Point3::from(from_mm);
    let mut left_mm = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let foot = part
            .surface()
            .closest_point(&chart.in_workpiece(&center_mm))
            .map_err(|source| PoseError::NoFoot { index: 0, source })?;
        let normal = chart.direction_to_machine(&foot.normal);
        left_mm = foot.signed_distance_mm - tip.signed_radius_mm();
        let step_mm = -left_mm / normal.z;
        center_mm.z += step_mm;
        if step_mm.abs() < LAST_STEP_MM {
            return Ok((center_mm.z, chart.distance_row(&center_mm, &normal), normal.z));
        }
        if !center_mm.z.is_finite() {
            break;
        }
    }
    Err(PoseError::NotConverged { iterations: MAX_STEPS, rms_mm: left_mm.abs() })
}
