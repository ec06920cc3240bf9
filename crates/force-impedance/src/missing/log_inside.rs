//! Scatter of samples inside the blocks that the loop sees.

use model_discrepancy::{Inside, State, independent_share, lag_one};

use crate::LogModel;
use crate::missing::log_blocks::{blocks, single};

/// Samples about the means of their blocks, in units of the declared noise, with what the effects
/// do to each sample taken off; `None` where no noise of the forces was declared, or every block is
/// one sample.
pub(crate) fn inside(model: &LogModel, at: &State) -> Option<Inside> {
    let sigma_n = model.sigma_n.filter(|_| model.has_reference)?;
    let log = &*model.log;
    // Blocks of measurements that could be made come after those of the log.
    let of_log = &model.blocks[..model.record_of.len()];
    let n_samples: usize = of_log.iter().map(|block| block.samples.len()).sum();
    if n_samples <= of_log.len() {
        return None;
    }
    let mut residual_n: Vec<f64> = Vec::with_capacity(log.samples.len());
    let record_of = |start: usize| {
        let after = of_log.partition_point(|b| b.samples.start <= start);
        model.record_of.get(after.saturating_sub(1))
    };
    for sample in blocks(log, single(&log.samples)) {
        let record = record_of(sample.samples.start);
        let effects = at.amplitudes.iter().map(nalgebra::DVector::as_slice).enumerate();
        let there = effects.filter(|(e, _)| at.has(*e));
        let off_n: f64 = there.map(|(e, a)| model.effect_on(e, a, (&sample, record)).0).sum();
        residual_n.push(sample.residual - off_n);
    }
    let mut square = 0.0;
    for block in of_log {
        let own = &residual_n[block.samples.clone()];
        let mean_n = own.iter().sum::<f64>() / crate::count(own.len());
        let sigma_n = sigma_n * block.noise_gain;
        square += own.iter().map(|r| ((r - mean_n) / sigma_n).powi(2)).sum::<f64>();
    }
    let segments = log.samples.chunk_by(|a, b| a.segment == b.segment);
    let mut rest = residual_n.as_slice();
    let series: Vec<&[f64]> = segments
        .map(|segment| {
            let (own, after) = rest.split_at(segment.len());
            rest = after;
            own
        })
        .collect();
    let (correlation, pairs) = lag_one(series.into_iter());
    let dof = crate::count(n_samples - of_log.len());
    Some(Inside { chi2: square, dof, share: independent_share(correlation, pairs) })
}
