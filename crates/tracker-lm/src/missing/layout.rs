//! What the observations of a survey of ranges are: their rows, groups, places and locks.

use std::collections::HashMap;

use model_discrepancy::{Cells, Group, Layout, Role, Row};

use crate::gauge::StationChart;
use crate::missing::reduction::Reduction;
use crate::network::Network;
use crate::{Approach, AxisModel, Options, Survey};

/// One observation per range, and one for what is known of the stations beforehand.
pub(crate) fn layout(
    network: &Network<'_>,
    reduction: &Reduction,
    chart: &StationChart,
    sigma_mm: f64,
    options: &Options,
) -> Layout {
    let survey = network.survey;
    let mut groups: Vec<Group> =
        survey.steps.iter().map(|s| Group { name: s.name.clone(), role: Role::Fit }).collect();
    let mut observations: Vec<usize> = survey.ranges.iter().map(|r| r.step).collect();
    let mut rows: Vec<Row> = (reduction.range_of_row.iter())
        .map(|&range| Row { observation: range, component: 0, sigma: sigma_mm, reported: true })
        .collect();
    if let Some(sigma) = chart.prior_mm {
        observations.push(groups.len());
        groups.push(Group { name: "nominal stations".to_owned(), role: Role::Prior });
        let observation = survey.ranges.len();
        let prior = Row { observation, component: 0, sigma, reported: false };
        rows.extend(std::iter::repeat_n(prior, chart.dim()));
    }
    Layout {
        rows,
        observations,
        groups,
        unit: "mm".to_owned(),
        sigma_declared: options.noise.displacement_mm.is_some(),
    }
}

/// What a reading says anew that another one has said: by which station, of which mount, at which angle, and the way the
/// axis came to it.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    pub(crate) station: usize,
    pub(crate) mount: usize,
    pub(crate) angle: usize,
    pub(crate) approach: Option<Approach>,
}

/// A number for each place, the same where it repeats.
pub(crate) fn numbered(seen: impl Iterator<Item = Seen>) -> Vec<usize> {
    let mut known = HashMap::new();
    let number = |Seen { station, mount, angle, approach }: Seen| {
        let key = (station, mount, angle, approach.map(|way| way == Approach::Positive));
        let next = known.len();
        *known.entry(key).or_insert(next)
    };
    seen.map(number).collect()
}

/// Place of every range: station, mount, angle and the way the axis came to it.
///
/// With free errors none repeats another: a row combines readings of several angles once what ties
/// them is taken out.
pub(crate) fn places(network: &Network<'_>, n_observations: usize) -> Vec<usize> {
    if network.axis_model == AxisModel::Free {
        return (0..n_observations).collect();
    }
    let survey = network.survey;
    let seen = survey.ranges.iter().map(|range| Seen {
        station: range.station,
        mount: range.mount,
        angle: network.angle_of_step[range.step],
        approach: survey.steps[range.step].approach,
    });
    let mut places = numbered(seen);
    let known = places.iter().map(|place| place + 1).max().unwrap_or(0);
    places.resize(n_observations, known);
    places
}

/// Station and mount of every range as one number; what is known beforehand is apart.
pub(crate) fn locks(survey: &Survey, n_observations: usize) -> Vec<usize> {
    let n_mounts = survey.mounts.len();
    let mut locks: Vec<usize> =
        survey.ranges.iter().map(|r| r.station * n_mounts + r.mount).collect();
    locks.resize(n_observations, survey.stations.len() * n_mounts);
    locks
}

/// Readings of one station at one step; what is known beforehand stands alone.
pub(crate) fn at_steps(survey: &Survey, n_observations: usize) -> Cells {
    let n_steps = survey.steps.len();
    let known = survey.stations.len() * n_steps;
    let mut of_observation: Vec<usize> =
        survey.ranges.iter().map(|r| r.station * n_steps + r.step).collect();
    of_observation.extend((known..).take(n_observations - survey.ranges.len()));
    Cells { what: "station at a step".to_owned(), of_observation }
}
