/// Which parameters each residual of a block depends on.
///
/// Rows keep the order in which they are added. Within a row, the directions keep the order in
/// which they are listed: it is that of the numbers in [`BlockRows`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pattern {
    rows: Vec<PatternRow>,
}

/// What one residual depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PatternRow {
    pub(super) of_block: Vec<usize>,
    pub(super) of_shared: Vec<usize>,
}

impl Pattern {
    /// A pattern without rows.
    #[must_use]
    pub const fn new() -> Self {
        Self { rows: Vec::new() }
    }

    /// `rows` residuals that depend on everything.
    #[must_use]
    pub fn dense(rows: usize, block_dim: usize, shared_dim: usize) -> Self {
        let row =
            PatternRow { of_block: (0..block_dim).collect(), of_shared: (0..shared_dim).collect() };
        Self { rows: vec![row; rows] }
    }

    /// Adds a residual that depends on these directions of the block and of the shared point.
    pub fn push(&mut self, of_block: &[usize], of_shared: &[usize]) {
        let row = PatternRow { of_block: of_block.to_vec(), of_shared: of_shared.to_vec() };
        self.rows.push(row);
    }

    /// Number of residuals.
    #[must_use]
    pub fn residual_count(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn rows(&self) -> &[PatternRow] {
        &self.rows
    }
}

/// Residuals of one block and their derivatives, row by row as its [`Pattern`] lists them.
#[derive(Debug)]
pub struct BlockRows<'a> {
    /// One per row.
    pub residuals: &'a mut [f64],
    /// Derivatives by the block's directions: those of the first row, of the second, and so on.
    pub by_block: &'a mut [f64],
    /// Derivatives by the shared directions, likewise.
    pub by_shared: &'a mut [f64],
}
