use super::hypothesis::{Hypothesis, present};
use super::order::rows_shifted_by;
use crate::case::Table;

/// Rows by which a component may stand too far down or up.
const FARTHEST: isize = 3;
/// Rows from which on lengths of one are no accident.
const FEWEST: usize = 8;

/// A component of unit vectors some rows further down or up than the others, where so they have the length of one in every
/// row and as they stand they have not: shown by the data, whatever is fitted.
pub(crate) fn component_shifted(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    tolerance: f64,
) -> Vec<Hypothesis> {
    let shifted = || {
        let table = table?;
        let values: Option<Vec<Vec<f64>>> =
            columns.iter().map(|name| table.numbers(name)).collect();
        let (component, by) = shift_to_unit_length(&values?, tolerance)?;
        Some(rows_shifted_by(file, Some(table), &[columns[component]], None, by))
    };
    let is_there = present(table, columns).len() == columns.len();
    let found = is_there.then(shifted).flatten().unwrap_or_default();
    found.into_iter().map(Hypothesis::certain).collect()
}

/// The component with the rows by which it stands too far down that come nearest to the length of one.
fn shift_to_unit_length(values: &[Vec<f64>], tolerance: f64) -> Option<(usize, isize)> {
    let n = values.first()?.len();
    let farthest_off = |component: usize, by: isize| {
        let length = |row: usize| {
            let square = |(c, of): (usize, &Vec<f64>)| {
                let at = if c == component { row.checked_add_signed(by)? } else { row };
                Some(of.get(at)?.powi(2))
            };
            Some(values.iter().enumerate().map(square).sum::<Option<f64>>()?.sqrt())
        };
        (0..n).filter_map(length).map(|length| (length - 1.0).abs()).fold(0.0, f64::max)
    };
    if n < FEWEST || farthest_off(0, 0) <= tolerance {
        return None;
    }
    let shifts = (-FARTHEST..=FARTHEST).filter(|by| *by != 0);
    let all = shifts.flat_map(|by| (0..values.len()).map(move |component| (component, by)));
    let off = all.map(|(component, by)| (farthest_off(component, by), (component, by)));
    let (least, best) = off.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    (least <= tolerance).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::shift_to_unit_length;

    const TOLERANCE: f64 = 1e-3;

    fn normals() -> Vec<Vec<f64>> {
        let rows: Vec<[f64; 3]> = (0..40)
            .map(|i| {
                let (tilt, turn) = (0.3 + 0.05 * f64::from(i % 7), 0.4 * f64::from(i));
                [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()]
            })
            .collect();
        (0..3).map(|c| rows.iter().map(|row| row[c]).collect()).collect()
    }

    #[test]
    fn the_component_that_is_two_rows_late_is_found() {
        let mut values = normals();
        values[2].rotate_right(2);
        assert_eq!(shift_to_unit_length(&values, TOLERANCE), Some((2, 2)));
    }

    #[test]
    fn unit_vectors_and_numbers_that_are_none_show_no_shift() {
        let mut values = normals();
        assert_eq!(shift_to_unit_length(&values, TOLERANCE), None);
        values[0].iter_mut().for_each(|x| *x *= 1.1);
        assert_eq!(shift_to_unit_length(&values, TOLERANCE), None);
    }
}
