//! Further measurements that would tell effects apart or make them visible.

use model_discrepancy::{Covariate, Proposal, Quantity};
use nalgebra::{Point, SVector};

use crate::missing::effects::TIME;
use crate::{FrameModel, MeasuredPoint, PointPair};

/// How far beyond the points a far point is, in root-mean-square spreads: twice the distance of
/// the outermost points of an even distribution.
const FAR_SPREADS: f64 = 3.5;
/// Points repeated at the end, enough to average their noise.
const REPEATED: usize = 3;
/// A change of temperature that a workshop can make.
const WARMER_K: f64 = 10.0;
/// Spread along a direction, relative to the largest, below which the points are called flat.
const FLAT: f64 = 0.2;

/// A planned reading: which point of the source frame, and how much warmer than before.
struct Planned<const D: usize> {
    source_mm: Point<f64, D>,
    like: usize,
    warmer_k: f64,
}

/// Further measurements, the cheapest first.
pub(crate) fn proposals<const D: usize>(model: &FrameModel<D>) -> Vec<Proposal<'_>> {
    let mut proposals = Vec::new();
    let mut propose = |text: String, planned: Vec<Planned<D>>| {
        proposals.push(Proposal::new(text, move || Some(extended(model, &planned))));
    };
    let repeated = REPEATED.min(model.points.len());
    propose(
        format!("measure the first {repeated} points again at the end"),
        (0..repeated).map(|i| again(model, i, 0.0)).collect(),
    );
    for axis in 0..D {
        propose(
            format!("measure two points far along {}, one on either side", ["x", "y", "z"][axis]),
            far_along(model, &SVector::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 })),
        );
    }
    for k in 1..D {
        if model.spread.rms_mm[k] < FLAT * model.spread.rms_mm[0] {
            let direction = model.spread.directions.column(k).into_owned();
            let of_what = if k == 1 { "off the line" } else { "out of the plane" };
            propose(
                format!("add points {of_what} of the others, along ({})", numbers(&direction)),
                far_along(model, &direction),
            );
        }
    }
    if model.covariates.iter().any(|c| c.quantity == Quantity::Temperature) {
        propose(
            format!("measure the same points again, {WARMER_K:.0} K warmer"),
            (0..model.points.len()).map(|i| again(model, i, WARMER_K)).collect(),
        );
    }
    propose(
        "measure all points a second time, in reverse order".to_owned(),
        (0..model.points.len()).rev().map(|i| again(model, i, 0.0)).collect(),
    );
    proposals
}

fn again<const D: usize>(model: &FrameModel<D>, like: usize, warmer_k: f64) -> Planned<D> {
    Planned { source_mm: model.points[like].pair.source_mm, like, warmer_k }
}

fn far_along<const D: usize>(
    model: &FrameModel<D>,
    direction: &SVector<f64, D>,
) -> Vec<Planned<D>> {
    let reach_mm = FAR_SPREADS * model.spread.rms_mm.norm();
    [-reach_mm, reach_mm]
        .map(|distance| Planned {
            source_mm: model.spread.centroid_mm + direction * distance,
            like: 0,
            warmer_k: 0.0,
        })
        .into()
}

/// The model with the planned readings at the end; only their design matters.
fn extended<const D: usize>(model: &FrameModel<D>, planned: &[Planned<D>]) -> FrameModel<D> {
    let mut points = model.points.clone();
    let mut covariates = model.covariates.clone();
    for (n, plan) in planned.iter().enumerate() {
        let pair = PointPair {
            target_mm: model.reference().apply(&plan.source_mm),
            source_mm: plan.source_mm,
            uncertainty: model.points[plan.like].pair.uncertainty,
        };
        let mut point = MeasuredPoint::new(format!("proposed {}", n + 1), pair);
        point.body.clone_from(&model.points[plan.like].body);
        points.push(point);
        for covariate in &mut covariates {
            let value = next_value(covariate, plan.like, plan.warmer_k);
            covariate.values.push(value);
        }
    }
    FrameModel::about(*model.reference(), points, covariates, model.options, model.mirrored)
        .with_shown(model.shown.clone())
}

/// Time goes on at its mean pace; temperatures are those of the point `like`, or warmer.
fn next_value(covariate: &Covariate, like: usize, warmer_k: f64) -> f64 {
    let values = &covariate.values;
    if covariate.name == TIME {
        let last = values[values.len() - 1];
        let pace = (last - values[0]) / crate::statistics::ratio(values.len().max(2) - 1);
        return last + pace;
    }
    let rise = if covariate.quantity == Quantity::Temperature { warmer_k } else { 0.0 };
    values[like] + rise
}

fn numbers<const D: usize>(vector: &SVector<f64, D>) -> String {
    vector.iter().map(|v| format!("{v:.2}")).collect::<Vec<_>>().join(", ")
}
