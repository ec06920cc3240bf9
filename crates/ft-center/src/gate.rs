//! Which samples of a record are in contact.

use crate::{Contact, FtCenterError, Sample, error::require_positive};

/// Share of the record's 95th percentile of `|Fz|` that makes the default gate.
const DEFAULT_GATE_RATIO: f64 = 0.2;

/// Share of samples over the gate that may have the other sign: spikes, not a press.
const MAX_OTHER_SIGN_RATIO: f64 = 0.05;

/// One sample in contact, as equations for the centre `p`: `moment = fz · p`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InContact {
    pub(crate) time_s: f64,
    pub(crate) fz_n: f64,
    /// `z0 Fx − My` and `Mx + z0 Fy`.
    pub(crate) moment_nmm: [f64; 2],
    /// Position in the record.
    pub(crate) index: usize,
}

/// A record after the force gate.
#[derive(Clone, Debug)]
pub(crate) struct Gated {
    pub(crate) samples: Vec<InContact>,
    pub(crate) min_fz_n: f64,
}

/// Validates a record and keeps its samples in contact.
pub(crate) fn gate(
    record: &[Sample],
    contact: &Contact,
    needed: usize,
) -> Result<Gated, FtCenterError> {
    check_record(record, contact)?;
    let min_fz_n = match contact.min_fz_n {
        Some(min_fz_n) => min_fz_n,
        None => default_gate_n(record),
    };
    let over = |s: &&Sample| s.wrench.force_n.z.abs() >= min_fz_n && min_fz_n > 0.0;
    let positive = record.iter().filter(over).filter(|s| s.wrench.force_n.z > 0.0).count();
    let negative = record.iter().filter(over).count() - positive;
    let sign = if positive >= negative { 1.0 } else { -1.0 };
    if crate::count(positive.min(negative))
        > MAX_OTHER_SIGN_RATIO * crate::count(positive + negative)
    {
        return Err(FtCenterError::MixedSign { positive, negative, min_fz_n });
    }
    let samples: Vec<_> = record
        .iter()
        .enumerate()
        .filter(|(_, s)| over(s) && s.wrench.force_n.z * sign > 0.0)
        .map(|(index, s)| equations(s, contact.z0_mm, index))
        .collect();
    if samples.len() < needed {
        let (contact, given) = (samples.len(), record.len());
        return Err(FtCenterError::TooFewContactSamples { contact, given, needed, min_fz_n });
    }
    Ok(Gated { samples, min_fz_n })
}

fn equations(sample: &Sample, z0_mm: f64, index: usize) -> InContact {
    let (f, m) = (sample.wrench.force_n, sample.wrench.torque_nmm);
    let moment_nmm = [z0_mm * f.x - m.y, m.x + z0_mm * f.y];
    InContact { time_s: sample.time_s, fz_n: f.z, moment_nmm, index }
}

fn check_record(record: &[Sample], contact: &Contact) -> Result<(), FtCenterError> {
    if !contact.z0_mm.is_finite() {
        return Err(FtCenterError::InvalidHeight { z0_mm: contact.z0_mm });
    }
    if let Some(min_fz_n) = contact.min_fz_n {
        require_positive(min_fz_n, "min_fz_n")?;
    }
    let finite =
        |s: &Sample| s.time_s.is_finite() && s.wrench.to_vector().iter().all(|v| v.is_finite());
    if let Some(index) = record.iter().position(|s| !finite(s)) {
        return Err(FtCenterError::NotFinite { index });
    }
    match record.windows(2).position(|w| w[1].time_s <= w[0].time_s) {
        Some(i) => Err(FtCenterError::TimeNotIncreasing {
            index: i + 1,
            before_s: record[i].time_s,
            after_s: record[i + 1].time_s,
        }),
        None => Ok(()),
    }
}

fn default_gate_n(record: &[Sample]) -> f64 {
    let mut loads: Vec<_> = record.iter().map(|s| s.wrench.force_n.z.abs()).collect();
    if loads.is_empty() {
        return 0.0;
    }
    let at = (loads.len() - 1) * 95 / 100;
    let (_, percentile, _) = loads.select_nth_unstable_by(at, f64::total_cmp);
    DEFAULT_GATE_RATIO * *percentile
}
