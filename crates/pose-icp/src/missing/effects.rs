//! What a pose leaves out: the catalogue of effects.
//!
//! A positive amplitude is a ball that is larger, a surface that is higher, a reading that is
//! longer than declared.

use model_discrepancy::{Quantity, Role};
use nalgebra::Vector3;

use super::entry::{AXES, Entry, Setting, entry, parameter};
use super::form::Form;
use super::measured::MeasuredTouch;
use super::reversal::reversals;
use super::setup::reported;
use super::term::Term;
use crate::PoseParameter;

/// Reference temperature of dimensional measurement, ISO 1.
const REFERENCE_C: f64 = 20.0;
/// Name of the column that times the touches.
pub(crate) const TIME: &str = "time_s";
/// Mean square of a normal's component from which a drift along that axis can be told: below it,
/// the touches see less than a fifth of it.
const SEEN_DRIFT: f64 = 0.04;
/// How far from where it was a part lies at least that is clamped anew, roughly: flat ones show that.
const CLAMPED_MM: f64 = 0.1;
/// Subject of a drift whose sideways part only a gross one shows.
const SIDEWAYS: &str = "sideways";

/// No machine is further out of square than this.
const GROSS_RAD: f64 = 1e-3;
/// No axis reads longer than this, even without any compensation, and no axes are further out of
/// square: what needs more is no error of the machine. A hundredth.
const NO_MACHINE: f64 = 1e-2;
/// No part is made with another conic constant by more: a sphere in place of a paraboloid has one.
const NO_PART: f64 = 1.0;
/// What a touch can show at all, unless its noise is less.
const SEEN_MM: f64 = 1e-3;

/// The catalogue.
pub(crate) fn catalogue(setting: &Setting<'_>) -> Vec<Entry> {
    let mut entries = pose(setting);
    let text = "the probe's ball is larger than declared";
    entries.push(entry("tip-radius", text, vec![parameter("radius", "mm", 1.0)], Term::Tip));
    if setting.part.shape().is_some() {
        entries.push(entry(
            "vertex-radius",
            "the vertex radius of the part is longer than declared",
            vec![parameter("radius", "mm", 1.0)],
            Term::Form(Form::VertexRadius),
        ));
        let mut conic = entry(
            "conic",
            "the conic constant of the part is larger than declared",
            vec![parameter("conic", "1", 1.0)],
            Term::Form(Form::Conic),
        );
        conic.effect.maximum = Some(NO_PART);
        entries.push(conic);
    } else {
        let text = "the part is bent more than declared, alike in all directions";
        let parameters = vec![parameter("height", "µm", 1e3)];
        let text = &at_radius(text, setting);
        entries.push(entry("focus", text, parameters, Term::Form(Form::Focus)));
    }
    for (id, text, form) in [
        ("astigmatism", "the part is bent like a saddle", Form::Astigmatism),
        ("coma", "the part has coma", Form::Coma),
        ("trefoil", "the part is bent with three lobes", Form::Trefoil),
    ] {
        let parameters = vec![parameter("cos", "µm", 1e3), parameter("sin", "µm", 1e3)];
        entries.push(entry(id, &at_radius(text, setting), parameters, Term::Form(form)));
    }
    if setting.machine_axes {
        entries.extend(diagonal_saddle(setting));
        entries.extend(scales(setting.center_mm));
        entries.push(squareness(setting));
        entries.extend(reversals(setting));
    }
    entries.extend(drifts(setting));
    entries.extend(temperatures(setting));
    entries.extend(bad_points(setting.touches));
    entries
}

/// A form with the place where its height counts, without which its amplitude says nothing.
fn at_radius(text: &str, setting: &Setting<'_>) -> String {
    format!("{text}; height at {:.1} mm from the axis", setting.form_radius_mm)
}

/// What the declared model holds may be wrong; γ of a surface of revolution changes nothing.
fn pose(setting: &Setting<'_>) -> Vec<Entry> {
    use PoseParameter::{Alpha, Beta, Gamma, X, Y, Z};
    let symmetric = setting.part.shape().is_some();
    let families: [(&str, &str, &[PoseParameter]); 4] = [
        ("height", "the part lies higher than declared", &[Z]),
        ("decentre", "the part lies beside where it is declared", &[X, Y]),
        ("tilt", "the part is tilted against its declared pose", &[Alpha, Beta]),
        ("rotation", "the part is turned against its declared pose", &[Gamma]),
    ];
    let mut entries = Vec::new();
    for (id, text, members) in families {
        let held: Vec<PoseParameter> = (members.iter().copied())
            .filter(|p| setting.held.contains(p) && !setting.known.contains(p))
            .filter(|p| !(symmetric && *p == Gamma))
            .collect();
        if held.is_empty() {
            continue;
        }
        let named = |p: &PoseParameter| {
            let (unit, factor) = reported(*p);
            parameter(p.name(), unit, factor)
        };
        let parameters = held.iter().map(named).collect();
        entries.push(entry(
            id,
            text,
            parameters,
            Term::Pose(held.iter().map(|p| *p as usize).collect()),
        ));
    }
    entries
}

/// To touches of a paraboloid a squareness of x and y is such a saddle, exactly: x·y/R. Named
/// apart, the two stand in one class, as a saddle in any direction and a squareness do not.
fn diagonal_saddle(setting: &Setting<'_>) -> Option<Entry> {
    setting.part.shape()?;
    let text = at_radius("the part is bent like a saddle along the machine's diagonals", setting);
    let form = Form::Diagonal { gamma_rad: setting.gamma_rad };
    let mut entry =
        entry("astigmatism", &text, vec![parameter("diagonal", "µm", 1e3)], Term::Form(form));
    entry.effect.subject = Some("diagonal".to_owned());
    Some(entry)
}

/// One candidate per axis: the scale of z alone is a vertex radius to the touches of a paraboloid,
/// and has to be called so.
fn scales(fixed_mm: Vector3<f64>) -> impl Iterator<Item = Entry> {
    AXES.into_iter().enumerate().map(move |(axis, name)| {
        let text = format!("the machine's {name} axis reads long");
        let parameters = vec![parameter(name, "ppm", 1e6)];
        let mut entry = entry("axis-scale", &text, parameters, Term::Scale { fixed_mm, axis });
        entry.effect.subject = Some(name.to_owned());
        entry.effect.maximum = Some(NO_MACHINE);
        entry
    })
}

/// Pairs with z only where the part is steep enough for a gross error to show.
fn squareness(setting: &Setting<'_>) -> Entry {
    let text = "the machine's axes are not square to each other";
    let pairs: Vec<(usize, usize)> = [(0, 1), (0, 2), (1, 2)]
        .into_iter()
        .filter(|&(first, second)| {
            second < 2 || setting.lateral_travel_mm[first] * GROSS_RAD > seen_mm(setting)
        })
        .collect();
    let parameters = (pairs.iter())
        .map(|&(a, b)| parameter(&format!("{}{}", AXES[a], AXES[b]), "µrad", 1e6))
        .collect();
    let fixed_mm = setting.center_mm;
    let mut entry = entry("squareness", text, parameters, Term::Squareness { fixed_mm, pairs });
    entry.effect.maximum = Some(NO_MACHINE);
    entry
}

fn drifts(setting: &Setting<'_>) -> Vec<Entry> {
    let axes = moved_axes(setting);
    let sideways = (0..2).any(|k| !axes.contains(&k) && shows_when_moved(setting, k));
    let mut all = vec![drift(setting, axes)];
    if sideways {
        let mut moved = drift(setting, (0..3).collect());
        moved.effect.subject = Some(SIDEWAYS.to_owned());
        moved.effect.description.push_str(", sideways as well");
        moved.effect.only_instead = true;
        all.push(moved);
    }
    all
}

fn drift(setting: &Setting<'_>, axes: Vec<usize>) -> Entry {
    let text = "the readings drift while the part is touched";
    let named =
        |unit: &str, factor| axes.iter().map(|&k| parameter(AXES[k], unit, factor)).collect();
    if let Some(time) = setting.covariates.iter().find(|c| c.name == TIME) {
        let start = time.values.first().copied().unwrap_or(0.0);
        let elapsed = time.values.iter().map(|t| t - start).collect();
        let parameters = named("µm/h", 3.6e6);
        let mut entry = entry("drift", text, parameters, Term::Drift { elapsed, axes });
        entry.effect.driver = Some(TIME.to_owned());
        return entry;
    }
    // Internally per touch, so that a longer series has the same parameter; reported over all.
    let count = setting.touches.len();
    let elapsed = (0..count).map(ratio).collect();
    let parameters = named("µm", 1e3 * ratio(count.saturating_sub(1).max(1)));
    entry("drift", text, parameters, Term::Drift { elapsed, axes })
}

/// Whether the touches see the part clamped elsewhere along an axis.
fn shows_when_moved(setting: &Setting<'_>, axis: usize) -> bool {
    setting.normal_squares[axis].sqrt() * CLAMPED_MM > seen_mm(setting)
}

/// What a touch sees at least.
fn seen_mm(setting: &Setting<'_>) -> f64 {
    setting.touches.iter().map(|t| t.touch.sigma_mm).fold(SEEN_MM, f64::min)
}

/// Along which the touches see how the part moves; z is one of them.
fn moved_axes(setting: &Setting<'_>) -> Vec<usize> {
    (0..3).filter(|&k| k == 2 || setting.normal_squares[k] > SEEN_DRIFT).collect()
}

fn temperatures(setting: &Setting<'_>) -> Vec<Entry> {
    let columns: Vec<_> =
        setting.covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
    let several = columns.len() > 1;
    let axes = moved_axes(setting);
    (columns.into_iter())
        .map(|column| {
            let text = if axes.len() == 1 {
                format!("the readings of z and the part's size go with {}", column.name)
            } else {
                format!("the part's size, and where its middle is, go with {}", column.name)
            };
            let excess_k = column.values.iter().map(|t| t - REFERENCE_C).collect();
            // Where a part stays as it grows, nobody knows; along z the machine grows too.
            let growth = |&axis: &usize| parameter(&format!("{} growth", AXES[axis]), "µm/K", 1e3);
            let mut parameters: Vec<_> = axes.iter().map(growth).collect();
            parameters.push(parameter("expansion", "ppm/K", 1e6));
            let term = Term::Temperature { excess_k, axes: axes.clone() };
            let mut entry = entry("temperature", &text, parameters, term);
            entry.effect.subject = several.then(|| column.name.clone());
            entry.effect.driver = Some(column.name.clone());
            entry
        })
        .collect()
}

fn bad_points(touches: &[MeasuredTouch]) -> Vec<Entry> {
    let fitted = touches.iter().enumerate().filter(|(_, t)| t.role == Role::Fit);
    fitted
        .map(|(observation, touch)| {
            let text = format!("touch {} is off on its own", touch.name);
            let parameters = vec![parameter("along the normal", "mm", 1.0)];
            let mut entry = entry("bad-point", &text, parameters, Term::BadPoint { observation });
            entry.effect.subject = Some(touch.name.clone());
            entry
        })
        .collect()
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn ratio(count: usize) -> f64 {
    count as f64
}
