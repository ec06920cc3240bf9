use nalgebra::{Point3, Unit, Vector3};
use pose_icp::PointCloud;

use super::ShapeProblem;

/// Coordinates, and normals where there are six columns.
///
/// Cells are separated by spaces, tabs, commas or semicolons. A first line that is not numbers is a
/// heading; lines that start with `#` or `//` are comments, and a line with one whole number before
/// all others is the count of points that `.pts` files begin with.
pub(super) fn parse(bytes: &[u8]) -> Result<PointCloud, ShapeProblem> {
    let text = std::str::from_utf8(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
        .map_err(|_| ShapeProblem::Malformed { format: "text", line: None })?;
    let mut rows = Rows::default();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if !(line.is_empty() || line.starts_with('#') || line.starts_with("//")) {
            rows.add(index + 1, line)?;
        }
    }
    rows.finish()
}

#[derive(Default)]
struct Rows {
    /// Cells of a row, once one was read.
    width: Option<usize>,
    is_past_heading: bool,
    points: Vec<Point3<f64>>,
    normals: Vec<Unit<Vector3<f64>>>,
}

impl Rows {
    fn add(&mut self, line: usize, text: &str) -> Result<(), ShapeProblem> {
        let is_separator = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let cells: Vec<&str> = text.split(is_separator).filter(|cell| !cell.is_empty()).collect();
        if !std::mem::replace(&mut self.is_past_heading, true) {
            let is_heading = cells.iter().all(|cell| cell.parse::<f64>().is_err());
            let is_count = cells.len() == 1 && cells[0].parse::<usize>().is_ok();
            if is_heading || is_count {
                return Ok(());
            }
        }
        let found = cells.len();
        match self.width {
            None if found == 3 || found == 6 => self.width = Some(found),
            None => return Err(ShapeProblem::Columns { line, found }),
            Some(expected) if found == expected => {}
            Some(expected) => return Err(ShapeProblem::Cells { line, expected, found }),
        }
        let mut numbers = [0.0; 6];
        for (column, (cell, number)) in cells.iter().zip(&mut numbers).enumerate() {
            *number = cell.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
                ShapeProblem::NotANumber { line, column: column + 1, found: (*cell).to_owned() }
            })?;
        }
        let [x, y, z, nx, ny, nz] = numbers;
        self.points.push(Point3::new(x, y, z));
        if found == 6 {
            let index = self.points.len() - 1;
            let normal = Unit::try_new(Vector3::new(nx, ny, nz), f64::MIN_POSITIVE);
            self.normals.push(normal.ok_or(ShapeProblem::NoNormal { index })?);
        }
        Ok(())
    }

    fn finish(self) -> Result<PointCloud, ShapeProblem> {
        if self.points.is_empty() {
            return Err(ShapeProblem::Nothing { what: "points" });
        }
        let normals = (self.width == Some(6)).then_some(self.normals);
        Ok(PointCloud { points_mm: self.points, normals })
    }
}
