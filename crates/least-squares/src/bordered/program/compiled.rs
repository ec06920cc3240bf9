//! One pattern as lists of products.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::bordered::Pattern;
use crate::bordered::triangle::row_start;

use super::PANEL;

/// Numbers that a block has, or the most that any has.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::bordered) struct Limits {
    pub(in crate::bordered) rows: usize,
    pub(in crate::bordered) by_block: usize,
    pub(in crate::bordered) by_shared: usize,
}

impl Limits {
    /// The most of each.
    pub(super) fn most(patterns: &[Compiled]) -> Self {
        let most =
            |part: fn(&Self) -> usize| patterns.iter().map(|p| part(&p.limits)).max().unwrap_or(0);
        Self {
            rows: most(|l| l.rows),
            by_block: most(|l| l.by_block),
            by_shared: most(|l| l.by_shared),
        }
    }

    /// Numbers of all three kinds.
    pub(in crate::bordered) const fn numbers(self) -> usize {
        self.rows + self.by_block + self.by_shared
    }
}

/// `to ← to + a b`, with `a` and `b` among a block's residuals, derivatives by its own
/// directions and by the shared ones, numbered through in this order.
#[derive(Clone, Copy, Debug)]
pub(in crate::bordered) struct Product {
    pub(in crate::bordered) a: u32,
    pub(in crate::bordered) b: u32,
    pub(in crate::bordered) to: u32,
}

impl Product {
    #[expect(clippy::cast_possible_truncation, reason = "nobody has 2^32 numbers in a block")]
    const fn new(a: usize, b: usize, to: usize) -> Self {
        Self { a: a as u32, b: b as u32, to: to as u32 }
    }
}

/// One pattern.
#[derive(Debug)]
pub(in crate::bordered) struct Compiled {
    pub(in crate::bordered) limits: Limits,
    pub(in crate::bordered) rows: Vec<Row>,
    /// Block direction of each derivative by the block's own.
    pub(in crate::bordered) block_columns: Vec<usize>,
    /// Derivatives by shared directions that are free, by row and column.
    pub(in crate::bordered) entries: Vec<Entry>,
    /// To the packed lower triangle of `V = J_bᵀ J_b`.
    pub(in crate::bordered) own: Vec<Product>,
    /// To the panels of `J_bᵀ [r J_s]`.
    pub(in crate::bordered) coupling: Vec<Product>,
    /// To the slots of `[r J_s]ᵀ J_s`.
    pub(in crate::bordered) shared: Vec<Product>,
}

#[derive(Clone, Debug)]
pub(in crate::bordered) struct Row {
    pub(in crate::bordered) by_block: Range<usize>,
    pub(in crate::bordered) entries: Range<usize>,
}

/// A derivative by a shared direction that is free.
#[derive(Clone, Copy, Debug)]
pub(in crate::bordered) struct Entry {
    pub(in crate::bordered) value: usize,
    pub(in crate::bordered) column: usize,
}

/// Pairs of columns, numbered as they are met.
#[derive(Default)]
pub(super) struct Slots {
    pub(super) pairs: Vec<[usize; 2]>,
    numbers: BTreeMap<[usize; 2], usize>,
}

impl Slots {
    fn number(&mut self, pair: [usize; 2]) -> usize {
        *self.numbers.entry(pair).or_insert_with(|| {
            self.pairs.push(pair);
            self.pairs.len() - 1
        })
    }
}

impl Compiled {
    pub(super) fn new(
        pattern: &Pattern,
        column_of: &[Option<usize>],
        first: &[usize],
        starts: &[usize],
        slots: &mut Slots,
    ) -> Self {
        let (mut rows, mut block_columns) = (Vec::new(), Vec::new());
        let (mut entries, mut value) = (Vec::new(), 0);
        for row in pattern.rows() {
            let (block_start, entry_start) = (block_columns.len(), entries.len());
            block_columns.extend_from_slice(&row.of_block);
            for &direction in &row.of_shared {
                entries.extend(column_of[direction].map(|column| Entry { value, column }));
                value += 1;
            }
            entries[entry_start..].sort_by_key(|e: &Entry| e.column);
            let by_block = block_start..block_columns.len();
            rows.push(Row { by_block, entries: entry_start..entries.len() });
        }
        let limits = Limits { rows: rows.len(), by_block: block_columns.len(), by_shared: value };
        let lists = (Vec::new(), Vec::new(), Vec::new());
        let mut compiled = Self {
            limits,
            rows,
            block_columns,
            entries,
            own: lists.0,
            coupling: lists.1,
            shared: lists.2,
        };
        compiled.list_own();
        compiled.list_coupling(first, starts);
        compiled.list_shared(slots);
        compiled
    }

    fn list_own(&mut self) {
        for row in &self.rows {
            for p in row.by_block.clone() {
                for q in row.by_block.start..=p {
                    let (a, b) = (self.block_columns[p], self.block_columns[q]);
                    let to = row_start(a.max(b)) + a.min(b);
                    self.own.push(Product::new(self.limits.rows + p, self.limits.rows + q, to));
                }
            }
        }
    }

    fn list_coupling(&mut self, first: &[usize], starts: &[usize]) {
        let by_shared = self.limits.rows + self.limits.by_block;
        for (i, row) in self.rows.iter().enumerate() {
            for p in row.by_block.clone() {
                let (own, direction) = (self.limits.rows + p, self.block_columns[p]);
                let to = |column: usize| {
                    let panel = column / PANEL;
                    (starts[panel] + direction - first[panel]) * PANEL + column % PANEL
                };
                self.coupling.push(Product::new(own, i, to(0)));
                for entry in &self.entries[row.entries.clone()] {
                    let value = by_shared + entry.value;
                    self.coupling.push(Product::new(own, value, to(entry.column)));
                }
            }
        }
    }

    fn list_shared(&mut self, slots: &mut Slots) {
        let by_shared = self.limits.rows + self.limits.by_block;
        for (i, row) in self.rows.iter().enumerate() {
            let entries = &self.entries[row.entries.clone()];
            for (n, entry) in entries.iter().enumerate() {
                let value = by_shared + entry.value;
                self.shared.push(Product::new(i, value, slots.number([0, entry.column])));
                for other in &entries[n..] {
                    let to = slots.number([entry.column, other.column]);
                    self.shared.push(Product::new(value, by_shared + other.value, to));
                }
            }
        }
    }
}
