use least_squares::Problem;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Unit, Vector3};

use super::reference::{ProbeTerms, Reference};
use crate::BallTouch;

/// Coordinates of the artefact's place.
pub(crate) const PLACE: usize = 3;
/// Index of the ball's effective radius.
pub(crate) const RADIUS: usize = PLACE;
/// Index of the first amplitude of the probe.
pub(crate) const FIRST: usize = RADIUS + 1;

/// Place and effective radius, then the amplitudes of the probe's terms.
///
/// With `a` the approach of a touch, `tₖ` its terms and `q` their amplitudes, the ball was at
/// `O − Σ qₖ tₖ(a)`, and that is `R ± ρ` from the artefact's place.
pub(crate) struct Calibration<'a> {
    pub(crate) touches: &'a [BallTouch],
    pub(crate) approaches: Vec<Unit<Vector3<f64>>>,
    pub(crate) reference: Reference,
    pub(crate) terms: &'a ProbeTerms,
}

impl Calibration<'_> {
    pub(crate) fn n_parameters(&self) -> usize {
        FIRST + n_amplitudes(self.terms)
    }

    /// The arm from the place to the corrected ball.
    fn arm(&self, index: usize, at: &DVector<f64>) -> Vector3<f64> {
        let place = Point3::new(at[0], at[1], at[2]);
        let shifts = shifts(self.terms, &self.approaches[index], self.touches[index].spindle_rad);
        let added = shifts.iter().zip(at.iter().skip(FIRST));
        let added = added.fold(Vector3::zeros(), |sum: Vector3<f64>, (shift, q)| sum + shift * *q);
        self.reference.across(self.touches[index].center_mm - place - added)
    }
}

impl Problem for Calibration<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.touches.len()
    }

    fn tangent_dim(&self) -> usize {
        self.n_parameters()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        let expected = self.reference.radius_mm() + self.reference.side() * at[RADIUS];
        for (i, touch) in self.touches.iter().enumerate() {
            out[i] = (self.arm(i, at).norm() - expected) / touch.sigma_mm;
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (i, touch) in self.touches.iter().enumerate() {
            let arm = self.arm(i, at);
            let outward = arm / arm.norm();
            for k in 0..PLACE {
                out[(i, k)] = -outward[k] / touch.sigma_mm;
            }
            out[(i, RADIUS)] = -self.reference.side() / touch.sigma_mm;
            let shifts = shifts(self.terms, &self.approaches[i], touch.spindle_rad);
            for (k, shift) in shifts.iter().enumerate() {
                out[(i, FIRST + k)] = -outward.dot(shift) / touch.sigma_mm;
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        let lobe = |k: usize| self.terms.lobes.get(k / 2).copied().unwrap_or_default();
        match index {
            0..PLACE => format!("place along {} (mm)", ["x", "y", "z"][index]),
            RADIUS => "effective radius of the ball (mm)".to_owned(),
            _ if index - FIRST < 2 * self.terms.lobes.len() => {
                let k = index - FIRST;
                format!("lobe {} {} (mm)", lobe(k), if k.is_multiple_of(2) { "cos" } else { "sin" })
            }
            _ => "bending (mm)".to_owned(),
        }
    }
}

fn n_amplitudes(terms: &ProbeTerms) -> usize {
    2 * terms.lobes.len() + usize::from(terms.bending)
}

/// What a unit of each amplitude adds to the reading of a touch from that approach.
pub(crate) fn shifts(
    terms: &ProbeTerms,
    approach: &Unit<Vector3<f64>>,
    spindle_rad: f64,
) -> Vec<Vector3<f64>> {
    let stylus = terms.stylus;
    let sideways = approach.into_inner() - stylus.into_inner() * stylus.dot(approach);
    let [zero, quarter] = axes(&stylus);
    let azimuth = quarter.dot(&sideways).atan2(zero.dot(&sideways)) - spindle_rad;
    let mut all = Vec::with_capacity(n_amplitudes(terms));
    for &order in &terms.lobes {
        let angle = f64::from(order) * azimuth;
        for height in [angle.cos(), angle.sin()] {
            all.push(approach.into_inner() * (height * sideways.norm()));
        }
    }
    if terms.bending {
        all.push(sideways);
    }
    all
}

/// Directions of azimuth 0 and 90° about the stylus: the machine's x, unless the stylus lies along
/// it.
fn axes(stylus: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let x = if stylus.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let across = Matrix3::identity() - stylus.into_inner() * stylus.transpose();
    let zero = (across * x).normalize();
    [zero, stylus.cross(&zero)]
}
