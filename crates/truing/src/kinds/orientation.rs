//! Orientations in tables, as unit quaternions.

use nalgebra::{Quaternion, UnitQuaternion};

use crate::Error;
use crate::case::{Change, Columns, Edit, Problem, Table};
use crate::suspect::{Hypothesis, component_shifted, signs};

pub(crate) const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];

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

/// What may be wrong with the columns of the quaternion.
pub(crate) fn mistakes_of_quaternion(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = component_shifted(file, table, &QUATERNION, LENGTH_TOL);
    all.extend(scalar_last(file));
    all.extend(turned(file, table));
    all
}

/// Components of the vector part of the opposite sign; all of them, the last of the sets, make the conjugate.
fn turned(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = signs(file, table, &QUATERNION[1..]);
    if let Some(conjugate) = all.last_mut() {
        conjugate.description.push_str(
            "; these are the conjugates, the inverse orientations: they map base axes to those of the sensor or flange",
        );
    }
    all
}

/// The scalar part of the quaternion written last instead of first, or read so.
fn scalar_last(file: &'static str) -> Vec<Hypothesis> {
    let one = |(by, what): (usize, &str)| {
        let columns = QUATERNION.map(str::to_owned).to_vec();
        let sources = (0..4).map(|i| QUATERNION[(i + by) % 4].to_owned()).collect();
        let description = format!(
            "the columns of the quaternion in {file} are exchanged (permuted): the scalar part \
             stands {what}"
        );
        let edits = vec![Edit { file, change: Change::Permute { columns, sources, rows: None } }];
        Hypothesis::of("input:exchanged", (file, &QUATERNION), description, edits)
    };
    [(3, "last"), (1, "first in the wrong place")].map(one).to_vec()
}
