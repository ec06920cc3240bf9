use std::ops::Range;
use std::sync::Arc;

/// Which row gives each row its cells, of tables of any length.
#[derive(Clone, Debug)]
pub(crate) enum Order {
    /// One after the other.
    Listed(Vec<usize>),
    /// The one so many rows further down in the same block, which begins anew at its end; of rows in no block,
    /// the row itself.
    Rolled { blocks: Arc<[Range<usize>]>, by: isize },
    /// The last of so many rows first.
    Reversed(usize),
    /// Two stretches of as many rows change places.
    Exchanged([Range<usize>; 2]),
}

impl Order {
    /// The row that gives its cells to `row`.
    pub(crate) fn of(&self, row: usize) -> usize {
        match self {
            Self::Listed(order) => order[row],
            Self::Rolled { blocks, by } => {
                let block = blocks.get(blocks.partition_point(|b| b.end <= row));
                let Some(Range { start, end }) = block.filter(|b| b.contains(&row)).cloned() else {
                    return row;
                };
                let (n, at) = (end - start, row - start);
                let further = by.unsigned_abs() % n;
                let next = if *by < 0 { at + n - further } else { at + further };
                start + next % n
            }
            Self::Reversed(rows) => rows - 1 - row,
            Self::Exchanged([one, other]) if one.contains(&row) => other.start + row - one.start,
            Self::Exchanged([one, other]) if other.contains(&row) => one.start + row - other.start,
            Self::Exchanged(_) => row,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Order;

    fn of(order: &Order, rows: usize) -> Vec<usize> {
        (0..rows).map(|row| order.of(row)).collect()
    }

    #[test]
    fn every_order_gives_each_row_once() {
        let blocks: std::sync::Arc<[_]> = [0..3, 3..4, 4..6].into();
        let rolled = |by| Order::Rolled { blocks: blocks.clone(), by };
        assert_eq!(of(&rolled(1), 6), [1, 2, 0, 3, 5, 4]);
        assert_eq!(of(&rolled(-1), 6), [2, 0, 1, 3, 5, 4]);
        assert_eq!(of(&rolled(2), 6), [2, 0, 1, 3, 4, 5]);
        assert_eq!(of(&rolled(-5), 6), [1, 2, 0, 3, 5, 4]);
        let some: std::sync::Arc<[_]> = [1..4, 5..7].into();
        assert_eq!(of(&Order::Rolled { blocks: some, by: 1 }, 8), [0, 2, 3, 1, 4, 6, 5, 7]);
        assert_eq!(of(&Order::Reversed(3), 3), [2, 1, 0]);
        assert_eq!(of(&Order::Exchanged([0..2, 3..5]), 6), [3, 4, 2, 0, 1, 5]);
        assert_eq!(of(&Order::Listed(vec![2, 0, 1]), 3), [2, 0, 1]);
    }
}
