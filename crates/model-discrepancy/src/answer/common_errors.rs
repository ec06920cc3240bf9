//! Errors that readings have in common by what they were read from and at.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::Remaining;
use crate::algebra::f_tail::f_tail;
use crate::answer::without_tails::without_tails;
use crate::choice::context::Context;
use crate::count::count;
use crate::levels::ONLY_NOISE;
use crate::model::Cells;
use crate::noise::linear::Linear;

/// Mean squares between and within the cells of each way in which observations belong together (one-way analysis of
/// variance), where they are too unlike for larger noise to be called nothing but noise.
pub(crate) fn common_errors(context: &Context<'_>, lin: &Linear<'_>) -> Option<Remaining> {
    let cells = &context.model.declared().cells;
    let residual = without_tails(&lin.basis.reject(&lin.residual));
    let level = ONLY_NOISE / count(cells.len().max(1));
    let of = |cells: &Cells| {
        let p_value = between(context, lin, (cells, &residual)).filter(|p| *p <= level)?;
        let shape = "readings of one agree".to_owned();
        Some(Remaining { covariate: cells.what.clone(), shape, p_value })
    };
    cells.iter().filter_map(of).min_by(|a, b| a.p_value.total_cmp(&b.p_value))
}

/// Probability of cells that differ so much by chance.
fn between(
    context: &Context<'_>,
    lin: &Linear<'_>,
    (cells, residual): (&Cells, &DVector<f64>),
) -> Option<f64> {
    let projected = &context.model.declared().projected;
    let is_combined = |row: usize| {
        projected.iter().any(|p| (p.first_row..p.first_row + p.combination.nrows()).contains(&row))
    };
    let mut rows: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (i, &row) in lin.rows.iter().enumerate().filter(|(_, row)| !is_combined(**row)) {
        let of = &lin.layout.rows[row];
        if let Some(cell) = cells.of_observation.get(of.observation).filter(|_| of.reported) {
            rows.entry((*cell, of.component)).or_default().push(i);
        }
    }
    rows.retain(|_, rows| rows.len() > 1);
    let q = lin.basis.matrix();
    let (mut all, mut free) = (0.0, 0.0);
    let (mut of_means, mut free_means) = (0.0, 0.0);
    for own in rows.values() {
        let n = count(own.len());
        let sum: f64 = own.iter().map(|&i| residual[i]).sum();
        of_means += sum * sum / n;
        all += own.iter().map(|&i| residual[i].powi(2)).sum::<f64>();
        // Of white noise the fit takes its share of either.
        free += own.iter().map(|&i| 1.0 - q.row(i).norm_squared()).sum::<f64>();
        let taken: f64 =
            (0..q.ncols()).map(|k| own.iter().map(|&i| q[(i, k)]).sum::<f64>().powi(2) / n).sum();
        free_means += 1.0 - taken;
    }
    let (within, free_within) = (all - of_means, free - free_means);
    let is_seen = free_means >= 1.0 && free_within >= 1.0 && within > 0.0;
    is_seen.then(|| f_tail(of_means / free_means / (within / free_within), free_means, free_within))
}
