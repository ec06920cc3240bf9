//! Further presses and standards that would split what the presses at hand confuse.

use std::f64::consts::FRAC_PI_2;

use geometry::Wrench;
use model_discrepancy::{Model, Proposal, Role};
use nalgebra::{Point2, Point3, Vector3};

use crate::missing::press_design::{PressPoint, Standard, load_n};
use crate::missing::press_model::PressModel;
use crate::pressure::pressure_point;

/// Loads of neighbouring size count as different levels from this ratio on.
const LEVEL_RATIO: f64 = 1.2;

/// Load of a proposed press over the largest one so far.
const LOAD_RATIO: f64 = 2.0;

/// Distance of a proposed press from the centroid over that of the press it repeats.
const DISTANCE_RATIO: f64 = 2.0;

/// Lateral force of a proposed press over its load: a head tilted by 11°.
const LATERAL_RATIO: f64 = 0.2;

/// Standard uncertainty of a known weight over its size: a class M1 weight.
const WEIGHT_RATIO: f64 = 5e-5;

/// Standard uncertainty of an interferometer over the length measured, in air of known
/// temperature and pressure.
const TRAVEL_RATIO: f64 = 1e-6;

/// Standard uncertainty of locating the sensor's reference point with a touch probe: housings
/// give it to a few tenths.
const DATUM_MM: f64 = 0.2;

/// The cheapest first.
pub(crate) fn proposals(model: &PressModel) -> Vec<Proposal<'_>> {
    let presses = fitted(model);
    if presses.is_empty() {
        return Vec::new();
    }
    let levels = levels(&presses);
    let another = match levels {
        1 => "press at a second load",
        2 => "press at a third load",
        _ => "press at a load beyond those used",
    };
    let largest_n = largest_n(&presses);
    let reach_mm = presses.iter().map(|p| (p.machine_mm - model.frame.pivot_mm).norm());
    let reach_mm = reach_mm.fold(0.0, f64::max);
    // With one load only, every gain also looks like a bias: a second load comes with the rest.
    let first = if levels == 1 { format!("{another}, and ") } else { String::new() };
    let start = move || if levels == 1 { loaded(model) } else { model.clone() };
    let standard = |text: String, standard: Standard| {
        Proposal::new(text, move || Some(with_standard(start(), standard)))
    };
    vec![
        Proposal::new(another, || Some(loaded(model))),
        Proposal::new("repeat the first press at the end", || {
            Some(with(model, model.points.first().cloned()))
        }),
        Proposal::new("press at positions farther apart", || {
            Some(with(model, fitted(model).into_iter().map(|p| farther(model, p))))
        }),
        Proposal::new(
            format!("{first}press with a lateral force, the head tilted to either side"),
            move || {
                let presses = fitted(model).into_iter().enumerate();
                Some(with(&start(), presses.map(|(i, p)| sideways(model, p, i))))
            },
        ),
        standard(
            format!("{first}put a known weight on the sensor"),
            Standard::Weight { load_n: largest_n, sigma_n: WEIGHT_RATIO * largest_n },
        ),
        standard(
            format!(
                "{first}measure the machine's travel with an independent length standard, e.g. a laser interferometer"
            ),
            Standard::Travel { length_mm: reach_mm, sigma_mm: TRAVEL_RATIO * reach_mm },
        ),
        Proposal::new("locate the sensor's datum in the machine with a touch probe", || {
            Some(with_standard(model.clone(), Standard::Datum { sigma_mm: DATUM_MM }))
        }),
    ]
}

/// The presses that are fitted.
fn fitted(model: &PressModel) -> Vec<&PressPoint> {
    (model.points.iter().zip(&model.declared().layout.groups))
        .filter(|(_, group)| group.role == Role::Fit)
        .map(|(point, _)| point)
        .collect()
}

fn largest_n(presses: &[&PressPoint]) -> f64 {
    presses.iter().map(|p| load_n(p)).fold(0.0, f64::max)
}

/// Every press again, at one load beyond those used.
fn loaded(model: &PressModel) -> PressModel {
    let presses = fitted(model);
    let load_n = LOAD_RATIO * largest_n(&presses);
    with(model, presses.into_iter().map(|p| heavier(p, load_n)))
}

fn with_standard(mut model: PressModel, standard: Standard) -> PressModel {
    model.add_standard(standard);
    model.shown_anew()
}

fn with(model: &PressModel, points: impl IntoIterator<Item = PressPoint>) -> PressModel {
    let mut extended = model.clone();
    let n = crate::count(model.points.len().max(1));
    for (i, mut point) in points.into_iter().enumerate() {
        // They come after everything so far.
        point.reading.elapsed_ratio = 1.0 + crate::count(i + 1) / n;
        point.come = model.come(point.reading.elapsed_ratio);
        extended.add_point(point);
    }
    extended.shown_anew()
}

/// Different loads among the presses.
fn levels(points: &[&PressPoint]) -> usize {
    let mut loads: Vec<_> = points.iter().map(|p| load_n(p)).collect();
    loads.sort_by(f64::total_cmp);
    1 + loads.windows(2).filter(|w| w[1] > LEVEL_RATIO * w[0]).count()
}

/// The same press under another load; its centre is taken to be no better known, so that a
/// proposal counts for what it splits and not for being one more press.
fn heavier(point: &PressPoint, load_n_wanted: f64) -> PressPoint {
    let ratio = load_n_wanted / load_n(point);
    let mut heavier = point.clone();
    heavier.reading.wrench = point.reading.wrench * ratio;
    heavier
}

fn farther(model: &PressModel, point: &PressPoint) -> PressPoint {
    let pivot_mm = model.frame.pivot_mm;
    let machine_mm = pivot_mm + (point.machine_mm - pivot_mm) * DISTANCE_RATIO;
    let sensor_mm = model.frame.sensor_from_machine().apply(&machine_mm);
    let force_n = point.reading.wrench.force_n;
    let mut farther = PressPoint { machine_mm, ..point.clone() };
    farther.reading.wrench = Wrench::of_force(force_n, &on_platform(model, sensor_mm));
    farther
}

/// A lateral force more at the same point, in a direction that turns with `index`.
fn sideways(model: &PressModel, point: &PressPoint, index: usize) -> PressPoint {
    let angle = FRAC_PI_2 * crate::count(index);
    let push_n = LATERAL_RATIO * load_n(point);
    let force_n = Vector3::new(push_n * angle.cos(), push_n * angle.sin(), 0.0);
    let center_mm = pressure_point(&point.reading.wrench, model.design.z0_mm).position_mm;
    let mut tilted = point.clone();
    tilted.reading.wrench += Wrench::of_force(force_n, &on_platform(model, center_mm));
    tilted
}

fn on_platform(model: &PressModel, sensor_mm: Point2<f64>) -> Point3<f64> {
    Point3::new(sensor_mm.x, sensor_mm.y, model.design.z0_mm)
}
