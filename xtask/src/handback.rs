//! What `truing loop` hands back, applied to the input by code of its own, leaves what it says.
//!
//! One module a kind. Each reads the tables of a case folder and the JSON of `truing loop`, applies
//! the deliverable as printed (a matrix and corrections, a frame, a weight, …) and gives the
//! residual of every observation. Nothing here is shared with the crates under test: the formulas
//! are those of `docs/`. Every committed case is checked, and small cases made for the purpose, in
//! which every effect of the catalogues is accepted at least once.

pub(crate) mod exports;
pub(crate) mod folder;
pub(crate) mod loops;

use serde_json::Value;

/// Largest relative difference between an error reproduced and the one printed: 10⁷ times the
/// round-off of a double, for differences of coordinates a million times as large.
pub(crate) const AGREEMENT: f64 = 1e-9;

/// Round-off of a residual over the size of the numbers that it is the difference of.
pub(crate) const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Residuals as the printed deliverable leaves them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Left {
    /// Of every fitted observation.
    pub(crate) fitted: Vec<Vec<f64>>,
    /// Of every observation that was only judged.
    pub(crate) checked: Vec<Vec<f64>>,
    /// Size of the largest number that a residual is the difference of, in its unit.
    pub(crate) scale: f64,
}

impl Left {
    /// Asserts that these residuals are those of `after`.
    pub(crate) fn assert_is(&self, case: &str, json: &Value) {
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
pub(crate) fn rms(residuals: &[Vec<f64>]) -> f64 {
    let squares: f64 = residuals.iter().flatten().map(|r| r * r).sum();
    (squares / as_f64(residuals.len())).sqrt()
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn as_f64(count: usize) -> f64 {
    count as f64
}
