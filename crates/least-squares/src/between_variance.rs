//! The scatter that all rows share beyond what is known of each.

use nalgebra::{DMatrix, DVector};

/// Points per decade of variance at which the likelihood is taken.
const STEPS_PER_DECADE: i32 = 6;

/// Decades below and above the mean square of the residual that are looked at: less scatter
/// makes no difference, and more is no better known from one degree of freedom.
const DECADES: [i32; 2] = [-4, 1];

/// Variance that rows share beyond the standard uncertainty `sigma` of each.
///
/// `residual` and `jacobian` are those of a fit, not whitened, one row per entry of `sigma`;
/// rows for which `shares` is false have no part in it.
/// The square of the median of `τ` under the restricted likelihood `exp(−D/2)` (Patterson and
/// Thompson 1971),
///
/// ```text
/// D = Σ ln(σᵢ² + τ²) + ln|JᵀV⁻¹J| + rᵀV⁻¹(I − J(JᵀV⁻¹J)⁻¹JᵀV⁻¹)r,   V = diag(σᵢ² + τ²)
/// ```
///
/// which unlike the plain likelihood pays for the parameters fitted. The median, every `τ ≥ 0` as
/// likely as any other beforehand, is never zero: where few rows leave `τ` open, none must
/// stand out by a weight that the data do not support.
#[must_use]
pub fn between_variance(
    sigma: &[f64],
    shares: impl Fn(usize) -> bool,
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
) -> f64 {
    let dof = sigma.len().saturating_sub(jacobian.ncols());
    #[expect(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
    let square = residual.norm_squared() / dof.max(1) as f64;
    if dof == 0 || square <= 0.0 || !square.is_finite() {
        return 0.0;
    }
    let step = |k: i32| square * 10f64.powf(f64::from(k) / f64::from(STEPS_PER_DECADE));
    let grid = (DECADES[0] * STEPS_PER_DECADE)..=(DECADES[1] * STEPS_PER_DECADE);
    let variances: Vec<_> = std::iter::once(0.0).chain(grid.map(step)).collect();
    let squares = |variance: f64| {
        let square = |(row, s): (usize, &f64)| s * s + if shares(row) { variance } else { 0.0 };
        sigma.iter().enumerate().map(square).collect::<Vec<_>>()
    };
    let deviances: Vec<_> =
        variances.iter().map(|v| deviance(&squares(*v), residual, jacobian)).collect();
    let least = deviances.iter().copied().fold(f64::INFINITY, f64::min);
    let density: Vec<_> = deviances.iter().map(|d| (0.5 * (least - d)).exp()).collect();
    let scatter: Vec<_> = variances.iter().map(|v| v.sqrt()).collect();
    median(&scatter, &density).powi(2)
}

/// Median of a law with `density` at increasing `values`, linear between them.
fn median(values: &[f64], density: &[f64]) -> f64 {
    let share = |i: usize| 0.5 * (density[i] + density[i + 1]) * (values[i + 1] - values[i]);
    let half = 0.5 * (0..values.len() - 1).map(share).sum::<f64>();
    let mut below = 0.0;
    for i in 0..values.len() - 1 {
        let next = share(i);
        if below + next >= half {
            return values[i] + (values[i + 1] - values[i]) * (half - below) / next;
        }
        below += next;
    }
    values[values.len() - 1]
}

/// Minus twice the restricted log likelihood, up to a constant.
fn deviance(variances: &[f64], residual: &DVector<f64>, jacobian: &DMatrix<f64>) -> f64 {
    let p = jacobian.ncols();
    let rows = variances.len();
    let mut white = DMatrix::zeros(rows, p);
    let mut y = DMatrix::zeros(rows, 1);
    let mut volume = 0.0;
    for (i, own) in variances.iter().enumerate() {
        volume += own.ln();
        white.row_mut(i).copy_from(&(jacobian.row(i) / own.sqrt()));
        y[(i, 0)] = residual[i] / own.sqrt();
    }
    let design = white.qr();
    design.q_tr_mul(&mut y);
    let r = design.r();
    volume += (0..p.min(rows)).map(|i| 2.0 * r[(i, i)].abs().ln()).sum::<f64>();
    volume + y.rows(p.min(rows), rows.saturating_sub(p)).norm_squared()
}
