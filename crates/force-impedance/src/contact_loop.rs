//! The controlled contact as a linear loop: impedance, dead time, lag of the legs, spring.

use nalgebra::Complex;

use crate::error::{require_not_negative, require_positive};
use crate::{Discretisation, ForceImpedanceError, Impedance, ImpedanceParameters, ReferenceMode};

/// Dead time in samples from which on something else is wrong.
const MAX_DELAY_SAMPLES: f64 = 1000.0;

/// What lies between a force error and the force it leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopSettings {
    /// Sampling interval.
    pub interval_s: f64,
    /// Time from a sample to the moment when its command begins to act.
    pub delay_s: f64,
    /// Time constant with which the legs follow their command.
    pub lag_s: f64,
    /// Kind of difference equation.
    pub discretisation: Discretisation,
    /// What the correction is counted from.
    pub mode: ReferenceMode,
}

/// An impedance in a loop of these settings; the contact's stiffness is the loop's gain.
///
/// Exact at the samples: the delay need not be a multiple of the interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactLoop {
    impedance: Impedance,
    mode: ReferenceMode,
    /// Whole samples of delay.
    delay_samples: usize,
    /// `a ← keep·a + newer·e[k−m] + older·e[k−m−1]`.
    keep: f64,
    newer: f64,
    older: f64,
}

impl ContactLoop {
    pub(crate) fn new(
        parameters: ImpedanceParameters,
        settings: &LoopSettings,
    ) -> Result<Self, ForceImpedanceError> {
        let t = settings.interval_s;
        let impedance = Impedance::new(parameters, t, settings.discretisation)?;
        require_not_negative("delay_s", settings.delay_s)?;
        require_not_negative("lag_s", settings.lag_s)?;
        let samples = (settings.delay_s / t).floor();
        crate::error::require(
            samples < MAX_DELAY_SAMPLES,
            "delay_s",
            settings.delay_s,
            "below a thousand sampling intervals",
        )?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1000")]
        let delay_samples = samples as usize;
        let rest_s = settings.delay_s - samples * t;
        let decay = |time_s: f64| {
            if settings.lag_s > 0.0 { libm::exp(-time_s / settings.lag_s) } else { 0.0 }
        };
        let (keep, acted) = (decay(t), decay(t - rest_s));
        let (newer, older) = (1.0 - acted, acted - keep);
        Ok(Self { impedance, mode: settings.mode, delay_samples, keep, newer, older })
    }

    /// `(E, v)` after a step, from before, the error of the step and that of the one before.
    fn step(&self, [e, v]: [f64; 2], error_n: f64, before_n: f64) -> [f64; 2] {
        match self.mode {
            ReferenceMode::Absolute => self.impedance.advance(e, v, error_n, before_n),
            ReferenceMode::Rebased => {
                let [moved, v] = self.impedance.advance(0.0, v, error_n, before_n);
                [e + moved, v]
            }
        }
    }

    /// Loop transfer for a contact of 1 N/mm at `z = e^{iω}`, ω per sample.
    pub(crate) fn transfer(&self, omega: f64) -> Complex<f64> {
        let late = Complex::new(0.0, -omega).exp();
        let step = &self.impedance.step;
        let [[mut p11, p12], [mut p21, p22]] = step.phi;
        if self.mode == ReferenceMode::Rebased {
            (p11, p21) = (1.0, 0.0);
        }
        let one = Complex::new(1.0, 0.0);
        let input = |i: usize| late * step.before[i] + step.now[i];
        // E of (I − Φ z⁻¹)⁻¹ (Γ + Γ' z⁻¹).
        let (a, b) = (one - late * p11, late * p12);
        let (c, d) = (late * p21, one - late * p22);
        let offset = (d * input(0) + b * input(1)) / (a * d - b * c);
        #[expect(clippy::cast_precision_loss, reason = "below a thousand")]
        let waited = Complex::new(0.0, -omega * (self.delay_samples as f64 + 1.0)).exp();
        let legs = waited * (late * self.older + self.newer) / (one - late * self.keep);
        offset * legs
    }

    /// Force after each sample when the reference steps from 0 to 1 N in contact, until it has
    /// settled or `most` samples have passed.
    pub(crate) fn step_response(&self, contact_n_per_mm: f64, most: usize) -> Vec<f64> {
        let mut state = [0.0, 0.0];
        let (mut before_n, mut stands_mm) = (0.0, 0.0);
        let mut sent_mm = vec![0.0; self.delay_samples + 2];
        let mut forces = Vec::new();
        for k in 0..most {
            let force_n = -contact_n_per_mm * stands_mm;
            forces.push(force_n);
            let error_n = force_n - 1.0;
            state = self.step(state, error_n, before_n);
            before_n = error_n;
            let n = sent_mm.len();
            sent_mm[k % n] = state[0];
            let newer = sent_mm[(k + n - self.delay_samples) % n];
            let older = sent_mm[(k + n - self.delay_samples - 1) % n];
            stands_mm = self.keep * stands_mm + self.newer * newer + self.older * older;
            if !force_n.is_finite() || force_n.abs() > 1e6 {
                break;
            }
        }
        forces
    }
}

pub(crate) fn check_contact(contact_n_per_mm: f64) -> Result<(), ForceImpedanceError> {
    require_positive("contact stiffness (N/mm)", contact_n_per_mm)
}
