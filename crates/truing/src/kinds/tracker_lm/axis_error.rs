use serde::Serialize;
use tracker_lm::AxisError;

/// The six errors at one angle, relative to the first angle measured.
///
/// For axis B, `e_x` is EXB and `e_c` is ECB.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "six errors and six standard uncertainties, as ISO 230-1 has them")]
pub struct AxisErrorEstimate {
    /// The angle.
    pub angle_deg: f64,
    pub e_x_mm: f64,
    pub e_y_mm: f64,
    pub e_z_mm: f64,
    pub e_a_rad: f64,
    pub e_b_rad: f64,
    pub e_c_rad: f64,
    pub std_e_x_mm: f64,
    pub std_e_y_mm: f64,
    pub std_e_z_mm: f64,
    pub std_e_a_rad: f64,
    pub std_e_b_rad: f64,
    pub std_e_c_rad: f64,
}

/// Location errors of the axis; the errors at the angles still contain what they cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisLocationEstimate {
    /// Names, ISO 230-1: for B `EX0B`, `EZ0B`, `EA0B`, `EC0B`.
    pub names: [String; 4],
    /// Values: two displacements in mm, two rotations in rad.
    pub values: [f64; 4],
    /// Their standard uncertainties.
    pub std: [f64; 4],
}

/// Angles come back as they stand in the table: what rounding to radians left is taken off.
const ROUND_DEG: f64 = 1e-9;

impl AxisErrorEstimate {
    pub(super) fn of(error: &AxisError) -> Self {
        let (e, std) = (&error.error, error.sigmas());
        Self {
            angle_deg: (error.angle_rad.to_degrees() / ROUND_DEG).round() * ROUND_DEG,
            e_x_mm: e[0],
            e_y_mm: e[1],
            e_z_mm: e[2],
            e_a_rad: e[3],
            e_b_rad: e[4],
            e_c_rad: e[5],
            std_e_x_mm: std[0],
            std_e_y_mm: std[1],
            std_e_z_mm: std[2],
            std_e_a_rad: std[3],
            std_e_b_rad: std[4],
            std_e_c_rad: std[5],
        }
    }

    /// Errors, then standard uncertainties.
    pub(super) fn numbers(&self) -> [f64; 12] {
        [
            self.e_x_mm,
            self.e_y_mm,
            self.e_z_mm,
            self.e_a_rad,
            self.e_b_rad,
            self.e_c_rad,
            self.std_e_x_mm,
            self.std_e_y_mm,
            self.std_e_z_mm,
            self.std_e_a_rad,
            self.std_e_b_rad,
            self.std_e_c_rad,
        ]
    }
}
