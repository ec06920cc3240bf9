//! Further measurements that would tell effects apart or make them visible.

use std::f64::consts::FRAC_PI_2;

use model_discrepancy::{Proposal, Quantity, Role};
use nalgebra::{Matrix2, Point2, Point3, Vector3};

use super::effects::{TIME, ratio};
use super::measured::MeasuredTouch;
use super::model::{PoseModel, Standard};
use crate::{LateralPrior, PoseOptions, PoseStart, Touch};

/// Standard uncertainty of a tip's radius from a calibrated sphere or ring.
const TIP_MM: f64 = 5e-4;
/// Standard uncertainty of a vertex radius, as a share: an interferometer on a radius bench.
const RADIUS_RATIO: f64 = 1e-5;
/// Standard uncertainty of a scale from a laser interferometer in known air.
const SCALE_RATIO: f64 = 1e-6;
/// Standard uncertainty of a squareness from an angle standard turned over.
const SQUARE_RAD: f64 = 2e-6;
/// Touches repeated at the end, enough to average their noise.
const REPEATED: usize = 3;
/// Touches of a proposed ring.
const RING: usize = 12;
/// Radius of the proposed ring over that of the aperture: the ball has to stay on the part.
const RING_RATIO: f64 = 0.98;
/// A change of temperature that a workshop can make.
const WARMER_K: f64 = 5.0;

/// Further measurements, the cheapest first.
pub(crate) fn proposals(model: &PoseModel) -> Vec<Proposal<'_>> {
    let n = model.touches.len();
    let touched = |text: &str, which: Vec<usize>, warmer_k: f64| {
        Proposal::new(text, move || again(model, &which, warmer_k))
    };
    let known =
        |text: &str, known: Vec<Known>| Proposal::new(text, move || with_standard(model, &known));
    let of = |effect: &'static str, names: [&'static str; 3], sigma: f64| {
        names.into_iter().map(|name| (effect, name, sigma)).collect()
    };
    let first = (0..REPEATED.min(n)).collect();
    let mut list = vec![touched("touch the first points again at the end", first, 0.0)];
    if model.options.lateral.is_none() {
        list.push(Proposal::new("touch the part's side at four points (edge.csv)", || {
            with_sides(model)
        }));
    }
    list.push(Proposal::new("touch a ring of points near the rim", || with_ring(model)));
    list.push(known(
        "calibrate the tip on a reference sphere or ring",
        vec![("tip-radius", "radius", TIP_MM)],
    ));
    if let Some(shape) = model.part.shape() {
        let sigma_mm = RADIUS_RATIO * shape.radius_mm.abs();
        list.push(known(
            "measure the vertex radius by other means, e.g. an interferometer on a radius bench",
            vec![("vertex-radius", "radius", sigma_mm)],
        ));
    }
    list.push(known(
        "measure the machine's travel with an independent length standard, e.g. a laser interferometer",
        of("axis-scale", ["x", "y", "z"], SCALE_RATIO),
    ));
    list.push(known(
        "measure the machine's squareness with an angle standard",
        of("squareness", ["xy", "xz", "yz"], SQUARE_RAD),
    ));
    list.push(touched(
        "touch all points a second time, in reverse order",
        (0..n).rev().collect(),
        0.0,
    ));
    if model.covariates.iter().any(|c| c.quantity == Quantity::Temperature) {
        list.push(touched("touch all points again, 5 K warmer", (0..n).collect(), WARMER_K));
    }
    list.push(Proposal::new("turn the part by 90° about its axis and touch it again", || {
        turned(model)
    }));
    list
}

/// Effect, parameter and standard uncertainty of what a standard tells.
type Known = (&'static str, &'static str, f64);

/// The model with further touches; only their design matters.
fn extended(
    model: &PoseModel,
    starts: &[PoseStart],
    planned: Vec<(Point3<f64>, usize, usize, f64)>,
    options: &PoseOptions,
    standards: Vec<Standard>,
) -> Option<PoseModel> {
    let mut touches = model.touches.clone();
    let mut covariates = model.covariates.clone();
    let mut setup_of = model.setup_of.clone();
    for (n, (center_mm, like, setup, warmer_k)) in planned.into_iter().enumerate() {
        let sigma_mm = model.touches.get(like)?.touch.sigma_mm;
        let name = format!("proposed {}", n + 1);
        let touch = Touch { center_mm, sigma_mm };
        touches.push(MeasuredTouch { group: name.clone(), name, role: Role::Fit, touch });
        setup_of.push(setup);
        for covariate in &mut covariates {
            let values = &covariate.values;
            let value = if covariate.name == TIME {
                let last = *values.last()?;
                last + (last - values[0]) / ratio(values.len().max(2) - 1)
            } else {
                let rise = if covariate.quantity == Quantity::Temperature { warmer_k } else { 0.0 };
                values[like] + rise
            };
            covariate.values.push(value);
        }
    }
    let part = model.part.clone();
    let extended =
        PoseModel::about(part, touches, covariates, starts, setup_of, options, standards);
    Some(extended.ok()?.with_shown(model.shown.clone()))
}

fn starts(model: &PoseModel) -> Vec<PoseStart> {
    model.setups.iter().map(|s| s.reference.pose()).collect()
}

fn again(model: &PoseModel, which: &[usize], warmer_k: f64) -> Option<PoseModel> {
    let planned = (which.iter())
        .map(|&i| (model.touches[i].touch.center_mm, i, model.setup_of[i], warmer_k))
        .collect();
    extended(model, &starts(model), planned, &model.options, vec![])
}

fn with_standard(model: &PoseModel, known: &[Known]) -> Option<PoseModel> {
    let standard = |&(effect, parameter, sigma): &Known| Standard { effect, parameter, sigma };
    let standards = known.iter().map(standard).collect();
    extended(model, &starts(model), vec![], &model.options, standards)
}

fn with_sides(model: &PoseModel) -> Option<PoseModel> {
    let pose = model.setups[0].reference.pose();
    let sigma_mm = model.touches.first()?.touch.sigma_mm;
    let prior = LateralPrior {
        at_z_mm: pose.position_mm.z,
        center_mm: Point2::new(pose.position_mm.x, pose.position_mm.y),
        covariance_mm2: Matrix2::identity() * (0.5 * sigma_mm * sigma_mm),
    };
    let options = PoseOptions { lateral: Some(prior), ..model.options.clone() };
    extended(model, &starts(model), vec![], &options, vec![])
}

fn with_ring(model: &PoseModel) -> Option<PoseModel> {
    let shape = model.part.shape()?;
    let radius_mm = 0.5 * RING_RATIO * shape.diameter_mm;
    let center = shape.aperture_center_mm;
    let at = |i: usize| {
        let angle = std::f64::consts::TAU * ratio(i) / ratio(RING);
        let (x, y) = (center.x + radius_mm * angle.cos(), center.y + radius_mm * angle.sin());
        on_surface(model, 0, x, y).map(|p| (p, 0, 0, 0.0))
    };
    let planned = (0..RING).map(at).collect::<Option<Vec<_>>>()?;
    extended(model, &starts(model), planned, &model.options, vec![])
}

/// The part turned by 90° in a second clamping, touched at the same points of the machine.
fn turned(model: &PoseModel) -> Option<PoseModel> {
    let mut poses = starts(model);
    let mut second = *poses.first()?;
    second.angles.gamma_rad += FRAC_PI_2;
    poses.push(second);
    let rotation = poses[0].machine_from_workpiece();
    let turned = second.machine_from_workpiece();
    let planned = (0..model.touches.len())
        .map(|i| {
            // The same place of the machine, as it is on the part in its second clamping.
            let local = rotation.inverse_transform_point(&model.touches[i].touch.center_mm);
            let onto = Point3::from(Vector3::new(local.y, -local.x, local.z));
            (turned * onto, i, 1, 0.0)
        })
        .collect();
    extended(model, &poses, planned, &model.options, vec![])
}

/// Centre of the ball that touches the part above (x, y) of the workpiece.
fn on_surface(model: &PoseModel, setup: usize, x: f64, y: f64) -> Option<Point3<f64>> {
    let foot = model.part.surface().closest_point(&Point3::new(x, y, 0.0)).ok()?;
    let center = foot.point_mm + foot.normal.into_inner() * model.options.tip.signed_radius_mm();
    let pose = model.setups[setup].reference.pose();
    Some(pose.machine_from_workpiece() * center)
}
