//! Centre of the orbit that a rotating, wobbling head describes during one press.

use std::f64::consts::TAU;

use geometry::Wrench;
use nalgebra::{Complex, Matrix2, Point2, Point3, Vector2, Vector3};

use crate::colour::mean_covariance;
use crate::error::require_positive;
use crate::gate::{InContact, gate};
use crate::harmonic::{self, Basis, HarmonicFit};
use crate::pressure::pressure_point;
use crate::spectrum::Spectrum;
use crate::{Contact, FtCenterError, Sample};

/// Fewest samples whatever the options say: four cosines tell the noise of their mean.
const MIN_SAMPLES: usize = 5;

/// Fewest samples in which a spin is searched for.
const MIN_SAMPLES_SPIN: usize = 32;

/// Fewest samples that afford a second harmonic.
const MIN_SAMPLES_SECOND: usize = 20;

/// Residual over moment that is no more than round-off.
const ROUND_OFF: f64 = 1e-14;

/// Chance of noise alone that a spin found by search must stay under; a false one costs two
/// degrees of freedom and no bias.
const SPIN_ALPHA: f64 = 1e-3;

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
    /// Root mean square of `Fz` in contact.
    pub rms_fz_n: f64,
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
    let gated = gate(record, contact, options.min_samples.max(MIN_SAMPLES))?;
    let samples = &gated.samples;
    let spin = spin(samples, options)?;
    let (basis, fitted) = spin.fitted;
    let n = crate::count(samples.len());

    let rate_hz = |h: usize| crate::count(h) * basis.frequency_hz;
    let span_s = [samples[0].time_s, samples[samples.len() - 1].time_s];
    let lines: Vec<_> =
        (1..=basis.harmonics).map(|h| rate_hz(h) * (span_s[1] - span_s[0])).collect();
    let shares = fitted.influence.iter().zip(&fitted.residuals_nmm);
    let errors: Vec<_> = shares.map(|(a, u)| Vector2::from(*u) * (a * n)).collect();
    let mean = mean_covariance(&errors, &lines);

    let square_n2 = samples.iter().map(|s| s.fz_n * s.fz_n).sum::<f64>() / n;
    let free = (samples.len() - basis.columns()).max(1);
    let scatter_mm2 = fitted.residual_moments() / (crate::count(free) * square_n2);
    let center_mm = Point2::from(fitted.center_mm());
    let (mean_wrench, free_moment_nmm) =
        mean_wrench(record, samples, &fitted.influence, contact.z0_mm, &center_mm);
    let orbit = Orbit {
        center_mm,
        covariance_mm2: mean.covariance,
        degrees_of_freedom: mean.degrees_of_freedom,
        effective_samples: effective_samples(&scatter_mm2, &mean.covariance, n),
        wobble: spin.p_value.map(|p| wobble(samples, basis, &fitted, options, p)),
        mean_wrench,
        free_moment_nmm,
        scatter_mm2,
        contact_samples: samples.len(),
        gated_samples: record.len() - samples.len(),
        rms_fz_n: square_n2.sqrt(),
        min_fz_n: gated.min_fz_n,
        span_s,
    };
    if is_finite(&orbit) { Ok(orbit) } else { Err(FtCenterError::OutOfRange) }
}

fn is_finite(orbit: &Orbit) -> bool {
    let matrices = orbit.covariance_mm2.iter().chain(orbit.scatter_mm2.iter());
    let wrench = orbit.mean_wrench.to_vector();
    let loads = [orbit.free_moment_nmm, orbit.rms_fz_n];
    let mut numbers = orbit.center_mm.iter().chain(matrices).chain(wrench.iter()).chain(&loads);
    numbers.all(|v| v.is_finite())
}

/// The harmonic fit, and how sure the spin is; `None` without spin.
struct Spin {
    fitted: (Basis, HarmonicFit),
    p_value: Option<f64>,
}

fn spin(samples: &[InContact], options: &OrbitOptions) -> Result<Spin, FtCenterError> {
    let constant = harmonic::fit(samples, Basis::CONSTANT).ok_or(FtCenterError::OutOfRange)?;
    if let Some(frequency_hz) = options.spin_hz {
        return given_spin(samples, frequency_hz, &constant);
    }
    let left = constant.residual_moments().trace();
    let size: f64 = samples.iter().flat_map(|s| s.moment_nmm).map(|m| m * m).sum();
    let still = Spin { fitted: (Basis::CONSTANT, constant), p_value: None };
    if samples.len() < MIN_SAMPLES_SPIN || left <= ROUND_OFF.powi(2) * size {
        return Ok(still);
    }
    let before = spectrum(samples, &still.fitted.1);
    let found = before.candidates_hz().into_iter().filter_map(|frequency_hz| {
        let fitted = harmonic::refine(samples, basis(samples, frequency_hz))?;
        // The noise is that of what the fit leaves: a strong line leaks over all of its own.
        let after = spectrum(samples, &fitted.1);
        let p_value = after.p_value(frequency_hz, before.power(frequency_hz)) * before.trials();
        (p_value < SPIN_ALPHA).then_some(Spin { fitted, p_value: Some(p_value) })
    });
    let clearest = found.min_by(|a, b| left_over(a).total_cmp(&left_over(b)));
    Ok(clearest.unwrap_or(still))
}

fn left_over(spin: &Spin) -> f64 {
    spin.fitted.1.residual_moments().trace()
}

fn given_spin(
    samples: &[InContact],
    frequency_hz: f64,
    constant: &HarmonicFit,
) -> Result<Spin, FtCenterError> {
    require_positive(frequency_hz, "spin_hz")?;
    let turns = frequency_hz * length_s(samples);
    if turns < 1.0 {
        return Err(FtCenterError::TooFewTurns { turns });
    }
    let basis = basis(samples, frequency_hz);
    let fitted = harmonic::fit(samples, basis).ok_or(FtCenterError::TooFewTurns { turns })?;
    let power = spectrum(samples, constant).power(frequency_hz);
    let p_value = spectrum(samples, &fitted).p_value(frequency_hz, power);
    Ok(Spin { fitted: (basis, fitted), p_value: Some(p_value) })
}

/// One harmonic, and a second one where the samples resolve and afford it.
fn basis(samples: &[InContact], frequency_hz: f64) -> Basis {
    let resolved = 2.0 * frequency_hz * length_s(samples) < 0.5 * crate::count(samples.len());
    let harmonics = if resolved && samples.len() >= MIN_SAMPLES_SECOND { 2 } else { 1 };
    Basis { frequency_hz, harmonics }
}

fn length_s(samples: &[InContact]) -> f64 {
    samples[samples.len() - 1].time_s - samples[0].time_s
}

fn spectrum(samples: &[InContact], fitted: &HarmonicFit) -> Spectrum {
    let times: Vec<_> = samples.iter().map(|s| s.time_s).collect();
    Spectrum::of(&times, &fitted.residuals_nmm)
}

fn effective_samples(scatter: &Matrix2<f64>, mean: &Matrix2<f64>, samples: f64) -> f64 {
    if mean.trace() > 0.0 { scatter.trace() / mean.trace() } else { samples }
}

fn wobble(
    samples: &[InContact],
    basis: Basis,
    fitted: &HarmonicFit,
    options: &OrbitOptions,
    p_value: f64,
) -> Wobble {
    let c = |row: usize| Complex::new(fitted.coefficients[(row, 0)], fitted.coefficients[(row, 1)]);
    // a cos + b sin = A₊ e^(iωt) + A₋ e^(−iωt)
    let i = Complex::new(0.0, 1.0);
    let forward = ((c(1) - i * c(2)) / 2.0).norm();
    let backward = ((c(1) + i * c(2)) / 2.0).norm();
    let radius_mm = forward.hypot(backward);
    let n = crate::count(samples.len());
    let noise = spectrum(samples, fitted).noise_power(basis.frequency_hz);
    // Too few neighbours: as for white noise.
    let power = noise.unwrap_or_else(|| fitted.residual_moments().trace());
    let square_n2 = samples.iter().map(|s| s.fz_n * s.fz_n).sum::<f64>() / n;
    // Variance of each complex amplitude; half of it is along the amplitude.
    let amplitude_mm2 = power / (n * n * square_n2);
    // Rife and Boorstyn 1974: var(ω) = 6 var(A) / (A² T²).
    let spin_std_hz = (6.0 * amplitude_mm2).sqrt() / (TAU * radius_mm * length_s(samples));
    Wobble {
        spin_hz: if forward >= backward { basis.frequency_hz } else { -basis.frequency_hz },
        spin_std_hz: if options.spin_hz.is_some() { 0.0 } else { spin_std_hz },
        radius_mm,
        radius_std_mm: (0.5 * amplitude_mm2).sqrt(),
        semi_axes_mm: [forward + backward, (forward - backward).abs()],
        p_value,
    }
}

/// The mean wrench, weighted as the fit weighs each sample in the centre, its moment moved so
/// that it acts there.
///
/// With these weights the mean reacts to an error of the sensor as the centre does: the centre
/// moves by `b Σaᵢ` under a moment bias `b`, and the mean load is `1/Σaᵢ`.
fn mean_wrench(
    record: &[Sample],
    samples: &[InContact],
    influence: &[f64],
    z0_mm: f64,
    center_mm: &Point2<f64>,
) -> (Wrench, f64) {
    let (mut force, mut free, mut total) = (Vector3::zeros(), 0.0, 0.0);
    for (s, share) in samples.iter().zip(influence) {
        let wrench = &record[s.index].wrench;
        force += wrench.force_n * *share;
        free += pressure_point(wrench, z0_mm).free_moment_nmm * share;
        total += share;
    }
    let (force_n, free_moment_nmm) = (force / total, free / total);
    let at = Point3::new(center_mm.x, center_mm.y, z0_mm);
    let mut mean = Wrench::of_force(force_n, &at);
    mean.torque_nmm.z += free_moment_nmm;
    (mean, free_moment_nmm)
}
