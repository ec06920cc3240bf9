//! Blocks that see the same, numbered as they are met.

use std::collections::HashMap;

/// Numbers of what blocks see: station, mount and dead path of every range, in their order.
#[derive(Debug, Default)]
pub(crate) struct Kinds {
    numbers: HashMap<Vec<[usize; 3]>, usize>,
    /// What the last block saw, and its number.
    last: (Vec<[usize; 3]>, usize),
    room: Vec<[usize; 3]>,
}

impl Kinds {
    /// Number of a block that sees these, and whether it is new. Most blocks see what the one before
    /// them saw.
    pub(crate) fn number(&mut self, seen: impl Iterator<Item = [usize; 3]>) -> (usize, bool) {
        self.room.clear();
        self.room.extend(seen);
        if !self.numbers.is_empty() && self.room == self.last.0 {
            return (self.last.1, false);
        }
        let next = self.numbers.len();
        let number = self.numbers.get(&self.room).copied().unwrap_or(next);
        if number == next {
            self.numbers.insert(self.room.clone(), next);
        }
        std::mem::swap(&mut self.last.0, &mut self.room);
        self.last.1 = number;
        (number, number == next)
    }
}
