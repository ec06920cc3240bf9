//! Components that were copied, not measured.

use crate::algebra::system::{Estimate, System};

/// Residual of a component below this share of the largest is «not measured».
const SILENT: f64 = 1e-12;

/// Components whose residual is zero in every fitted row: copied, not measured.
pub(crate) fn silent_components(system: &System<'_>, at: &Estimate, rows: &[usize]) -> Vec<bool> {
    let layout = &system.model.declared().layout;
    let all = system.residuals(at);
    let components = layout.rows.iter().map(|r| r.component + 1).max().unwrap_or(0);
    let mut largest = vec![0.0_f64; components];
    for &row in rows {
        let component = layout.rows[row].component;
        largest[component] = largest[component].max(all[row].abs());
    }
    let scale = largest.iter().copied().fold(0.0, f64::max);
    // With every component at zero there is nothing to find and nothing to leave out.
    largest.iter().map(|&l| scale > 0.0 && l <= SILENT * scale).collect()
}
