//! What a transform leaves out: the catalogue of effects.
//!
//! An effect moves the prediction: a positive amplitude is a `to` point that lies further along
//! the effect than declared, so the residual `to − T(from)` grows with it. Scales, shears, sag
//! and expansion deform the source frame before the transform; shift, rotation, drift and bad
//! points act in the target frame after it. A reflection is a candidate only where the points fit
//! a mirrored frame decisively better: nothing short of a whole mirror is one.

mod bodies;
mod optics;
mod sessions;

use std::collections::HashMap;

use model_discrepancy::{Covariate, Effect, Parameter, Quantity, Role, Scope};
use nalgebra::SVector;

use crate::MeasuredPoint;
use crate::Transform;
use crate::missing::term::Term;
use crate::motion::axis_pairs;
use crate::spread::Spread;
use crate::statistics::ratio;

/// Reference temperature of dimensional measurement, ISO 1.
const REFERENCE_C: f64 = 20.0;
/// Name of the column that times the points.
pub(crate) const TIME: &str = "time_s";
/// Beginning of the columns that are 1 for the points of one session and 0 for all others.
pub(crate) const SESSION: &str = "session: ";
/// Beyond this many times their spread the points no longer tell a deformation about the origin
/// from one about their centroid with a shift: the difference is under 1 % of the effect.
const FAR: f64 = 10.0;

const AXES: [&str; 3] = ["x", "y", "z"];

/// An effect as the loop sees it, and what it does.
#[derive(Clone, Debug)]
pub(crate) struct Entry<const D: usize> {
    pub(crate) effect: Effect,
    pub(crate) term: Term<D>,
}

/// The catalogue for `points` under `transform`; the fitted ones are `spread`.
pub(crate) fn catalogue<const D: usize>(
    transform: Transform,
    points: &[MeasuredPoint<D>],
    spread: &Spread<D>,
    covariates: &[Covariate],
    mirrored: bool,
) -> Vec<Entry<D>> {
    let fixed_mm = fixed_point(transform, spread);
    let mut entries = Vec::new();
    if mirrored {
        entries.push(reflection(fixed_mm, spread));
    }
    if !transform.has_translation() {
        entries.push(shift());
    }
    if !transform.has_rotation() {
        entries.push(rotation(fixed_mm));
    }
    if transform < Transform::Similarity {
        entries.push(scale(fixed_mm));
    }
    if transform < Transform::Affine {
        entries.push(anisotropic_scale(fixed_mm));
        entries.push(shear(fixed_mm));
    }
    entries.extend(bad_points(points));
    entries.push(drift(points.len(), covariates));
    entries.push(sag(transform, spread.centroid_mm.coords));
    entries.extend(temperatures(transform, points, covariates));
    entries.extend(sessions::sessions(transform, points, covariates));
    entries.extend(optics::distortions(points, spread));
    entries.extend(bodies::sub_assembly(points));
    entries
}

/// The point of the source frame that rotations, scales and shears leave where it is.
///
/// Where the transform has a translation this is a matter of conditioning only, and the centroid
/// is best. Without one the frames share their origin, and that is the fixed point, unless it is
/// too far away to matter.
pub(crate) fn fixed_point<const D: usize>(
    transform: Transform,
    spread: &Spread<D>,
) -> SVector<f64, D> {
    let centroid_mm = spread.centroid_mm.coords;
    let far = centroid_mm.norm() > FAR * spread.rms_mm.norm();
    if transform.has_translation() || far { centroid_mm } else { SVector::zeros() }
}

fn entry<const D: usize>(
    id: &str,
    description: &str,
    parameters: Vec<Parameter>,
    term: Term<D>,
) -> Entry<D> {
    let effect = Effect::new(id, description, parameters).within(scope(&term));
    Entry { effect, term }
}

/// What a term moves: planes, lines and a column that stands still show nothing of some.
fn scope<const D: usize>(term: &Term<D>) -> Scope {
    match term {
        Term::BadPoint { observation } => Scope::Observation(*observation),
        Term::Shift | Term::Reflection { .. } | Term::Scale { .. } => Scope::Everywhere,
        _ => Scope::SomeDesigns,
    }
}

fn parameter(name: impl Into<String>, unit: &str, report_factor: f64) -> Parameter {
    Parameter { name: name.into(), unit: unit.to_owned(), report_factor }
}

/// One parameter per axis.
fn per_axis<const D: usize>(unit: &str, report_factor: f64) -> Vec<Parameter> {
    AXES[..D].iter().map(|axis| parameter(*axis, unit, report_factor)).collect()
}

fn shift<const D: usize>() -> Entry<D> {
    let text = "the target frame is shifted against the source frame";
    entry("shift", text, per_axis::<D>("mm", 1.0), Term::Shift)
}

fn rotation<const D: usize>(pivot_mm: SVector<f64, D>) -> Entry<D> {
    let text = "the target frame is rotated against the source frame";
    let names = if D == 2 { &["rz"][..] } else { &["rx", "ry", "rz"][..] };
    let parameters = names.iter().map(|name| parameter(*name, "µrad", 1e6)).collect();
    entry("rotation", text, parameters, Term::Rotation { pivot_mm })
}

/// Mirrors along the direction in which the points extend least: there a proper fit is nearest to
/// the improper one.
fn reflection<const D: usize>(fixed_mm: SVector<f64, D>, spread: &Spread<D>) -> Entry<D> {
    let text = "one frame is mirrored: an axis points the other way";
    let normal = spread.directions.column(D - 1).into_owned();
    let parameters = vec![parameter("mirrored", "1", 1.0)];
    entry("reflection", text, parameters, Term::Reflection { fixed_mm, normal })
}

fn scale<const D: usize>(fixed_mm: SVector<f64, D>) -> Entry<D> {
    let text = "the two frames differ in scale";
    entry("scale", text, vec![parameter("scale", "ppm", 1e6)], Term::Scale { fixed_mm })
}

/// An axis that is off by its whole length is mirrored, or in another unit.
const NO_SCALE: f64 = 1.0;

fn anisotropic_scale<const D: usize>(fixed_mm: SVector<f64, D>) -> Entry<D> {
    let text = "the axes of the source frame differ in scale from those of the target frame, \
                each by its own amount";
    let parameters = per_axis::<D>("ppm", 1e6);
    let mut entry =
        entry("anisotropic-scale", text, parameters, Term::AnisotropicScale { fixed_mm });
    entry.effect.maximum = Some(NO_SCALE);
    entry
}

fn shear<const D: usize>(fixed_mm: SVector<f64, D>) -> Entry<D> {
    let text = "the axes of the source frame are not square to each other";
    let parameters = axis_pairs(D)
        .map(|(a, b)| parameter(format!("{}{}", AXES[a], AXES[b]), "µrad", 1e6))
        .collect();
    entry("shear", text, parameters, Term::Shear { fixed_mm })
}

fn bad_points<const D: usize>(points: &[MeasuredPoint<D>]) -> Vec<Entry<D>> {
    let mut times: HashMap<&str, usize> = HashMap::new();
    let counted = points.iter().enumerate().map(|(observation, point)| {
        let time = times.entry(&point.name).or_default();
        *time += 1;
        (observation, point, *time)
    });
    counted
        .filter(|(_, point, _)| point.role == Role::Fit)
        .map(|(observation, point, time)| {
            let subject = match time {
                1 => point.name.clone(),
                n => format!("{} ({n})", point.name),
            };
            let text = format!("point {subject} is off on its own");
            let parameters = per_axis::<D>("mm", 1.0);
            let mut entry = entry("bad-point", &text, parameters, Term::BadPoint { observation });
            entry.effect.subject = Some(subject);
            entry
        })
        .collect()
}

fn drift<const D: usize>(count: usize, covariates: &[Covariate]) -> Entry<D> {
    let text = "the target frame drifts against the source frame while the points are measured";
    let Passed { elapsed, unit, report_factor, driver } = passed(count, covariates);
    let mut entry =
        entry("drift", text, per_axis::<D>(unit, report_factor), Term::Drift { elapsed });
    entry.effect.driver = driver;
    entry
}

/// What has passed since the first of a series, and how an amplitude per unit of it is reported.
pub(crate) struct Passed {
    pub(crate) elapsed: Vec<f64>,
    pub(crate) unit: &'static str,
    pub(crate) report_factor: f64,
    pub(crate) driver: Option<String>,
}

/// Time where it is recorded, else the order.
pub(crate) fn passed(count: usize, covariates: &[Covariate]) -> Passed {
    if let Some(time) = covariates.iter().find(|c| c.name == TIME) {
        let start = time.values.first().copied().unwrap_or(0.0);
        let elapsed = time.values.iter().map(|t| t - start).collect();
        return Passed {
            elapsed,
            unit: "mm/h",
            report_factor: 3600.0,
            driver: Some(TIME.to_owned()),
        };
    }
    // Internally per step, so that a longer series has the same parameter; reported over all.
    let whole = ratio(count.saturating_sub(1).max(1));
    let elapsed = (0..count).map(ratio).collect();
    Passed { elapsed, unit: "mm", report_factor: whole, driver: None }
}

fn sag<const D: usize>(transform: Transform, centroid_mm: SVector<f64, D>) -> Entry<D> {
    let text = "the part or the machine sags: a deflection downwards that is quadratic in the \
                horizontal position";
    // 1/mm is a billion µm/m².
    let quadratic = |name: &str| parameter(name, "µm/m²", 1e9);
    let mut parameters = if D == 2 {
        vec![quadratic("xx")]
    } else {
        vec![quadratic("xx"), quadratic("xy"), quadratic("yy")]
    };
    // The deflection need not be level above the centroid: a rotation would take up its slope, but
    // move the points sideways, which a shear would then have to repair.
    let slope = |name: &str| parameter(name, "µm/m", 1e6);
    parameters.extend(AXES[..D - 1].iter().map(|axis| slope(&format!("slope {axis}"))));
    // Without a translation nothing takes up where the deflection is zero.
    let level = !transform.has_translation();
    if level {
        parameters.push(parameter("level", "mm", 1.0));
    }
    entry("sag", text, parameters, Term::Sag { centroid_mm, level })
}

fn temperatures<const D: usize>(
    transform: Transform,
    points: &[MeasuredPoint<D>],
    covariates: &[Covariate],
) -> Vec<Entry<D>> {
    let columns: Vec<_> =
        covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
    let several = columns.len() > 1;
    columns
        .into_iter()
        .map(|column| {
            let text = format!("thermal expansion with {} between the two frames", column.name);
            let excess_k: Vec<f64> = column.values.iter().map(|t| t - REFERENCE_C).collect();
            let mut parameters = vec![parameter("expansion", "ppm/K", 1e6)];
            let mut term = expansion(transform, points, excess_k);
            // Where what grows stays, nobody knows.
            if let (true, Term::Expansion { excess_k, about_any, .. }) =
                (transform.has_translation(), &mut term)
            {
                *about_any = Some(mean_excess(points, excess_k));
                let shift = |axis: &&str| parameter(format!("shift {axis}"), "µm/K", 1e3);
                parameters.extend(AXES.iter().take(D).map(shift));
            }
            let mut entry = entry("temperature", &text, parameters, term);
            entry.effect.subject = several.then(|| column.name.clone());
            entry.effect.driver = Some(column.name.clone());
            entry
        })
        .collect()
}

/// An expansion about the origin; less its mean over the fitted points, where a translation takes that.
pub(super) fn expansion<const D: usize>(
    transform: Transform,
    points: &[MeasuredPoint<D>],
    excess_k: Vec<f64>,
) -> Term<D> {
    let constant_mm =
        if transform.has_translation() { mean_growth(points, &excess_k) } else { SVector::zeros() };
    Term::Expansion { excess_k, constant_mm, about_any: None }
}

/// Mean over the fitted points.
fn mean_excess<const D: usize>(points: &[MeasuredPoint<D>], excess_k: &[f64]) -> f64 {
    let fitted = points.iter().zip(excess_k).filter(|(p, _)| p.role == Role::Fit);
    let (sum, count) = fitted.fold((0.0, 0.0), |(sum, n), (_, excess)| (sum + excess, n + 1.0));
    sum / f64::max(count, 1.0)
}

/// Mean over the fitted points of what an expansion of 1/K moves them.
fn mean_growth<const D: usize>(points: &[MeasuredPoint<D>], excess_k: &[f64]) -> SVector<f64, D> {
    let mut mean = SVector::zeros();
    let mut count = 0.0;
    for (point, excess) in points.iter().zip(excess_k).filter(|(p, _)| p.role == Role::Fit) {
        count += 1.0;
        mean += (point.pair.source_mm.coords * *excess - mean) / count;
    }
    mean
}
