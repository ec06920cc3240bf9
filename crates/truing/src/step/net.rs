//! B-spline surfaces.

use std::fmt;

use geometry::nalgebra::Point3;
use geometry::{GeometryError, Nurbs};

use super::StepProblem;
use super::entity::{Entity, Record};
use super::exchange::Exchange;
use super::shown::rounded;
use super::value::Value;

/// Degrees, knots and control points of a B-spline surface.
#[derive(Clone, Debug, PartialEq)]
pub struct StepNet {
    /// Along u and v.
    pub degrees: [usize; 2],
    /// Along u and v, each as often as its multiplicity says.
    pub knots: [Vec<f64>; 2],
    /// Control points along u and v.
    pub counts: [usize; 2],
    /// Control points, u running fastest.
    pub points_mm: Vec<Point3<f64>>,
    /// One per control point; 1 where the surface has none.
    pub weights: Vec<f64>,
    /// Number of the entity in the file.
    pub id: u64,
    /// Its line in the file, from 1.
    pub line: usize,
}

/// Knots that the standard derives from degree and number of control points.
#[derive(Clone, Copy)]
enum Spacing {
    Uniform,
    QuasiUniform,
    Bezier,
}

/// Types whose knots follow, by their records.
const SPACINGS: [(&str, Spacing); 3] = [
    ("UNIFORM_SURFACE", Spacing::Uniform),
    ("QUASI_UNIFORM_SURFACE", Spacing::QuasiUniform),
    ("BEZIER_SURFACE", Spacing::Bezier),
];
const WITH_KNOTS: &str = "B_SPLINE_SURFACE_WITH_KNOTS";

impl StepNet {
    /// The surface; its normal is `∂u × ∂v`.
    ///
    /// # Errors
    ///
    /// Those of [`Nurbs::new`].
    pub fn nurbs(&self) -> Result<Nurbs, GeometryError> {
        Nurbs::new(self.degrees, self.knots.clone(), &self.points_mm, &self.weights)
    }

    /// The same surface with the opposite normal: u and v exchanged.
    pub(crate) fn flipped(&self) -> Self {
        let [columns, rows] = self.counts;
        let order = || (0..columns).flat_map(move |i| (0..rows).map(move |j| i + j * columns));
        let [u, v] = self.knots.clone();
        Self {
            degrees: [self.degrees[1], self.degrees[0]],
            knots: [v, u],
            counts: [rows, columns],
            points_mm: order().map(|index| self.points_mm[index]).collect(),
            weights: order().map(|index| self.weights[index]).collect(),
            id: self.id,
            line: self.line,
        }
    }

    pub(crate) fn is_rational(&self) -> bool {
        self.weights.windows(2).any(|pair| pair[0].total_cmp(&pair[1]).is_ne())
    }
}

impl Exchange<'_> {
    /// The B-spline that an entity is; `None` for another surface.
    pub(super) fn net(
        &self,
        entity: &Entity<'_>,
        unit_mm: f64,
    ) -> Result<Option<StepNet>, StepProblem> {
        // A record of a complex entity has only attributes of its own; else a name and all others
        // come before.
        let (base, with_knots) = if entity.is_complex() {
            let Some(base) = entity.named("B_SPLINE_SURFACE") else { return Ok(None) };
            (base, entity.named(WITH_KNOTS))
        } else {
            let record = entity.record();
            let is_derived = SPACINGS.iter().any(|(keyword, _)| *keyword == record.keyword);
            match record.keyword {
                WITH_KNOTS => (record.behind(1), Some(record.behind(8))),
                _ if is_derived => (record.behind(1), None),
                _ => return Ok(None),
            }
        };
        let degrees = [base.count(0)?, base.count(1)?];
        let (n_u, ids) = base.net(2)?;
        let ids = base.all(2, &ids, "references to points", Value::reference)?;
        let counts = [n_u, ids.len().checked_div(n_u).unwrap_or(0)];
        let spacing =
            SPACINGS.iter().find(|(keyword, _)| entity.named(keyword).is_some()).map(|(_, s)| *s);
        let given = |d: usize| -> Result<Vec<f64>, StepProblem> {
            match (with_knots, spacing) {
                (Some(record), _) => given_knots(&record, d, degrees[d], counts[d]),
                (None, Some(spacing)) => derived_knots(entity, spacing, d, degrees[d], counts[d]),
                (None, None) => Err(knots_missing(entity, d, degrees[d], counts[d], 0)),
            }
        };
        let knots = [given(0)?, given(1)?];
        let points: Vec<Point3<f64>> = ids
            .iter()
            .map(|id| self.point_mm(*id, entity.id, unit_mm))
            .collect::<Result<_, _>>()?;
        let weights = match entity.named("RATIONAL_B_SPLINE_SURFACE") {
            Some(record) => weights(&record, counts)?,
            None => vec![1.0; points.len()],
        };
        let (id, line) = (entity.id, entity.line);
        let [columns, rows] = counts;
        // The standard has v running fastest.
        let order = || (0..rows).flat_map(move |j| (0..columns).map(move |i| j + i * rows));
        let points_mm = order().map(|index| points[index]).collect();
        let weights = order().map(|index| weights[index]).collect();
        Ok(Some(StepNet { degrees, knots, counts, points_mm, weights, id, line }))
    }
}

fn weights(record: &Record<'_, '_>, counts: [usize; 2]) -> Result<Vec<f64>, StepProblem> {
    let (n_u, values) = record.net(0)?;
    let number = |value: &Value<'_>| match value {
        Value::Number(weight) => Some(*weight),
        _ => None,
    };
    let weights = record.all(0, &values, "numbers", number)?;
    if n_u != counts[0] || weights.len() != counts[0] * counts[1] {
        return Err(record.wrong(0, "one weight for every control point"));
    }
    Ok(weights)
}

fn knots_missing(
    entity: &Entity<'_>,
    d: usize,
    degree: usize,
    points: usize,
    got: usize,
) -> StepProblem {
    let (line, id, direction) = (entity.line, entity.id, ["u", "v"][d]);
    StepProblem::Knots { line, id, direction, degree, points, got }
}

/// Knots and their multiplicities along one direction, written out.
fn given_knots(
    record: &Record<'_, '_>,
    d: usize,
    degree: usize,
    points: usize,
) -> Result<Vec<f64>, StepProblem> {
    let (multiplicities, knots) = (record.counts(d)?, record.numbers(d + 2)?);
    if multiplicities.len() != knots.len() {
        return Err(record.wrong(d + 2, "one knot for every multiplicity"));
    }
    // Added up before they are written out: a slip may ask for thousands of millions.
    let got = multiplicities.iter().fold(0_usize, |sum, m| sum.saturating_add(*m));
    if got != points.saturating_add(degree).saturating_add(1) {
        let (line, id, direction) = (record.line, record.id, ["u", "v"][d]);
        return Err(StepProblem::Knots { line, id, direction, degree, points, got });
    }
    Ok(knots.iter().zip(multiplicities).flat_map(|(k, m)| std::iter::repeat_n(*k, m)).collect())
}

fn derived_knots(
    entity: &Entity<'_>,
    spacing: Spacing,
    d: usize,
    degree: usize,
    points: usize,
) -> Result<Vec<f64>, StepProblem> {
    /// Beyond it the surface is refused anyway.
    const MAX_DEGREE: usize = 15;
    let none = || knots_missing(entity, d, degree, points, 0);
    if degree == 0 || degree > MAX_DEGREE || points <= degree {
        return Err(none());
    }
    let number = |n: usize| u32::try_from(n).map(f64::from).map_err(|_| none());
    match spacing {
        Spacing::Uniform => (0..=points + degree).map(number).collect(),
        Spacing::QuasiUniform => Ok(Nurbs::clamped_knots(degree, points)),
        Spacing::Bezier if !(points - 1).is_multiple_of(degree) => Err(none()),
        Spacing::Bezier => {
            let pieces = (points - 1) / degree;
            let times = |n: usize| if n == 0 || n == pieces { degree + 1 } else { degree };
            let repeated = (0..=pieces).flat_map(|n| std::iter::repeat_n(n, times(n)));
            repeated.map(number).collect()
        }
    }
}

impl fmt::Display for StepNet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [u, v] = self.degrees;
        let [columns, rows] = self.counts;
        let rational = if self.is_rational() { "rational " } else { "" };
        write!(
            f,
            "{rational}B-spline of degree {u} × {v}, {columns} × {rows} control points over"
        )?;
        for (d, name) in ["x", "y", "z"].into_iter().enumerate() {
            let values = self.points_mm.iter().map(|p| p[d]);
            let low = rounded(values.clone().fold(f64::INFINITY, f64::min));
            let high = rounded(values.fold(f64::NEG_INFINITY, f64::max));
            write!(f, "{} {name} {low} to {high}", if d == 0 { "" } else { "," })?;
        }
        write!(f, " mm")
    }
}
