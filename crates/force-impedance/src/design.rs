//! The design card: what a set of impedance parameters does on a contact.

use std::f64::consts::PI;

use crate::contact_loop::{ContactLoop, check_contact};
use crate::error::{require, require_positive};
use crate::{ForceImpedanceError, ImpedanceParameters, LoopSettings, ReferenceMode};

/// Frequencies at which the loop is looked at, evenly in logarithm over six decades up to half the
/// sampling frequency; crossings between them are bisected.
const N_FREQUENCIES: u32 = 1500;
const DECADES: f64 = 6.0;
/// A force within this share of its final value has settled.
const SETTLED: f64 = 0.02;
/// Samples after which a loop counts as not settling.
const MAX_SAMPLES: usize = 400_000;
/// Margins that a recommendation keeps: 6 dB and 45°, the textbook's.
const GAIN_MARGIN: f64 = 2.0;
const PHASE_MARGIN_RAD: f64 = PI / 4.0;

/// One contact on the card.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DesignPoint {
    /// Stiffness of the contact.
    pub contact_n_per_mm: f64,
    /// Whether the loop is stable.
    pub stable: bool,
    /// Factor by which the contact may be stiffer before the loop is unstable.
    pub gain_margin_ratio: f64,
    /// Phase that may be lost at the crossover; `None` where the gain is below 1 everywhere.
    pub phase_margin_rad: Option<f64>,
    /// Dead time that may be added; `None` where the gain is below 1 everywhere.
    pub delay_margin_s: Option<f64>,
    /// Share of an error of the programmed path that stays, `1/(1 + K_e/K)`.
    pub steady_error_ratio: f64,
    /// How far a step of the reference is overshot; `None` where it does not settle.
    pub overshoot_ratio: Option<f64>,
    /// Time until the force stays within 2 % of its final value; `None` where it does not.
    pub settling_s: Option<f64>,
}

/// Stability, margins, steady error and response of an impedance on one contact.
///
/// # Errors
///
/// [`ForceImpedanceError::InvalidSetting`], [`ForceImpedanceError::TooFastForSampling`].
pub fn design_point(
    parameters: ImpedanceParameters,
    settings: &LoopSettings,
    contact_n_per_mm: f64,
) -> Result<DesignPoint, ForceImpedanceError> {
    check_contact(contact_n_per_mm)?;
    let closed = ContactLoop::new(parameters, settings)?;
    let margins = margins(&closed, contact_n_per_mm, settings.interval_s);
    let k = parameters.stiffness_n_per_mm;
    let steady_error_ratio = match settings.mode {
        ReferenceMode::Absolute => k / (k + contact_n_per_mm),
        ReferenceMode::Rebased => 0.0,
    };
    let stable = margins.gain_ratio > 1.0;
    let response = if stable {
        response(&closed, contact_n_per_mm, 1.0 - steady_error_ratio, settings.interval_s)
    } else {
        None
    };
    Ok(DesignPoint {
        contact_n_per_mm,
        stable,
        gain_margin_ratio: margins.gain_ratio,
        phase_margin_rad: margins.phase_rad,
        delay_margin_s: margins.delay_s,
        steady_error_ratio,
        overshoot_ratio: response.map(|(overshoot, _)| overshoot),
        settling_s: response.map(|(_, settling_s)| settling_s),
    })
}

/// Parameters for a range of contacts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Recommendation {
    /// Without stiffness: the force reaches its reference in either mode.
    pub parameters: ImpedanceParameters,
    /// Settling time asked for.
    pub settling_s: f64,
    /// Stiffness from which on it is met.
    pub met_from_n_per_mm: Option<f64>,
}

/// One set of parameters with margins of 6 dB and 45° on every contact of a range, as quick as
/// they allow and no quicker than asked for on the softest.
///
/// A loop's speed goes with the contact's stiffness: on a range of a thousand to one, the softest
/// contact settles a thousand times slower than the stiffest.
///
/// # Errors
///
/// [`ForceImpedanceError::InvalidSetting`].
pub fn recommend(
    settings: &LoopSettings,
    range_n_per_mm: [f64; 2],
    settling_s: f64,
) -> Result<Recommendation, ForceImpedanceError> {
    let [softest, stiffest] = range_n_per_mm;
    check_contact(softest)?;
    require(stiffest >= softest, "stiffest contact", stiffest, "at least the softest")?;
    require_positive("settling_s", settling_s)?;
    // The inertia filters the force for a quarter of what the loop waits anyway.
    let wait_s = settings.interval_s + settings.delay_s + settings.lag_s;
    let with = |damping: f64| ImpedanceParameters {
        mass_kg: 1e3 * damping * 0.25 * wait_s,
        damping_ns_per_mm: damping,
        stiffness_n_per_mm: 0.0,
    };
    ContactLoop::new(with(stiffest * wait_s), settings)?;
    let comfortable = |damping: f64| {
        margins_at(with(damping), settings, stiffest).is_ok_and(|m| m.is_comfortable())
    };
    let least = bisect(stiffest * wait_s, comfortable);
    let settles = |damping: f64, contact: f64| {
        let point = design_point(with(damping), settings, contact).ok();
        point.and_then(|p| p.settling_s).is_some_and(|s| s <= settling_s)
    };
    // Slower than it must be where time is left: more margin, less noise.
    let damping = if settles(least, softest) {
        slowest(least, |damping| settles(damping, softest))
    } else {
        least
    };
    let met_from_n_per_mm = settles(damping, stiffest).then(|| {
        if settles(damping, softest) {
            softest
        } else {
            first(softest, stiffest, |c| settles(damping, c))
        }
    });
    Ok(Recommendation { parameters: with(damping), settling_s, met_from_n_per_mm })
}

/// Smallest number, to 0.1 %, from which on something holds; `from` is anywhere.
fn bisect(from: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (from, from);
    for _ in 0..60 {
        if holds(high) {
            break;
        }
        high *= 2.0;
    }
    for _ in 0..60 {
        if !holds(low) {
            break;
        }
        low *= 0.5;
    }
    while high / low > 1.001 {
        let middle = (low * high).sqrt();
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Largest multiple of `least`, up to a thousand, for which something still holds.
fn slowest(least: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (least, 1e3 * least);
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

fn first(low: f64, high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (low, high);
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// How far a loop is from instability.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Margins {
    /// Smallest factor on the gain that makes the loop unstable; below 1 it is.
    pub gain_ratio: f64,
    /// Least phase margin; `None` where the gain is below 1 everywhere.
    pub phase_rad: Option<f64>,
    /// Dead time that takes that phase; `None` where the gain is below 1 everywhere.
    pub delay_s: Option<f64>,
}

impl Margins {
    /// Whether they are what a recommendation keeps: 6 dB and 45°.
    #[must_use]
    pub fn is_comfortable(&self) -> bool {
        self.gain_ratio >= GAIN_MARGIN && self.phase_rad.is_none_or(|m| m >= PHASE_MARGIN_RAD)
    }
}

/// Margins of an impedance on one contact, without its response.
///
/// # Errors
///
/// As [`design_point`].
pub fn margins_at(
    parameters: ImpedanceParameters,
    settings: &LoopSettings,
    contact_n_per_mm: f64,
) -> Result<Margins, ForceImpedanceError> {
    check_contact(contact_n_per_mm)?;
    let closed = ContactLoop::new(parameters, settings)?;
    Ok(margins(&closed, contact_n_per_mm, settings.interval_s))
}

/// With a small gain the loop is stable, so it stays so up to the first gain at which the locus
/// passes −1.
fn margins(closed: &ContactLoop, contact_n_per_mm: f64, interval_s: f64) -> Margins {
    let transfer = |omega: f64| closed.transfer(omega) * contact_n_per_mm;
    let frequency = |i: u32| {
        let share = f64::from(i) / f64::from(N_FREQUENCIES);
        PI * 10f64.powf(DECADES * (share - 1.0))
    };
    let mut out = Margins { gain_ratio: f64::INFINITY, phase_rad: None, delay_s: None };
    let mut note_gain = |real: f64| {
        if real < 0.0 {
            out.gain_ratio = out.gain_ratio.min(-1.0 / real);
        }
    };
    let mut crossings = Vec::new();
    let mut before = (frequency(0), transfer(frequency(0)));
    for i in 1..=N_FREQUENCIES {
        let now = (frequency(i), transfer(frequency(i)));
        if before.1.im * now.1.im <= 0.0 && before.1.re.min(now.1.re) < 0.0 {
            let at = crossing(before.0, now.0, |omega| transfer(omega).im);
            note_gain(transfer(at).re);
        }
        if (before.1.norm() - 1.0) * (now.1.norm() - 1.0) <= 0.0 {
            crossings.push(crossing(before.0, now.0, |omega| transfer(omega).norm() - 1.0));
        }
        before = now;
    }
    note_gain(before.1.re);
    for omega in crossings {
        let value = transfer(omega);
        // Lag behind the positive axis, 0 to 2π.
        let lag = (-value.arg()).rem_euclid(2.0 * PI);
        let phase_rad = PI - lag;
        if out.phase_rad.is_none_or(|least| phase_rad < least) {
            out.phase_rad = Some(phase_rad);
            out.delay_s = Some(phase_rad / omega * interval_s);
        }
    }
    out
}

fn crossing(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (low, high);
    let negative = f(low) < 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == negative { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Overshoot and settling time of a step of the reference.
fn response(
    closed: &ContactLoop,
    contact_n_per_mm: f64,
    last_n: f64,
    interval_s: f64,
) -> Option<(f64, f64)> {
    let mut most = 1000;
    loop {
        let forces = closed.step_response(contact_n_per_mm, most);
        let off = |f: &f64| (f / last_n - 1.0).abs() > SETTLED;
        let settled = forces.iter().rposition(off).map_or(0, |i| i + 1);
        // Twice as long without leaving the band again.
        if 2 * settled < forces.len() {
            let highest = forces.iter().copied().fold(0.0, f64::max);
            let overshoot = (highest / last_n - 1.0).max(0.0);
            return Some((overshoot, crate::count(settled) * interval_s));
        }
        if most >= MAX_SAMPLES {
            return None;
        }
        most *= 4;
    }
}
