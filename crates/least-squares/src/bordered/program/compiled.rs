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

/// Sums of products `a b`, with `a` and `b` among a block's residuals, derivatives by its own
/// directions and by the shared ones, numbered through in this order.
#[derive(Debug, Default)]
pub(in crate::bordered) struct Products {
    /// Those of one product, with the place of the sum.
    pub(in crate::bordered) single: Vec<[u32; 3]>,
    /// Those of several.
    pub(in crate::bordered) sums: Vec<Sum>,
    pub(in crate::bordered) pairs: Vec<[u32; 2]>,
}

/// A sum of products.
#[derive(Clone, Copy, Debug)]
pub(in crate::bordered) struct Sum {
    /// Place of the sum.
    pub(in crate::bordered) to: u32,
    /// Number of its pairs, which follow those of the sum before.
    pub(in crate::bordered) count: u32,
}

impl Products {
    /// Of `[a, b, to]` in the order in which they are added up.
    fn new(mut products: Vec<[usize; 3]>) -> Self {
        products.sort_by_key(|[_, _, to]| *to);
        let number = |n: usize| u32::try_from(n).expect("nobody has 2^32 numbers in a block");
        let mut compiled = Self::default();
        for all in products.chunk_by(|[_, _, a], [_, _, b]| a == b) {
            if let [single] = all {
                compiled.single.push(single.map(number));
                continue;
            }
            compiled.sums.push(Sum { to: number(all[0][2]), count: number(all.len()) });
            compiled.pairs.extend(all.iter().map(|&[a, b, _]| [number(a), number(b)]));
        }
        compiled
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
    pub(in crate::bordered) own: Products,
    /// To the panels of `J_bᵀ [r J_s]`.
    pub(in crate::bordered) coupling: Products,
    /// To the slots of `[r J_s]ᵀ J_s`.
    pub(in crate::bordered) shared: Products,
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
        let mut compiled = Self {
            limits,
            rows,
            block_columns,
            entries,
            own: Products::default(),
            coupling: Products::default(),
            shared: Products::default(),
        };
        compiled.own = Products::new(compiled.own());
        compiled.coupling = Products::new(compiled.coupling(first, starts));
        compiled.shared = Products::new(compiled.shared(slots));
        compiled
    }

    fn own(&self) -> Vec<[usize; 3]> {
        let mut products = Vec::new();
        for row in &self.rows {
            for p in row.by_block.clone() {
                for q in row.by_block.start..=p {
                    let (a, b) = (self.block_columns[p], self.block_columns[q]);
                    let to = row_start(a.max(b)) + a.min(b);
                    products.push([self.limits.rows + p, self.limits.rows + q, to]);
                }
            }
        }
        products
    }

    fn coupling(&self, first: &[usize], starts: &[usize]) -> Vec<[usize; 3]> {
        let mut products = Vec::new();
        let by_shared = self.limits.rows + self.limits.by_block;
        for (i, row) in self.rows.iter().enumerate() {
            for p in row.by_block.clone() {
                let (own, direction) = (self.limits.rows + p, self.block_columns[p]);
                let to = |column: usize| {
                    let panel = column / PANEL;
                    (starts[panel] + direction - first[panel]) * PANEL + column % PANEL
                };
                products.push([own, i, to(0)]);
                for entry in &self.entries[row.entries.clone()] {
                    let value = by_shared + entry.value;
                    products.push([own, value, to(entry.column)]);
                }
            }
        }
        products
    }

    fn shared(&self, slots: &mut Slots) -> Vec<[usize; 3]> {
        let mut products = Vec::new();
        let by_shared = self.limits.rows + self.limits.by_block;
        for (i, row) in self.rows.iter().enumerate() {
            let entries = &self.entries[row.entries.clone()];
            for (n, entry) in entries.iter().enumerate() {
                let value = by_shared + entry.value;
                products.push([i, value, slots.number([0, entry.column])]);
                for other in &entries[n..] {
                    let to = slots.number([entry.column, other.column]);
                    products.push([value, by_shared + other.value, to]);
                }
            }
        }
        products
    }
}
