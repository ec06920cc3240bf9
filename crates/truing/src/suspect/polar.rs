use super::hypothesis::{Hypothesis, listed, present};
use crate::case::{Change, Edit, Table};

/// Two coordinates of a place given as radius and angle in degrees.
pub(crate) fn polar(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let there = present(Some(table), columns);
    let of_pair = |[first, second]: [usize; 2]| {
        let pair = [*there.get(first)?, *there.get(second)?];
        let (radii, angles) = (table.numbers(pair[0])?, table.numbers(pair[1])?);
        let are_radii = radii.iter().all(|r| *r >= 0.0);
        let are_degrees = angles.iter().all(|a| a.abs() <= 360.0);
        if !are_radii || !are_degrees {
            return None;
        }
        let places = radii.iter().zip(&angles).map(|(r, a)| {
            let (sin, cos) = a.to_radians().sin_cos();
            [r * cos, r * sin]
        });
        let (x, y): (Vec<f64>, Vec<f64>) = places.map(|[x, y]| (x, y)).unzip();
        let description = format!(
            "{} of {file} are polar coordinates, a radius and an angle in degrees, in place of Cartesian ones: \
             convert them",
            listed(&pair)
        );
        let edit = |(column, values): (&str, Vec<f64>)| Edit {
            file,
            change: Change::Replace { column: column.to_owned(), values },
        };
        let edits = [(pair[0], x), (pair[1], y)].map(edit).to_vec();
        Some(Hypothesis::of("input:polar", (file, &pair), description, edits))
    };
    [[0, 1], [0, 2], [1, 2]].into_iter().filter_map(of_pair).collect()
}
