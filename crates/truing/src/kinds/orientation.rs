//! Orientations in tables, as unit quaternions.

use nalgebra::{Quaternion, UnitQuaternion};

use crate::Error;
use crate::case::{Columns, Problem, Table};

/// Quaternions printed with four digits are this close to unit length; others are slips.
pub(crate) const LENGTH_TOL: f64 = 1e-3;

/// Columns `qw`, `qx`, `qy`, `qz`.
pub(crate) fn orientations(
    table: &Table,
    columns: &mut Columns<'_>,
) -> Result<Vec<UnitQuaternion<f64>>, Error> {
    let (w, x) = (columns.numbers("qw")?, columns.numbers("qx")?);
    let (y, z) = (columns.numbers("qy")?, columns.numbers("qz")?);
    let orientation = |row: usize| {
        let quaternion = Quaternion::new(w[row], x[row], y[row], z[row]);
        let length = quaternion.norm();
        if (length - 1.0).abs() > LENGTH_TOL {
            return Err(Error::case(table.at_row(row), Problem::NotAUnitQuaternion { length }));
        }
        Ok(UnitQuaternion::from_quaternion(quaternion))
    };
    (0..w.len()).map(orientation).collect()
}
