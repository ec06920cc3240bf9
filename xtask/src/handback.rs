//! What `truing loop` hands back, applied to the input by code of its own, leaves what it says.
//!
//! One module a kind. Each reads the tables of a case folder and the JSON of `truing loop`, applies
//! the deliverable as printed (a matrix and corrections, a frame, a weight, …) and gives the
//! residual of every observation. Nothing here is shared with the crates under test: the formulas
//! are those of `docs/`. Every committed case is checked, and small cases made for the purpose, in
//! which every effect of the catalogues is accepted at least once.

mod exports;
mod folder;
mod force_impedance;
mod frame_fit;
mod frame_scenes;
mod ft_center;
mod gravity_scenes;
mod loops;
mod pose_icp;
mod pose_scenes;
mod probe_comp;
mod probe_scenes;
mod target_scenes;
mod targets;
mod tracker_lm;
mod tracker_scenes;

use serde_json::Value;

/// Largest relative difference between an error reproduced and the one printed: 10⁷ times the
/// round-off of a double, for differences of coordinates a million times as large.
const AGREEMENT: f64 = 1e-9;

/// Round-off of a residual over the size of the numbers that it is the difference of.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Residuals as the printed deliverable leaves them.
#[derive(Clone, Debug, Default)]
struct Left {
    /// Of every fitted observation.
    fitted: Vec<Vec<f64>>,
    /// Of every observation that was only judged.
    checked: Vec<Vec<f64>>,
    /// Size of the largest number that a residual is the difference of, in its unit.
    scale: f64,
}

impl Left {
    /// Asserts that these residuals are those of `after`.
    fn assert_is(&self, case: &str, json: &Value) {
        let after = &json["after"];
        let train = after["train_rms"].as_f64().expect("an error after");
        self.assert_close(case, "train rms", rms(&self.fitted), train);
        if after["hold_out"] == "check-groups" && !self.checked.is_empty() {
            let held_out = after["held_out_rms"].as_f64().expect("an error after");
            self.assert_close(case, "rms of the check groups", rms(&self.checked), held_out);
        }
    }

    fn assert_close(&self, case: &str, what: &str, applied: f64, printed: f64) {
        let allowed = AGREEMENT * printed + ROUND_OFF * self.scale;
        assert!(
            (applied - printed).abs() <= allowed,
            "{case}: {what} is {applied:e} with what was printed applied, and said to be {printed:e}"
        );
    }
}

/// Root mean square length.
fn rms(residuals: &[Vec<f64>]) -> f64 {
    let squares: f64 = residuals.iter().flatten().map(|r| r * r).sum();
    (squares / as_f64(residuals.len())).sqrt()
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
