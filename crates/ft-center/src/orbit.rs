//! Centre of the orbit that a rotating, wobbling head describes during one press.

use geometry::Wrench;
use nalgebra::{Matrix2, Point2};

use crate::{Contact, FtCenterError, Sample};

/// How a record is reduced to an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OrbitOptions {
    /// Fewest samples in contact. Default 8: fewer leave too little to estimate their own noise.
    pub min_samples: usize,
    /// Spin frequency where the machine knows it. Default `None`: searched for.
    pub spin_hz: Option<f64>,
}

impl Default for OrbitOptions {
    fn default() -> Self {
        Self { min_samples: 8, spin_hz: None }
    }
}

/// One press, reduced.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Orbit {
    /// Centre of the orbit in the contact plane, sensor frame.
    pub center_mm: Point2<f64>,
    /// Covariance of `center_mm` under coloured noise, estimated from the record alone.
    pub covariance_mm2: Matrix2<f64>,
    /// Degrees of freedom of `covariance_mm2`: intervals are Student's.
    pub degrees_of_freedom: f64,
    /// Independent samples that would give the same covariance.
    pub effective_samples: f64,
    /// The spin, where it rises above the noise.
    pub wobble: Option<Wobble>,
    /// One wrench that stands for the whole press: mean force, and the moment that puts it at
    /// `center_mm`, with the mean free moment about z.
    pub mean_wrench: Wrench,
    /// Mean moment about z that the force does not explain.
    pub free_moment_nmm: f64,
    /// Covariance of one sample about the orbit, referred to the mean load.
    pub scatter_mm2: Matrix2<f64>,
    /// Samples in contact.
    pub contact_samples: usize,
    /// Samples under the force gate.
    pub gated_samples: usize,
    /// Force gate that was applied.
    pub min_fz_n: f64,
    /// First and last time in contact.
    pub span_s: [f64; 2],
}

/// Circling of the centre of pressure with the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wobble {
    /// Spin frequency; positive turns x towards y, seen in the sensor frame.
    pub spin_hz: f64,
    /// Standard uncertainty of `spin_hz`; zero where it was given.
    pub spin_std_hz: f64,
    /// Root mean square distance of the first harmonic from the centre; the radius of a circle.
    pub radius_mm: f64,
    /// Standard uncertainty of `radius_mm`.
    pub radius_std_mm: f64,
    /// Semi-axes of the ellipse that the first harmonic describes, larger first.
    pub semi_axes_mm: [f64; 2],
    /// Chance that noise alone rises as high anywhere in the spectrum.
    pub p_value: f64,
}

/// Reduces the record of one press to the centre of its orbit.
///
/// # Errors
///
/// [`FtCenterError::NotFinite`], [`FtCenterError::TimeNotIncreasing`],
/// [`FtCenterError::TooFewContactSamples`], [`FtCenterError::MixedSign`] and
/// [`FtCenterError::NotPositive`] for a gate or spin that is not positive.
pub fn solve_orbit(
    record: &[Sample],
    contact: &Contact,
    options: &OrbitOptions,
) -> Result<Orbit, FtCenterError> {
    let _ = (record, contact, options);
    unimplemented!("lands with the next commit")
}
