//! Chooses which of too many readings are drawn.

/// Indices of at most about `limit` values: of each stretch its smallest and its largest, so
/// that the envelope and every extreme stay.
pub(crate) fn envelope(values: &[f64], limit: usize) -> Vec<usize> {
    if values.len() <= limit {
        return (0..values.len()).collect();
    }
    let stretch = values.len().div_ceil((limit / 2).max(1));
    let mut kept = Vec::with_capacity(limit);
    for (block, stretch_values) in values.chunks(stretch).enumerate() {
        let order = |a: &usize, b: &usize| stretch_values[*a].total_cmp(&stretch_values[*b]);
        let smallest = (0..stretch_values.len()).min_by(order).unwrap_or(0);
        let largest = (0..stretch_values.len()).max_by(order).unwrap_or(0);
        let start = block * stretch;
        kept.push(start + smallest.min(largest));
        if smallest != largest {
            kept.push(start + smallest.max(largest));
        }
    }
    kept
}

/// Every how many-th reading is drawn so that at most `limit` are.
pub(crate) fn stride(n: usize, limit: usize) -> usize {
    n.div_ceil(limit.max(1)).max(1)
}
