//! Covariance of every orbit centre by the noise within its record, drawn towards the mean of all
//! presses.

use nalgebra::{Matrix2, Vector2};

use crate::error::require_positive;
use crate::{FtCenterError, Noise, SolvedPress};

/// Standard uncertainty under which no centre is believed, so that records without any noise
/// still have weights: a picometre.
const FLOOR_MM: f64 = 1e-9;

/// Degrees of freedom that the mean over all presses counts for beside a press's own.
const MEAN_DOF: f64 = 16.0;

/// Covariance of each centre in the sensor frame, from inside its record.
///
/// A record's own covariance rests on a few cosines; as moment noise, `C n ⟨Fz²⟩`, it is much
/// the same for all presses of one sensor and head, and is drawn towards their mean the more, the
/// less it is known itself. Declared noise is of one reading: it is spread over the records, and
/// widened by how much more than white they vary slowly.
///
/// How well the head seats from press to press is no part of it: no record shows that.
pub(crate) fn center_covariances(
    presses: &[SolvedPress],
    z0_mm: f64,
    noise: Option<Noise>,
) -> Result<Vec<Matrix2<f64>>, FtCenterError> {
    let pooled = Pooled::of(presses);
    if let Some(noise) = noise {
        require_positive(noise.force_n, "force_n")?;
        require_positive(noise.moment_nmm, "moment_nmm")?;
    }
    let floor = Matrix2::identity() * FLOOR_MM.powi(2);
    let one = |p: &SolvedPress| {
        let one_sample = if let Some(noise) = noise {
            reading_noise(p, z0_mm, noise) * pooled.colour()
        } else {
            let own = own_share(p);
            slow_noise(p) * own + pooled.slow * (1.0 - own)
        };
        let samples = crate::count(p.orbit.contact_samples);
        one_sample / (samples * p.orbit.rms_fz_n.powi(2)) + floor
    };
    Ok(presses.iter().map(one).collect())
}

/// Noise of one sample, of the press itself against the mean of all.
fn own_share(press: &SolvedPress) -> f64 {
    let dof = press.orbit.degrees_of_freedom;
    dof / (dof + MEAN_DOF)
}

/// What one sample's noise would have to be, were samples independent; N²mm².
fn slow_noise(press: &SolvedPress) -> Matrix2<f64> {
    let samples = crate::count(press.orbit.contact_samples);
    samples * press.orbit.rms_fz_n.powi(2) * press.orbit.covariance_mm2
}

/// Means over presses, weighted by degrees of freedom.
struct Pooled {
    slow: Matrix2<f64>,
    /// Noise of one sample as it is, slow or not.
    all: Matrix2<f64>,
}

impl Pooled {
    fn of(presses: &[SolvedPress]) -> Self {
        let degrees_of_freedom: f64 = presses.iter().map(|p| p.orbit.degrees_of_freedom).sum();
        let (mut slow, mut all) = (Matrix2::zeros(), Matrix2::zeros());
        for p in presses {
            let share = p.orbit.degrees_of_freedom / degrees_of_freedom;
            slow += share * slow_noise(p);
            all += share * p.orbit.rms_fz_n.powi(2) * p.orbit.scatter_mm2;
        }
        Self { slow, all }
    }

    /// How much larger the noise of a mean is than that of as many independent samples.
    fn colour(&self) -> f64 {
        let white = self.all.trace();
        if white > 0.0 { (self.slow.trace() / white).max(1.0) } else { 1.0 }
    }
}

/// Covariance of `m − Fz·p` of one reading, N²mm²: (1.11) in its linear form.
fn reading_noise(press: &SolvedPress, z0_mm: f64, noise: Noise) -> Matrix2<f64> {
    let p: Vector2<f64> = press.orbit.center_mm.coords;
    let lateral_and_moment = (z0_mm * noise.force_n).powi(2) + noise.moment_nmm.powi(2);
    Matrix2::identity() * lateral_and_moment + p * p.transpose() * noise.force_n.powi(2)
}
