use geometry::Wrench;
use nalgebra::Vector3;

use crate::Error;
use crate::case::Columns;

/// One wrench per row, from the six columns of a table.
pub(super) fn wrenches(columns: &mut Columns<'_>) -> Result<Vec<Wrench>, Error> {
    let mut six = Vec::with_capacity(6);
    for name in ["fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"] {
        six.push(columns.numbers(name)?);
    }
    let wrench = |row: usize| Wrench {
        force_n: Vector3::new(six[0][row], six[1][row], six[2][row]),
        torque_nmm: Vector3::new(six[3][row], six[4][row], six[5][row]),
    };
    Ok((0..six[0].len()).map(wrench).collect())
}
