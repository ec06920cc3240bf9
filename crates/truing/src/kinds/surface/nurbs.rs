use geometry::{GeometryError, Nurbs};
use nalgebra::Point3;

use super::{Drawn, DrawnShape, SurfaceSettings};
use crate::Error;
use crate::case::{
    ColumnKinds, Columns, ControlPoints, Document, Finite, Folder, Location, Problem, Table, quote,
};

/// Control points of a NURBS surface.
pub(super) const CONTROL: &str = "control.csv";
const INDICES: [&str; 2] = ["i", "j"];
const PLACES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const WEIGHT: &str = "weight";
const NEEDED: &[&str] = &[INDICES[0], INDICES[1], PLACES[0], PLACES[1], PLACES[2]];
const KNOWN: &[&str] = &[INDICES[0], INDICES[1], PLACES[0], PLACES[1], PLACES[2], WEIGHT];
/// Control points along one direction: beyond it, the number is a slip.
const MAX_COUNT: usize = 100_000;

/// Control points in the order of the net.
struct Net {
    /// Points along u and v.
    counts: [usize; 2],
    points_mm: Vec<Point3<f64>>,
    weights: Vec<f64>,
    /// Row of the table of each.
    rows: Vec<usize>,
    table: Table,
}

impl SurfaceSettings {
    /// Degree and knots in `case.toml`, control points in `control.csv`. Its normal points to +z
    /// in the middle, so that sides mean the same as on every other surface.
    pub(super) fn nurbs(&self, folder: &Folder, document: &Document) -> Result<Drawn, Error> {
        let degree = self.degree.as_ref().ok_or_else(|| {
            self.missing(document, "degree", "the degrees along u and v, `[3, 3]`")
        })?;
        let degrees = degree.get_ref().map(usize::from);
        let net = net(folder)?;
        let given = [&self.knots_u, &self.knots_v];
        let knots = [0, 1].map(|d| match given[d] {
            Some(knots) => knots.get_ref().iter().map(|Finite(knot)| *knot).collect(),
            None => Nurbs::clamped_knots(degrees[d], net.counts[d]),
        });
        for (d, name) in ["knots_u", "knots_v"].into_iter().enumerate() {
            let (got, needed) = (knots[d].len(), net.counts[d] + degrees[d] + 1);
            if got != needed {
                let message = format!(
                    "`[surface] {name}`: {got} knots, but {} control points of degree {} need {needed}",
                    net.counts[d], degrees[d]
                );
                let at = given[d].as_ref().map_or(degree.span(), toml::Spanned::span);
                return Err(Error::case(document.at(&at), Problem::WrongValue { message }));
            }
        }
        // The surface lies within the hull of its control points.
        let reach_mm = net.points_mm.iter().map(|p| p.x.hypot(p.y)).reduce(f64::max);
        let Net { counts, points_mm, weights, rows, table } = net;
        let of = ControlPoints { degrees, knots, points_mm, weights };
        let surface = folder
            .surface(of)
            .map_err(|source| self.no_nurbs(document, (&table, &rows), source))?;
        let [[u, v], counts] = [degrees, counts];
        let words =
            format!("NURBS of degree {u} × {v}, {} × {} control points", counts[0], counts[1]);
        let shape = DrawnShape::Nurbs(surface);
        Ok(Drawn { tables: vec![CONTROL], ..Drawn::of(shape, words, reach_mm) })
    }

    /// What is wrong with a control point is put to its row, the rest to `case.toml`.
    fn no_nurbs(
        &self,
        document: &Document,
        (table, rows): (&Table, &[usize]),
        source: GeometryError,
    ) -> Error {
        match source {
            GeometryError::InvalidWeight { index, weight } => {
                let message = format!("expected a positive weight, found {weight}");
                let at = table.at_row(rows[index]);
                Error::case(at, Problem::WrongValue { message })
            }
            _ => self.no_surface(document, source),
        }
    }
}

/// The control points in `control.csv`: every `i`, `j` from 1 on once, in any order.
fn net(folder: &Folder) -> Result<Net, Error> {
    let table = folder.table(CONTROL, NEEDED)?;
    let mut columns = Columns::new(&table, KNOWN);
    let [i, j] = [indices(&mut columns, &table, 0)?, indices(&mut columns, &table, 1)?];
    let [x, y, z] = PLACES.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let weights = if columns.has(WEIGHT) { columns.numbers(WEIGHT)? } else { vec![1.0; x.len()] };
    columns.rest(&ColumnKinds::default())?;
    let wrong = |at: Location, message: String| Error::case(at, Problem::WrongValue { message });
    let counts = [&i, &j].map(|of| of.iter().max().map_or(0, |last| last + 1));
    if counts[0] * counts[1] != table.n_rows() {
        let message = format!(
            "{} rows are no full net: i to {} and j to {} make {} control points",
            table.n_rows(),
            counts[0],
            counts[1],
            counts[0] * counts[1]
        );
        return Err(wrong(table.at_file(), message));
    }
    let mut rows: Vec<Option<usize>> = vec![None; table.n_rows()];
    for row in 0..table.n_rows() {
        let slot = &mut rows[i[row] + j[row] * counts[0]];
        if let Some(first) = *slot {
            let line = table.line(first);
            let message =
                format!("i = {}, j = {} is already on line {line}", i[row] + 1, j[row] + 1);
            return Err(wrong(table.at_row(row), message));
        }
        *slot = Some(row);
    }
    // As many rows as places, and none twice: every place has one.
    let rows: Vec<usize> = rows.into_iter().flatten().collect();
    let points_mm = rows.iter().map(|&row| Point3::new(x[row], y[row], z[row])).collect();
    let weights = rows.iter().map(|&row| weights[row]).collect();
    Ok(Net { counts, points_mm, weights, rows, table })
}

/// Indices from 0 on of one direction.
fn indices(columns: &mut Columns<'_>, table: &Table, d: usize) -> Result<Vec<usize>, Error> {
    let cells = columns.texts(INDICES[d])?;
    let index = |(row, cell): (usize, &&str)| {
        let number = cell.parse::<usize>().ok().filter(|n| (1..=MAX_COUNT).contains(n));
        number.map(|n| n - 1).ok_or_else(|| {
            let message = format!("expected a number 1, 2, 3, …, found {}", quote(cell));
            let at = table.at_cell(row, table.column(INDICES[d]).unwrap_or_default());
            Error::case(at, Problem::WrongValue { message })
        })
    };
    cells.iter().enumerate().map(index).collect()
}
