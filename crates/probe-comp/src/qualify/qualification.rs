use least_squares::{Options, SolveError, solve};
use nalgebra::{DMatrix, DVector, Point3, Unit, Vector3};

use super::problem::{Calibration, FIRST, PLACE, RADIUS, shifts};
use super::reference::{ProbeTerms, Reference};
use crate::{BallTouch, Nominal, ProbeError};

/// A qualified probe: what it adds to a reading, by direction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Qualification {
    /// Where the artefact stood; along the axis of a ring, the mean of the touches.
    pub place_mm: Point3<f64>,
    /// Radius of the ball less the travel until the trigger: the two are one to a touch along the
    /// normal.
    pub effective_radius_mm: f64,
    /// One per harmonic that was asked for.
    pub lobes: Vec<Lobe>,
    /// How far the stylus gives way at right angles to it.
    pub bending_mm: f64,
    /// Covariance of place, effective radius, lobes (cos, sin) and bending; scaled by the variance
    /// factor.
    pub covariance_mm2: DMatrix<f64>,
    /// Residual of each touch.
    pub residuals_mm: Vec<f64>,
    /// Touches minus parameters.
    pub degrees_of_freedom: usize,
    /// `Σ (residual/σ)²` over degrees of freedom; `None` without redundancy.
    pub variance_factor: Option<f64>,
    terms: ProbeTerms,
}

/// Travel until the trigger by azimuth: `(cos) cos nφ + (sin) sin nφ`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Lobe {
    /// Lobes around the stylus, n.
    pub order: u32,
    /// Amplitude of the cosine, for an approach at right angles to the stylus.
    pub cos_mm: f64,
    /// Amplitude of the sine.
    pub sin_mm: f64,
}

/// Qualifies a probe on a calibrated artefact.
///
/// Minimises `Σ ((|Oᵢ − Σ qₖ tₖ(aᵢ) − C| − (R ± ρ))/σᵢ)²` over the place C, the effective radius ρ and
/// the amplitudes q. Where a touch does not say how it was approached, the normal of the artefact is
/// taken.
///
/// # Errors
///
/// [`ProbeError::InvalidOption`] for a radius or a lobe that cannot be,
/// [`ProbeError::InvalidTouch`], [`ProbeError::NotQualified`] with the parameters that the touches
/// leave free.
pub fn qualify(
    touches: &[BallTouch],
    reference: &Reference,
    terms: &ProbeTerms,
) -> Result<Qualification, ProbeError> {
    check(reference, terms)?;
    for (index, touch) in touches.iter().enumerate() {
        crate::compensate::check(index, touch)?;
    }
    let start = start(touches, reference)?;
    let place = Point3::new(start[0], start[1], start[2]);
    let inward = |touch: &BallTouch| {
        let arm = reference.across(touch.center_mm - place) * -reference.side();
        touch.approach.unwrap_or_else(|| Unit::new_normalize(arm))
    };
    let approaches = touches.iter().map(inward).collect();
    let reference = *reference;
    let problem = Calibration { touches, approaches, reference, terms };
    // Along its axis a ring shows nothing: the direction is held, not guessed.
    let held = match reference {
        Reference::Sphere { .. } => Vec::new(),
        Reference::Ring { axis, .. } => vec![axis.iamax()],
    };
    let mut from = DVector::zeros(problem.n_parameters());
    from.rows_mut(0, FIRST).copy_from(&start);
    let solved = solve(&problem, from, &Options { held, ..Options::default() }).map_err(refused)?;
    let at = &solved.point;
    let scale = solved.variance_factor.unwrap_or(1.0);
    let residuals_mm =
        solved.residuals.iter().zip(touches).map(|(r, touch)| r * touch.sigma_mm).collect();
    let lobes = (terms.lobes.iter().enumerate())
        .map(|(k, &order)| Lobe { order, cos_mm: at[FIRST + 2 * k], sin_mm: at[FIRST + 2 * k + 1] })
        .collect();
    Ok(Qualification {
        place_mm: Point3::new(at[0], at[1], at[2]),
        effective_radius_mm: at[RADIUS],
        lobes,
        bending_mm: if terms.bending { at[at.len() - 1] } else { 0.0 },
        covariance_mm2: &solved.covariance * scale,
        residuals_mm,
        degrees_of_freedom: solved.degrees_of_freedom,
        variance_factor: solved.variance_factor,
        terms: terms.clone(),
    })
}

/// What a qualification leaves uncertain of the probe.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeUncertainty {
    /// What was asked of the probe beside its radius.
    pub terms: ProbeTerms,
    /// Covariance of effective radius, lobes (cos, sin) and bending.
    pub covariance_mm2: DMatrix<f64>,
}

impl Qualification {
    /// Its own uncertainty, for a model of touches that were corrected with it.
    ///
    /// `scale` is the variance of the artefact's touches over the square of their `sigma_mm`; one where
    /// these only weigh the touches, of the artefact and of the part alike.
    #[must_use]
    pub fn uncertainty(&self, scale: f64) -> ProbeUncertainty {
        let of_probe = self.covariance_mm2.nrows() - PLACE;
        let covariance = self.covariance_mm2.view((RADIUS, RADIUS), (of_probe, of_probe));
        let covariance_mm2 = covariance * (scale / self.variance_factor.unwrap_or(1.0));
        ProbeUncertainty { terms: self.terms.clone(), covariance_mm2 }
    }

    /// Travel until the trigger, where the ball's radius is known by itself.
    #[must_use]
    pub fn pretravel_mm(&self, ball_radius_mm: f64) -> f64 {
        ball_radius_mm - self.effective_radius_mm
    }

    /// What the probe adds to a reading that is taken along `approach`, beside its effective radius.
    #[must_use]
    pub fn shift_mm(&self, approach: &Unit<Vector3<f64>>, spindle_rad: f64) -> Vector3<f64> {
        let mut amplitudes: Vec<f64> =
            self.lobes.iter().flat_map(|lobe| [lobe.cos_mm, lobe.sin_mm]).collect();
        amplitudes.push(self.bending_mm);
        let shifts = shifts(&self.terms, approach, spindle_rad);
        shifts.iter().zip(amplitudes).fold(Vector3::zeros(), |sum, (shift, q)| sum + shift * q)
    }

    /// Touches of a part without what the probe added; compensate them with
    /// [`Qualification::effective_radius_mm`].
    ///
    /// # Errors
    ///
    /// [`ProbeError::NoFoot`] where a touch without approach has no nominal normal either.
    pub fn applied(
        &self,
        nominal: &Nominal,
        touches: &[BallTouch],
    ) -> Result<Vec<BallTouch>, ProbeError> {
        let corrected = |(index, touch): (usize, &BallTouch)| {
            let approach = if let Some(approach) = touch.approach {
                approach
            } else {
                let foot = nominal.foot(&touch.center_mm);
                -foot.map_err(|source| ProbeError::NoFoot { index, source })?.normal
            };
            let shift = self.shift_mm(&approach, touch.spindle_rad);
            let micro_mm = touch.micro_mm.iter().map(|p| p - shift).collect();
            Ok(BallTouch { center_mm: touch.center_mm - shift, micro_mm, ..touch.clone() })
        };
        touches.iter().enumerate().map(corrected).collect()
    }
}

fn check(reference: &Reference, terms: &ProbeTerms) -> Result<(), ProbeError> {
    let value = reference.radius_mm();
    if !(value > 0.0 && value.is_finite()) {
        let (name, needed) = ("radius_mm", "positive and finite");
        return Err(ProbeError::InvalidOption { name, needed, value });
    }
    let mut orders = terms.lobes.clone();
    orders.sort_unstable();
    let distinct = orders.windows(2).all(|pair| pair[0] < pair[1]);
    match orders.first() {
        Some(&order) if order < 2 || !distinct => {
            let needed = "2 or more, each once: the first harmonic is the artefact's place";
            let value = f64::from(order);
            Err(ProbeError::InvalidOption { name: "lobes", needed, value })
        }
        _ => Ok(()),
    }
}

/// Place and effective radius by linear least squares: `|O|² = 2 C·O + const`.
fn start(touches: &[BallTouch], reference: &Reference) -> Result<DVector<f64>, ProbeError> {
    if touches.is_empty() {
        return Err(ProbeError::NotQualified { free: Vec::new() });
    }
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = touches.len() as f64;
    let sum =
        touches.iter().fold(Vector3::zeros(), |sum: Vector3<f64>, t| sum + t.center_mm.coords);
    let mean = sum / n;
    let arms: Vec<Vector3<f64>> =
        touches.iter().map(|t| reference.across(t.center_mm.coords - mean)).collect();
    let design =
        DMatrix::from_fn(
            arms.len(),
            PLACE + 1,
            |i, k| {
                if k < PLACE { 2.0 * arms[i][k] } else { 1.0 }
            },
        );
    let squares = DVector::from_iterator(arms.len(), arms.iter().map(Vector3::norm_squared));
    // The direction along a ring's axis is a column of zeros: it stays at the mean.
    let solved = design.svd(true, true).solve(&squares, SMALL).ok();
    let solved = solved.ok_or(ProbeError::NotQualified { free: Vec::new() })?;
    let offset = Vector3::new(solved[0], solved[1], solved[2]);
    let distance = (solved[PLACE] + offset.norm_squared()).max(0.0).sqrt();
    let radius = (distance - reference.radius_mm()) * reference.side();
    let place = mean + offset;
    Ok(DVector::from_vec(vec![place.x, place.y, place.z, radius]))
}

/// Singular values below this, in mm², are those of a direction that the artefact does not show.
const SMALL: f64 = 1e-9;

fn refused(error: SolveError<DVector<f64>>) -> ProbeError {
    let mut free: Vec<String> = Vec::new();
    if let SolveError::Unobservable { directions, .. } = error {
        // A parameter may be in several free directions.
        for (name, _) in directions.into_iter().flat_map(|d| d.components) {
            if !free.contains(&name) {
                free.push(name);
            }
        }
    }
    ProbeError::NotQualified { free }
}
