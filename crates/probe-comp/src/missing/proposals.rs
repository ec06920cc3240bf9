//! Further measurements that would tell effects apart or make them visible.

use std::f64::consts::FRAC_PI_3;

use model_discrepancy::{Covariate, Model, Proposal, Quantity, Role};
use nalgebra::{Rotation3, Unit, Vector3};

use super::catalogue::{ABOUT_THE_PART, AXES};
use super::columns::{TIME, as_f64, feed};
use super::measured::MeasuredTouch;
use super::model::{ProbeModel, Standard};

/// Standard uncertainty of a ball's radius measured by itself.
const BALL_MM: f64 = 2e-4;
/// Standard uncertainty of a scale from a laser interferometer in known air.
const SCALE_RATIO: f64 = 1e-6;
/// Standard uncertainty of a squareness from an angle standard turned over.
const SQUARE_RAD: f64 = 2e-6;
/// Standard uncertainty of the part's form by other means, e.g. an interferometer.
const FORM_MM: f64 = 2e-4;
/// Touches repeated at the end, enough to average their noise.
const REPEATED: usize = 3;
/// A change of temperature that a workshop can make.
const WARMER_K: f64 = 5.0;
/// Feed of a proposed slow touch over the one recorded.
const SLOW: f64 = 0.25;
/// Feeds of a proposal where none is recorded, mm/min.
const FEEDS_MM_PER_MIN: [f64; 2] = [100.0, 25.0];
/// Angle between the normal and a proposed oblique approach, rad.
const OBLIQUE_RAD: f64 = 0.5;

/// How touches are repeated.
#[derive(Clone, Copy)]
struct Repeat {
    warmer_k: f64,
    feed_ratio: f64,
    spindle_rad: f64,
    oblique: bool,
}

const AS_BEFORE: Repeat =
    Repeat { warmer_k: 0.0, feed_ratio: 1.0, spindle_rad: 0.0, oblique: false };

/// Further measurements, the cheapest first.
pub(crate) fn proposals(model: &ProbeModel) -> Vec<Proposal<'_>> {
    let n = model.touches.len();
    let touched = |text: &str, which: Vec<usize>, how: Repeat| {
        Proposal::new(text, move || again(model, &which, how))
    };
    let known = |text: &str, standards: Vec<Standard>| {
        Proposal::new(text, move || with_standards(model, standards.clone()))
    };
    let of = |effect: &'static str, names: &[&'static str], sigma: f64| {
        let of = |&parameter: &&'static str| Standard { effect, subject: None, parameter, sigma };
        names.iter().map(of).collect::<Vec<_>>()
    };
    let effects = &model.declared().effects;
    let is_there = |(subject, _): &(&str, &str)| {
        effects.iter().any(|e| e.id == "axis-scale" && e.subject.as_deref() == Some(*subject))
    };
    let scales = AXES.into_iter().zip(AXES).chain(ABOUT_THE_PART.into_iter().zip(AXES));
    let axes = scales.filter(is_there).map(|(subject, axis)| Standard {
        effect: "axis-scale",
        subject: Some(subject),
        parameter: axis,
        sigma: SCALE_RATIO,
    });
    let mut list = vec![
        touched(
            "touch the first points again at the end",
            (0..REPEATED.min(n)).collect(),
            AS_BEFORE,
        ),
        Proposal::new(
            "touch the points again at a quarter of the feed (column feed_mm_per_min)",
            move || slower(model, &(0..n).collect::<Vec<_>>()),
        ),
        touched(
            "turn the probe by 60° in its spindle and touch the points again (column spindle_deg)",
            (0..n).collect(),
            Repeat { spindle_rad: FRAC_PI_3, ..AS_BEFORE },
        ),
        touched(
            "touch the points again from other directions, 30° off the normal (columns nx, ny, nz)",
            (0..n).collect(),
            Repeat { oblique: true, ..AS_BEFORE },
        ),
        known(
            "measure the ball by itself, e.g. between gauge blocks",
            of("tip-radius", &["radius"], BALL_MM),
        ),
        known(
            "measure the machine's travel with an independent length standard, e.g. a laser interferometer",
            axes.collect(),
        ),
        known(
            "measure the machine's squareness with an angle standard",
            of("squareness", &["xy", "xz", "yz"], SQUARE_RAD),
        ),
        touched(
            "touch all points a second time, in reverse order",
            (0..n).rev().collect(),
            AS_BEFORE,
        ),
    ];
    if model.covariates.iter().any(|c| c.quantity == Quantity::Temperature) {
        let warmer = Repeat { warmer_k: WARMER_K, ..AS_BEFORE };
        list.push(touched("touch all points again, 5 K warmer", (0..n).collect(), warmer));
    }
    list.push(known("measure the part's form by other means", forms(model)));
    list
}

/// The model with further touches; only their design matters.
fn again(model: &ProbeModel, which: &[usize], how: Repeat) -> Option<ProbeModel> {
    extended(model, model.covariates.clone(), which, how)
}

fn slower(model: &ProbeModel, which: &[usize]) -> Option<ProbeModel> {
    let mut covariates = model.covariates.clone();
    let mut how = Repeat { feed_ratio: SLOW, ..AS_BEFORE };
    if feed(&covariates).is_none() {
        covariates.push(Covariate::recorded(
            "feed_mm_per_min",
            Quantity::Other,
            vec![FEEDS_MM_PER_MIN[0]; model.touches.len()],
        ));
        how.feed_ratio = FEEDS_MM_PER_MIN[1] / FEEDS_MM_PER_MIN[0];
    }
    extended(model, covariates, which, how)
}

fn extended(
    model: &ProbeModel,
    mut covariates: Vec<Covariate>,
    which: &[usize],
    how: Repeat,
) -> Option<ProbeModel> {
    let mut touches = model.touches.clone();
    let feed = feed(&covariates).map(|(column, _)| column.name.clone());
    for (n, &like) in which.iter().enumerate() {
        let mut touch = model.touches.get(like)?.touch.clone();
        touch.spindle_rad += how.spindle_rad;
        if how.oblique {
            touch.approach = Some(oblique(model, like));
        }
        let name = format!("proposed {}", n + 1);
        touches.push(MeasuredTouch { group: name.clone(), name, role: Role::Fit, touch });
        for covariate in &mut covariates {
            let values = &covariate.values;
            let value = if covariate.name == TIME {
                let last = *values.last()?;
                last + (last - values[0]) / as_f64(values.len().max(2) - 1)
            } else if Some(&covariate.name) == feed.as_ref() {
                values[like] * how.feed_ratio
            } else {
                let rise =
                    if covariate.quantity == Quantity::Temperature { how.warmer_k } else { 0.0 };
                values[like] + rise
            };
            covariate.values.push(value);
        }
    }
    let setup = model.setup.clone();
    let extended = ProbeModel::with_standards(setup, touches, covariates, Vec::new());
    Some(extended.ok()?.with_shown(model.shown.clone()))
}

/// The way to the part, tilted about a tangent that turns from touch to touch.
fn oblique(model: &ProbeModel, index: usize) -> Unit<Vector3<f64>> {
    // The golden angle: neighbours are approached from everywhere.
    const TURN_RAD: f64 = 2.399_963;
    let normal = model.feet[index].normal;
    let tangent = Unit::new_normalize(normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
    let axis = Rotation3::from_axis_angle(&normal, TURN_RAD * as_f64(index)) * tangent;
    Rotation3::from_axis_angle(&axis, OBLIQUE_RAD) * -normal
}

fn with_standards(model: &ProbeModel, standards: Vec<Standard>) -> Option<ProbeModel> {
    let (setup, touches) = (model.setup.clone(), model.touches.clone());
    let known = ProbeModel::with_standards(setup, touches, model.covariates.clone(), standards);
    Some(known.ok()?.with_shown(model.shown.clone()))
}

fn forms(model: &ProbeModel) -> Vec<Standard> {
    let families = super::form::Form::OVER.iter().chain(&super::form::Form::AROUND);
    let is_known = |form: &&super::form::Form| {
        use model_discrepancy::Model;
        let effects = model.declared().effects.iter();
        effects.into_iter().any(|e| (e.id.as_str(), e.subject.as_deref()) == form.id())
    };
    families
        .filter(is_known)
        .flat_map(|form| {
            form.parameters().iter().map(|&parameter| Standard {
                effect: form.id().0,
                subject: form.id().1,
                parameter,
                sigma: FORM_MM,
            })
        })
        .chain(model.shown.patches.first().map(|_| Standard {
            effect: "patch",
            subject: None,
            parameter: "height",
            sigma: FORM_MM,
        }))
        .collect()
}
