use geometry::HeightGrid;
use nalgebra::{Point2, Vector2};

use super::even_places::axis;
use super::{Drawn, DrawnShape};
use crate::Error;
use crate::case::{ColumnKinds, Columns, Folder, Location, Problem};

/// Heights of a part that was measured or drawn place by place.
pub(super) const HEIGHTS: &str = "heights.csv";
const PLACES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const KNOWN: &[&str] = &PLACES;

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
