/// The shared point and those of all blocks.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BorderedPoint {
    /// What all blocks share.
    pub shared: Vec<f64>,
    /// Points of the blocks, one after the other, each of the same length.
    pub blocks: Vec<f64>,
}

impl BorderedPoint {
    /// Numbers that each of so many blocks has.
    pub(super) fn block_len(&self, block_count: usize) -> usize {
        self.blocks.len().checked_div(block_count).unwrap_or(0)
    }
}
