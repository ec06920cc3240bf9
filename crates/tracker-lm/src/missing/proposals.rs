//! Further measurements that would tell effects apart or make them visible.

use least_squares::BorderedPoint;
use model_discrepancy::{Covariate, Proposal};
use nalgebra::{Point3, Vector3};

use crate::count::count;
use crate::gauge::StationChart;
use crate::missing::effects::approaches;
use crate::missing::model::{Choices, Recorded};
use crate::missing::solved::Solved;
use crate::{Approach, Gauge, Options, Step, Survey, TrackerModel};

/// How well a coordinate measuring machine, or a compensated machine tool, knows a place.
const KNOWN_STATION_MM: f64 = 1e-3;

/// Further measurements, the cheapest first.
pub(crate) fn proposals(model: &TrackerModel) -> Vec<Proposal<'_>> {
    let steps = 0..model.survey.steps.len();
    let backward: Vec<usize> = steps.clone().rev().collect();
    let forward: Vec<usize> = steps.collect();
    vec![
        Proposal::new("run back through the same angles", move || again(model, &backward, true)),
        Proposal::new("run through the same angles once more", move || {
            again(model, &forward, false)
        }),
        Proposal::new(
            "determine the stations' positions to 1 µm and give them with their uncertainty",
            || known_stations(model),
        ),
    ]
}

/// The same steps again, in this order; `reversed` turns the way the axis comes to them.
fn again(model: &TrackerModel, order: &[usize], reversed: bool) -> Option<TrackerModel> {
    let mut survey = model.survey.clone();
    let ways = approaches(&survey.steps);
    for (step, way) in survey.steps.iter_mut().zip(&ways) {
        step.approach = Some(*way);
    }
    let n_steps = survey.steps.len();
    let mut recorded = model.recorded.clone();
    let mut extra_times = Vec::new();
    for (n, &of) in order.iter().enumerate() {
        let approach = match (ways[of], reversed) {
            (Approach::Positive, true) | (Approach::Negative, false) => Approach::Negative,
            _ => Approach::Positive,
        };
        let step = Step {
            name: format!("again {}", n + 1),
            approach: Some(approach),
            ..survey.steps[of].clone()
        };
        survey.steps.push(step);
        for index in 0..model.survey.ranges.len() {
            let range = model.survey.ranges[index];
            if range.step != of {
                continue;
            }
            survey.ranges.push(crate::Range { step: n_steps + n, ..range });
            for Covariate { values, .. } in &mut recorded.covariates {
                values.push(values[index]);
            }
            extra_times.push((index, of, n));
        }
    }
    if let Some(times) = &mut recorded.time_s {
        continue_times(times, &model.survey, &extra_times);
    }
    let mut solved = model.solved.clone();
    if !solved.shifts.is_empty() {
        let repeated: Vec<_> = extra_times.iter().map(|(r, ..)| solved.shifts[*r]).collect();
        solved.shifts.extend(repeated);
    }
    let choices = Choices { tied: None, ..model.choices() };
    TrackerModel::about(survey, model.options, recorded, solved, Some(&choices)).ok()
}

/// Times of repeated ranges: as late after the run as the step's place in the new order says.
fn continue_times(times: &mut Vec<f64>, survey: &Survey, extra: &[(usize, usize, usize)]) {
    let first = times.iter().copied().fold(f64::INFINITY, f64::min);
    let last = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let per_step = (last - first) / count(survey.steps.len());
    for &(index, of, n) in extra {
        let moved = per_step * (count(n) - count(of));
        times.push(times[index] + (last - first) + moved);
    }
}

/// The same ranges with stations whose places are known.
fn known_stations(model: &TrackerModel) -> Option<TrackerModel> {
    let mut options: Options = model.options;
    options.gauge = Gauge::Stations;
    if options.noise.station_mm.is_some_and(|known| known <= KNOWN_STATION_MM) {
        return None;
    }
    options.noise.station_mm = Some(KNOWN_STATION_MM);
    let nominal: Vec<Point3<f64>> = model.survey.stations.iter().map(|s| s.nominal_mm).collect();
    let chart = StationChart::new(&nominal, &options).ok()?;
    let old = StationChart::new(&nominal, &model.options).ok()?;
    let point = &model.solved.point;
    let stations: Vec<Vector3<f64>> =
        (0..nominal.len()).map(|i| old.position_mm(i, &point.shared)).collect();
    let rest = point.shared[old.dim()..].iter().copied();
    let shared = chart.parameters(&stations).iter().copied().chain(rest).collect();
    let point = BorderedPoint { shared, blocks: point.blocks.clone() };
    let solved = Solved { point, ..model.solved.clone() };
    let recorded: Recorded = model.recorded.clone();
    let choices = Choices { tied: None, ..model.choices() };
    TrackerModel::about(model.survey.clone(), options, recorded, solved, Some(&choices)).ok()
}
