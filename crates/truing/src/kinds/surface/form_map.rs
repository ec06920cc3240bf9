//! `[surface.form]`: what was measured of a part's form, added to the part as drawn.

use geometry::{DeviationAlong, HeightGrid};
use nalgebra::{Matrix6, Point2, Vector2, Vector6};
use pose_icp::TriangleMesh;
use serde::Deserialize;

use super::even_places::{Axis, axis};
use crate::Error;
use crate::case::{ColumnKinds, Columns, Folder, Location, Positive, Problem, Table};

/// Deviations of the part, place by place.
pub(super) const FORM: &str = "form.csv";
const X: &str = "x_mm";
const Y: &str = "y_mm";
pub(super) const DEVIATION: &str = "deviation_mm";
const KNOWN: &[&str] = &[X, Y, DEVIATION];
/// Places of a map: an interferometer has four million.
const MOST_PLACES: usize = 4_000_000;
/// Places on either side, in spacings, that count for one of a map of scattered places.
const WINDOW: usize = 2;
/// Share of the largest below which a quadric through scattered places is not determined.
const DETERMINED: f64 = 1e-4;

/// `[surface.form]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FormMapSettings {
    #[serde(default)]
    along: AlongName,
    spacing_mm: Option<Positive>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AlongName {
    #[default]
    Normal,
    Z,
}

/// A measured map of deviations, and how to speak of it.
#[derive(Debug)]
pub(crate) struct FormMap {
    pub(crate) map_mm: HeightGrid,
    pub(crate) along: DeviationAlong,
    pub(super) words: String,
}

/// The columns of the table.
struct Deviations<'t> {
    table: &'t Table,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl FormMapSettings {
    pub(super) fn read(&self, folder: &Folder) -> Result<FormMap, Error> {
        let table = folder.table(FORM, KNOWN)?;
        let mut columns = Columns::new(&table, KNOWN);
        let [x, y, z] = [X, Y, DEVIATION].map(|name| columns.numbers(name));
        let deviations = Deviations { x: x?, y: y?, z: z?, table: &table };
        columns.rest(&ColumnKinds::default())?;
        let map_mm = match self.spacing_mm {
            Some(Positive(spacing_mm)) => deviations.scattered(spacing_mm)?,
            None => deviations.on_grid()?,
        };
        let (along, name) = match self.along {
            AlongName::Normal => (DeviationAlong::Normal, "the normal"),
            AlongName::Z => (DeviationAlong::Z, "z"),
        };
        let words = format!("{} deviations measured along {name}", table.n_rows());
        Ok(FormMap { map_mm, along, words })
    }
}

impl FormMap {
    /// The mesh with the deviations, its triangles divided to the spacing of the map; `None` where
    /// they are too many.
    pub(super) fn on_mesh(&self, mesh: &TriangleMesh) -> Option<TriangleMesh> {
        mesh.formed(&self.map_mm, self.along, self.map_mm.spacing_mm().max())
    }
}

impl Deviations<'_> {
    fn wrong(at: Location, message: String) -> Error {
        Error::case(at, Problem::WrongValue { message })
    }

    /// Every place one of an even grid, some of them missing.
    fn on_grid(&self) -> Result<HeightGrid, Error> {
        let (x_axis, y_axis) = (axis(&self.x), axis(&self.y));
        let (columns, rows) = (x_axis.count, y_axis.count);
        let places = columns.saturating_mul(rows);
        let scattered = "; for scattered places give `[surface.form] spacing_mm`";
        if places > MOST_PLACES {
            let message = format!(
                "{} rows are no even grid: {columns} places along x and {rows} along y{scattered}",
                self.table.n_rows()
            );
            return Err(Self::wrong(self.table.at_file(), message));
        }
        let mut heights = vec![None; places];
        for row in 0..self.table.n_rows() {
            let slot = (x_axis.slot(self.x[row]).zip(y_axis.slot(self.y[row])))
                .and_then(|(i, j)| heights.get_mut(j * columns + i));
            let Some(slot) = slot.filter(|slot| slot.is_none()) else {
                let message = format!(
                    "({}, {}) mm is no new place of an even grid from ({}, {}) mm by ({}, {}) \
                     mm{scattered}",
                    self.x[row], self.y[row], x_axis.first, y_axis.first, x_axis.step, y_axis.step
                );
                return Err(Self::wrong(self.table.at_row(row), message));
            };
            *slot = Some(self.z[row]);
        }
        self.grid(&x_axis, &y_axis, &heights)
    }

    /// Scattered places brought to an even grid, by the quadric through those near each place of it,
    /// with weights that fall to e⁻² two spacings away. Quadrics are repeated; where too few places are near,
    /// the map has a gap.
    fn scattered(&self, spacing_mm: f64) -> Result<HeightGrid, Error> {
        let [x_axis, y_axis] = [&self.x, &self.y].map(|of| even(of, spacing_mm));
        let (columns, rows) = (x_axis.count, y_axis.count);
        if columns.saturating_mul(rows) > MOST_PLACES {
            let message = format!(
                "`[surface.form] spacing_mm` = {spacing_mm} makes {columns} × {rows} places of this \
                 table; widen it"
            );
            return Err(Self::wrong(self.table.at_file(), message));
        }
        // Rows by the nearest place of the grid.
        let mut near: Vec<Vec<usize>> = vec![Vec::new(); columns * rows];
        for row in 0..self.table.n_rows() {
            let (i, j) = (x_axis.nearest(self.x[row]), y_axis.nearest(self.y[row]));
            near[j * columns + i].push(row);
        }
        let around =
            |at: usize, count: usize| at.saturating_sub(WINDOW)..(at + WINDOW + 1).min(count);
        let heights: Vec<Option<f64>> = (0..columns * rows)
            .map(|place| {
                let (i, j) = (place % columns, place / columns);
                let at = Point2::new(x_axis.at(i), y_axis.at(j));
                let rows = around(j, rows).flat_map(|l| around(i, columns).map(move |k| (k, l)));
                let rows = rows.flat_map(|(k, l)| near[l * columns + k].iter().copied());
                self.quadric_at(at, spacing_mm, rows)
            })
            .collect();
        if heights.iter().all(Option::is_none) {
            let message = format!(
                "no place has six others within {WINDOW} spacings; widen `[surface.form] spacing_mm` \
                 = {spacing_mm}"
            );
            return Err(Self::wrong(self.table.at_file(), message));
        }
        self.grid(&x_axis, &y_axis, &heights)
    }

    /// Height at a place of the weighted least-squares quadric through rows around it; `None` where they do not
    /// determine one, or where none is within a spacing.
    fn quadric_at(
        &self,
        at: Point2<f64>,
        spacing_mm: f64,
        rows: impl Iterator<Item = usize>,
    ) -> Option<f64> {
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        let mut nearest = f64::INFINITY;
        for row in rows {
            let step = (Point2::new(self.x[row], self.y[row]) - at) / spacing_mm;
            nearest = nearest.min(step.norm());
            let (u, v) = (step.x, step.y);
            let of = Vector6::new(1.0, u, v, u * u, u * v, v * v);
            let weight = (-0.5 * step.norm_squared()).exp();
            normal += of * of.transpose() * weight;
            right += of * (weight * self.z[row]);
        }
        let factor = normal.cholesky().filter(|_| nearest <= 1.0)?;
        let diagonal = factor.l().diagonal();
        (diagonal.min() > DETERMINED * diagonal.max()).then(|| factor.solve(&right).x)
    }

    fn grid(&self, x: &Axis, y: &Axis, heights: &[Option<f64>]) -> Result<HeightGrid, Error> {
        let origin = Point2::new(x.first, y.first);
        let spacing = Vector2::new(x.step, y.step);
        HeightGrid::with_gaps(origin, spacing, x.count, heights)
            .map_err(|source| Self::wrong(self.table.at_file(), source.to_string()))
    }
}

/// Places `spacing_mm` apart over all values, in the middle of them.
fn even(values: &[f64], spacing_mm: f64) -> Axis {
    let (low, high) =
        values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    let steps = ((high - low) / spacing_mm).ceil().min(1e9);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded just before"
    )]
    let count = steps as usize + 1;
    Axis { first: 0.5 * (low + high - steps * spacing_mm), step: spacing_mm, count }
}
