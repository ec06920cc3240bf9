use frame_fit::{FrameFit, FrameMap, Transform, shape_of};
use geometry::{EulerAngles, EulerReading};
use nalgebra::{DMatrix, Matrix3, Point, Rotation3, UnitQuaternion};
use serde::Serialize;

use crate::estimates::Estimated;
use crate::text_table::{Cell, TextTable};

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
    /// Residual of every point, in the order of the table.
    pub points: Vec<PointResidual>,
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
}

/// Residual `to − T(from)` of one point.
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
}

impl FrameFitEstimates {
    pub(crate) fn of<const D: usize>(
        map: &FrameMap<D>,
        std: Option<TransformStd>,
        points: Vec<PointResidual>,
    ) -> Self {
        let shape = shape_of(map);
        let angles = angles(map).map(|a| {
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
            std,
            points,
        }
    }

    pub(crate) fn parameters(&self) -> Vec<Estimated> {
        let std = self.std.as_ref();
        let mut all = Vec::new();
        for (i, value) in self.translation_mm.iter().enumerate() {
            let std = std.map(|s| s.translation_mm[i]);
            all.push(Estimated::new(["x", "y", "z"][i], "mm", *value, std));
        }
        let names = if self.translation_mm.len() == 2 {
            &["angle"][..]
        } else {
            &["alpha (about x)", "beta (about y)", "gamma (about z)"]
        };
        for (i, value) in self.angles_deg.iter().flatten().enumerate() {
            let std = std.and_then(|s| s.angles_deg.as_ref()).map(|s| s[i]);
            all.push(Estimated::new(names[i], "°", *value, std));
        }
        all.push(Estimated::new("scale", "", self.scale, std.and_then(|s| s.scale)));
        all
    }

    pub(crate) fn table(&self) -> TextTable {
        let planar = self.translation_mm.len() == 2;
        let columns = ["point", "use", "dx mm", "dy mm", "dz mm"];
        let columns = if planar { &columns[..4] } else { &columns[..] };
        let mut table = TextTable::new("residual to − T(from)", columns);
        for p in &self.points {
            let mut row: Vec<Cell> = vec![p.point.clone().into(), p.usage.into()];
            row.extend([Cell::from(p.dx_mm), p.dy_mm.into()]);
            if !planar {
                row.push(p.dz_mm.into());
            }
            table.push(row);
        }
        table
    }
}

impl TransformStd {
    /// Uncertainties from the covariance of a perturbation on the left.
    ///
    /// The translation is the image of the source frame's origin, and moves as that point does.
    pub(crate) fn of<const D: usize>(fit: &FrameFit<D>) -> Option<Self> {
        if fit.transform == Transform::None {
            return None;
        }
        let stds = fit.standard_uncertainties()?;
        let a_priori = fit.covariance.diagonal().map(f64::sqrt);
        // One factor scales the whole covariance; read it where it is not 0 / 0.
        let factor = (0..stds.len()).find(|&i| a_priori[i] > 0.0).map(|i| stds[i] / a_priori[i])?;
        let origin = Point::from(fit.target_from_source.translation_mm);
        let covariance = fit.covariance_about(&origin) * factor * factor;
        let named = |name: &str| fit.parameters().iter().position(|p| p.name == name);
        let std_of = |name: &str| named(name).map(|i| covariance[(i, i)].sqrt());
        Some(Self {
            translation_mm: ["tx", "ty", "tz"].into_iter().filter_map(std_of).collect(),
            angles_deg: angles_std(fit, &covariance),
            scale: std_of("scale"),
        })
    }
}

fn angles_std<const D: usize>(fit: &FrameFit<D>, covariance: &DMatrix<f64>) -> Option<Vec<f64>> {
    let parameters = fit.parameters();
    let index = |name: &str| parameters.iter().position(|p| p.name == name);
    if D == 2 {
        let rz = index("rz")?;
        return Some(vec![covariance[(rz, rz)].sqrt().to_degrees()]);
    }
    let rotations = [index("rx")?, index("ry")?, index("rz")?];
    let rotation = Matrix3::from_fn(|i, j| covariance[(rotations[i], rotations[j])]);
    let EulerReading::Unique(angles) = angles(&fit.target_from_source)? else { return None };
    let inverse = angles.left_jacobian().try_inverse()?;
    let of_angles = inverse * rotation * inverse.transpose();
    Some(of_angles.diagonal().iter().map(|v| v.sqrt().to_degrees()).collect())
}

fn angles<const D: usize>(map: &FrameMap<D>) -> Option<EulerReading> {
    let rotation = shape_of(map).rotation;
    let embedded = Matrix3::from_fn(|row, column| match (row < D, column < D) {
        (true, true) => rotation[(row, column)],
        _ if row == column => 1.0,
        _ => 0.0,
    });
    // A reflection has no angles.
    (embedded.determinant() > 0.0).then(|| {
        let rotation = Rotation3::from_matrix_unchecked(embedded);
        EulerAngles::from_rotation(&UnitQuaternion::from_rotation_matrix(&rotation))
    })
}
