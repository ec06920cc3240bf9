//! Lists of indices, one after the other in one piece of memory.

/// Lists of indices.
#[derive(Clone, Debug)]
pub(crate) struct Lists {
    numbers: Vec<u32>,
    /// Where each list begins; then the end.
    starts: Vec<usize>,
}

impl Lists {
    /// Lists of so many numbers each, filled from indices with the list that they belong to.
    pub(crate) fn sorted(counts: &[usize], lists: impl Iterator<Item = usize>) -> Self {
        let mut starts = vec![0];
        starts.extend(counts.iter().scan(0, |end, count| {
            *end += count;
            Some(*end)
        }));
        let mut next = starts.clone();
        let mut numbers = vec![0; counts.iter().sum()];
        for (index, list) in lists.enumerate() {
            numbers[next[list]] = number(index);
            next[list] += 1;
        }
        Self { numbers, starts }
    }

    /// Lists that each join some of these.
    pub(crate) fn joined<'a>(&self, parts: impl Iterator<Item = &'a [usize]>) -> Self {
        let (mut numbers, mut starts) = (Vec::with_capacity(self.numbers.len()), vec![0]);
        for lists in parts {
            for &list in lists {
                numbers.extend_from_slice(self.at(list));
            }
            starts.push(numbers.len());
        }
        Self { numbers, starts }
    }

    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn at(&self, list: usize) -> &[u32] {
        &self.numbers[self.starts[list]..self.starts[list + 1]]
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|list| self.at(list))
    }
}

fn number(index: usize) -> u32 {
    u32::try_from(index).expect("nobody has 2^32 readings")
}
