//! Where a part lies, out of what `truing loop` printed.

use std::path::Path;

use nalgebra::{Affine3, Matrix4};
use serde::Deserialize;

use crate::carry::CarryProblem;
use crate::file::{MAX_BYTES, read_bytes};
use crate::{Error, PoseIcpEstimates};

#[derive(Deserialize)]
struct Answer {
    kind: String,
    estimates: Estimates,
}

#[derive(Deserialize)]
struct Estimates {
    matrix: [[f64; 4]; 4],
    points: Vec<Touch>,
}

#[derive(Deserialize)]
struct Touch {
    #[serde(rename = "point")]
    name: String,
    x_mm: f64,
    y_mm: f64,
    z_mm: f64,
}

/// What takes a point of the workpiece to where the machine reads it, by an answer of the loop on
/// the touches that `solved` is from.
pub(crate) fn found_pose(path: &Path, solved: &PoseIcpEstimates) -> Result<Affine3<f64>, Error> {
    let fail = |problem| Error::carry(path, problem);
    let text = read_bytes(path, MAX_BYTES)
        .map_err(|problem| fail(CarryProblem::Unreadable { problem }))?;
    let answer: Answer = serde_json::from_slice(&text).map_err(|source| {
        fail(if source.is_data() {
            CarryProblem::NotAnAnswer { source }
        } else {
            CarryProblem::NotJson { source }
        })
    })?;
    if answer.kind != KIND {
        return Err(fail(CarryProblem::OtherKind { found: answer.kind, expected: KIND }));
    }
    let (there, here) = (&answer.estimates.points, &solved.points);
    // Numbers come out of JSON as they went in.
    let differs = here.iter().enumerate().find(|(i, p)| {
        there.get(*i).is_none_or(|t| {
            let bits = |place: [f64; 3]| place.map(f64::to_bits);
            t.name != p.point || bits([t.x_mm, t.y_mm, t.z_mm]) != bits([p.x_mm, p.y_mm, p.z_mm])
        })
    });
    let surplus = there.get(here.len()).map(|t| t.name.clone());
    if let Some(point) = differs.map(|(_, p)| p.point.clone()).or(surplus) {
        return Err(fail(CarryProblem::OtherMeasurement { point }));
    }
    let matrix = answer.estimates.matrix;
    let matrix = Matrix4::from_fn(|row, column| matrix[row][column]);
    Ok(Affine3::from_matrix_unchecked(matrix))
}

const KIND: &str = "pose-icp";
