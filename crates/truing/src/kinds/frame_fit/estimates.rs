use frame_fit::{FrameMap, NearestSimilarity, shape_of};
use geometry::{EulerAngles, EulerReading};
use nalgebra::{DMatrix, Matrix3, Rotation3, SMatrix, UnitQuaternion, Vector3};
use serde::Serialize;

use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::{Cell, TextTable};

/// Share of the other variances below which that of scale or rotation is round-off of the quadratic
/// form, some units in the last place: neither is estimated.
const NOT_ESTIMATED: f64 = 1e-12;

/// What a `frame-fit` case is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameFitEstimates {
    /// Rows of the homogeneous matrix that maps `from` to `to`: 3 × 3 planar, 4 × 4 spatial.
    pub matrix: Vec<Vec<f64>>,
    /// Its last column.
    pub translation_mm: Vec<f64>,
    /// Angles of the rotation nearest to the linear part.
    ///
    /// `[α, β, γ]` of `Rz(γ) Ry(β) Rx(α)`, planar `[γ]`; `None` where the map mirrors.
    pub angles_deg: Option<Vec<f64>>,
    /// Geometric mean of the principal scales; 1 for a rigid transform.
    pub scale: f64,
    /// `proper`, or `improper` where the map mirrors.
    pub handedness: String,
    /// Standard uncertainties; `None` where the noise is unknown and nothing is redundant.
    pub std: Option<TransformStd>,
    /// Covariance of the entries of the first rows of `matrix`, row by row, their last in mm.
    pub matrix_covariance: Option<Vec<Vec<f64>>>,
    /// Point of the first frame to which scales, shears and rotations refer: the centroid of the
    /// fitted points, or the origin where the frames share it.
    pub reference_mm: Vec<f64>,
    /// When the matrix holds, and what of the accepted effects it leaves to the corrections.
    pub conditions: Vec<String>,
    /// Scale of the similarity nearest to matrix and distortion together, where there is one.
    pub nearest_similarity: Option<ScaleEstimate>,
    /// Residual of every point, in the order of the table.
    pub points: Vec<PointResidual>,
}

/// A scale with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaleEstimate {
    /// The scale.
    pub scale: f64,
    /// Its standard uncertainty.
    pub std_scale: f64,
}

/// Standard uncertainties of a transform.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransformStd {
    /// Of `translation_mm`.
    pub translation_mm: Vec<f64>,
    /// Of `angles_deg`; `None` where the angles are not estimated, or not unique.
    pub angles_deg: Option<Vec<f64>>,
    /// Of the scale, where there is one to estimate.
    pub scale: Option<f64>,
    /// Of `matrix`, row by row; the last row is exact.
    pub matrix: Vec<Vec<f64>>,
}

/// Residual `to − (matrix · from + correction)` of one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointResidual {
    /// Name of the point.
    pub point: String,
    /// `fit` or `check`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Along x.
    pub dx_mm: f64,
    /// Along y.
    pub dy_mm: f64,
    /// Along z; `None` in a planar case.
    pub dz_mm: Option<f64>,
    /// What the accepted effects add to this reading beyond the matrix, along x.
    pub correction_x_mm: f64,
    /// Along y.
    pub correction_y_mm: f64,
    /// Along z; `None` in a planar case.
    pub correction_z_mm: Option<f64>,
}

/// A map as handed back, with what belongs to it.
pub(super) struct HandedBack<const D: usize> {
    pub(super) map: FrameMap<D>,
    /// Of the entries of `[L | t]`, row by row; `None` where the noise is not known.
    pub(super) covariance: Option<DMatrix<f64>>,
    pub(super) reference_mm: Vec<f64>,
    pub(super) conditions: Vec<String>,
    pub(super) nearest_similarity: Option<NearestSimilarity>,
}

impl FrameFitEstimates {
    pub(super) fn of<const D: usize>(
        handed_back: HandedBack<D>,
        points: Vec<PointResidual>,
    ) -> Self {
        let HandedBack { map, covariance, reference_mm, conditions, nearest_similarity } =
            handed_back;
        let covariance = covariance.filter(|c| c.amax() > 0.0);
        let shape = shape_of(&map);
        let angles = angles(&map).map(|a| {
            let a = a.angles();
            let all = [a.alpha_rad, a.beta_rad, a.gamma_rad].map(f64::to_degrees);
            if D == 2 { vec![all[2]] } else { all.to_vec() }
        });
        Self {
            matrix: map.homogeneous_rows(),
            translation_mm: map.translation_mm.iter().copied().collect(),
            angles_deg: angles,
            scale: shape.mean_scale,
            handedness: shape.handedness.to_string(),
            std: covariance.as_ref().map(|c| TransformStd::of(&map, c)),
            matrix_covariance: covariance
                .map(|c| c.row_iter().map(|row| row.iter().copied().collect()).collect()),
            reference_mm,
            conditions,
            nearest_similarity: nearest_similarity
                .map(|n| ScaleEstimate { scale: n.scale, std_scale: n.std_scale }),
            points,
        }
    }
}

impl Estimates for FrameFitEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let std = self.std.as_ref();
        let mut all = Vec::new();
        for (i, value) in self.translation_mm.iter().enumerate() {
            let std = std.map(|s| s.translation_mm[i]);
            all.push(Estimated::new(["x", "y", "z"][i], "mm", *value, std));
        }
        let names = if self.translation_mm.len() == 2 {
            &["angle"][..]
        } else {
            &["alpha", "beta", "gamma"]
        };
        for (i, value) in self.angles_deg.iter().flatten().enumerate() {
            let std = std.and_then(|s| s.angles_deg.as_ref()).map(|s| s[i]);
            all.push(Estimated::new(names[i], "°", *value, std));
        }
        all.push(Estimated::new("scale", "", self.scale, std.and_then(|s| s.scale)));
        if let Some(n) = self.nearest_similarity {
            let name = "scale of the nearest similarity";
            all.push(Estimated::new(name, "", n.scale, Some(n.std_scale)));
        }
        all
    }

    fn tables(&self) -> Vec<TextTable> {
        let planar = self.translation_mm.len() == 2;
        let corrected = !self.conditions.is_empty();
        let columns: &[&'static str] = match (planar, corrected) {
            (true, false) => &["point", "use", "dx mm", "dy mm"],
            (true, true) => {
                &["point", "use", "dx mm", "dy mm", "correction x mm", "correction y mm"]
            }
            (false, false) => &["point", "use", "dx mm", "dy mm", "dz mm"],
            (false, true) => &[
                "point",
                "use",
                "dx mm",
                "dy mm",
                "dz mm",
                "correction x mm",
                "correction y mm",
                "correction z mm",
            ],
        };
        let title = if corrected {
            "residual to − (matrix · from + correction)"
        } else {
            "residual to − T(from)"
        };
        let mut table = TextTable::new(title, columns);
        for p in &self.points {
            let mut row: Vec<Cell> = vec![p.point.clone().into(), p.usage.into()];
            row.extend([Cell::from(p.dx_mm), p.dy_mm.into()]);
            row.extend(p.dz_mm.map(Cell::from));
            if corrected {
                row.extend([Cell::from(p.correction_x_mm), p.correction_y_mm.into()]);
                row.extend(p.correction_z_mm.map(Cell::from));
            }
            table.push(row);
        }
        vec![table]
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        // A frame may be anywhere: grids of land surveys are thousands of kilometres from their zero.
        None
    }
}

impl TransformStd {
    /// Uncertainties from the covariance of the entries of `[L | t]`.
    fn of<const D: usize>(map: &FrameMap<D>, covariance: &DMatrix<f64>) -> Self {
        let std: Vec<f64> = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        let mut matrix: Vec<Vec<f64>> = std.chunks(D + 1).map(<[f64]>::to_vec).collect();
        matrix.push(vec![0.0; D + 1]);
        Self {
            translation_mm: matrix[..D].iter().map(|row| row[D]).collect(),
            angles_deg: angles_std(map, covariance),
            scale: scale_std(map, covariance),
            matrix,
        }
    }
}

/// The linear part of a change of the entries of `[L | t]`.
fn linear_of<const D: usize>(entries: &[f64]) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|row, column| entries[row * (D + 1) + column])
}

/// Derivative of functions of the linear part by the entries, one row per function.
fn by_entries<const D: usize>(
    functions: usize,
    of_linear: impl Fn(&SMatrix<f64, D, D>) -> Vec<f64>,
) -> DMatrix<f64> {
    let n = D * (D + 1);
    let mut jacobian = DMatrix::zeros(functions, n);
    for entry in 0..n {
        let unit: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == entry))).collect();
        for (row, value) in of_linear(&linear_of::<D>(&unit)).into_iter().enumerate() {
            jacobian[(row, entry)] = value;
        }
    }
    jacobian
}

/// Of the geometric mean of the principal scales; `None` where no change of it is estimated.
fn scale_std<const D: usize>(map: &FrameMap<D>, covariance: &DMatrix<f64>) -> Option<f64> {
    let inverse = dynamic(&map.linear).try_inverse()?;
    #[expect(clippy::cast_precision_loss, reason = "two or three")]
    let dimension = D as f64;
    let scale = shape_of(map).mean_scale;
    // d ln det L = tr(L⁻¹ dL).
    let jacobian =
        by_entries::<D>(1, |d| vec![scale * (&inverse * dynamic(d)).trace() / dimension]);
    let variance = (&jacobian * covariance * jacobian.transpose())[(0, 0)];
    (variance > NOT_ESTIMATED * linear_variance::<D>(covariance)).then(|| variance.sqrt())
}

/// Largest variance of an entry of the linear part.
fn linear_variance<const D: usize>(covariance: &DMatrix<f64>) -> f64 {
    let linear = (0..D * (D + 1)).filter(|k| k % (D + 1) < D);
    linear.map(|k| covariance[(k, k)]).fold(0.0, f64::max)
}

/// Of the angles of the nearest rotation `R`, `L = R U`.
///
/// From `dL = [ω]× L + R dU`: the skew part of `Rᵀ dL` is that of `[Rᵀω]× U`, whose vector is
/// `(tr U − U) Rᵀω / 2`.
fn angles_std<const D: usize>(map: &FrameMap<D>, covariance: &DMatrix<f64>) -> Option<Vec<f64>> {
    let EulerReading::Unique(angles) = angles(map)? else { return None };
    let rotation = shape_of(map).rotation;
    let stretch = embedded(&(rotation.transpose() * map.linear), 1.0);
    let rotation = embedded(&rotation, 1.0);
    let solved = (Matrix3::identity() * stretch.trace() - stretch).try_inverse()?;
    let jacobian = by_entries::<D>(3, |d| {
        let skew = rotation.transpose() * embedded(d, 0.0);
        let vector = Vector3::new(
            skew[(2, 1)] - skew[(1, 2)],
            skew[(0, 2)] - skew[(2, 0)],
            skew[(1, 0)] - skew[(0, 1)],
        );
        (rotation * solved * vector).iter().copied().collect()
    });
    let turned = &jacobian * covariance * jacobian.transpose();
    let turned: Matrix3<f64> = turned.fixed_view::<3, 3>(0, 0).into_owned();
    if turned.diagonal().amax()
        <= NOT_ESTIMATED * linear_variance::<D>(covariance).max(f64::MIN_POSITIVE)
    {
        return None;
    }
    let inverse = angles.left_jacobian().try_inverse()?;
    let of_angles = inverse * turned * inverse.transpose();
    let all = of_angles.diagonal().map(|v| v.max(0.0).sqrt().to_degrees());
    Some(if D == 2 { vec![all[2]] } else { all.iter().copied().collect() })
}

fn dynamic<const D: usize>(matrix: &SMatrix<f64, D, D>) -> DMatrix<f64> {
    DMatrix::from_column_slice(D, D, matrix.as_slice())
}

/// A planar matrix in space, with `rest` on the diagonal beyond.
fn embedded<const D: usize>(matrix: &SMatrix<f64, D, D>, rest: f64) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| match (row < D, column < D) {
        (true, true) => matrix[(row, column)],
        _ if row == column => rest,
        _ => 0.0,
    })
}

fn angles<const D: usize>(map: &FrameMap<D>) -> Option<EulerReading> {
    let rotation = shape_of(map).rotation;
    let embedded = embedded(&rotation, 1.0);
    // A reflection has no angles.
    (embedded.determinant() > 0.0).then(|| {
        let rotation = Rotation3::from_matrix_unchecked(embedded);
        EulerAngles::from_rotation(&UnitQuaternion::from_rotation_matrix(&rotation))
    })
}
