//! Rows of a block of groups.

use crate::noise::linear::Linear;

/// Rows of some groups.
pub(super) struct Rows {
    /// Positions in [`Linearised::rows`](crate::algebra::linearised::Linearised::rows).
    pub(super) some: Vec<usize>,
    /// The same, of every row whether it is one.
    pub(super) is_one: Vec<bool>,
    /// Clusters of the groups.
    pub(super) clusters: Vec<usize>,
}

impl Rows {
    /// Of the groups for which `left_out` is true.
    pub(super) fn of(lin: &Linear<'_>, left_out: &[bool]) -> Self {
        let mut is_one = vec![false; lin.rows.len()];
        let is_of = |cluster: &usize| left_out[lin.cluster_groups[*cluster]];
        let clusters: Vec<usize> = (0..lin.clusters.len()).filter(is_of).collect();
        for &row in clusters.iter().flat_map(|&cluster| &lin.clusters[cluster]) {
            is_one[row] = true;
        }
        let some = (0..is_one.len()).filter(|&row| is_one[row]).collect();
        Self { some, is_one, clusters }
    }
}
