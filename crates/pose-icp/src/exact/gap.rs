use nalgebra::{Matrix1x6, Point3, Vector3};

use super::chart::Chart;
use crate::{Part, PoseError, PoseFit, TipSide};

/// Distance between a point of a tool and the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Along the part's normal, positive on the tool's side.
    pub gap_mm: f64,
    /// Its standard uncertainty from that of the pose; `None` where the noise is not known.
    pub sigma_mm: Option<f64>,
    /// The part's normal there, machine frame.
    pub normal: Vector3<f64>,
    /// Whether the part is there; beside it the surface is continued.
    pub inside_aperture: bool,
}

/// How far a point of the machine is from the part as it was found to lie: of a polishing wheel's
/// lowest point the h of document \[D\], whose film of height H is pressed in by Δh = H − h.
///
/// # Errors
///
/// [`PoseError::NoFoot`] where no point of the part is closest.
pub fn gap_at(
    part: &Part,
    fit: &PoseFit,
    side: TipSide,
    point_mm: &Point3<f64>,
) -> Result<Gap, PoseError> {
    let chart = Chart::new(&fit.pose, 0.0);
    let foot = part
        .surface()
        .closest_point(&chart.in_workpiece(point_mm))
        .map_err(|source| PoseError::NoFoot { index: 0, source })?;
    let normal = chart.direction_to_machine(&foot.normal);
    let row = Matrix1x6::from_row_slice(&chart.distance_row(point_mm, &normal));
    let variance = (row * fit.covariance * row.transpose())[(0, 0)].max(0.0);
    let outward = match side {
        TipSide::Above => 1.0,
        TipSide::Below => -1.0,
    };
    Ok(Gap {
        gap_mm: outward * foot.signed_distance_mm,
        sigma_mm: fit.covariance_scale().map(|s| (s * variance).sqrt()),
        normal: normal * outward,
        inside_aperture: part.contains(&foot),
    })
}
