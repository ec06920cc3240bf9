//! Shapes that a residual can have along a covariate, as columns of an empirical correction.

use crate::algebra::components::{added, reported_components};
use std::cmp::Ordering;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::algebra::system::Empirical;
use crate::choice::level::Levels;
use crate::count::count;
use crate::{Covariate, Layout, Quantity, Role};

/// Reference temperature of ISO 1, in °C.
const REFERENCE_C: f64 = 20.0;

/// Distinct values from which on a curve is more than a set of levels.
const MIN_DISTINCT_FOR_CURVE: usize = 6;

/// Distinct values from which on a period can be looked for.
const MIN_DISTINCT_FOR_PERIOD: usize = 16;

/// Most periods in the range of a covariate that are looked for; scattered readings have no
/// Nyquist limit, but every further period makes chance finds likelier.
const MAX_PERIODS: usize = 32;
/// The same of scattered readings that are not many: a screw turns a hundred times where nobody touches as often.
const MAX_PERIODS_OF_SCATTERED: usize = 100;
const NOT_MANY: usize = 200;
/// Share of the mean gap below which the lower quartile of the gaps of scattered readings lies; of those that lie
/// at random it is 0.29.
const UNEVEN: f64 = 0.5;

/// Widest gap, as a share of the range: between bunches of readings any period fits.
const MAX_GAP: f64 = 0.25;

/// Most levels of which one may be apart: of many, one is a bad place, which groups show.
const MAX_APART: usize = 12;

/// Fewest values that come again, and visits of each on the mean, from which on a design repeats.
const MIN_LEVELS: usize = 3;
const MIN_VISITS: usize = 2;

/// Name of the shape with a value of its own at each level.
pub(crate) const BY_LEVEL: &str = "a value of its own at each level";
/// How the names of those with one level apart begin.
const APART: &str = "another value at";

/// Whether the shape of this name is one of levels.
pub(crate) fn is_of_levels(name: &str) -> bool {
    name == BY_LEVEL || name.starts_with(APART)
}

/// Share by which a period may differ from that of the design.
const SAME_PERIOD: f64 = 0.1;

/// An angle must cover this much, in degrees, before its harmonics are looked for.
const MIN_ARC_DEG: f64 = 120.0;

/// Name of the function that goes along where the model has no constant.
const CONSTANT: &str = "constant";

/// A shape: values per observation, and how many were tried to find it.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) name: String,
    /// One column per function, one value per observation.
    pub(crate) functions: Vec<(String, Vec<f64>)>,
    /// Shapes of this family that were looked at; the p-value is multiplied by it.
    pub(crate) tried: f64,
}

/// Shapes worth looking for along `covariate`, judged on the fitted observations.
pub(crate) fn shapes(layout: &Layout, covariate: &Covariate) -> Vec<Shape> {
    let fitted: Vec<f64> = fitted_values(layout, covariate);
    let distinct = distinct_fitted(layout, covariate);
    if distinct.len() < 2 {
        return Vec::new();
    }
    let mut shapes = vec![linear(covariate, &fitted, distinct.len())];
    shapes.extend(by_level(covariate, &fitted));
    if distinct.len() >= MIN_DISTINCT_FOR_CURVE {
        shapes.push(smooth(covariate, &fitted));
        shapes.extend(lagged(covariate));
    }
    shapes
}

/// Periods along a covariate: parts of one that is the longest; the caller picks the best and
/// multiplies by `tried`.
#[derive(Clone, Debug)]
pub(crate) struct Periods {
    pub(crate) longest: f64,
    /// In how many parts it goes, ascending.
    pub(crate) parts: Vec<usize>,
    pub(crate) tried: f64,
}

impl Periods {
    #[cfg(test)]
    pub(crate) fn of_parts(longest: f64, parts: Vec<usize>) -> Self {
        Self { longest, parts, tried: 1.0 }
    }

    /// The shape with this part of the longest period.
    pub(crate) fn shape(&self, covariate: &Covariate, part: usize) -> Shape {
        periodic(covariate, self.longest / count(part), self.tried)
    }
}

/// Periods along `covariate`; `None` where none can be told.
///
/// Along the order, periods with which one of `all` repeats are left out: they are that covariate's. Nothing
/// repeats along a temperature.
pub(crate) fn periods(
    layout: &Layout,
    covariate: &Covariate,
    all: &[Covariate],
) -> Option<Periods> {
    let distinct = distinct_fitted(layout, covariate);
    if covariate.quantity == Quantity::Temperature {
        return None;
    }
    let (Some(&low), Some(&high)) = (distinct.first(), distinct.last()) else {
        return None;
    };
    let range = high - low;
    if covariate.quantity == Quantity::Angle && range >= MIN_ARC_DEG && distinct.len() > 4 {
        return Some(Periods { longest: 360.0, parts: vec![1, 2, 3], tried: 3.0 });
    }
    let widest = distinct.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    if distinct.len() < MIN_DISTINCT_FOR_PERIOD || widest > MAX_GAP * range {
        return None;
    }
    // Half periods in the range, so that no phase falls between two frequencies.
    let most = if distinct.len() <= NOT_MANY && are_scattered(&distinct) {
        (2 * distinct.len()).min(MAX_PERIODS_OF_SCATTERED)
    } else {
        (2 * distinct.len() / 3).min(MAX_PERIODS)
    };
    let longest = 2.0 * range;
    let design =
        if covariate.quantity == Quantity::Order { revisits(layout, all) } else { Vec::new() };
    let is_open = |half: &usize| !is_of_the_design(longest / count(*half), &design);
    let parts = (3..=2 * most).filter(is_open).collect();
    Some(Periods { longest, parts, tried: count(most) })
}

/// Whether values, in ascending order, are spread so unevenly that periods shorter than their gaps show.
fn are_scattered(distinct: &[f64]) -> bool {
    let mut gaps: Vec<f64> = distinct.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let mean = gaps.iter().sum::<f64>() / count(gaps.len());
    gaps.get(gaps.len() / 4).is_some_and(|quartile| *quartile <= UNEVEN * mean)
}

/// Values at the fitted observations, ascending, each once.
pub(crate) fn distinct_fitted(layout: &Layout, covariate: &Covariate) -> Vec<f64> {
    let mut distinct = fitted_values(layout, covariate);
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    distinct
}

fn fitted_values(layout: &Layout, covariate: &Covariate) -> Vec<f64> {
    let fitted = |o: &usize| layout.groups[layout.observations[*o]].role == Role::Fit;
    (0..layout.observations.len()).filter(fitted).map(|o| covariate.values[o]).collect()
}

/// Mean and largest distance from it.
fn centre_and_scale(fitted: &[f64]) -> (f64, f64) {
    let mean = fitted.iter().sum::<f64>() / count(fitted.len());
    let scale = fitted.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
    (mean, if scale > 0.0 { scale } else { 1.0 })
}

fn linear(covariate: &Covariate, fitted: &[f64], distinct: usize) -> Shape {
    let unit = covariate.name.rsplit_once('_').map_or("unit", |(_, unit)| unit);
    let name = if distinct == 2 { "two-valued" } else { "linear" };
    if covariate.quantity == Quantity::Temperature {
        let values = covariate.values.iter().map(|v| v - REFERENCE_C).collect();
        return Shape {
            name: name.to_owned(),
            functions: vec![(format!("per {unit} from 20 °C"), values)],
            tried: 1.0,
        };
    }
    let (mean, _) = centre_and_scale(fitted);
    let values = covariate.values.iter().map(|v| v - mean).collect();
    let functions = vec![(format!("per {unit}"), values), constant(covariate)];
    Shape { name: name.to_owned(), functions, tried: 1.0 }
}

pub(crate) fn constant(covariate: &Covariate) -> (String, Vec<f64>) {
    (CONSTANT.to_owned(), vec![1.0; covariate.values.len()])
}

/// Whether a function is the constant that goes along.
pub(crate) fn is_constant(name: &str) -> bool {
    name == CONSTANT
}

/// Legendre polynomials of degree 1 to 3 over the fitted range.
fn smooth(covariate: &Covariate, fitted: &[f64]) -> Shape {
    let (mean, scale) = centre_and_scale(fitted);
    let t: Vec<f64> = covariate.values.iter().map(|v| (v - mean) / scale).collect();
    let map = |f: fn(f64) -> f64| t.iter().map(|&t| f(t)).collect::<Vec<_>>();
    let functions = vec![
        ("degree 1".to_owned(), map(|t| t)),
        ("degree 2".to_owned(), map(|t| 1.5 * t * t - 0.5)),
        ("degree 3".to_owned(), map(|t| 2.5 * t * t * t - 1.5 * t)),
        constant(covariate),
    ];
    Shape { name: "smooth".to_owned(), functions, tried: 1.0 }
}

/// A value of its own at each level of `covariate`; `None` where there are no levels.
///
/// Values that are not visited again follow the mean of the others.
fn by_level(covariate: &Covariate, fitted: &[f64]) -> Option<Shape> {
    let levels = levels(covariate, fitted)?;
    let repeated = levels.repeated();
    let mut functions: Vec<_> =
        repeated[1..].iter().map(|&level| at_level(covariate, &levels, level)).collect();
    functions.push(constant(covariate));
    Some(Shape { name: BY_LEVEL.to_owned(), functions, tried: 1.0 })
}

/// One level of `covariate` apart from the others, in turn; the caller picks the best and
/// multiplies by `tried`. A session, a load or a batch that went otherwise is that.
pub(crate) fn apart(layout: &Layout, covariate: &Covariate) -> Vec<Shape> {
    let Some(levels) = levels(covariate, &fitted_values(layout, covariate)) else {
        return Vec::new();
    };
    if levels.len() > MAX_APART {
        return Vec::new();
    }
    let repeated = levels.repeated();
    let shape = |&level: &usize| Shape {
        name: format!("{APART} {}", levels.name(level)),
        functions: vec![at_level(covariate, &levels, level), constant(covariate)],
        tried: count(repeated.len()),
    };
    repeated.iter().map(shape).collect()
}

fn levels(covariate: &Covariate, fitted: &[f64]) -> Option<Levels> {
    if covariate.quantity == Quantity::Order { None } else { Levels::of(fitted) }
}

/// One at the observations of a level.
fn at_level(covariate: &Covariate, levels: &Levels, level: usize) -> (String, Vec<f64>) {
    let is_there = |v: &f64| f64::from(u8::from(levels.level(*v) == Some(level)));
    (format!("at {}", levels.name(level)), covariate.values.iter().map(is_there).collect())
}

/// Whether two values are one place: as written, with −0 the same as 0.
fn is_same(a: f64, b: f64) -> bool {
    a.partial_cmp(&b) == Some(Ordering::Equal)
}

/// Orders between successive visits to the same value of `covariate`, the middle one; `None` where
/// its values do not repeat.
fn revisited_after(layout: &Layout, covariate: &Covariate) -> Option<f64> {
    let fitted = fitted_values(layout, covariate);
    let distinct = distinct_fitted(layout, covariate);
    if distinct.len() < MIN_LEVELS || fitted.len() < MIN_VISITS * distinct.len() {
        return None;
    }
    let next = |i: usize| {
        let again = fitted[i + 1..].iter().position(|v| is_same(*v, fitted[i]))?;
        (again > 0).then_some(again + 1)
    };
    let mut gaps: Vec<usize> = (0..fitted.len()).filter_map(next).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).map(|&gap| count(gap))
}

/// [`revisited_after`] of every covariate but the order, where its values repeat.
fn revisits(layout: &Layout, covariates: &[Covariate]) -> Vec<f64> {
    let others = covariates.iter().filter(|c| c.quantity != Quantity::Order);
    others.filter_map(|c| revisited_after(layout, c)).collect()
}

/// Whether a period along the order is that of a design that repeats itself, or a part of it.
fn is_of_the_design(period: f64, revisits: &[f64]) -> bool {
    revisits.iter().any(|gap| {
        let parts = gap / period;
        parts > 1.0 - SAME_PERIOD && (parts - parts.round()).abs() < SAME_PERIOD
    })
}

fn periodic(covariate: &Covariate, period: f64, tried: f64) -> Shape {
    let wave = |v: &f64| (TAU * v / period).sin_cos();
    let (sine, cosine) = covariate.values.iter().map(wave).unzip();
    let functions =
        vec![("cosine".to_owned(), cosine), ("sine".to_owned(), sine), constant(covariate)];
    Shape { name: format!("periodic, period {}", significant(period)), functions, tried }
}

/// The covariate one observation earlier, and the way it is going; the way to the first reading is not
/// recorded, so both are looked at.
fn lagged(covariate: &Covariate) -> Vec<Shape> {
    let values = &covariate.values;
    let before = |i: usize| values[i.saturating_sub(1)];
    let mean = values.iter().sum::<f64>() / count(values.len());
    let late = (0..values.len()).map(|i| before(i) - mean).collect();
    let on = ways(values);
    let mut back = on.clone();
    back[0] = -back[0];
    let shape = |name: &str, function: &str, column| Shape {
        name: name.to_owned(),
        functions: vec![(function.to_owned(), column), constant(covariate)],
        tried: 1.0,
    };
    vec![
        shape("lagged", "per unit, one earlier", late),
        shape("direction", "half step", on),
        shape("direction, the first reading reached the other way", "half step", back),
    ]
}

/// The way each value was reached, 1 or −1: as the one before where it stays, the first as the one
/// after it.
fn ways(values: &[f64]) -> Vec<f64> {
    let moves = values.windows(2).map(|w| w[1] - w[0]).filter(|step| *step != 0.0);
    let mut way = moves.map(f64::signum).next().unwrap_or(1.0);
    let steps = std::iter::once(0.0).chain(values.windows(2).map(|w| w[1] - w[0]));
    steps
        .map(|step| {
            way = if step == 0.0 { way } else { step.signum() };
            way
        })
        .collect()
}

/// Three significant digits.
fn significant(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    #[expect(clippy::cast_possible_truncation, reason = "a decimal exponent is small")]
    let decimals = 2 - x.abs().log10().floor() as i32;
    format!("{x:.*}", usize::try_from(decimals.max(0)).unwrap_or(0))
}

/// The empirical correction that lets every reported component follow `shape`.
///
/// The last function is the constant that goes along where the model has none.
pub(crate) fn correction(layout: &Layout, covariate: &str, shape: &Shape) -> Empirical {
    let components = reported_components(layout);
    let mut columns = Vec::new();
    let mut coefficients = Vec::new();
    for (name, values) in &shape.functions {
        for component in 0..components {
            let value = |row| added(row, component, values);
            columns.push(DVector::from_iterator(layout.rows.len(), layout.rows.iter().map(value)));
            coefficients.push(if components > 1 {
                format!("{} {name}", ["x", "y", "z"].get(component).copied().unwrap_or("other"))
            } else {
                name.clone()
            });
        }
    }
    let constants = shape.functions.iter().filter(|(name, _)| is_constant(name)).count();
    Empirical {
        covariate: covariate.to_owned(),
        shape: shape.name.clone(),
        coefficients,
        constants: constants * components,
        columns: DMatrix::from_columns(&columns),
    }
}
