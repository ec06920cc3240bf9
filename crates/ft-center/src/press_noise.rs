//! Covariance of every orbit centre, pooled over the presses.

use nalgebra::{Matrix2, Vector2};

use crate::error::require_positive;
use crate::{FtCenterError, Noise, SolvedPress};

/// Standard uncertainty under which no centre is believed, so that records without any noise
/// still have weights: a picometre.
const FLOOR_MM: f64 = 1e-9;

/// Covariances of centres, and the degrees of freedom they are known to.
#[derive(Clone, Debug)]
pub(crate) struct CenterNoise {
    /// Sensor frame, one per press.
    pub(crate) covariances_mm2: Vec<Matrix2<f64>>,
    pub(crate) degrees_of_freedom: f64,
}

impl CenterNoise {
    /// Pools the noise of all records, or spreads the declared noise over them.
    ///
    /// A record's own covariance rests on a few cosines; as moment noise, `C n ⟨Fz²⟩`, it is the
    /// same for all presses of one sensor and head, and is averaged over them. Declared noise
    /// is of one reading, and is widened by how much more than white the records vary slowly.
    pub(crate) fn of(
        presses: &[SolvedPress],
        z0_mm: f64,
        noise: Option<Noise>,
    ) -> Result<Self, FtCenterError> {
        let degrees_of_freedom = presses.iter().map(|p| p.orbit.degrees_of_freedom).sum();
        let (mut slow, mut all) = (Matrix2::zeros(), Matrix2::zeros());
        for p in presses {
            let share = p.orbit.degrees_of_freedom / degrees_of_freedom;
            let square_n2 = p.orbit.rms_fz_n.powi(2);
            let samples = crate::count(p.orbit.contact_samples);
            slow += share * samples * square_n2 * p.orbit.covariance_mm2;
            all += share * square_n2 * p.orbit.scatter_mm2;
        }
        let colour: f64 = if all.trace() > 0.0 { slow.trace() / all.trace() } else { 1.0 };
        if let Some(noise) = noise {
            require_positive(noise.force_n, "force_n")?;
            require_positive(noise.moment_nmm, "moment_nmm")?;
        }
        let floor = Matrix2::identity() * FLOOR_MM.powi(2);
        let one = |p: &SolvedPress| {
            let one_sample = match noise {
                Some(noise) => reading_noise(p, z0_mm, noise) * colour.max(1.0),
                None => slow,
            };
            let samples = crate::count(p.orbit.contact_samples);
            one_sample / (samples * p.orbit.rms_fz_n.powi(2)) + floor
        };
        Ok(Self { covariances_mm2: presses.iter().map(one).collect(), degrees_of_freedom })
    }
}

/// Covariance of `m − Fz·p` of one reading, N²mm²: (1.11) in its linear form.
fn reading_noise(press: &SolvedPress, z0_mm: f64, noise: Noise) -> Matrix2<f64> {
    let p: Vector2<f64> = press.orbit.center_mm.coords;
    let lateral_and_moment = (z0_mm * noise.force_n).powi(2) + noise.moment_nmm.powi(2);
    Matrix2::identity() * lateral_and_moment + p * p.transpose() * noise.force_n.powi(2)
}
