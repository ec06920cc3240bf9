//! Numbers of `case.toml`, which a person typed: digits exchanged, a decimal point elsewhere, two numbers exchanged,
//! or one that is another.

use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::search::misfit_with;
use super::setting::{Typed, name_of, number_of};
use super::written::{digits_exchanged, shortest};
use crate::case::{CASE_FILE, Change, Document, Edit};
use crate::count::count;
use crate::kind::Files;

/// A number that is wrong and fits once it is another.
pub(super) const SETTING: &str = "input:setting";
/// Factors of a decimal point in the wrong place.
const POINTS: [f64; 6] = [10.0, 0.1, 100.0, 0.01, 1e3, 1e-3];
/// Lengths by themselves that count from somewhere.
const HEIGHTS: [&str; 2] = ["center_of_gravity_mm", "z0_mm"];
/// First step of a number that is set free, as a share of it, or as it is where it is nothing.
const FIRST_STEP: f64 = 1e-3;
/// Steps towards the best value; a fit that is linear in it needs two.
const MOST_STEPS: usize = 12;
/// Times its spacing that a value is moved at once at most, and looked at on both sides then.
const FARTHEST: f64 = 1000.0;
const NEXT: f64 = 50.0;
/// Share of the first misfit, squared, that a value must promise to leave at most: others are not gone after.
const HARDLY: f64 = 0.5;
/// Share of its standard uncertainty to which a value is sought.
const SETTLED: f64 = 0.05;

/// One number of a setting.
#[derive(Clone, Debug, PartialEq)]
struct Number {
    path: &'static [&'static str],
    /// Place in lists within lists.
    at: Vec<usize>,
    value: f64,
}

/// What may be wrong with each number, and with any two of a sort.
pub(super) fn mistyped(document: &Document, settings: &[Typed]) -> Vec<Hypothesis> {
    let numbers = numbers(document, settings);
    let mut all: Vec<_> = numbers.iter().flat_map(|number| number.mistyped(document)).collect();
    for (i, one) in numbers.iter().enumerate() {
        let others = numbers[..i].iter().filter(|other| one.is_of_a_sort_with(other));
        all.extend(others.map(|other| exchanged(document, other, one)));
    }
    all
}

/// Every number as it fits best.
pub(super) fn set_free(files: &Files) -> Vec<Hypothesis> {
    let numbers = numbers(&files.document, files.kind.typed);
    numbers.par_iter().filter_map(|number| number.set_free(files)).collect()
}

fn numbers(document: &Document, settings: &[Typed]) -> Vec<Number> {
    let mut all = Vec::new();
    for Typed { path, unwritten } in settings {
        let unwritten = || unwritten.map(toml::Value::Float);
        if let Some(value) = document.value(path).or_else(unwritten) {
            list(path, &value, &mut Vec::new(), &mut all);
        }
    }
    all
}

/// The numbers of a value; of a list within a list the last, as of `[i, j, a]`.
fn list(
    path: &'static [&'static str],
    value: &toml::Value,
    at: &mut Vec<usize>,
    all: &mut Vec<Number>,
) {
    all.extend(number_of(value).map(|value| Number { path, at: at.clone(), value }));
    for (i, value) in value.as_array().into_iter().flatten().enumerate() {
        let is_within = !at.is_empty();
        if !is_within || value_of_term(path) == Some(i) {
            at.push(i);
            list(path, value, at, all);
            at.pop();
        }
    }
}

/// Place of the number among what stands in a list within this list.
fn value_of_term(path: &[&str]) -> Option<usize> {
    (path.last() == Some(&"terms")).then_some(2)
}

impl Number {
    /// What is wrong with it, and which number of a list it is.
    fn said(&self, what: &str) -> String {
        let which = self.at.first().map_or_else(String::new, |i| format!(" in number {}", i + 1));
        format!("`{}` of {CASE_FILE} {what}{which}", name_of(self.path))
    }

    fn hypothesis(
        &self,
        document: &Document,
        effect: &'static str,
        what: &str,
        to: f64,
    ) -> Hypothesis {
        let description = format!("{}: {to} instead of {}", self.said(what), self.value);
        let edits = replaced(document, &[(self, to)]);
        Hypothesis::of(effect, (CASE_FILE, &[&name_of(self.path)]), description, edits)
    }

    fn mistyped(&self, document: &Document) -> Vec<Hypothesis> {
        let of = |effect, what, to| self.hypothesis(document, effect, what, to);
        let slip = "is written with two digits exchanged (a typing slip)";
        let digits = digits_exchanged(self.value);
        let mut all: Vec<_> = digits.into_iter().map(|to| of("input:digits", slip, to)).collect();
        if self.value == 0.0 {
            return all;
        }
        let is_one_of_several = !self.at.is_empty();
        if is_one_of_several || self.is_a_height() {
            all.push(of("input:sign", "has the opposite sign", -self.value));
        }
        // Of a length by itself each factor is a unit.
        if is_one_of_several || !self.is_a_length() {
            let point = "has a decimal point in the wrong place (a factor, an exponent)";
            all.extend(
                POINTS
                    .map(|factor| of("input:decimal-point", point, shortest(self.value * factor))),
            );
        }
        all
    }

    fn is_a_length(&self) -> bool {
        self.path.last().is_some_and(|key| key.ends_with("_mm"))
    }

    /// Whether it counts from somewhere, and may do so to either side.
    fn is_a_height(&self) -> bool {
        self.path.last().is_some_and(|key| HEIGHTS.contains(key))
    }

    /// Whether it may stand where the other should: in one list, or in one section in one unit.
    fn is_of_a_sort_with(&self, other: &Self) -> bool {
        let unit = |number: &Self| {
            number.path.last().and_then(|key| key.rsplit_once('_')).map(|(_, unit)| unit.to_owned())
        };
        let section = |number: &Self| number.path.first().copied();
        let are_of_one = self.at.is_empty() && other.at.is_empty();
        let is_alike = self.path == other.path
            || are_of_one
                && section(self) == section(other)
                && unit(self).is_some_and(|u| Some(u) == unit(other));
        is_alike && self.value.total_cmp(&other.value).is_ne()
    }

    /// The value with which the least is left.
    fn set_free(&self, files: &Files) -> Option<Hypothesis> {
        let left = |to: f64| {
            let misfit = misfit_with(files, &replaced(&files.document, &[(self, to)]))?;
            Some((misfit.rms.powi(2), count(misfit.dof.max(1))))
        };
        let (mut at, mut spacing) = (self.value, FIRST_STEP * self.value.abs());
        if spacing == 0.0 {
            spacing = FIRST_STEP;
        }
        let mut uncertainty = f64::INFINITY;
        let (mut before, mut least, mut at_first) = (at, f64::INFINITY, None);
        for _ in 0..MOST_STEPS {
            let Some((here, dof)) = left(at).filter(|(here, _)| *here <= least) else {
                // Too far: half of the way.
                at = at.midpoint(before);
                continue;
            };
            (before, least) = (at, here);
            let Some(((below, _), (above, _))) = left(at - spacing).zip(left(at + spacing)) else {
                spacing /= NEXT;
                continue;
            };
            let slope = (above - below) / (2.0 * spacing);
            let curvature = (above - 2.0 * here + below) / (2.0 * spacing * spacing);
            let most = FARTHEST * spacing;
            let mut step = -slope.signum() * most;
            if curvature > 0.0 {
                step = (-slope / (2.0 * curvature)).clamp(-most, most);
                let lowest = (here - curvature * step * step).max(0.0);
                uncertainty = (lowest / (curvature * dof)).sqrt();
                if lowest > HARDLY * *at_first.get_or_insert(here) {
                    return None;
                }
            }
            at += step;
            if step.abs() <= SETTLED * uncertainty {
                break;
            }
            spacing = uncertainty.min(spacing).max(step.abs() / NEXT);
        }
        let to = rounded(at, uncertainty)?;
        let digits = rounded(uncertainty, uncertainty)?;
        let what = format!(
            "is another (a typing slip, another drawing, another set-up; ± {digits} standard uncertainty)"
        );
        Some(self.hypothesis(&files.document, SETTING, &what, to))
    }
}

/// A number to the second digit of its uncertainty; `None` of what is none.
fn rounded(value: f64, uncertainty: f64) -> Option<f64> {
    let digits = (-(uncertainty.log10().floor())).max(0.0) + 1.0;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "digits of a number"
    )]
    let digits = (digits.is_finite() && digits < 18.0).then_some(digits as usize)?;
    format!("{value:.digits$}").parse().ok().filter(|value: &f64| value.is_finite())
}

/// The changes after which these numbers are others.
fn replaced(document: &Document, numbers: &[(&Number, f64)]) -> Vec<Edit> {
    let mut edits: Vec<(&'static [&'static str], toml::Value)> = Vec::new();
    for (number, to) in numbers {
        let known = edits.iter().position(|(path, _)| *path == number.path);
        let at = known.unwrap_or_else(|| {
            let value = document.value(number.path).unwrap_or(toml::Value::Float(number.value));
            edits.push((number.path, value));
            edits.len() - 1
        });
        let mut place = Some(&mut edits[at].1);
        for i in &number.at {
            place = place.and_then(|list| list.as_array_mut()).and_then(|list| list.get_mut(*i));
        }
        if let Some(place) = place {
            *place = toml::Value::Float(*to);
        }
    }
    let edit = |(path, value): (&[&'static str], toml::Value)| Edit {
        file: CASE_FILE,
        change: Change::Setting { path: path.to_vec(), value },
    };
    edits.into_iter().map(edit).collect()
}

fn exchanged(document: &Document, one: &Number, other: &Number) -> Hypothesis {
    let (name, of) = (name_of(one.path), name_of(other.path));
    let description = match (one.at.first(), other.at.first()) {
        (Some(i), Some(j)) => format!(
            "`{name}` of {CASE_FILE} is wrong, its numbers {} and {} are exchanged (swapped): exchange them",
            i + 1,
            j + 1
        ),
        _ => format!("`{name}` and `{of}` of {CASE_FILE} are exchanged (swapped): exchange them"),
    };
    let edits = replaced(document, &[(one, other.value), (other, one.value)]);
    Hypothesis::of("input:exchanged", (CASE_FILE, &[&name]), description, edits)
}
