//! Repeatability of a head, and whether it is within its tolerance.

use ft_center::{Repeatability, SolvedPress};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::case::Conformance;
use crate::kinds::ft_center::settings::ToleranceSettings;

/// Standard deviations across the band of a repeatability, as ISO 230-2 has it: `R = 4 s`.
const BAND: f64 = 4.0;

/// How well the head comes back to a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepeatabilityEstimate {
    /// Places that were pressed more than once.
    pub places: usize,
    /// Presses at these places.
    pub presses: usize,
    /// Degrees of freedom of the standard deviations.
    pub degrees_of_freedom: usize,
    /// Standard deviation of one press along the machine's x.
    pub std_x_mm: f64,
    /// The same along y.
    pub std_y_mm: f64,
    /// Repeatability along x, four standard deviations.
    pub x_mm: f64,
    /// The same along y.
    pub y_mm: f64,
    /// What the tolerance says of it; `None` where there is none.
    pub conformity: Option<Conformity>,
}

/// A repeatability held against its tolerance.
///
/// The decision rule is that of JCGM 106 with guard bands on both sides: what is known of the true
/// value, `s²` over its true value being χ² over its degrees of freedom, gives the probability that
/// it is within the tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conformity {
    /// Largest repeatability allowed.
    pub tolerance_mm: f64,
    /// Probability from which on it passes; it fails at the complement.
    pub required: f64,
    /// Probability that the true repeatability is within the tolerance, of the worse axis.
    pub probability: f64,
    /// Largest repeatability found that passes: the tolerance less the guard band.
    pub acceptance_limit_mm: f64,
    /// Smallest repeatability found that fails.
    pub rejection_limit_mm: f64,
    /// `pass`, `fail`, or `undecided` between the two limits.
    pub decision: &'static str,
}

impl RepeatabilityEstimate {
    pub(super) fn of(
        presses: &[SolvedPress],
        centers: &[ft_center::Center],
        tolerance: ToleranceSettings,
    ) -> Option<Self> {
        let found = ft_center::repeatability(presses, centers)?;
        let Repeatability { places, presses, degrees_of_freedom, std_mm } = found;
        let worse_mm = BAND * std_mm.max();
        let conformity = tolerance.repeatability_mm.map(|limit| {
            let Conformance(required) = tolerance.conformance.unwrap_or_default();
            Conformity::of(worse_mm, degrees_of_freedom, (limit.0, required))
        });
        Some(Self {
            places,
            presses,
            degrees_of_freedom,
            std_x_mm: std_mm.x,
            std_y_mm: std_mm.y,
            x_mm: BAND * std_mm.x,
            y_mm: BAND * std_mm.y,
            conformity,
        })
    }

    /// One line for people.
    pub(super) fn sentence(&self) -> String {
        let Self { places, presses, x_mm, y_mm, .. } = self;
        let found = format!(
            "repeatability (4 s, {presses} presses of {places} places): {x_mm:.4} mm along x, \
             {y_mm:.4} mm along y"
        );
        let Some(c) = &self.conformity else { return found };
        format!(
            "{found}; tolerance {} mm: {} (within it with a probability of {:.1} %; JCGM 106, passes \
             up to {:.4} mm, fails from {:.4} mm on)",
            c.tolerance_mm,
            c.decision,
            100.0 * c.probability,
            c.acceptance_limit_mm,
            c.rejection_limit_mm
        )
    }
}

impl Conformity {
    fn of(found_mm: f64, dof: usize, (tolerance_mm, required): (f64, f64)) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let nu = dof as f64;
        let law = ChiSquared::new(nu).expect("there is a degree of freedom");
        // σ ≤ T/4 where χ² = ν s²/σ² is at least ν (4 s/T)².
        let probability = law.sf(nu * (found_mm / tolerance_mm).powi(2));
        let limit = |p: f64| tolerance_mm * (law.inverse_cdf(p) / nu).sqrt();
        let (acceptance_limit_mm, rejection_limit_mm) = (limit(1.0 - required), limit(required));
        let decision = if found_mm <= acceptance_limit_mm {
            "pass"
        } else if found_mm >= rejection_limit_mm {
            "fail"
        } else {
            "undecided"
        };
        Self {
            tolerance_mm,
            required,
            probability,
            acceptance_limit_mm,
            rejection_limit_mm,
            decision,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Conformity;

    /// χ² of 10 degrees of freedom has its 5 % and 95 % points at 3.940 and 18.307 (tables).
    #[test]
    fn limits_are_those_of_the_tables() {
        let of = |found| Conformity::of(found, 10, (0.1, 0.95));
        let c = of(0.05);
        assert!((c.acceptance_limit_mm - 0.1 * 0.3940_f64.sqrt()).abs() < 1e-5, "{c:?}");
        assert!((c.rejection_limit_mm - 0.1 * 1.8307_f64.sqrt()).abs() < 1e-5, "{c:?}");
        assert_eq!(c.decision, "pass");
        assert_eq!((of(0.1).decision, of(0.14).decision), ("undecided", "fail"));
        let at_limit = of(c.acceptance_limit_mm);
        assert!((at_limit.probability - 0.95).abs() < 1e-9, "{at_limit:?}");
    }
}
