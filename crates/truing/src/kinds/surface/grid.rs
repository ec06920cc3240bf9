use geometry::HeightGrid;
use nalgebra::{Point2, Vector2};

use super::{Drawn, DrawnShape};
use crate::Error;
use crate::case::{ColumnKinds, Columns, Folder, Location, Problem};

/// Heights of a part that was measured or drawn place by place.
const HEIGHTS: &str = "heights.csv";
const PLACES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const KNOWN: &[&str] = &PLACES;
/// Share of the spacing by which the decimals of a file may put a place beside its own.
const UNEVEN_SHARE: f64 = 1e-3;

/// The grid in `heights.csv`: every place once, in any order.
pub(super) fn grid(folder: &Folder) -> Result<Drawn, Error> {
    let table = folder.table(HEIGHTS, KNOWN)?;
    let mut columns = Columns::new(&table, KNOWN);
    let [x, y, z] = PLACES.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    columns.rest(&ColumnKinds::default())?;
    let wrong = |at: Location, message: String| Error::case(at, Problem::WrongValue { message });
    let (x_axis, y_axis) = (axis(&x), axis(&y));
    let (columns, rows) = (x_axis.count, y_axis.count);
    let places = columns.saturating_mul(rows);
    if places != table.n_rows() {
        let message = format!(
            "{} rows are no even grid: {columns} places along x and {rows} along y are {places}",
            table.n_rows()
        );
        return Err(wrong(table.at_file(), message));
    }
    let mut heights = vec![f64::NAN; places];
    for row in 0..table.n_rows() {
        let slot = (x_axis.slot(x[row]).zip(y_axis.slot(y[row])))
            .and_then(|(i, j)| heights.get_mut(j * columns + i));
        let Some(slot) = slot.filter(|slot| slot.is_nan()) else {
            let message = format!(
                "({}, {}) mm is no new place of an even grid from ({}, {}) mm by ({}, {}) mm",
                x[row], y[row], x_axis.first, y_axis.first, x_axis.step, y_axis.step
            );
            return Err(wrong(table.at_row(row), message));
        };
        *slot = z[row];
    }
    let origin = Point2::new(x_axis.first, y_axis.first);
    let spacing = Vector2::new(x_axis.step, y_axis.step);
    let grid = HeightGrid::new(origin, spacing, columns, &heights)
        .map_err(|e| wrong(table.at_file(), e.to_string()))?;
    let words =
        format!("grid of {columns} × {rows} heights, {} × {} mm apart", spacing.x, spacing.y);
    let reach_mm = [x_axis.first, x_axis.last()]
        .into_iter()
        .flat_map(|x| [y_axis.first, y_axis.last()].map(|y| f64::hypot(x, y)))
        .reduce(f64::max);
    Ok(Drawn { tables: vec![HEIGHTS], ..Drawn::of(DrawnShape::Grid(grid), words, reach_mm) })
}

/// Evenly spaced places along one axis.
pub(super) struct Axis {
    pub(super) first: f64,
    pub(super) step: f64,
    pub(super) count: usize,
}

/// First place, least step and number of steps; a single place has no step.
pub(super) fn axis(values: &[f64]) -> Axis {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (first, last) = (sorted[0], sorted[sorted.len() - 1]);
    let rounding = UNEVEN_SHARE * UNEVEN_SHARE * (last - first);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > rounding);
    let step = steps.fold(last - first, f64::min);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded just before; too uneven a grid has too many places"
    )]
    let count = if step > 0.0 { ((last - first) / step).round().min(1e9) as usize + 1 } else { 1 };
    // The mean step, as rounding spreads over all of them.
    let even = if count > 1 { (last - first) / as_f64(count - 1) } else { 0.0 };
    Axis { first, step: even, count }
}

impl Axis {
    fn last(&self) -> f64 {
        self.first + self.step * as_f64(self.count.saturating_sub(1))
    }

    pub(super) fn at(&self, index: usize) -> f64 {
        self.first + self.step * as_f64(index)
    }

    /// Index of the place next to a value.
    pub(super) fn nearest(&self, value: f64) -> usize {
        let place = ((value - self.first) / self.step).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of places"
        )]
        let index = place.clamp(0.0, as_f64(self.count.saturating_sub(1))) as usize;
        index
    }

    pub(super) fn slot(&self, value: f64) -> Option<usize> {
        let place = if self.step > 0.0 { (value - self.first) / self.step } else { 0.0 };
        let near = place.round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of places"
        )]
        let index = near as usize;
        ((place - near).abs() <= UNEVEN_SHARE).then_some(index)
    }
}

#[expect(clippy::cast_precision_loss, reason = "places of a grid are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
