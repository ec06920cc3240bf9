use nalgebra::{Matrix3, Matrix4, Matrix6, Vector6};
use pose_icp::PoseStart;
use serde::Serialize;

use super::plausible::{bad_axes, too_far};
use super::pose_numbers::PoseNumbers;
use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::{Cell, TextTable};

/// What a `pose-icp` case is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseIcpEstimates {
    /// Workpiece to machine.
    pub pose: PoseEstimate,
    /// Rows of the homogeneous matrix that takes a point of the workpiece to where the machine reads
    /// it: the pose, and in a loop what the machine's axes were found to add.
    pub matrix: Vec<Vec<f64>>,
    /// Where the machine reads right although its axes are long or out of square; `None` where
    /// nothing of the kind was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_mm: Option<[f64; 3]>,
    /// Points that were only judged: where the pose puts them along the machine's z.
    pub checks: Vec<HeightCheck>,
    /// Residual of every point, in the order of the table.
    pub points: Vec<TouchResidual>,
    /// Of the whitened Jacobian without the held parameters, the largest first; angles are
    /// measured by the travel they cause at the points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub singular_values: Vec<f64>,
    /// Motions of the part that the points hardly show.
    pub weak_directions: Vec<String>,
}

/// `p_machine = Rz(γ) Ry(β) Rx(α) p + d`, with standard uncertainties.
///
/// They are 0 for what is held, `None` where the noise is unknown and nothing is redundant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseEstimate {
    /// Position and angles.
    #[serde(flatten)]
    pub numbers: PoseNumbers,
    /// Of `x_mm`.
    pub std_x_mm: Option<f64>,
    /// Of `y_mm`.
    pub std_y_mm: Option<f64>,
    /// Of `z_mm`.
    pub std_z_mm: Option<f64>,
    /// Of `alpha_deg`.
    pub std_alpha_deg: Option<f64>,
    /// Of `beta_deg`.
    pub std_beta_deg: Option<f64>,
    /// Of `gamma_deg`.
    pub std_gamma_deg: Option<f64>,
    /// 95 % intervals, where the touches show the pose so little that none is symmetric; the
    /// standard uncertainties are then those that cover the longer side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_95: Option<PoseIntervals>,
}

/// From and to, at 95 % coverage each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseIntervals {
    /// Of the position of the workpiece's origin.
    pub x_mm: [f64; 2],
    /// As `x_mm`.
    pub y_mm: [f64; 2],
    /// As `x_mm`.
    pub z_mm: [f64; 2],
    /// Of the tilt about x.
    pub alpha_deg: [f64; 2],
    /// Of the tilt about y.
    pub beta_deg: [f64; 2],
    /// Of the rotation about z.
    pub gamma_deg: [f64; 2],
}

/// A point that was only judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeightCheck {
    /// Its name.
    pub point: String,
    /// Machine z as measured.
    pub z_measured_mm: f64,
    /// Machine z at which the probe would meet the part there.
    pub z_computed_mm: f64,
    /// Computed − measured.
    pub dz_mm: f64,
    /// Standard uncertainty of `z_computed_mm` from that of the pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_mm: Option<f64>,
}

/// Residual of one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchResidual {
    /// Its name.
    pub point: String,
    /// `fit` or `check`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Where the machine read the centre of the ball.
    pub x_mm: f64,
    /// As `x_mm`.
    pub y_mm: f64,
    /// As `x_mm`.
    pub z_mm: f64,
    /// Distance from the surface along its normal, less the tip's radius.
    pub residual_mm: f64,
    /// Contact on the part as the declared model places it, workpiece frame: where the errors of
    /// form that a loop found are taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub declared_contact_mm: Option<[f64; 3]>,
    /// Normal of the part there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub declared_normal: Option<[f64; 3]>,
    /// What corrections along a column without a known cause add to the residual; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical_mm: Option<f64>,
}

impl PoseEstimate {
    pub(crate) fn of(pose: &PoseStart, stds: Option<Vector6<f64>>) -> Self {
        let length = |k: usize| stds.map(|s| s[k]);
        let angle = |k: usize| stds.map(|s| s[k].to_degrees());
        Self {
            numbers: pose.into(),
            std_x_mm: length(0),
            std_y_mm: length(1),
            std_z_mm: length(2),
            std_alpha_deg: angle(3),
            std_beta_deg: angle(4),
            std_gamma_deg: angle(5),
            interval_95: None,
        }
    }

    /// With intervals that reach this far below and above `[x y z α β γ]`, mm and rad, at that
    /// coverage factor.
    pub(crate) fn within(self, reach: &[[f64; 2]; 6], coverage_factor: f64) -> Self {
        let std = |k: usize| Some(reach[k][0].max(reach[k][1]) / coverage_factor);
        let angle_std = |k: usize| std(k).map(f64::to_degrees);
        let around = |k: usize, value: f64| [value - reach[k][0], value + reach[k][1]];
        let around_deg = |k: usize, value: f64| {
            [value - reach[k][0].to_degrees(), value + reach[k][1].to_degrees()]
        };
        let at = &self.numbers;
        let interval_95 = PoseIntervals {
            x_mm: around(0, at.x_mm),
            y_mm: around(1, at.y_mm),
            z_mm: around(2, at.z_mm),
            alpha_deg: around_deg(3, at.alpha_deg),
            beta_deg: around_deg(4, at.beta_deg),
            gamma_deg: around_deg(5, at.gamma_deg),
        };
        Self {
            std_x_mm: std(0),
            std_y_mm: std(1),
            std_z_mm: std(2),
            std_alpha_deg: angle_std(3),
            std_beta_deg: angle_std(4),
            std_gamma_deg: angle_std(5),
            interval_95: Some(interval_95),
            ..self
        }
    }
}

pub(crate) fn stds(covariance: &Matrix6<f64>) -> Vector6<f64> {
    covariance.diagonal().map(|v| v.max(0.0).sqrt())
}

pub(super) fn rows(matrix: &Matrix4<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

impl Estimates for PoseIcpEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let p = &self.pose;
        let at = &p.numbers;
        vec![
            Estimated::new("x", "mm", at.x_mm, p.std_x_mm),
            Estimated::new("y", "mm", at.y_mm, p.std_y_mm),
            Estimated::new("z", "mm", at.z_mm, p.std_z_mm),
            Estimated::new("alpha", "°", at.alpha_deg, p.std_alpha_deg),
            Estimated::new("beta", "°", at.beta_deg, p.std_beta_deg),
            Estimated::new("gamma", "°", at.gamma_deg, p.std_gamma_deg),
        ]
    }

    fn tables(&self) -> Vec<TextTable> {
        if self.checks.is_empty() {
            let mut table = TextTable::new("points", &["point", "use", "residual (mm)"]);
            for p in &self.points {
                let residual = p.residual_mm;
                table.push(vec![p.point.clone().into(), p.usage.into(), residual.into()]);
            }
            return vec![table];
        }
        let columns = ["point", "z measured (mm)", "z computed (mm)", "dz (mm)", "U (k = 2, mm)"];
        let mut table = TextTable::new("check points", &columns);
        for c in &self.checks {
            table.push(vec![
                c.point.clone().into(),
                Cell::Known(c.z_measured_mm, c.std_mm),
                Cell::Known(c.z_computed_mm, c.std_mm),
                Cell::Known(c.dz_mm, c.std_mm),
                Cell::Expanded(c.std_mm),
            ]);
        }
        vec![table]
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        let place = [0, 1, 2].map(|row| self.matrix[row][3]);
        let axes = Matrix3::from_fn(|row, column| self.matrix[row][column]);
        too_far(place).or_else(|| bad_axes(&axes))
    }
}
