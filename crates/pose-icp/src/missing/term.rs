//! What the effects do to a touch.

use model_discrepancy::Patch;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::form::Form;

/// What one effect does.
#[derive(Clone, Debug)]
pub(crate) enum Term {
    /// Pose parameters that the declared model holds: indices into `[x y z α β γ]`.
    Pose(Vec<usize>),
    /// The ball is larger than declared.
    Tip,
    /// The surface is not the nominal one.
    Form(Form),
    /// It is higher in one place.
    Patch(Patch),
    /// The machine reads one axis long, about `fixed_mm`.
    Scale { fixed_mm: Vector3<f64>, axis: usize },
    /// The machine's axes are not square: `first += γ second` for each pair; about `fixed_mm`.
    Squareness { fixed_mm: Vector3<f64>, pairs: Vec<(usize, usize)> },
    /// Axes stop behind where they are read, on the side that they came from: +1 or −1 by touch along
    /// each of `axes`.
    Reversal { ways: Vec<Vector3<f64>>, axes: Vec<usize>, ways_from: WaysFrom },
    /// Readings along the axes in `axes` go with time or order.
    Drift { elapsed: Vec<f64>, axes: Vec<usize> },
    /// Readings along axes, and the part's size, go with a temperature.
    Temperature { excess_k: Vec<f64>, axes: Vec<usize> },
    /// One touch is off on its own.
    BadPoint { observation: usize },
}

/// What says from which side an axis came to a touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WaysFrom {
    /// The touch before: the axis was sent there first, and the touch itself is made along another one.
    TouchBefore,
    /// The approach: the ball comes along the normal, with all axes moving.
    Approach,
    /// A recorded column, which has one sign for a way there and the other for the way back.
    Column,
}

/// Where and how a touch was made.
pub(crate) struct Contact<'a> {
    pub(crate) observation: usize,
    /// Ball's centre as read, machine frame.
    pub(crate) center_mm: Vector3<f64>,
    /// Contact in the part as declared, workpiece frame.
    pub(crate) foot: &'a geometry::Foot,
}

impl Term {
    /// Time that had passed at each observation, of a drift.
    pub(crate) fn elapsed(&self) -> Option<&[f64]> {
        match self {
            Self::Drift { elapsed, .. } => Some(elapsed),
            _ => None,
        }
    }

    /// What a unit of each amplitude adds to the reading per distance from the place where the machine reads right;
    /// empty where the effect does not grow with it.
    pub(crate) fn of_distance(&self) -> Vec<Matrix3<f64>> {
        let along = |first: usize, second: usize| {
            Vector3::ith(first, 1.0) * Vector3::ith(second, 1.0).transpose()
        };
        match self {
            Self::Scale { axis, .. } => vec![along(*axis, *axis)],
            Self::Squareness { pairs, .. } => {
                pairs.iter().map(|&(first, second)| along(first, second)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// What a unit of each amplitude adds to the reading, machine frame; empty where the effect
    /// is not one of the machine.
    pub(crate) fn readings(&self, contact: &Contact<'_>) -> Vec<Vector3<f64>> {
        match self {
            Self::Scale { fixed_mm, .. } | Self::Squareness { fixed_mm, .. } => {
                let arm = contact.center_mm - fixed_mm;
                self.of_distance().into_iter().map(|adds| adds * arm).collect()
            }
            Self::Reversal { ways, axes, ways_from } => {
                let way = ways.get(contact.observation).copied().unwrap_or_default();
                let along = axes.iter().map(|&axis| Vector3::ith(axis, way[axis]));
                let first = (*ways_from == WaysFrom::TouchBefore).then(Vector3::zeros);
                along.chain(first).collect()
            }
            Self::Drift { elapsed, axes } => {
                let elapsed = elapsed.get(contact.observation).copied().unwrap_or(0.0);
                axes.iter().map(|&axis| Vector3::ith(axis, elapsed)).collect()
            }
            Self::Temperature { excess_k, axes } => {
                let excess_k = excess_k.get(contact.observation).copied().unwrap_or(0.0);
                let along = axes.iter().map(|&axis| Vector3::ith(axis, excess_k));
                along.chain([Vector3::zeros()]).collect()
            }
            _ => Vec::new(),
        }
    }

    /// What a unit of each amplitude adds to the distance from the nominal surface, apart from
    /// [`Term::readings`]; empty where it adds nothing.
    pub(crate) fn distances(&self, contact: &Contact<'_>, parts: &Distances<'_>) -> Vec<f64> {
        let normal = contact.foot.normal;
        match self {
            Self::Tip => vec![parts.side],
            Self::Form(form) => form
                .heights(parts.shape, parts.radius_mm, &contact.foot.point_mm)
                .into_iter()
                .map(|height| height * normal.z)
                .collect(),
            Self::Patch(patch) => vec![patch.share(&contact.foot.point_mm)],
            Self::Reversal { ways, axes, ways_from: WaysFrom::TouchBefore } => {
                // From which side an axis came to the first touch is not known.
                let way = ways.get(contact.observation);
                let is_unknown = way.is_some_and(|way| axes.iter().any(|&axis| way[axis] == 0.0));
                let mut distances = vec![0.0; axes.len()];
                distances.push(f64::from(u8::from(is_unknown)));
                distances
            }
            Self::Temperature { excess_k, axes } => {
                let excess_k = excess_k.get(contact.observation).copied().unwrap_or(0.0);
                let growth = normal.dot(&contact.foot.point_mm.coords) * excess_k;
                axes.iter().map(|_| 0.0).chain([growth]).collect()
            }
            Self::BadPoint { observation } => {
                vec![f64::from(u8::from(*observation == contact.observation))]
            }
            _ => Vec::new(),
        }
    }
}

/// What [`Term::distances`] needs to know of the part.
pub(crate) struct Distances<'a> {
    pub(crate) shape: Option<&'a geometry::AsphereShape>,
    /// Where ρ = 1.
    pub(crate) radius_mm: f64,
    /// +1 or −1: the side on which the ball is.
    pub(crate) side: f64,
}

/// Sum of the columns times the amplitudes.
pub(crate) fn combined(columns: &[Vector3<f64>], amplitudes: &DVector<f64>) -> Vector3<f64> {
    columns.iter().zip(amplitudes.iter()).fold(Vector3::zeros(), |sum, (c, a)| sum + c * *a)
}

/// Rows of every touch, zero elsewhere.
pub(crate) fn stacked(
    n_rows: usize,
    columns: usize,
    of_touch: impl Fn(usize) -> Vec<f64>,
    touches: usize,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(n_rows, columns);
    for i in 0..touches {
        for (j, value) in of_touch(i).into_iter().enumerate().take(columns) {
            out[(i, j)] = value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use geometry::{Plane, Surface};
    use nalgebra::Point3;

    use super::*;

    /// An axis that came to the first touch from nobody knows where has a reading of its own there.
    #[test]
    fn where_no_way_is_known_the_reversal_is_a_distance_of_its_own() {
        let plane = Plane::new(Point3::origin(), Vector3::z()).expect("a plane");
        let foot = plane.closest_point(&Point3::new(1.0, 2.0, 3.0)).expect("a foot");
        let term = Term::Reversal {
            ways: vec![Vector3::new(1.0, 0.0, 0.0), Vector3::new(1.0, -1.0, -1.0)],
            axes: vec![1, 2],
            ways_from: WaysFrom::TouchBefore,
        };
        let parts = Distances { shape: None, radius_mm: 1.0, side: 1.0 };
        let at = |observation: usize| {
            let contact =
                Contact { observation, center_mm: Vector3::new(1.0, 2.0, 3.0), foot: &foot };
            term.distances(&contact, &parts)
        };
        assert_eq!(at(0), [0.0, 0.0, 1.0]);
        assert_eq!(at(1), [0.0; 3]);
    }
}
