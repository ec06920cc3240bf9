use nalgebra::Vector3;

use crate::{Part, PoseError, PoseStart, Tip, Touch};

/// A pose to start from where nothing but the touches is known.
///
/// The touches are taken to lie around the centre of the part, which is taken to be level: the
/// part is shifted until their mean lies over the aperture's centre and their mean distance from
/// the surface is that of the tip.
///
/// # Errors
///
/// [`PoseError::TooFewTouches`] without touches; [`PoseError::NoFoot`] where the touches spread
/// beyond the part.
pub fn start_from_touches(
    part: &Part,
    touches: &[Touch],
    tip: Tip,
    gamma_rad: f64,
) -> Result<PoseStart, PoseError> {
    if touches.is_empty() {
        return Err(PoseError::TooFewTouches { got: 0, prior_rows: 0, parameters: 1 });
    }
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = touches.len() as f64;
    let mean = touches.iter().fold(Vector3::zeros(), |sum, t| sum + t.center_mm.coords) / n;
    let turned = PoseStart::level(Vector3::zeros(), gamma_rad);
    let rotation = turned.machine_from_workpiece().rotation;
    let center = part.shape().map_or(Vector3::zeros(), |s| {
        Vector3::new(s.aperture_center_mm.x, s.aperture_center_mm.y, 0.0)
    });
    let mut position_mm = mean - rotation * center;
    // The mean height is right to the sag of the part; two rounds level out what it bends.
    for _ in 0..ROUNDS {
        let pose = PoseStart { position_mm, ..turned }.machine_from_workpiece();
        let mut off_mm = 0.0;
        for (index, touch) in touches.iter().enumerate() {
            let foot = part
                .surface()
                .closest_point(&pose.inverse_transform_point(&touch.center_mm))
                .map_err(|source| PoseError::NoFoot { index, source })?;
            off_mm += (foot.signed_distance_mm - tip.signed_radius_mm()) / n;
        }
        position_mm.z += off_mm;
    }
    Ok(PoseStart { position_mm, ..turned })
}

/// Rounds of levelling; the second is left with the square of the slope.
const ROUNDS: usize = 3;
