//! Rows of a stream of wrenches.

use ft_center::Sample;
use geometry::Wrench;
use nalgebra::{Point2, Vector3};

/// Columns of a stream, in the order of a stream without a header.
const COLUMNS: [&str; 9] = [
    "time_s",
    "fx_n",
    "fy_n",
    "fz_n",
    "mx_nmm",
    "my_nmm",
    "mz_nmm",
    "machine_x_mm",
    "machine_y_mm",
];

/// A wrench and where the machine was sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamRow {
    /// Time and wrench.
    pub sample: Sample,
    /// Commanded position, machine frame.
    pub commanded_mm: Point2<f64>,
}

/// Why a line of a stream is no row.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RowProblem {
    /// The header lacks a column.
    #[error("column `{column}` is missing; a stream has the columns {}", COLUMNS.join(", "))]
    MissingColumn {
        /// The first that is missing.
        column: &'static str,
    },
    /// A line with another number of cells.
    #[error("expected {expected} cells, found {found}")]
    Cells {
        /// As many as the header has.
        expected: usize,
        /// In the line.
        found: usize,
    },
    /// A cell that is no number.
    #[error("column `{column}`: expected a number, found `{found}`")]
    NotANumber {
        /// Its column.
        column: &'static str,
        /// The cell.
        found: String,
    },
}

/// Which cell of a line is what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamTable {
    places: [usize; COLUMNS.len()],
    width: usize,
}

impl Default for StreamTable {
    /// Time, wrench and position, in the order of the page, and nothing else.
    fn default() -> Self {
        Self { places: std::array::from_fn(|i| i), width: COLUMNS.len() }
    }
}

impl StreamTable {
    /// By the header of a stream; further columns are not used.
    ///
    /// # Errors
    ///
    /// [`RowProblem::MissingColumn`].
    pub fn of_header(line: &str) -> Result<Self, RowProblem> {
        let names: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut places = [0; COLUMNS.len()];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            let found = names.iter().position(|name| *name == column);
            *place = found.ok_or(RowProblem::MissingColumn { column })?;
        }
        Ok(Self { places, width: names.len() })
    }

    /// Whether a line holds names, not numbers.
    #[must_use]
    pub fn is_header(line: &str) -> bool {
        line.split(',').any(|cell| COLUMNS.contains(&cell.trim()))
    }

    /// A line as a row. Numbers that are not finite are left to the monitor.
    ///
    /// # Errors
    ///
    /// [`RowProblem::Cells`], [`RowProblem::NotANumber`].
    pub fn row(&self, line: &str) -> Result<StreamRow, RowProblem> {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != self.width {
            return Err(RowProblem::Cells { expected: self.width, found: cells.len() });
        }
        let mut numbers = [0.0; COLUMNS.len()];
        for ((number, &place), column) in numbers.iter_mut().zip(&self.places).zip(COLUMNS) {
            let found = cells[place];
            *number = found.parse().map_err(|_| RowProblem::NotANumber {
                column,
                found: found.chars().take(MOST_SHOWN).collect(),
            })?;
        }
        let [time_s, fx, fy, fz, mx, my, mz, x, y] = numbers;
        let wrench =
            Wrench { force_n: Vector3::new(fx, fy, fz), torque_nmm: Vector3::new(mx, my, mz) };
        Ok(StreamRow { sample: Sample { time_s, wrench }, commanded_mm: Point2::new(x, y) })
    }
}

/// Characters of a cell that a message shows.
const MOST_SHOWN: usize = 40;

#[cfg(test)]
mod tests {
    use super::{RowProblem, StreamTable};

    #[test]
    fn columns_are_found_by_name_and_further_ones_are_left() {
        let header = "machine_y_mm,machine_x_mm,air_c,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm";
        assert!(StreamTable::is_header(header));
        let row = StreamTable::of_header(header).unwrap().row("2,1,20,0.5,3,4,-5,6,7,8").unwrap();
        assert_eq!((row.commanded_mm.x, row.commanded_mm.y, row.sample.time_s), (1.0, 2.0, 0.5));
        assert_eq!(row.sample.wrench.to_vector().as_slice(), [3.0, 4.0, -5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn what_is_no_row_is_said() {
        let table = StreamTable::default();
        assert_eq!(table.row("1,2"), Err(RowProblem::Cells { expected: 9, found: 2 }));
        let found = "x".to_owned();
        assert_eq!(
            table.row("0,1,2,x,4,5,6,7,8"),
            Err(RowProblem::NotANumber { column: "fz_n", found })
        );
        let column = "fy_n";
        assert_eq!(
            StreamTable::of_header("time_s,fx_n"),
            Err(RowProblem::MissingColumn { column })
        );
    }
}
