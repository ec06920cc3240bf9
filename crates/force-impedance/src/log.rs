use nalgebra::{Unit, Vector3};

use crate::scalar::norm;
use crate::{ForceImpedanceError, Head};

/// One row of a recorded run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LogSample {
    /// Time of the sample.
    pub time_s: f64,
    /// `l1, l2, l3, l4`.
    pub lengths_mm: [f64; 4],
    /// Load cells, compression positive.
    pub cells_n: [f64; 4],
    /// Outward normal of the workpiece, frame Y.
    pub normal: Unit<Vector3<f64>>,
    /// Normal contact force that a reference instrument read.
    pub reference_n: Option<f64>,
    /// Which stretch of the run it belongs to, counted from 0; samples of one follow each other.
    pub segment: usize,
}

/// How the normal force is had from the readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ForceFormula {
    /// Three components from axial force and two moments, friction and weight included.
    #[default]
    FullBalance,
    /// `Σ F_i cos γ_i + F4` over the cosine of the normal, as \[C\] has it.
    Published,
}

/// What one sample of a log says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoggedForce {
    /// Normal force by the formula asked for.
    pub normal_n: f64,
    /// Across the normal, by the full balance.
    pub tangential_n: f64,
    /// Normal force − reference; `None` without a reference.
    pub residual_n: Option<f64>,
    /// Disagreement of the four lengths, see [`ForwardPose`](crate::ForwardPose).
    pub consistency_mm: f64,
    /// Internal force of the legs.
    pub preload_n: f64,
    /// Standard uncertainty of the residual per standard uncertainty of one force reading.
    pub noise_gain: f64,
    /// Where the tip was, frame Y.
    pub tip_mm: Vector3<f64>,
}

/// The contact force of every sample of a log.
///
/// # Errors
///
/// [`ForceImpedanceError::Sample`], [`ForceImpedanceError::TimeNotIncreasing`],
/// [`ForceImpedanceError::PartialReference`], [`ForceImpedanceError::TooFewSamples`] when empty.
pub fn solve_log(
    head: &Head,
    samples: &[LogSample],
    formula: ForceFormula,
) -> Result<Vec<LoggedForce>, ForceImpedanceError> {
    check(samples)?;
    let solve = |(index, sample)| {
        solve_sample(head, sample, formula)
            .map_err(|source| ForceImpedanceError::Sample { index, source: Box::new(source) })
    };
    samples.iter().enumerate().map(solve).collect()
}

fn solve_sample(
    head: &Head,
    sample: &LogSample,
    formula: ForceFormula,
) -> Result<LoggedForce, ForceImpedanceError> {
    if let Some(i) = sample.cells_n.iter().position(|f| !f.is_finite()) {
        return Err(ForceImpedanceError::NotFinite { quantity: "load cell", index: i + 1 });
    }
    let found = head.pose_of_lengths(&sample.lengths_mm)?;
    let balance = head.balance(&found.pose);
    let contact = balance.contact(&sample.cells_n, &sample.normal);
    let (normal_n, noise) = match formula {
        ForceFormula::FullBalance => {
            let [a, b, c, d] = balance.normal_weights(&sample.normal);
            (contact.normal_n, a * a + b * b + c * c + d * d)
        }
        ForceFormula::Published => {
            let of_cells = |cells_n: &[f64; 4]| balance.published_normal_n(cells_n, &sample.normal);
            let mut square = 0.0;
            for cell in 0..4 {
                let mut alone_n = [0.0; 4];
                alone_n[cell] = 1.0;
                let weight = of_cells(&alone_n)?;
                square += weight * weight;
            }
            (of_cells(&sample.cells_n)?, square)
        }
    };
    // The reference is a force reading too.
    let of_reference = if sample.reference_n.is_some() { 1.0 } else { 0.0 };
    Ok(LoggedForce {
        normal_n,
        tangential_n: contact.tangential_n,
        residual_n: sample.reference_n.map(|reference_n| normal_n - reference_n),
        consistency_mm: found.consistency_mm,
        preload_n: balance.preload_n(&sample.cells_n),
        noise_gain: (noise + of_reference).sqrt(),
        tip_mm: found.pose.tip_mm.coords,
    })
}

fn check(samples: &[LogSample]) -> Result<(), ForceImpedanceError> {
    if samples.is_empty() {
        return Err(ForceImpedanceError::TooFewSamples { got: 0, needed: 1 });
    }
    let with = samples.iter().filter(|s| s.reference_n.is_some()).count();
    if with != 0 && with != samples.len() {
        return Err(ForceImpedanceError::PartialReference { with, samples: samples.len() });
    }
    for (index, sample) in samples.iter().enumerate() {
        let not_finite = |quantity| ForceImpedanceError::Sample {
            index,
            source: Box::new(ForceImpedanceError::NotFinite { quantity, index: 1 }),
        };
        if !sample.time_s.is_finite() {
            return Err(not_finite("time"));
        }
        if sample.reference_n.is_some_and(|r| !r.is_finite()) {
            return Err(not_finite("reference"));
        }
        if !norm(&sample.normal).is_finite() {
            return Err(not_finite("normal"));
        }
    }
    for (i, pair) in samples.windows(2).enumerate() {
        let [before, after] = [pair[0], pair[1]];
        if before.segment == after.segment && after.time_s <= before.time_s {
            return Err(ForceImpedanceError::TimeNotIncreasing {
                index: i + 1,
                before_s: before.time_s,
                after_s: after.time_s,
            });
        }
    }
    Ok(())
}
