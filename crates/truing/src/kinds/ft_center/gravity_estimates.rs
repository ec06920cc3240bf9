//! What static poses are solved for.

use ft_center::{GravityCalibration, StaticPose};
use geometry::Wrench;
use nalgebra::{Unit, Vector3};
use serde::Serialize;

use super::{CenterEstimate, FrameEstimate};
use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::{ImplausibleResult, too_long};
use crate::text_table::TextTable;

/// What static poses are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GravityEstimates {
    /// Always `None`: poses do not place the sensor.
    pub frame: Option<FrameEstimate>,
    /// Always empty.
    pub centers: Vec<CenterEstimate>,
    /// What the sensor reads under no load.
    pub bias: WrenchEstimate,
    /// Weight of the tool beyond the sensor.
    pub weight_n: f64,
    /// Standard uncertainty of it.
    pub std_weight_n: f64,
    /// Centre of gravity of the tool, sensor frame.
    pub center_of_gravity_mm: [f64; 3],
    /// Standard uncertainty of it.
    pub std_center_of_gravity_mm: [f64; 3],
    /// Root mean square of `line_miss_mm` over the poses.
    pub line_miss_rms_mm: f64,
    /// When bias, weight and centre of gravity hold, and what they leave to the corrections.
    pub conditions: Vec<String>,
    /// One per pose.
    pub poses: Vec<LineMiss>,
}

/// A wrench with its standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "force and moment components in the sensor's axes, as named")]
pub struct WrenchEstimate {
    pub fx_n: f64,
    pub fy_n: f64,
    pub fz_n: f64,
    pub mx_nmm: f64,
    pub my_nmm: f64,
    pub mz_nmm: f64,
    pub std_fx_n: f64,
    pub std_fy_n: f64,
    pub std_fz_n: f64,
    pub std_mx_nmm: f64,
    pub std_my_nmm: f64,
    pub std_mz_nmm: f64,
}

/// One pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineMiss {
    /// Name of the pose.
    pub pose: String,
    /// Distance of the weight's line of action from the centre of gravity.
    pub line_miss_mm: f64,
    /// What accepted effects add to the wrench of the weight: the force.
    pub correction_n: [f64; 3],
    /// And the moment.
    pub correction_nmm: [f64; 3],
    /// Force read − (bias + weight + correction).
    pub residual_n: [f64; 3],
    /// Moment read − (bias + weight + correction).
    pub residual_nmm: [f64; 3],
}

impl GravityEstimates {
    pub(super) fn of(
        calibration: &GravityCalibration,
        poses: &[StaticPose],
        gravity: &Unit<Vector3<f64>>,
        conditions: Vec<String>,
    ) -> Self {
        let bias = calibration.bias.to_vector();
        let std = calibration.covariance.diagonal().map(f64::sqrt);
        let center = calibration.center_of_gravity_mm;
        let misses = &calibration.line_miss_mm;
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let mean_square = misses.iter().map(|m| m * m).sum::<f64>() / misses.len() as f64;
        Self {
            frame: None,
            centers: Vec::new(),
            bias: WrenchEstimate {
                fx_n: bias[0],
                fy_n: bias[1],
                fz_n: bias[2],
                mx_nmm: bias[3],
                my_nmm: bias[4],
                mz_nmm: bias[5],
                std_fx_n: std[0],
                std_fy_n: std[1],
                std_fz_n: std[2],
                std_mx_nmm: std[3],
                std_my_nmm: std[4],
                std_mz_nmm: std[5],
            },
            weight_n: calibration.weight_n,
            std_weight_n: std[6],
            center_of_gravity_mm: [center.x, center.y, center.z],
            std_center_of_gravity_mm: [std[7], std[8], std[9]],
            line_miss_rms_mm: mean_square.sqrt(),
            conditions,
            poses: (poses.iter().zip(misses).zip(&calibration.residuals))
                .map(|((pose, miss), residual)| {
                    let down = pose.base_from_sensor.inverse() * gravity.into_inner();
                    let weight = Wrench::of_force(down * calibration.weight_n, &center);
                    let correction = pose.wrench - calibration.bias - weight - *residual;
                    LineMiss {
                        pose: pose.name.clone(),
                        line_miss_mm: *miss,
                        correction_n: correction.force_n.into(),
                        correction_nmm: correction.torque_nmm.into(),
                        residual_n: residual.force_n.into(),
                        residual_nmm: residual.torque_nmm.into(),
                    }
                })
                .collect(),
        }
    }
}

impl Estimates for GravityEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let b = &self.bias;
        let [x, y, z] = self.center_of_gravity_mm;
        let [std_x, std_y, std_z] = self.std_center_of_gravity_mm;
        let all = [
            ("bias fx", "N", b.fx_n, b.std_fx_n),
            ("bias fy", "N", b.fy_n, b.std_fy_n),
            ("bias fz", "N", b.fz_n, b.std_fz_n),
            ("bias mx", "N·mm", b.mx_nmm, b.std_mx_nmm),
            ("bias my", "N·mm", b.my_nmm, b.std_my_nmm),
            ("bias mz", "N·mm", b.mz_nmm, b.std_mz_nmm),
            ("weight", "N", self.weight_n, self.std_weight_n),
            ("centre of gravity x", "mm", x, std_x),
            ("centre of gravity y", "mm", y, std_y),
            ("centre of gravity z", "mm", z, std_z),
        ];
        let mut all: Vec<Estimated> =
            all.map(|(name, unit, value, std)| Estimated::new(name, unit, value, Some(std))).into();
        all.push(Estimated::new(
            "line of action misses by (rms)",
            "mm",
            self.line_miss_rms_mm,
            None,
        ));
        all
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = ["pose", "line miss mm"];
        let mut table = TextTable::new("line of action past the centre of gravity", &columns);
        for p in &self.poses {
            table.push(vec![p.pose.clone().into(), p.line_miss_mm.into()]);
        }
        vec![table]
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        too_long("the centre of gravity", "the sensor", self.center_of_gravity_mm)
    }
}
