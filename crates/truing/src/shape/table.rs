use nalgebra::{Point3, Unit, Vector3};
use pose_icp::PointCloud;

use super::ShapeProblem;
use crate::case::{Undecoded, Writing, decode, with_point, writing};
use crate::import::unit_of_coordinate;

/// Coordinates, and normals where there are six columns.
///
/// Cells are separated by spaces, tabs, commas or semicolons; where it is not commas that separate
/// them, decimals may have one. A first line that is not numbers is a heading; lines that start
/// with `#` or `//` are comments, and a line with one whole number before all others is the count
/// of points that `.pts` files begin with.
pub(super) fn parse(bytes: &[u8]) -> Result<PointCloud, ShapeProblem> {
    let decoded = decode(bytes.to_vec()).map_err(|e| {
        let Undecoded { line, column, problem } = e;
        ShapeProblem::NotText { line, column, problem }
    })?;
    let text = decoded.text.as_str();
    let mut rows = Rows { cells: Cells::of(text)?, ..Rows::default() };
    for (line, row) in data_lines(text) {
        rows.add(line, row)?;
    }
    rows.finish()
}

/// Lines with something on them that is no comment, and their numbers from 1.
fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    lines.filter(|(_, line)| {
        !(line.is_empty()
            || line.starts_with('#')
            || line.starts_with("//")
            || is_separator_line(line))
    })
}

/// The first line `sep=;` of spreadsheets: what it says is seen from the rows.
fn is_separator_line(line: &str) -> bool {
    matches!(line.trim_matches('"').to_ascii_lowercase().as_str(), "sep=;" | "sep=," | "sep=\t")
}

/// What the cells of a table are separated by, and how its numbers are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Cells {
    /// By anything but letters and digits; decimals with a point.
    #[default]
    Plain,
    /// By semicolons or blanks; decimals with a comma.
    DecimalComma { has_semicolons: bool },
    /// By semicolons; decimals with a point.
    Semicolons,
}

impl Cells {
    fn of(text: &str) -> Result<Self, ShapeProblem> {
        if !text.contains(',') {
            return Ok(Self::Plain);
        }
        let has_semicolons = data_lines(text).any(|(_, line)| line.contains(';'));
        if !has_semicolons && !data_lines(text).any(|(_, line)| has_commas_in_blanks(line)) {
            return Ok(Self::Plain);
        }
        let style = Self::DecimalComma { has_semicolons };
        let (mut comma, mut either, mut point) = (false, None, None);
        for (line, row) in data_lines(text) {
            for (index, cell) in style.split(row).enumerate() {
                let place = Some((line, index + 1, cell));
                match writing(cell) {
                    Writing::Plain => {}
                    Writing::Point => point = point.or(place),
                    Writing::Comma => comma = true,
                    Writing::CommaOrGroups => either = either.or(place),
                    Writing::Groups => return Err(two_ways(place)),
                }
            }
        }
        match (comma || either.is_some(), point) {
            (true, Some(_)) => Err(two_ways(point)),
            (true, None) if !comma => Err(two_ways(either)),
            (true, None) => Ok(style),
            (false, _) if has_semicolons => Ok(Self::Semicolons),
            (false, _) => Ok(Self::Plain),
        }
    }

    fn split(self, row: &str) -> impl Iterator<Item = &str> {
        let separates = move |c: char| match self {
            Self::Plain => c.is_whitespace() || c == ',' || c == ';',
            Self::DecimalComma { has_semicolons: true } | Self::Semicolons => c == ';',
            Self::DecimalComma { has_semicolons: false } => c.is_whitespace(),
        };
        row.split(separates).map(str::trim).filter(|cell| !cell.is_empty())
    }
}

/// Whether blanks separate cells of which some have a comma inside, as in `1,5 2,5 3,5`.
fn has_commas_in_blanks(row: &str) -> bool {
    let ends = |cell: &str| cell.starts_with(',') || cell.ends_with(',');
    let n = row.split_whitespace().count();
    (n == 3 || n == 6) && row.contains(',') && !row.split_whitespace().any(ends)
}

fn two_ways(place: Option<(usize, usize, &str)>) -> ShapeProblem {
    let (line, column, found) = place.unwrap_or((1, 1, ""));
    ShapeProblem::TwoWays { line, column, found: found.to_owned() }
}

#[derive(Default)]
struct Rows {
    cells: Cells,
    /// Cells of a row, once one was read.
    width: Option<usize>,
    is_past_heading: bool,
    points: Vec<Point3<f64>>,
    normals: Vec<Unit<Vector3<f64>>>,
}

impl Rows {
    fn add(&mut self, line: usize, text: &str) -> Result<(), ShapeProblem> {
        let cells: Vec<&str> = self.cells.split(text).collect();
        if !std::mem::replace(&mut self.is_past_heading, true) {
            let is_heading = cells.iter().all(|cell| number(cell).is_none());
            if is_heading {
                return units(line, &cells);
            }
            if cells.len() == 1 && cells[0].parse::<usize>().is_ok() {
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
        for (column, (cell, value)) in cells.iter().zip(&mut numbers).enumerate() {
            *value = number(cell).filter(|v| v.is_finite()).ok_or_else(|| {
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

/// A number with a point, or with a comma where commas separate nothing.
fn number(cell: &str) -> Option<f64> {
    cell.parse().ok().or_else(|| with_point(cell).parse().ok())
}

/// Refuses a heading that says another unit than mm.
fn units(line: usize, headings: &[&str]) -> Result<(), ShapeProblem> {
    let other = headings.iter().find(|h| unit_of_coordinate(h).is_some_and(|unit| unit != "mm"));
    match other {
        Some(found) => Err(ShapeProblem::OtherUnit { line, found: (*found).to_owned() }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{ShapeProblem, parse};

    fn points(text: &str) -> Vec<[f64; 3]> {
        let cloud = parse(text.as_bytes()).unwrap();
        cloud.points_mm.iter().map(|p| [p.x, p.y, p.z]).collect()
    }

    #[test]
    fn one_cloud_however_it_is_separated() {
        let expected = [[1.5, -2.25, 3.0], [0.5, 4.0, -0.125]];
        for text in [
            "1.5 -2.25 3\n0.5 4 -0.125\n",
            "1.5,-2.25,3\n0.5,4,-0.125\n",
            "1.5, -2.25, 3\n0.5 ,4 ,-0.125\n",
            "x;y;z\n1.5;-2.25;3\n0.5;4;-0.125\n",
            "sep=;\nx;y;z\n1,5;-2,25;3\n0,5;4;-0,125\n",
            "1,5 -2,25 3\n0,5 4 -0,125\n",
            "1,5\t-2,25\t3\n0,5\t4\t-0,125\n",
            "x, mm; y, mm; z, mm\n1,5; -2,25; 3\n0,5; 4; -0,125\n",
        ] {
            assert_eq!(points(text), expected, "{text}");
        }
        let wide: Vec<u8> = "1,5;-2,25;3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let cloud = parse(&[&b"\xff\xfe"[..], &wide].concat()).unwrap();
        assert_eq!(cloud.points_mm[0].coords.as_slice(), [1.5, -2.25, 3.0]);
    }

    #[test]
    fn what_is_no_text_is_told_with_the_format() {
        for (bytes, said) in [
            (&b"PK\x03\x04\x14\0"[..], "line 1, column 1: this is a spreadsheet workbook"),
            (b"1 2 3\n4 5 \xb5", "line 2, column 5: expected UTF-8 text, found byte 0xb5"),
        ] {
            let message = parse(bytes).unwrap_err().to_string();
            assert!(message.starts_with(said), "{message}");
            assert!(message.ends_with("one point a line, x, y, z or x, y, z, nx, ny, nz in mm"));
        }
    }

    #[test]
    fn what_can_be_read_in_two_ways_is_refused() {
        for (text, line, column) in [
            ("1,234;2;3\n4;5;6\n", 1, 1),
            ("1,5;2;3\n4;5.5;6\n", 2, 2),
            ("1;2;3\n1.234,5;5;6\n", 2, 1),
            ("1,234 2,345 3,456\n", 1, 1),
        ] {
            match parse(text.as_bytes()) {
                Err(ShapeProblem::TwoWays { line: l, column: c, .. }) => {
                    assert_eq!((l, c), (line, column), "{text}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(matches!(
            parse(b"x_um y_um z_um\n1 2 3\n"),
            Err(ShapeProblem::OtherUnit { line: 1, .. })
        ));
        assert!(parse(b"x_mm y_mm z_mm nx ny nz\n1 2 3 0 0 1\n").is_ok());
    }
}
