//! Normals measured by touching around a place.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Point3, Unit, Vector2, Vector3};

use crate::ProbeError;

/// Spread of the neighbours across a line over that along it, below which they lie on it.
const MIN_SPREAD: f64 = 1e-6;
/// Singular values of a design below this share of the largest leave a coefficient free.
const MIN_SINGULAR: f64 = 1e-9;

/// What is fitted to the balls' centres around a touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LocalShape {
    /// `w = a + b u + c v`: through three centres exactly, through more by least squares.
    Plane,
    /// The same with `u², u v, v²`, the touch itself included.
    Quadric,
}

impl LocalShape {
    /// Fewest neighbours.
    pub(crate) fn needed(self) -> usize {
        match self {
            Self::Plane => 3,
            Self::Quadric => 5,
        }
    }

    fn row(self, [u, v]: [f64; 2]) -> Vec<f64> {
        match self {
            Self::Plane => vec![1.0, u, v],
            Self::Quadric => vec![1.0, u, v, u * u, u * v, v * v],
        }
    }
}

/// A measured normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasuredNormal {
    /// Towards the side of the normal that it was asked for.
    pub(crate) normal: Unit<Vector3<f64>>,
    /// Covariance of the unit vector over the variance of a coordinate, 1/mm².
    pub(crate) spread_per_mm2: Matrix3<f64>,
}

/// Normal at `center` of the surface on which the balls' centres lie; it is that of the part.
pub(crate) fn measured_normal(
    index: usize,
    center: &Point3<f64>,
    neighbours: &[Point3<f64>],
    about: &Unit<Vector3<f64>>,
    shape: LocalShape,
) -> Result<MeasuredNormal, ProbeError> {
    let (got, needed) = (neighbours.len(), shape.needed());
    if got < needed {
        return Err(ProbeError::TooFewNeighbours { index, got, needed });
    }
    let frame = Frame::about(about);
    let mut local: Vec<Vector3<f64>> =
        neighbours.iter().map(|p| frame.local(&(p - center))).collect();
    spread(index, &local)?;
    if shape == LocalShape::Quadric {
        local.push(Vector3::zeros());
    }
    // In units of the neighbours' distance, all columns are of one size.
    let unit_mm = local.iter().map(|p| p.xy().norm()).fold(0.0, f64::max);
    let rows: Vec<Vec<f64>> =
        local.iter().map(|p| shape.row([p.x / unit_mm, p.y / unit_mm])).collect();
    let design = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let heights = DVector::from_iterator(local.len(), local.iter().map(|p| p.z));
    let svd = design.svd(true, true);
    let smallest = MIN_SINGULAR * svd.singular_values.max();
    if svd.rank(smallest) < rows[0].len() {
        return Err(ProbeError::TooFewNeighbours { index, got, needed: needed + 1 });
    }
    let fitted = svd.solve(&heights, smallest).expect("both factors were asked for");
    let slope = Vector2::new(fitted[1], fitted[2]) / unit_mm;
    let v_t = svd.v_t.expect("it was asked for");
    let inverse = DVector::from_iterator(
        svd.singular_values.len(),
        svd.singular_values.iter().map(|s| s.powi(-2)),
    );
    let covariance = v_t.transpose() * DMatrix::from_diagonal(&inverse) * v_t;
    let slopes = Matrix2::from_fn(|i, j| covariance[(i + 1, j + 1)]) / (unit_mm * unit_mm);
    Ok(frame.tilted(&slope, &slopes))
}

/// Orthonormal axes with w along a normal.
struct Frame {
    axes: Matrix3<f64>,
}

impl Frame {
    fn about(w: &Unit<Vector3<f64>>) -> Self {
        // The axis least aligned with the normal gives the best conditioned tangent.
        let u = w.cross(&Vector3::ith(w.iamin(), 1.0)).normalize();
        Self { axes: Matrix3::from_columns(&[u, w.cross(&u), w.into_inner()]) }
    }

    fn local(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.axes.tr_mul(v)
    }

    /// The normal of a plane of that slope; the noise of a reading tilts it by that of the slope,
    /// and the noise of its place by that times the slope, hence the stretch.
    fn tilted(&self, slope: &Vector2<f64>, slopes_per_mm2: &Matrix2<f64>) -> MeasuredNormal {
        let stretch = 1.0 + slope.norm_squared();
        let normal = Unit::new_normalize(self.axes * Vector3::new(-slope.x, -slope.y, 1.0));
        let project = Matrix3::identity() - normal.into_inner() * normal.transpose();
        let by_slope = project * self.axes.fixed_columns::<2>(0) / stretch.sqrt();
        let spread_per_mm2 = by_slope * slopes_per_mm2 * by_slope.transpose() * stretch;
        MeasuredNormal { normal, spread_per_mm2 }
    }
}

fn spread(index: usize, local: &[Vector3<f64>]) -> Result<(), ProbeError> {
    #[expect(clippy::cast_precision_loss, reason = "a handful of neighbours")]
    let n = local.len() as f64;
    let mean = local.iter().fold(Vector2::zeros(), |sum: Vector2<f64>, p| sum + p.xy()) / n;
    let scatter = local.iter().fold(Matrix2::zeros(), |sum: Matrix2<f64>, p| {
        let arm = p.xy() - mean;
        sum + arm * arm.transpose()
    });
    let eigen = scatter.symmetric_eigenvalues().map(|v| (v.max(0.0) / n).sqrt());
    let (major_mm, minor_mm) = (eigen.max(), eigen.min());
    // Also true for NaN.
    let spans_a_plane = minor_mm > MIN_SPREAD * major_mm;
    if spans_a_plane {
        Ok(())
    } else {
        Err(ProbeError::NeighboursOnALine { index, major_mm, minor_mm })
    }
}
