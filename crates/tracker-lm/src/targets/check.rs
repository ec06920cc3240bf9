//! What a survey of points has to be before anything is computed.

use std::collections::HashSet;

use crate::curves::LOCATION;
use crate::error::{Record, Shortage};
use crate::network::{LARGEST, MIN_MOUNTS, check_collinear};
use crate::{AxisModel, TargetNoise, TargetOptions, TargetSurvey, TrackerError};

/// Unknowns of an angle, and of a station.
const SIX: usize = 6;

pub(super) fn check(survey: &TargetSurvey, options: &TargetOptions) -> Result<(), TrackerError> {
    check_noise(options.noise)?;
    check_numbers(survey)?;
    check_references(survey)?;
    let got = survey.mounts.len();
    if got < MIN_MOUNTS {
        return Err(TrackerError::TooFewMounts { needed: MIN_MOUNTS, got });
    }
    check_collinear(&survey.mounts.iter().map(|m| m.nominal_mm.coords).collect::<Vec<_>>())
}

/// Refuses fewer equations than unknowns, or as many.
pub(super) fn check_count(
    survey: &TargetSurvey,
    n_angles: usize,
    axis: AxisModel,
) -> Result<(), TrackerError> {
    let equations = 3 * survey.targets.len();
    let shared = SIX * survey.stations.len() + 3 * survey.mounts.len() - SIX;
    let (located, own, free) = match axis {
        AxisModel::Free => (0, SIX, n_angles - 1),
        AxisModel::Fixed => (0, 0, 0),
        AxisModel::Located => (LOCATION.len(), 0, 0),
    };
    let unknowns = shared + located + own * free;
    if equations > unknowns {
        return Ok(());
    }
    let brings = (equations / n_angles).saturating_sub(own);
    let (shortage, needed, got) = match (shared + located).saturating_sub(own).checked_div(brings) {
        Some(more) => (Shortage::Angles, (more + 1).max(n_angles + 1), n_angles),
        None => (Shortage::RangesPerAngle, own + 1, equations / n_angles),
    };
    Err(TrackerError::TooFewRanges { equations, unknowns, shortage, needed, got })
}

fn check_noise(noise: TargetNoise) -> Result<(), TrackerError> {
    let all = match noise {
        TargetNoise::Estimated => Vec::new(),
        TargetNoise::Point { point_mm } => vec![("point_mm", point_mm)],
        TargetNoise::Polar { range_mm, angle_rad } => {
            vec![("range_mm", range_mm), ("angle_rad", angle_rad)]
        }
    };
    let bad = all.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite()));
    bad.map_or(Ok(()), |(which, value)| Err(TrackerError::InvalidNoise { which, value }))
}

fn check_numbers(survey: &TargetSurvey) -> Result<(), TrackerError> {
    let check = |what: Record, index: usize, values: &[f64]| {
        let bad = values.iter().find(|v| !v.is_finite() || v.abs() > LARGEST);
        bad.map_or(Ok(()), |&value| {
            Err(TrackerError::InvalidNumber { what, index, value, limit: LARGEST })
        })
    };
    for (j, mount) in survey.mounts.iter().enumerate() {
        check(Record::Mount, j, mount.nominal_mm.coords.as_slice())?;
    }
    for (k, step) in survey.steps.iter().enumerate() {
        check(Record::Step, k, &[step.angle_rad])?;
    }
    for (n, target) in survey.targets.iter().enumerate() {
        check(Record::Target, n, target.at_mm.coords.as_slice())?;
    }
    Ok(())
}

fn check_references(survey: &TargetSurvey) -> Result<(), TrackerError> {
    let counts = [survey.stations.len(), survey.mounts.len(), survey.steps.len()];
    let kinds = [Record::Station, Record::Mount, Record::Step];
    let mut seen = HashSet::with_capacity(survey.targets.len());
    let mut unseen = counts.map(|count| vec![true; count]);
    for (range, t) in survey.targets.iter().enumerate() {
        for (kind, index) in [t.station, t.mount, t.step].into_iter().enumerate() {
            if index >= counts[kind] {
                let (what, count) = (kinds[kind], counts[kind]);
                return Err(TrackerError::UnknownIndex { range, what, index, count });
            }
            unseen[kind][index] = false;
        }
        if !seen.insert((t.station, t.mount, t.step)) {
            return Err(TrackerError::DuplicateRange {
                station: survey.stations[t.station].name.clone(),
                mount: survey.mounts[t.mount].name.clone(),
                step: survey.steps[t.step].name.clone(),
                range,
            });
        }
    }
    for (kind, unseen) in unseen.iter().enumerate() {
        if let Some(index) = unseen.iter().position(|u| *u) {
            let name = match kinds[kind] {
                Record::Station => &survey.stations[index].name,
                Record::Mount => &survey.mounts[index].name,
                _ => &survey.steps[index].name,
            };
            return Err(TrackerError::Unseen { what: kinds[kind], name: name.clone() });
        }
    }
    Ok(())
}
